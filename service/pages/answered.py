"""The answer to a form that asks laws and shots, computed by a child process."""

from collections.abc import Mapping
from dataclasses import dataclass

from markupsafe import Markup

from studies.quantities.findings import Finding, InvalidInput
from studies.reports.figure import Figure


@dataclass(frozen=True)
class AnsweredForm:
    """What laws and shots say of the shot of a form, as HTML; or what is wrong with the form."""

    findings: tuple[Finding, ...]
    headline: str = ""
    body: str = ""
    sheet: str = ""  # the same as a page by itself


def answered_form(fields: Mapping[str, str]) -> AnsweredForm:
    """The answer to the shot of a form, whose fields have one value each."""
    from studies.answers import answer, page, question
    from studies.reports.drawing.charts import of_page
    from studies.reports.drawing.images import as_images

    try:
        asked = question.read_question(fields)
    except InvalidInput as error:
        return AnsweredForm(error.findings)

    def drawn(figure: Figure) -> Markup:
        images = zip(("wide", "narrow"), as_images(of_page(figure, "answer")), strict=True)
        tag = '<img class="chart {}" src="{}" alt="{}">'
        return Markup("").join(Markup(tag).format(width, image, figure.title) for width, image in images)

    [given] = answer.answers(asked)
    shot = asked.shot(asked.fixed)
    return AnsweredForm((), given.headline(), page.body(given, shot, drawn), page.page(given, shot))
