"""Two sweeps beside each other, at an address that can be kept: the points that both have, and both in one figure."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request, Response
from starlette.concurrency import run_in_threadpool

from service.api.access import Reader
from service.api.dependencies import AppStore
from service.pages.charts import Chart
from service.pages.covers import ShownCover, cover_of
from service.pages.differing import differences
from service.pages.grid import NO_CHART, in_words, printed, quantities_of, unit_of, value_of
from service.pages.page_routes import PageRoutes
from service.pages.rendering import LONGEST_TEXT, drawn, page
from service.records.jobs import GridCell, SweepStatus
from service.store import Store
from studies import measurements
from studies.quantities.display import kind_of, printed_beside
from studies.quantities.findings import refusal
from studies.quantities.parameters import Plain, Value
from studies.reports.figure import Scale, Series
from studies.sweeps.reading import OFFSET, RESOLUTION

router = APIRouter(include_in_schema=False)
PAGE = PageRoutes("comparison", 15, router)

MOST_CELLS = 400  # of each sweep
LETTERS = ("A", "B")
REFINED = (RESOLUTION, OFFSET)
PREFERRED = "speed"  # the abscissa where both have it

Key = tuple[tuple[str, Value], ...]  # coordinates, by name
MOST_IDS = 20  # in the address, so that ticking too many is said and not refused by its length


@dataclass(frozen=True)
class ComparedSweep:
    """One of two sweeps: its document and its runs, the finest last."""

    status: SweepStatus
    document: Mapping[str, Plain]
    cells: Sequence[GridCell]

    @property
    def points(self) -> dict[Key, GridCell]:
        """The finest run of each point, without offset."""
        ordered = sorted(self.cells, key=lambda cell: (-_number(cell, OFFSET), _number(cell, RESOLUTION)))
        measured = (cell for cell in ordered if cell.value is not None)
        return {
            tuple(sorted((k, at) for k, at in cell.coordinates.items() if k not in REFINED)): cell for cell in measured
        }


@dataclass(frozen=True)
class SharedPoint:
    """A point that both sweeps have, with what each measured there."""

    place: Mapping[str, str]  # values of the axes that both vary, in words
    texts: tuple[str, str]  # with their error bars, in the unit that people read
    runs: tuple[str, str]  # ids
    difference: str  # second value less first, in per cent of the first, or "another outcome"


def shared_points(pair: Sequence[ComparedSweep], name: str) -> Iterator[SharedPoint]:
    """The points of the first sweep that the second has too, by the axes that both vary."""
    first, second = (sweep.points for sweep in pair)
    for key, cell in first.items():
        if key in second:
            cells = (cell, second[key])
            texts = tuple(_printed(each, name) for each in cells)
            yield SharedPoint(
                {axis: value_of(pair[0].status.scenario, axis, at) for axis, at in key},
                (texts[0], texts[1]),
                (cell.run_id, second[key].run_id),
                _difference(cells, name),
            )


def chart_of_both(pair: Sequence[ComparedSweep], name: str) -> Chart:
    """A quantity of both sweeps over an axis of numbers that both have; empty where they share none."""
    quantity = measurements.load(name)
    shared = [axis for axis in _numeric(pair[0]) if axis in _numeric(pair[1])]
    if quantity.is_outcome or not shared:
        return NO_CHART
    along = PREFERRED if PREFERRED in shared else shared[0]
    lines = [line for letter, sweep in zip(LETTERS, pair, strict=True) for line in _lines(letter, sweep, along)]
    x = Scale(along, along.replace("_", " "), unit_of(pair[0].status.scenario, along) or "1")
    return Chart(quantity.title, x, Scale(name, quantity.title, quantity.unit), lines)


def _lines(letter: str, sweep: ComparedSweep, along: str) -> Iterator[Series]:
    """A line for each value of the other axes."""
    groups: dict[Key, list[tuple[float, GridCell]]] = {}
    for key, cell in sweep.points.items():
        at = dict(key)
        groups.setdefault(tuple(pair for pair in key if pair[0] != along), []).append((float(at[along] or 0.0), cell))
    for others, cells in groups.items():
        cells.sort(key=itemgetter(0))
        label = ", ".join(filter(None, (letter, in_words(sweep.status.scenario, dict(others)))))
        values, bars = (tuple(getattr(cell, part) for _, cell in cells) for part in ("value", "uncertainty"))
        yield Series("quantity", label, tuple(at for at, _ in cells), values, bars)


def _numeric(sweep: ComparedSweep) -> list[str]:
    """The axes of a sweep whose points have numbers on them."""
    keys = [dict(key) for key in sweep.points]
    return [name for name in (keys[0] if keys else ()) if all(isinstance(key.get(name), float | int) for key in keys)]


def _number(cell: GridCell, name: str) -> float:
    at = cell.coordinates.get(name)
    return float(at) if isinstance(at, float | int) else 0.0


def _printed(cell: GridCell, name: str) -> str:
    quantity = measurements.load(name)
    text = printed(quantity, cell.value, cell.uncertainty)
    if quantity.is_outcome or not cell.uncertainty:
        return text
    return f"{text} ± {printed_beside(cell.uncertainty, kind_of(quantity.unit), cell.uncertainty)}"


def _difference(cells: tuple[GridCell, GridCell], name: str) -> str:
    first, second = (cell.value for cell in cells)
    if first is None or second is None or measurements.load(name).is_outcome:
        return "" if first == second else "another outcome"
    return printed_beside((second - first) / first, "share_residual", None) if first else "–"


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
    first, second = (quantities_of(status.scenario) for status in statuses)
    names = [name for name in first if name in second]
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
