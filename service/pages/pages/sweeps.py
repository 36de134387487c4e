"""A sweep: the answer of its report, its grid of runs as they end, and what may be done with it."""

import secrets
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal
from urllib.parse import urlencode

from fastapi import APIRouter, Depends, Query, Request, Response
from fastapi.responses import RedirectResponse
from starlette.concurrency import run_in_threadpool

from service.api.access import Caller, Reader, Submitter
from service.api.browsers import FormFields, check_token
from service.api.dependencies import AppArtifacts, AppSettings, AppStore, SweepId, in_child, submit, submitting
from service.api.routes import sweeps
from service.api.schemas import SweepModel
from service.pages.charts import Chart
from service.pages.computed import longer
from service.pages.covers import CoverOfSweep
from service.pages.differing import parts_of
from service.pages.grid import GridSheet, chart_of, quantities_of, sheet_of, shown_cells
from service.pages.notes import note_on
from service.pages.page_routes import PageRoutes
from service.pages.rendering import LONGEST_TEXT, MOST_PLACE, SEE_OTHER, as_svg, drawn, idempotency_of, page
from service.records.jobs import USUAL_PRIORITIES, GridCell, NotFound, Scope, State, SweepState, SweepStatus
from studies import measurements
from studies.quantities.parameters import Plain
from studies.reports.cover import DRAWINGS, drawing

router = APIRouter(include_in_schema=False)
PAGE = PageRoutes("sweeps", 15, router)

Order = Literal["cancel", "retry", "delete"]


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
    shown = sheet_of(document, status.planned, sheet, row)
    quantities = quantities_of(status.scenario)
    name = quantity if quantity in quantities else quantities[0]
    ordinals = [*shown.beside, *(ordinal for row in shown.ordinals for ordinal in row)]
    return ShownSweep(status, names, document, shown, name, store.sweeps.cells(id, ordinals, name))


@router.get("/sweeps/{id}/chart")
async def show_chart(request: Request, shown: Annotated[ShownSweep, Depends(_shown)]) -> Response:
    """The quantity over an axis of the sweep, as far as it is measured: SVG."""
    return await drawn(request, shown.chart)


@router.get("/sweeps/{id}/cover/{name}")
def show_drawing(name: Literal[DRAWINGS], shown: CoverOfSweep) -> Response:  # type: ignore[valid-type]
    """A drawing of a sweep's report: SVG."""
    if shown is None or name not in shown.cover.drawings:
        raise NotFound("drawing", name)
    return as_svg(drawing(shown.file, name))


@router.get("/sweeps/{id}")
def show_sweep(
    request: Request, shown: Annotated[ShownSweep, Depends(_shown)], cover: CoverOfSweep, caller: Reader
) -> Response:
    """A sweep: the answer of its report with figure and picture, its grid of runs, and what the caller may do."""
    status, names = shown.status, shown.files
    sweep = SweepModel.of(status, names)
    quantities = quantities_of(status.scenario)
    is_drawn = cover is not None and bool(cover.cover.figure) and shown.quantity == quantities[0]
    return page(
        request,
        "sweep.html",
        caller,
        sweep=sweep,
        cover=cover.cover if cover else None,
        drawings={name: cover.address(status, name) for name in DRAWINGS} if cover else {},
        parts=parts_of(shown.document),
        orders=_orders(caller, status),
        document=shown.document,
        sheet=shown.sheet,
        cells=shown_cells(shown.cells, measurements.load(shown.quantity), status.scenario),
        quantity=measurements.load(shown.quantity),
        quantities=[measurements.load(name) for name in quantities],
        chart="" if is_drawn else shown.chart.image(f"/sweeps/{status.id}/chart", shown.query()),
        note=note.of_sweep(shown.document) if (note := note_on(shown.quantity)) else "",
        once=secrets.token_urlsafe(),
        may_add=bool(shown.sheet.dimensions) and caller.may(Scope.SUBMIT),
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
    once = idempotency_of(form, id, axis, values)
    priority = status.priority if caller.may(Scope.ADMIN) else max(status.priority, USUAL_PRIORITIES[0])
    async with submitting(request):
        sweep = await in_child(request, longer, document, axis, values, settings.max_runs)
        stored = await submit(request, sweep, priority, status.keep, once)
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
