"""Forms that ask laws and measured shots about one shot, with the answer below: of plates and blocks, and of features.

A page of them has its own path, fields and example; its template imports ``question.html``.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlencode

from fastapi import Request, Response
from fastapi.responses import HTMLResponse

from service.api.access import Caller, Reader
from service.api.dependencies import in_child
from service.pages.computed import AnsweredForm, answered_form
from service.pages.fields import field_of, placed
from service.records.jobs import KEY_VARIABLE, Scope
from studies import materials, scenarios
from studies.answers.question import shot_parameters
from studies.answers.targets import meant
from studies.quantities.findings import InvalidInput
from studies.quantities.parameters import declared

# The sheet has its styles inside, and runs and loads nothing.
SHEET_POLICY = "default-src 'none'; style-src 'unsafe-inline'; frame-ancestors 'none'; base-uri 'none'"


def simulated(fields: Mapping[str, str]) -> str:
    """The address of the form that simulates a shot at a plate or a block."""
    table = meant(fields).table
    if table is None:
        return ""
    known = declared(scenarios.load(table[1]).parameters)
    given = {name: text for name, text in fields.items() if name in known}
    if "projectile_length" in given:
        given["projectile_shape"] = "cylinder"
    return f"/new/{table[1]}?{urlencode(given)}"


@dataclass(frozen=True)
class AskedPage:
    """A page with such a form."""

    path: str
    first: tuple[str, ...]  # fields that always stand there
    others: tuple[str, ...]  # fields that are folded away
    more: str  # what these are about
    example: Callable[[], Mapping[str, str]]  # the fields without any in the address
    simulation: Callable[[Mapping[str, str]], str] = simulated  # the address of a form; empty where there is none

    def fields(self, request: Request) -> Mapping[str, str]:
        """The fields of the form in the address; without any, those of the example."""
        known = {*self.first, *self.others}
        given = {name: text.strip() for name, text in request.query_params.items() if name in known}
        return {name: text for name, text in given.items() if text} or self.example()

    async def answer(self, request: Request, _: Reader) -> AnsweredForm:
        """What laws and shots say; a dependency of the page."""
        return await in_child(request, answered_form, self.fields(request))

    async def sheet(self, request: Request, caller: Reader) -> Response:
        """The answer on one sheet of A4, to print or to keep; an endpoint. Raises InvalidInput."""
        answer = await self.answer(request, caller)
        if answer.findings:
            raise InvalidInput(answer.findings)
        return HTMLResponse(answer.sheet, headers={"Content-Security-Policy": SHEET_POLICY})

    def content(self, request: Request, caller: Caller, answer: AnsweredForm) -> dict[str, Any]:
        """What the template of a form and its answer takes."""
        parameters, fields = shot_parameters(), self.fields(request)
        first, others = ([field_of(parameters[name]) for name in names] for names in (self.first, self.others))
        return {
            "asked": self,
            "first": first,
            "others": others,
            "values": fields,
            "findings": placed(answer.findings, {*self.first, *self.others}),
            "answer": answer,
            "is_example": fields == self.example(),
            "names": materials.names(),
            "query": urlencode(fields),
            "simulation": self.simulation(fields) if caller.may(Scope.SUBMIT) else "",
            "address": str(request.base_url).rstrip("/"),
            "key_variable": KEY_VARIABLE if caller.name else "",
        }
