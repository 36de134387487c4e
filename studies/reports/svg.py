"""Lines, arrows, text and ticks of a drawing, as SVG; kinds of lines and text are classes of the page's style sheet."""

import math
from typing import Any

from markupsafe import escape

from studies.values.formats import display_of, printed, printed_in


def svg(kind: str, width: float, height: float, parts: list[str], alt: str) -> str:
    """A drawing of a kind, with its alternative text; sizes in px."""
    label = escape(alt)
    return (
        f'<svg class="picture {kind}" viewBox="0 0 {px(width)} {px(height)}" role="img" aria-label="{label}">'
        f"{''.join(parts)}</svg>"
    )


def step_of(length: float) -> float:
    """A round step near a length.

    >>> step_of(0.0011), step_of(0.0034), step_of(7.1)
    (0.001, 0.005, 10.0)
    """
    power = 10.0 ** math.floor(math.log10(length))
    return float(f"{min((1.0, 2.0, 5.0, 10.0), key=lambda step: abs(math.log(step * power / length))) * power:.12g}")


def ticks(low: float, high: float, step: float) -> list[float]:
    """Multiples of a step from ``low`` to ``high``."""
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [number * step for number in range(first, last + 1)]


def millimetres(value: float, form: Any = None) -> str:
    """A length (m) with its unit; by default with the digits of measured lengths."""
    unit = display_of("m")
    number = form(round(value * unit.factor, 9)) if form else printed(value, "length")
    return f"{number} {unit.unit}"


def microseconds(seconds: float) -> str:
    """A time (s) with its unit, three significant digits."""
    return f"{printed_in(float(f'{seconds:.3g}'), 's')} {display_of('s').unit}"


def line(kind: str, x1: float, y1: float, x2: float, y2: float) -> str:
    """A straight line."""
    return f'<line class="{kind}" x1="{px(x1)}" y1="{px(y1)}" x2="{px(x2)}" y2="{px(y2)}"/>'


def arrow(kind: str, x1: float, y1: float, x2: float, y2: float, *, both: bool = True) -> str:
    """A line with a head at both ends, or at its end alone."""
    angle = math.atan2(y2 - y1, x2 - x1)
    heads = []
    tips = ((x2, y2, angle + math.pi), (x1, y1, angle))
    for x, y, towards in tips[: 1 + both]:
        ends = [(x + 7 * math.cos(towards + side), y + 7 * math.sin(towards + side)) for side in (-0.4, 0.4)]
        corners = " ".join(f"{px(a)},{px(b)}" for a, b in ((x, y), *ends))
        heads.append(f'<polygon class="{kind} head" points="{corners}"/>')
    return line(kind, x1, y1, x2, y2) + "".join(heads)


def text(kind: str, x: float, y: float, words: str, anchor: str) -> str:
    """Words whose ``anchor`` (start, middle, end) is at a place."""
    return f'<text class="{kind}" x="{px(x)}" y="{px(y)}" text-anchor="{anchor}">{escape(words)}</text>'


def px(value: float) -> str:
    """A coordinate, to a tenth of a pixel."""
    return f"{value:.1f}".removesuffix(".0")
