"""The catalogue as pages: scenarios, laws with their formulas, materials with their curves, and measured shots."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query, Request, Response
from fastapi.responses import HTMLResponse
from markupsafe import Markup

from service.api.access import Reader
from service.api.pages.formulas import typeset
from service.api.pages.rendering import page
from service.api.reading import drawn_material
from service.api.routes.dependencies import read_content
from studies import laws, materials, measurements, observations, scenarios
from studies.laws import NOT_FOUND, Law, Limit, limit_in_latex
from studies.materials import CONFIDENCES, Material
from studies.observations.table import rows_of
from studies.observations.tables import further_tables
from studies.quantities.display import display_alone, printed_in, with_unit
from studies.quantities.parameters import declared
from studies.shields.shots import table as shield_shots

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

SHOWN = 100  # shots on shields on one page
SHIELDS = "shields"  # the table of shots on shields
# Columns of shots on shields, and those by which they are chosen.
COLUMNS = (
    *("outcome", "speed", "obliquity", "projectile_diameter", "bumper_thickness", "stand_off", "wall_thickness"),
    *("wall_yield_stress", "projectile", "bumper", "wall", "source", "shot"),
)
FILTERS = ("outcome", "speed", "projectile_diameter", "bumper_thickness", "wall_thickness", "source")
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


@router.get("/scenarios")
def show_scenarios(request: Request, caller: Reader) -> Response:
    """Every scenario with its parameters and what it measures."""
    listed = [scenarios.load(name) for name in scenarios.names()]
    titles = {name: measurements.load(name).title for each in listed for name in each.measurements}
    return page(
        request,
        "scenarios.html",
        caller,
        scenarios=[(each, declared(each.parameters).values()) for each in listed],
        titles=titles,
        shown=shown,
    )


@router.get("/laws")
def show_laws(request: Request, caller: Reader) -> Response:
    """Every law with its formula, range and source, by what it predicts."""
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
    )


def _limit(law: Law, limit: Limit) -> Markup:
    """A limit of a law's range, with its source where that is another one than the law's."""
    is_own = limit.source in law.source or (not limit.is_published and limit.source != NOT_FOUND)
    notes = [*([] if is_own else [limit.source]), *([] if limit.machine_checked else ["not checked"])]
    return typeset(limit_in_latex(limit)) + (f" ({', '.join(notes)})" if notes else "")


@router.get("/materials")
def show_materials(request: Request, caller: Reader) -> Response:
    """Every material that ships, with its models."""
    listed = [materials.load(name) for name in materials.names()]
    return page(request, "materials.html", caller, materials=listed, shown=shown)


async def _drawings(name: str, request: Request, _: Reader) -> list[Any]:
    """The pictures of a material, made once by a child process."""
    kept: dict[str, list[Any]] = request.app.state.drawings
    if materials.load(name).name not in kept:
        kept[name] = await read_content(request, {"name": name}, drawn_material)
    return kept[name]


@router.get("/materials/{name}")
def show_material(
    request: Request, name: str, caller: Reader, drawings: Annotated[list[Any], Depends(_drawings)]
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
    parameters = material.parameters()
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
    tables = [(each.name, each.address, each.remark, each.count()) for each in further_tables()]
    for name in observations.names():
        tables.append((name, f"/shots/{name}", _remark(name), len(rows_of(observations.text(name), name))))
    return page(request, "shots.html", caller, tables=tables)


def _remark(table: str) -> str:
    """The remarks before a table, which say what it is."""
    lines = observations.text(table).splitlines()
    return " ".join(
        line.removeprefix("#").strip()
        for line in lines[: next(n for n, line in enumerate(lines) if not line.startswith("#"))]
    )


@router.get(f"/shots/{SHIELDS}")
def show_shield_shots(request: Request, caller: Reader, begin: Annotated[int, Query(ge=0)] = 0) -> Response:
    """Measured shots on shields, those that the address chooses."""
    chosen = {name: text for name in FILTERS if (text := request.query_params.get(name, "").strip())}
    within = shield_shots.read_filters([f"{name}={text}" for name, text in chosen.items()])
    found = shield_shots.filtered(published := shield_shots.published().shots, *within)
    fields = declared(shield_shots.ShieldShot)
    units = {name: fields[name].unit for name in COLUMNS}
    rows = [
        [(name, _cell(getattr(each, name), unit)) for name, unit in units.items()]
        for each in islice(found, begin, begin + SHOWN)
    ]
    return page(
        request,
        "shield_shots.html",
        caller,
        columns=[_heading(name.replace("_", " "), unit) for name, unit in units.items()],
        rows=rows,
        found=found,
        begin=begin,
        shown=SHOWN,
        chosen=chosen,
        filters=FILTERS,
        choices={"outcome": shield_shots.OUTCOMES, "source": sorted({shot.source for shot in published})},
        following=str(request.url.include_query_params(begin=begin + SHOWN).query),
        citation=shield_shots.citation,
    )


def _heading(name: str, unit: str | None) -> str:
    return f"{name} (deg)" if unit == "rad" else with_unit(name, unit)


def _cell(value: Any, unit: str | None) -> str:
    """A number in the unit of its column; people read angles in degrees."""
    if unit == "rad":
        return f"{math.degrees(value):.4g}"
    return printed_in(value, unit) if unit else str(value)


@router.get("/shots/{table}")
def show_shots(request: Request, table: str, caller: Reader) -> Response:
    """A table of measured shots, as it ships."""
    rows = [row for _, row in rows_of(observations.text(table), table)]
    return page(request, "shot_table.html", caller, table=table, remark=_remark(table), rows=rows, columns=[*rows[0]])
