"""What published laws and measured shots say of one shield, at once: a form, and the answer of a child process."""

from collections.abc import Mapping
from functools import cache
from typing import Annotated
from urllib.parse import urlencode

from fastapi import APIRouter, Depends, Request, Response
from fastapi.responses import HTMLResponse

from service.api.access import Reader
from service.api.pages.fields import field_of, placed
from service.api.pages.rendering import page
from service.api.reading import AnsweredForm, answered_form
from service.api.routes.dependencies import read_content
from service.records.jobs import KEY_VARIABLE
from studies import materials
from studies.answers.question import shot_parameters
from studies.quantities.findings import InvalidInput
from studies.quantities.numerical_defaults import NO_FAILURE
from studies.shields.answered import PLATE
from studies.shields.answered import TARGET as SHIELD
from studies.shields.shots.drawn import FAST, beside_held, failures_found
from studies.shields.shots.table import published
from studies.sweeps.document import read_yaml

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

# The sheet has its styles inside, and runs and loads nothing.
SHEET_POLICY = "default-src 'none'; style-src 'unsafe-inline'; frame-ancestors 'none'; base-uri 'none'"
ALWAYS = (
    *("speed", "obliquity", "projectile", "projectile_diameter", "bumper", "bumper_thickness", "stand_off", "wall"),
    "wall_thickness",
)


@cache
def _example() -> Mapping[str, str]:
    """The shield that ships."""
    assert SHIELD.example is not None
    document = read_yaml(SHIELD.example.read_text(encoding="utf-8"), SHIELD.example.name)
    return {name: str(value) for name, value in document.items()}


def _fields(request: Request) -> Mapping[str, str]:
    """The fields of a form in the address; without any, those of the shield that ships."""
    known = shot_parameters()
    given = {name: text.strip() for name, text in request.query_params.items() if name in known}
    return {name: text for name, text in given.items() if text} or _example()


ShieldFields = Annotated[Mapping[str, str], Depends(_fields)]


async def _answer(request: Request, fields: ShieldFields, _: Reader) -> AnsweredForm:
    return await read_content(request, fields, answered_form)


AnswerToForm = Annotated[AnsweredForm, Depends(_answer)]


@router.get("/shields")
def show_shield(request: Request, caller: Reader, fields: ShieldFields, answer: AnswerToForm) -> Response:
    """The form of a shield, and what laws and shots say of it."""
    every = {name: field_of(each) for name, each in shot_parameters().items() if name not in PLATE}
    return page(
        request,
        "shields.html",
        caller,
        first=[every[name] for name in ALWAYS],
        others=[each for name, each in every.items() if name not in ALWAYS],
        values=fields,
        findings=placed(answer.findings, every),
        answer=answer,
        is_example=fields == _example(),
        names=materials.names(),
        shots=len(published().shots),
        query=urlencode(fields),
        simulation=_simulation(fields),
        beside_held=beside_held(failures_found(NO_FAILURE, FAST)),
        address=str(request.base_url).rstrip("/"),
        key_variable=KEY_VARIABLE if caller.name else "",
    )


def _simulation(fields: Mapping[str, str]) -> str:
    """The address of the form that simulates a shield; empty for another target."""
    if "bumper" not in fields:
        return ""
    given = {"wall": fields["bumper"], **fields}
    if "projectile_length" in given:
        given["projectile_shape"] = "cylinder"
    given.pop("wall_yield_stress", None)  # a run has the strength of its materials
    return "/new/whipple_shield?" + urlencode(given)


@router.get("/shields/sheet")
def show_sheet(answer: AnswerToForm) -> Response:
    """The answer on one sheet of A4, to print or to keep; raises InvalidInput."""
    if answer.findings:
        raise InvalidInput(answer.findings)
    return HTMLResponse(answer.sheet, headers={"Content-Security-Policy": SHEET_POLICY})
