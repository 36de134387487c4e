"""The list of sweeps, and a sweep with its orders."""

from typing import Annotated, Literal

from fastapi import APIRouter, Depends, Query, Request, Response
from fastapi.responses import HTMLResponse, RedirectResponse

from service.api.access import Caller, Reader, Submitter
from service.api.browsers import check_token
from service.api.pages.rendering import SEE_OTHER, page
from service.api.routes import sweeps
from service.api.routes.dependencies import AppArtifacts, AppSettings, AppStore, SweepId
from service.api.schemas import SweepModel
from service.files.artifacts import Artifacts
from service.records.jobs import Scope, Stored, SweepState, SweepStatus
from studies.quantities.files import REPORT_JSON

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

Order = Literal["cancel", "retry", "delete"]


@router.get("/")
def show_sweeps(
    request: Request, caller: Reader, store: AppStore, cursor: Annotated[str | None, Query()] = None
) -> Response:
    """The sweeps with state, progress and links to report and cube."""
    front = store.sweeps.page_with_files(cursor=cursor)
    found = front.sweeps
    return page(
        request,
        "sweeps.html",
        caller,
        sweeps=[SweepModel.of(row, front.files[row.id]) for row in found.items],
        next_cursor=found.next_cursor,
        queue=front,
        events="/v1/queue/events",
    )


@router.get("/sweeps/{id}")
def show_sweep(request: Request, id: SweepId, caller: Reader, store: AppStore, artifacts: AppArtifacts) -> Response:
    """A sweep with the headline of its report, and what the caller may do with it."""
    row, names = store.sweeps.get_with_files(id)
    _, report = store.sweeps.get_with_file(id, REPORT_JSON)
    sweep = SweepModel.of(row, names)
    return page(
        request,
        "sweep.html",
        caller,
        sweep=sweep,
        headline=_headline(artifacts, report),
        orders=_orders(caller, row),
        events=None if row.is_terminal else sweep.links["events"],
    )


def _orders(caller: Caller, sweep: SweepStatus) -> list[Order]:
    """The orders that a caller may give for a sweep in its present state."""
    if not caller.may(Scope.SUBMIT) or not caller.owns(sweep):
        return []
    if not sweep.is_terminal:
        return ["cancel"]
    return ["delete"] if sweep.state == SweepState.SUCCEEDED else ["retry", "delete"]


@router.post("/sweeps/{id}/{order}", dependencies=[Depends(check_token)])
def carry_out(
    id: SweepId, order: Order, caller: Submitter, store: AppStore, settings: AppSettings, artifacts: AppArtifacts
) -> Response:
    """Carry out an order of the page of a sweep, and show the page again; of a deleted one, the list."""
    if order == "delete":
        sweeps.delete_sweep(id, caller, store)
        return RedirectResponse("/", SEE_OTHER)
    if order == "cancel":
        sweeps.cancel_sweep(id, caller, store)
    else:
        sweeps.retry_sweep(id, caller, store, settings, artifacts)
    return RedirectResponse(f"/sweeps/{id}", SEE_OTHER)


def _headline(artifacts: Artifacts, report: Stored | None) -> str:
    """The headline of a report; empty without a report, or in one of an early version."""
    if report is None or not artifacts.is_there(report):
        return ""
    return str(artifacts.read_json(report).get("headline", ""))
