"""Text with formulas in LaTeX as MathML, which browsers typeset by themselves."""

from functools import lru_cache

from markupsafe import Markup, escape


@lru_cache(maxsize=512)
def typeset(text: str) -> Markup:
    """Text as HTML, what stands between its dollar signs as MathML; raises where LaTeX cannot be read.

    >>> print(typeset("$D$ <= 2 m"))
    <math xmlns="http://www.w3.org/1998/Math/MathML" display="inline"><mrow><mi>D</mi></mrow></math> &lt;= 2 m
    """
    from latex2mathml.converter import convert  # here, because it takes 0.08 s, and most processes show no page

    parts = enumerate(text.split("$"))
    return Markup("").join(Markup(convert(part)) if place % 2 else escape(part) for place, part in parts)
