"""Words by templates: records in, plain text out, in the longest form that is short enough for a headline."""

import math
import re
from collections.abc import Callable, Mapping
from functools import cache
from importlib.resources import files as resources
from typing import TYPE_CHECKING, TypeAlias

from jinja2 import Environment, FileSystemBytecodeCache, FunctionLoader, StrictUndefined, Template

from studies.quantities.display import (
    MESH_UNKNOWN,
    MINUS,
    NARROW_SPACE,
    decimals,
    digits,
    display_alone,
    display_of,
    duration,
    percent,
    printed_in,
)
from studies.quantities.units import readable

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

MOST_WORDS = 30  # of a headline
FORMS = 6  # of a headline, from the longest to the shortest
COUNTS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
Told: TypeAlias = "DataclassInstance | Callable[..., str] | Mapping[str, str | None] | int | None"


def worded(template: Template, **told: Told) -> str:
    """A headline: a template's first form with at most ``MOST_WORDS`` words, by its variable ``form`` from 0 on."""
    text = ""
    for form in range(FORMS):
        text = in_words(template, form=form, **told)
        if len(text.split()) <= MOST_WORDS:
            return text
    return f"{' '.join(text.split()[:MOST_WORDS])}…"


def in_words(template: Template, **told: Told) -> str:
    """A text by a template, on one line."""
    # Narrow spaces stay: they hold a number and its unit together.
    text = re.sub(r"[ \n]+", " ", template.render(**told)).strip()
    text = re.sub(r" ([,.;:])", r"\1", text)
    return text[:1].upper() + text[1:]


@cache
def text_template(name: str) -> Template:
    """A template of plain text, by its file among those of reports, or "package:file"."""
    return text_environment().get_template(name)


def environment_of(*, is_html: bool) -> Environment:
    """How templates are read and rendered."""
    return Environment(
        loader=FunctionLoader(source_of),
        # In the user's own folder among temporary files: a first report compiles for 0.2 s, the next need not.
        bytecode_cache=FileSystemBytecodeCache() if is_html else None,
        autoescape=is_html,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def text_environment() -> Environment:
    """What templates of plain text share; a caller may add filters."""
    environment = environment_of(is_html=False)
    environment.globals["mesh_unknown"] = MESH_UNKNOWN
    environment.filters.update(
        size=size,
        digits=lambda value, unit: digits(value * display_of(unit).factor),
        share=share,
        ends=lambda ends: signed(*ends),
        unit=lambda unit: display_of(unit).unit,
        duration=duration,
        words=words,
        counted=lambda count: COUNTS[count] if count < len(COUNTS) else digits(count),
        told=lambda value, unit: value if isinstance(value, str) else readable(float(f"{value:.3g}"), unit or "1"),
        span=lambda ends, unit: spanned(*(number_of(end, unit) for end in ends)) + unit_of(unit),
        number_beside=number_beside,
        percent=percent,
        unit_alone=lambda value, unit: display_alone(value, unit).unit,
    )
    return environment


def size(value: float, unit: str) -> str:
    """A size with three digits, in the unit that people read."""
    shown = float(f"{value * display_of(unit).factor:.3g}")
    if not 0.01 <= abs(shown) < 1e3:
        return digits(shown)
    return decimals(shown, max(0, 2 - math.floor(math.log10(abs(shown)))))


def number_beside(value: float, other: float, unit: str) -> str:
    """A number in the unit in which another one stands alone.

    >>> number_beside(900.0, 1100.0, "m s-1"), number_beside(180.0, 183.0, "m s-1")
    ('0.9', '180')
    """
    return digits(value * display_alone(other, unit).factor)


@cache
def source_of(name: str) -> str:
    """A template of reports, or of a feature: "package:file"."""
    package, _, file = name.rpartition(":")
    return resources(package or "studies.reports").joinpath("templates", file).read_text(encoding="utf-8")


# ---- numbers and names ----------------------------------------------------------------------------


def share(size: float) -> str:
    """A share in per cent: "6 %", "0.4 %".

    >>> share(0.0601), share(0.004)
    ('6\u202f%', '0.4\u202f%')
    """
    return f"{decimals(100.0 * size, 0 if size >= 0.01 else 1).removesuffix('.0')}{NARROW_SPACE}%"


def signed(low: float, high: float) -> str:
    """Differences with their signs.

    >>> signed(-0.07, 0.04), signed(-0.1, -0.1), signed(-0.0003, 0.009)
    ('−7 to +4\u202f%', '−10\u202f%', '0 to +0.9\u202f%')
    """
    ends = ((end, share(abs(end))) for end in (low, high))
    told = [text if text == share(0.0) else f"{'+' if end > 0.0 else MINUS}{text}" for end, text in ends]
    return told[0] if told[0] == told[1] else f"{told[0].removesuffix(f'{NARROW_SPACE}%')} to {told[1]}"


def number_of(value: float | str, unit: str | None) -> str:
    return value if isinstance(value, str) else printed_in(value, unit)


def unit_of(unit: str | None) -> str:
    name = display_of(unit).unit
    return f" {name}" if name else ""


def words(name: str) -> str:
    return name.replace("_", " ")


def spanned(low: str, high: str) -> str:
    """Two printed numbers as a range: "2-7", and one where they are the same.

    >>> spanned("2", "7"), spanned("6", "6"), spanned("−1", "2")
    ('2-7', '6', '−1 to 2')
    """
    if low == high:
        return low
    return f"{low} to {high}" if "−" in low + high else f"{low}-{high}"
