"""What child processes compute for pages: sweeps that are made of a stored one, answers of laws, and drawings."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from markupsafe import Markup

from service.api.reading import expanded_sweep
from service.pages.charts import Chart
from service.pages.forms import read_value
from service.records.expansion import ExpandedSweep
from studies.quantities.findings import Finding, InvalidInput
from studies.quantities.parameters import Plain, Value
from studies.reports.figure import Figure
from studies.sweeps.longer import with_values
from studies.sweeps.reading import ACCEPTED, SweepLimits
from studies.sweeps.sweep import Sweep


def longer(document: Mapping[str, Plain], axis: str, text: str, max_runs: int) -> ExpandedSweep:
    """A sweep with further values on an axis, written with commas between them; raises InvalidInput."""
    values = read_value("values", text)
    sweep = with_values(Sweep.parse(document, ACCEPTED), axis, values if isinstance(values, list) else [values])
    # Once more, under the limits of a sweep that is posted.
    return expanded_sweep(Sweep.parse(sweep.document(), SweepLimits(max_runs)))


def alone(
    id: str, document: Mapping[str, Plain], coordinates: Mapping[str, Value], title: str, max_runs: int
) -> ExpandedSweep:
    """The sweep, of a title, that has a single run of another sweep; raises InvalidInput."""
    sweep = Sweep.parse(document, ACCEPTED)
    if {*coordinates} < {axis.name for axis in sweep.axes}:  # a run that screens the models
        cure = "submit a sweep with these parameters"
        raise InvalidInput([Finding("run", id, "a run at a point of the axes of its sweep", cure)])
    single = replace(sweep.of_point(coordinates), title=title).document()
    expanded = expanded_sweep(Sweep.parse(single, SweepLimits(max_runs)))
    if expanded.points[0].run_id != id:
        cure = "submit its sweep again: results of different versions stay separate"
        raise InvalidInput([Finding("run", id, "a run of this version of the physics", cure)])
    return expanded


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


def drawn_material(name: str) -> list[tuple[str, str]]:
    """The pictures of a material that ships, each with its title, as images."""
    from service.pages.material import drawings
    from studies import materials
    from studies.reports.drawing.images import as_image

    return [(title, as_image(drawing)) for title, drawing in drawings(materials.load(name))]


def flow_stresses() -> dict[str, list[tuple[float, float]]]:
    """The flow stress (Pa) of each material that ships against plastic strain, at ``material.MIDDLE``."""
    from service.pages.material import MIDDLE, STRAINS, flow_stress
    from studies import materials

    curves = {name: flow_stress(materials.load(name), MIDDLE, 0.0) for name in materials.names()}
    return {
        name: [(float(strain), float(at)) for strain, at in zip(STRAINS[::10], stress[::10], strict=True)]
        for name, stress in curves.items()
    }


def drawn_end(sections: str, scenario: str, parameters: Mapping[str, Value], lengths: Mapping[str, float]) -> str:
    """The section of a run at its end as SVG, from the file of its sections; empty where it has no end."""
    from studies import scenarios
    from studies.pictures.shown import picture_of_end
    from studies.reports.drawing.images import as_files
    from studies.reports.drawing.sections import Gallery
    from studies.sections.section import read_sections

    outline = scenarios.load(scenario).parameters.outline(parameters)
    sign = outline.upward if outline else 1.0
    file, diameter = Path(sections), float(parameters.get("projectile_diameter") or "nan")
    picture = picture_of_end(read_sections(file), lengths, diameter=diameter, sign=sign)
    return next(as_files(Gallery({0: file}).picture(0, picture, full=True)), "") if picture else ""


def drawn_chart(chart: Chart) -> str:
    """A line chart of a live page as SVG."""
    from studies.reports.drawing.charts import lines
    from studies.reports.drawing.images import as_files

    [svg] = as_files(lines(chart.title, chart.x, chart.y, chart.lines))
    return svg
