"""The list of sweeps, and a sweep: its grid of runs as they end, its report, and what may be done with it."""

import json
import secrets
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Literal
from urllib.parse import urlencode

from fastapi import APIRouter, Depends, Query, Request, Response
from fastapi.responses import HTMLResponse, RedirectResponse
from starlette.concurrency import run_in_threadpool

from service.api.access import Caller, Reader, Submitter
from service.api.browsers import FormFields, check_token
from service.api.dependencies import (
    AppArtifacts,
    AppSettings,
    AppStore,
    LocalArtifacts,
    SweepId,
    in_child,
    submit,
    submitting,
)
from service.api.downloads import bring_back
from service.api.routes import sweeps
from service.api.schemas import SweepModel
from service.files.artifacts import Artifacts
from service.pages.browsers import idempotency_of
from service.pages.charts import Chart
from service.pages.computed import FurtherValues, longer
from service.pages.grid import GridSheet, chart_of, layout_of, quantities_of, shown_cells
from service.pages.notes import note_on
from service.pages.page_routes import PageRoutes
from service.pages.rendering import SEE_OTHER, drawn, page
from service.records.jobs import USUAL_PRIORITIES, GridCell, Scope, State, Stored, SweepState, SweepStatus
from studies import measurements
from studies.quantities.files import REPORT_JSON
from studies.quantities.parameters import Plain

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)
PAGE = PageRoutes("sweeps", 10, router, (("/", "Sweeps"),))

Order = Literal["cancel", "retry", "delete"]
LONGEST_TEXT = 200  # characters of what is searched for
MOST_PLACE = 10**6  # of a row in a query


@router.get("/")
def show_sweeps(
    request: Request,
    caller: Reader,
    store: AppStore,
    q: Annotated[str, Query(max_length=LONGEST_TEXT)] = "",
    state: Annotated[SweepState | Literal[""], Query()] = "",
    own: Annotated[bool, Query()] = False,
    cursor: Annotated[str | None, Query()] = None,
) -> Response:
    """The sweeps with state, progress and links to their pages, reports and cubes."""
    front = store.sweeps.page_with_files(
        text=q.strip(), state=SweepState(state) if state else None, owner=caller.name if own else None, cursor=cursor
    )
    found = front.sweeps
    asked = {"q": q, "state": str(state), "own": "true" if own else ""}
    return page(
        request,
        "sweeps.html",
        caller,
        sweeps=[SweepModel.of(row, front.files[row.id]) for row in found.items],
        older=urlencode({**_given(asked), "cursor": found.next_cursor}) if found.next_cursor else None,
        asked=asked,
        is_narrowed=bool(_given(asked)),
        states=list(SweepState),
        queue=front,
        events="/v1/queue/events",
    )


def _given(asked: dict[str, str]) -> dict[str, str]:
    return {name: value for name, value in asked.items() if value}


@dataclass(frozen=True)
class ShownSweep:
    """A sweep with the sheet of its grid and the quantity that a query names."""

    status: SweepStatus
    files: Sequence[str]
    document: Mapping[str, Plain]
    sheet: GridSheet
    quantity: str
    cells: Sequence[GridCell]

    @property
    def chart(self) -> Chart:
        return chart_of(self.sheet, self.cells, self.quantity, self.status.scenario)

    def query(self) -> dict[str, str | int]:
        return {"quantity": self.quantity, "sheet": self.sheet.word, "row": self.sheet.first}


def _shown(
    id: SweepId,
    _: Reader,
    store: AppStore,
    quantity: Annotated[str, Query(max_length=LONGEST_TEXT)] = "",
    sheet: Annotated[str, Query(max_length=LONGEST_TEXT)] = "",
    row: Annotated[int, Query(ge=0, le=MOST_PLACE)] = 0,
) -> ShownSweep:
    status, names = store.sweeps.get_with_files(id)
    document = store.sweeps.document(id)
    shown = GridSheet.read(layout_of(document, status.planned), sheet, row)
    quantities = quantities_of(status.scenario)
    name = quantity if quantity in quantities else quantities[0]
    ordinals = [*shown.beside, *(ordinal for each in shown.ordinals for ordinal in each)]
    return ShownSweep(status, names, document, shown, name, store.sweeps.cells(id, ordinals, name))


@router.get("/sweeps/{id}/chart")
async def show_chart(request: Request, shown: Annotated[ShownSweep, Depends(_shown)]) -> Response:
    """The quantity over an axis of the sweep, as far as it is measured: SVG."""
    return await drawn(request, shown.chart)


async def _report(request: Request, shown: Annotated[ShownSweep, Depends(_shown)], store: AppStore) -> Stored | None:
    """The report of a sweep, brought back from a bucket; None without one."""
    if REPORT_JSON not in shown.files:
        return None
    _, report = await run_in_threadpool(store.sweeps.get_with_file, shown.status.id, REPORT_JSON)
    if report is not None:
        await bring_back(request, report)
    return report


@router.get("/sweeps/{id}")
def show_sweep(
    request: Request,
    shown: Annotated[ShownSweep, Depends(_shown)],
    report: Annotated[Stored | None, Depends(_report)],
    caller: Reader,
    artifacts: LocalArtifacts,
) -> Response:
    """A sweep with its grid of runs, its report, and what the caller may do with it."""
    status, names = shown.status, shown.files
    sweep = SweepModel.of(status, names)
    quantities = quantities_of(status.scenario)
    return page(
        request,
        "sweep.html",
        caller,
        sweep=sweep,
        headline=_headline(artifacts, report),
        orders=_orders(caller, status),
        document=shown.document,
        sheet=shown.sheet,
        cells=shown_cells(shown.cells, measurements.load(shown.quantity), status.scenario),
        quantity=measurements.load(shown.quantity),
        quantities=[measurements.load(each) for each in quantities],
        chart=shown.chart.image(f"/sweeps/{status.id}/chart", shown.query()),
        note=note.of_sweep(shown.document) if (note := note_on(shown.quantity)) else "",
        once=secrets.token_urlsafe(),
        may_add=bool(shown.sheet.layout.dimensions) and caller.may(Scope.SUBMIT),
        link=lambda **changes: "?" + urlencode({**shown.query(), **changes}),
        events=None if status.is_terminal else sweep.links["events"],
    )


def _orders(caller: Caller, sweep: SweepStatus) -> list[Order]:
    """The orders that a caller may give for a sweep in its present state."""
    if not caller.may(Scope.SUBMIT) or not caller.owns(sweep):
        return []
    if not sweep.is_terminal:
        return [] if sweep.state is SweepState.CANCELLING else ["cancel"]
    is_whole = sweep.state == SweepState.SUCCEEDED and not sweep.counts[State.FAILED]
    orders: list[Order] = [] if is_whole else ["retry"]
    return orders if sweep.pinned else [*orders, "delete"]


@router.post("/sweeps/{id}/values", name="add points", dependencies=[Depends(check_token)])
async def add_values(
    request: Request, id: SweepId, caller: Submitter, form: FormFields, store: AppStore, settings: AppSettings
) -> Response:
    """Submit a sweep with further values on an axis, and show it; what was computed is not computed again."""
    status, document = await run_in_threadpool(lambda: (store.sweeps.get(id), store.sweeps.document(id)))
    axis, values = form.get("axis", ""), form.get("values", "")
    further = FurtherValues(document, axis, values, settings.max_runs)
    once = idempotency_of(form, id, axis, values)
    priority = status.priority if caller.may(Scope.ADMIN) else max(status.priority, USUAL_PRIORITIES[0])
    async with submitting(request):
        stored = await submit(request, await in_child(request, longer, further), priority, status.keep, once)
    return RedirectResponse(f"/sweeps/{stored.id}", SEE_OTHER)


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
    if report is None or not artifacts.may_be_shown(report):
        return ""
    return _headline_of(artifacts, report)


@lru_cache(maxsize=256)
def _headline_of(artifacts: Artifacts, report: Stored) -> str:
    """The headline of a report, which has megabytes; its record has the digest of its content."""
    return str(json.loads(artifacts.path(report).read_bytes()).get("headline", ""))
