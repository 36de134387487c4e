"""The answer to one shot as a page of one sheet: headline, picture, laws; folded below, shots and sources."""

from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import Environment, FunctionLoader, StrictUndefined

from studies import laws
from studies.laws import Shot
from studies.observations.shields.shots import citation
from studies.quantities.display import NONE, digits, display_of, printed_alone
from studies.reports.answers.answer import ShotAnswer, of_target
from studies.reports.answers.picture import drawn_for_page, picture
from studies.reports.figures import Figure


def page(answer: ShotAnswer, shot: Shot) -> str:
    """One HTML file that needs no network."""
    drawn: Figure = picture(shot, answer.target)
    return (
        _environment()
        .get_template("answer.html")
        .render(
            answer=answer,
            target=of_target(shot, answer.target),
            figure=drawn,
            drawing=drawn_for_page(drawn),
            size=_size,
            between=_between,
            unit=lambda unit: display_of(unit).unit,
            share=_share,
            citation=citation,
            title=lambda law: laws.load(law).title,
        )
    )


def _size(value: Any, unit: str) -> str:
    return NONE if value is None else printed_alone(value, unit)


def _between(low: float, high: float, unit: str) -> str:
    """A value, or its bounds, in the display unit."""
    factor = display_of(unit).factor
    if low != low:  # NaN
        return NONE
    texts = digits(low * factor), digits(high * factor)
    return texts[0] if texts[0] == texts[1] else " to ".join(texts)


def _share(share: Any) -> str:
    """A share of shots with its interval: "7 of 9 (45 to 94 %)"."""
    if not share.of:
        return NONE
    low, high = (f"{100.0 * bound:.0f}" for bound in share.interval)
    return f"{share.count} of {share.of} ({low} to {high} %)"


@cache
def _environment() -> Environment:
    def source(name: str) -> str:
        return files("studies.reports.answers").joinpath("templates", name).read_text(encoding="utf-8")

    loader = FunctionLoader(source)
    return Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
