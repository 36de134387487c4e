"""Shields: what laws and shots say of one, as a form and its answer; the shots; what stands beside walls that hold."""

import math
from collections.abc import Mapping
from functools import cache
from itertools import islice
from typing import Annotated
from urllib.parse import urlencode

from fastapi import APIRouter, Depends, Query, Request, Response

from service.api.access import Reader
from service.pages.computed import AnsweredForm
from service.pages.notes import OutcomeNote
from service.pages.page_routes import PageRoutes
from service.pages.questions import AskedPage
from service.pages.rendering import page, rendered
from studies.answers.question import shot_parameters
from studies.quantities.display import printed_in, with_unit
from studies.quantities.numerical_defaults import NO_FAILURE
from studies.quantities.parameters import Plain, Value, declared
from studies.shields.answered import PLATE
from studies.shields.answered import TARGET as SHIELD
from studies.shields.shield import WALL_PERFORATED
from studies.shields.shots.drawn import FAST, failures_found
from studies.shields.shots.table import OUTCOMES, ShieldShot, citation, filtered, published, read_filters
from studies.sweeps.document import read_yaml

router = APIRouter(include_in_schema=False)
PAGE = PageRoutes("shields", 30, router, (("/shields", "Shields"),))

TEMPLATE = "service.shields.pages:walls.txt"
SHOWN = 100  # shots on shields on one page
# Columns of shots on shields, and those by which they are chosen.
COLUMNS = (
    *("outcome", "speed", "obliquity", "projectile_diameter", "bumper_thickness", "stand_off", "wall_thickness"),
    *("wall_yield_stress", "projectile", "bumper", "wall", "source", "shot"),
)
FILTERS = ("outcome", "speed", "projectile_diameter", "bumper_thickness", "wall_thickness", "source")


@cache
def _example() -> Mapping[str, str]:
    """The shield that ships."""
    assert SHIELD.example is not None
    document = read_yaml(SHIELD.example.read_text(encoding="utf-8"), SHIELD.example.name)
    return {name: str(value) for name, value in document.items()}


def _simulation(fields: Mapping[str, str]) -> str:
    """The address of the form that simulates a shield; empty for another target."""
    if "bumper" not in fields:
        return ""
    given = {"wall": fields["bumper"], **fields}
    if "projectile_length" in given:
        given["projectile_shape"] = "cylinder"
    given.pop("wall_yield_stress", None)  # a run has the strength of its materials
    return "/new/whipple_shield?" + urlencode(given)


ALWAYS = (
    *("speed", "obliquity", "projectile", "projectile_diameter", "bumper", "bumper_thickness", "stand_off", "wall"),
    "wall_thickness",
)
ASKED = AskedPage(
    path="/shields",
    first=ALWAYS,
    others=tuple(name for name in shot_parameters() if name not in (*ALWAYS, *PLATE)),
    more="Further bumpers, cylinder, yield stress of the wall",
    example=_example,
    simulation=_simulation,
)


router.get("/shields/sheet")(ASKED.sheet)


@router.get("/shields")
def show_shield(request: Request, caller: Reader, answer: Annotated[AnsweredForm, Depends(ASKED.answer)]) -> Response:
    """The form of a shield, and what laws and shots say of it."""
    content = ASKED.content(request, caller, answer)
    shots, held = len(published().shots), beside_held(NO_FAILURE, FAST)
    return page(request, "service.shields.pages:shields.html", caller, shots=shots, beside_held=held, **content)


@router.get("/shots/shields")
def show_shield_shots(request: Request, caller: Reader, begin: Annotated[int, Query(ge=0)] = 0) -> Response:
    """Measured shots on shields, those that the address chooses."""
    chosen = {name: text for name in FILTERS if (text := request.query_params.get(name, "").strip())}
    within = read_filters([f"{name}={text}" for name, text in chosen.items()])
    found = filtered(every := published().shots, *within)
    fields = declared(ShieldShot)
    units = {name: fields[name].unit for name in COLUMNS}
    rows = [
        [(name, _cell(getattr(shot, name), unit)) for name, unit in units.items()]
        for shot in islice(found, begin, begin + SHOWN)
    ]
    return page(
        request,
        "service.shields.pages:shots.html",
        caller,
        columns=[with_unit(name.replace("_", " "), unit) for name, unit in units.items()],
        rows=rows,
        found=found,
        begin=begin,
        shown=SHOWN,
        chosen=chosen,
        filters=FILTERS,
        choices={"outcome": OUTCOMES, "source": sorted({shot.source for shot in every})},
        following=str(request.url.include_query_params(begin=begin + SHOWN).query),
        citation=citation,
    )


def _cell(value: Value, unit: str | None) -> str:
    """A number in the unit of its column."""
    return str(value) if unit is None or isinstance(value, str) else printed_in(value, unit)


def beside_held(failure: str, normal_speed: float) -> str:
    """What stands beside a wall that holds."""
    return rendered(TEMPLATE, found=failures_found(failure, normal_speed))


def _of_run(value: float, parameters: Mapping[str, Value]) -> str:
    if value:
        return ""
    normal_speed = float(parameters["speed"] or 0.0) * math.cos(float(parameters.get("obliquity") or 0.0))
    return beside_held(str(parameters.get("failure")), normal_speed)


def _of_sweep(document: Mapping[str, Plain]) -> str:
    """By the failures of the runs."""
    axes, fixed = document.get("axes"), document.get("fixed")
    failures = axes.get("failure") if isinstance(axes, Mapping) else None
    if not isinstance(failures, list):
        failures = [fixed.get("failure") if isinstance(fixed, Mapping) else None]
    found = {name: failures_found(name, FAST) for name in (str(failure or NO_FAILURE) for failure in failures)}
    return rendered(TEMPLATE, found=found, fast=FAST / 1e3)


NOTE = OutcomeNote(WALL_PERFORATED, _of_run, _of_sweep)
