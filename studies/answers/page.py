"""The answer to one shot as a page of one sheet: headline, picture, laws; folded below, shots and sources."""

from collections.abc import Callable
from functools import cache

from jinja2 import Template
from markupsafe import Markup

from studies import laws
from studies.answers.answer import ShotAnswer, shot_in_words
from studies.answers.picture import picture
from studies.answers.targets import targets
from studies.laws import Shot
from studies.quantities.display import display_of
from studies.quantities.units import readable
from studies.reports.figure import Figure
from studies.reports.wording import environment_of


def page(answer: ShotAnswer, shot: Shot) -> str:
    """One HTML file that needs no network."""
    from studies.reports.drawing.charts import of_page
    from studies.reports.drawing.images import picture_style

    style = Markup(picture_style())
    return _rendered("answer.html", answer, shot, lambda figure: of_page(figure, "answer"), style)


def body(answer: ShotAnswer, shot: Shot, drawn: Callable[[Figure], Markup]) -> str:
    """What a page says below the headline, for pages of one's own; ``drawn`` is how the figure becomes HTML."""
    return _rendered("body.html", answer, shot, drawn)


def _rendered(template: str, answer: ShotAnswer, shot: Shot, drawn: Callable[[Figure], Markup], style: str = "") -> str:
    figure, target = picture(shot, answer.target), targets()[answer.target]
    return _template(template).render(
        answer=answer,
        target=target,
        shot=shot_in_words(shot),
        figure=figure,
        drawing=drawn(figure),
        style=style,
        readable=readable,
        unit=lambda unit: display_of(unit).unit,
        title=lambda law: laws.load(law).title,
    )


@cache
def _template(name: str) -> Template:
    return environment_of(is_html=True).get_template(f"studies.answers:{name}")
