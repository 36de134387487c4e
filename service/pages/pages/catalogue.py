"""The catalogue as pages: scenarios, laws with their formulas, materials with their curves, and measured shots."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import takewhile
from typing import Annotated

from fastapi import APIRouter, Depends, Request, Response
from markupsafe import Markup, escape

from service.api.access import Reader
from service.api.dependencies import in_child
from service.pages.computed import AnsweredForm, drawn_material, flow_stresses
from service.pages.page_routes import PageRoutes
from service.pages.questions import AskedPage
from service.pages.rendering import as_svg, page
from service.pages.sparks import Spark, spark, spark_of_table, within
from service.records.jobs import NotFound
from studies import laws, materials, measurements, observations, scenarios
from studies.laws import NOT_FOUND, Law, Limit, limit_in_latex
from studies.materials import CONFIDENCES, Material
from studies.observations.table import rows_of
from studies.observations.tables import further_tables
from studies.quantities.display import display_alone
from studies.quantities.parameters import declared

router = APIRouter(include_in_schema=False)
LINKS = (("/scenarios", "Scenarios"), ("/laws", "Laws"), ("/materials", "Materials"), ("/shots", "Shots"))
PAGE = PageRoutes("catalogue", 40, router, LINKS)

Drawings = list[tuple[str, str]]  # titles and images
DRAWN: dict[str, Drawings] = {}  # by material
FLOW_STRESSES: dict[str, Spark] = {}  # by material
STRONGEST = 1.5e9  # Pa: where the pictures of flow stresses end
# Colours of the drawings of scenarios.
DRAWING_STYLE = (
    "<style>path,circle{stroke-linejoin:round}.matter{fill:#9db2c4}.hitting{fill:#b36b00}.paper,.grid,.text,.crack,"
    ".flight,.measured{fill:none;stroke:#777;stroke-width:1.5}.flight{stroke:#1a1a1a}.measured,.crack{stroke:#a3003c}"
    "@media(prefers-color-scheme:dark){.matter{fill:#55697b}.hitting{fill:#ffb347}.flight{stroke:#e8e8e6}"
    ".measured,.crack{stroke:#ff7aa5}}</style>"
)
SECTIONS: Mapping[str, str] = {
    "": "At rest",
    "elastic": "Elasticity",
    "eos": "Equation of state",
    "thermal": "Heat",
    "strength": "Strength",
    "tension": "Tension",
    "fracture": "Fracture of Johnson and Cook",
    "spall": "Spall",
    "yield_stresses": "Yield stresses, for laws",
}


def shown(value: float, unit: str | None) -> str:
    """A number with all of its digits, in the unit that people read.

    >>> shown(74217892800.0, "Pa"), shown(1.4, "1"), shown(896.0, "J kg-1 K-1")
    ('74.2178928 GPa', '1.4', '896 J kg⁻¹ K⁻¹')
    """
    display = display_alone(value, unit)
    return f"{value * display.factor:.12g} {display.unit}".rstrip()


@lru_cache(maxsize=512)
def typeset(text: str) -> Markup:
    """Text as HTML, what stands between its dollar signs as MathML; raises where LaTeX cannot be read.

    >>> print(typeset("$D$ <= 2 m"))
    <math xmlns="http://www.w3.org/1998/Math/MathML" display="inline"><mrow><mi>D</mi></mrow></math> &lt;= 2 m
    """
    from latex2mathml.converter import convert  # here, because it takes 0.08 s, and most processes show no page

    parts = enumerate(text.split("$"))
    return Markup("").join(Markup(convert(part)) if place % 2 else escape(part) for place, part in parts)


@router.get("/scenarios")
def show_scenarios(request: Request, caller: Reader) -> Response:
    """Every scenario with its parameters and what it measures."""
    listed = sorted(map(scenarios.load, scenarios.names()), key=lambda scenario: scenario.place)
    titles = {name: measurements.load(name).title for scenario in listed for name in scenario.measurements}
    return page(
        request,
        "scenarios.html",
        caller,
        scenarios=[(scenario, declared(scenario.parameters).values()) for scenario in listed],
        titles=titles,
        shown=shown,
    )


@router.get("/scenarios/{name}.svg")
def show_drawing(name: str, _: Reader) -> Response:
    """The small drawing of a scenario, with colours that hold in light and dark."""
    text = scenarios.load(name).drawing
    if not text:
        raise NotFound("drawing", name)
    return as_svg(text.replace(">", f">{DRAWING_STYLE}", 1))


# A sphere on a plate: the fields of a plate or a block, which has no thickness.
EXAMPLE = {
    "speed": "6 km/s",
    "projectile": "al-2017-t4",
    "projectile_diameter": "10 mm",
    "target": "al-6061-t6",
    "plate_thickness": "4 mm",
}
ASKED = AskedPage("/laws", tuple(EXAMPLE), ("obliquity", "projectile_length"), "Obliquity, cylinder", lambda: EXAMPLE)


router.get("/laws/sheet")(ASKED.sheet)


@router.get("/laws")
def show_laws(request: Request, caller: Reader, answer: Annotated[AnsweredForm, Depends(ASKED.answer)]) -> Response:
    """What laws and shots say of a plate or a block, and every law with formula, range and source, by quantity."""
    every = [laws.load(name) for name in laws.names()]
    answered = {law.quantity for law in every}
    measured = sorted(answered - {*laws.unmeasured()}, reverse=True)
    titles = {name: measurements.load(name).title for name in measured}
    titles |= {name: title for name, title in laws.unmeasured().items() if name in answered}
    return page(
        request,
        "laws.html",
        caller,
        quantities=[(name, title, laws.answering(name)) for name, title in titles.items()],
        typeset=typeset,
        limit=_limit,
        confidences=CONFIDENCES,
        **ASKED.content(request, caller, answer),
    )


def _limit(law: Law, limit: Limit) -> Markup:
    """A limit of a law's range, with its source where that is another one than the law's."""
    is_own = limit.source in law.source or (not limit.is_published and limit.source != NOT_FOUND)
    notes = [*([] if is_own else [limit.source]), *([] if limit.machine_checked else ["not checked"])]
    return typeset(limit_in_latex(limit)) + (f" ({', '.join(notes)})" if notes else "")


async def _flow_stresses(request: Request, _: Reader) -> dict[str, Spark]:
    """The flow stresses of the materials on one scale, made once by a child process."""
    if not FLOW_STRESSES:
        for name, curve in (await in_child(request, flow_stresses)).items():
            if all(math.isfinite(stress) for _, stress in curve):
                cut = ((strain, min(stress, STRONGEST)) for strain, stress in curve)
                points = tuple(within(point, (0.0, 0.0), (1.0, STRONGEST)) for point in cut)
                FLOW_STRESSES[name] = Spark(f"Flow stress of {materials.load(name).title}", points)
    return FLOW_STRESSES


@router.get("/materials")
def show_materials(
    request: Request, caller: Reader, sparks: Annotated[dict[str, Spark], Depends(_flow_stresses)]
) -> Response:
    """Every material that ships, with its models."""
    listed = [materials.load(name) for name in materials.names()]
    return page(request, "materials.html", caller, materials=listed, shown=shown, sparks=sparks)


async def _drawings(name: str, request: Request, _: Reader) -> Drawings:
    """The pictures of a material, made once by a child process."""
    if materials.load(name).name not in DRAWN:
        DRAWN[name] = await in_child(request, drawn_material, name)
    return DRAWN[name]


@router.get("/materials/{name}")
def show_material(
    request: Request, name: str, caller: Reader, drawings: Annotated[Drawings, Depends(_drawings)]
) -> Response:
    """A material: every constant with its source, its Hugoniot and its flow stress."""
    material = materials.load(name)
    return page(
        request,
        "material.html",
        caller,
        material=material,
        sections=[*_sections(material)],
        drawings=drawings,
        confidences=CONFIDENCES,
    )


@dataclass(frozen=True)
class ShownConstant:
    """A constant of a material as a page shows it."""

    name: str
    meaning: str
    value: str
    source: str
    confidence: str


def _sections(material: Material) -> Iterator[tuple[str, str, list[ShownConstant]]]:
    """Title, model and constants of each section that has any."""
    parameters = material.parameters
    for section, title in SECTIONS.items():
        rows = []
        for path, constant in material.sources.items():
            inside, _, name = path.partition(".") if "." in path else ("", "", path)
            if inside == section:
                meaning = parameters[path].meaning if path in parameters else "stated, and not used"
                value = "none" if constant.value is None else shown(constant.value, constant.unit)
                is_yield = section == "yield_stresses"
                rows.append(
                    ShownConstant(name, "" if is_yield else meaning, value, constant.source, constant.confidence)
                )
        if rows:
            yield title, getattr(getattr(material, section, None), "kind", ""), rows


@router.get("/shots")
def show_tables(request: Request, caller: Reader) -> Response:
    """The tables of measured shots that ship."""
    tables = [
        (table.name, table.address, table.remark, table.count(), spark(*table.points()) if table.points else None)
        for table in further_tables()
    ]
    for name in observations.names():
        rows = [row for _, row in rows_of(observations.text(name), name)]
        tables.append((name, f"/shots/{name}", _remark(name), len(rows), spark_of_table(rows)))
    return page(request, "shots.html", caller, tables=tables)


def _remark(table: str) -> str:
    """The remarks before a table, which say what it is."""
    lines = takewhile(lambda line: line.startswith("#"), observations.text(table).splitlines())
    return " ".join(line.removeprefix("#").strip() for line in lines)


@router.get("/shots/{table}")
def show_shots(request: Request, table: str, caller: Reader) -> Response:
    """A table of measured shots, as it ships."""
    rows = [row for _, row in rows_of(observations.text(table), table)]
    remark, picture, columns = _remark(table), spark_of_table(rows), [*rows[0]]
    return page(
        request, "shot_table.html", caller, table=table, remark=remark, rows=rows, columns=columns, picture=picture
    )
