"""Two sweeps beside each other, at an address that can be kept."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request, Response
from fastapi.responses import HTMLResponse
from starlette.concurrency import run_in_threadpool

from service.api.access import Reader
from service.api.dependencies import AppStore
from service.pages.comparison import LETTERS, MOST_CELLS, ComparedSweep, chart_of_both, shared_points, shared_quantities
from service.pages.covers import ShownCover, cover_of
from service.pages.differing import differences
from service.pages.page_routes import PageRoutes
from service.pages.rendering import LONGEST_TEXT, drawn, page
from service.records.jobs import SweepStatus
from service.store import Store
from studies import measurements
from studies.quantities.findings import refusal

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)
PAGE = PageRoutes("comparison", 15, router)

MOST_IDS = 20  # in the address, so that ticking too many is said and not refused by its length


@dataclass(frozen=True)
class ShownPair:
    """Two sweeps, and the quantity that a query names."""

    sweeps: Sequence[ComparedSweep]
    quantities: Sequence[str]  # that both measure
    quantity: str  # empty where there is none

    def query(self) -> dict[str, str | list[str]]:
        return {"sweep": [sweep.status.id for sweep in self.sweeps], "quantity": self.quantity}


def _pair(
    _: Reader,
    store: AppStore,
    sweep: Annotated[list[str] | None, Query(max_length=MOST_IDS)] = None,
    quantity: Annotated[str, Query(max_length=LONGEST_TEXT)] = "",
) -> ShownPair:
    """The sweeps of an address; raises InvalidInput unless there are two, and NotFound."""
    ids = list(dict.fromkeys(sweep or ()))
    if len(ids) != len(LETTERS):
        raise refusal("sweep", f"{len(ids)} sweeps", "two sweeps", "tick two in the list of sweeps, then compare them")
    statuses = [store.sweeps.get(id) for id in ids]
    names = shared_quantities(*(status.scenario for status in statuses))
    chosen = quantity if quantity in names else next(iter(names), "")
    sweeps = [_compared(store, status, chosen) for status in statuses]
    return ShownPair(sweeps, names, chosen)


def _compared(store: Store, status: SweepStatus, quantity: str) -> ComparedSweep:
    cells = store.sweeps.cells(status.id, range(min(status.planned, MOST_CELLS)), quantity) if quantity else ()
    return ComparedSweep(status, store.sweeps.document(status.id), cells)


Pair = Annotated[ShownPair, Depends(_pair)]


async def _covers(request: Request, pair: Pair, caller: Reader, store: AppStore) -> list[ShownCover | None]:
    return [await cover_of(request, sweep.status.id, caller, store) for sweep in pair.sweeps]


@router.get("/compare")
def show_comparison(
    request: Request, pair: Pair, covers: Annotated[list[ShownCover | None], Depends(_covers)], caller: Reader
) -> Response:
    """Two sweeps: both in one figure, in what their requests differ, and what both measured at the same points."""
    statuses = [sweep.status for sweep in pair.sweeps]
    chart = chart_of_both(pair.sweeps, pair.quantity).image("/compare/chart", pair.query()) if pair.quantity else ""
    points = list(shared_points(pair.sweeps, pair.quantity)) if pair.quantity else []
    return page(
        request,
        "comparison.html",
        caller,
        sweeps=[*zip(LETTERS, statuses, covers, strict=True)],
        quantities=[measurements.load(name) for name in pair.quantities],
        quantity=measurements.load(pair.quantity) if pair.quantity else None,
        chart=chart,
        differences=[*differences([sweep.document for sweep in pair.sweeps])],
        points=points,
        most=MOST_CELLS if any(status.planned > MOST_CELLS for status in statuses) else None,
    )


@router.get("/compare/chart")
async def show_chart(request: Request, pair: Pair) -> Response:
    """Both sweeps in one figure: SVG."""
    return await drawn(request, await run_in_threadpool(chart_of_both, pair.sweeps, pair.quantity))
