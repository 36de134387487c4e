"""Two sweeps beside each other: the points that both have, and both in one figure."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter

from service.pages.charts import Chart
from service.pages.grid import NO_CHART, in_words, printed, quantities_of, unit_of, value_of
from service.records.jobs import GridCell, SweepStatus
from studies import measurements
from studies.quantities.display import kind_of, printed_beside
from studies.quantities.parameters import Plain, Value
from studies.reports.figure import Scale, Series
from studies.sweeps.reading import OFFSET, RESOLUTION

MOST_CELLS = 400  # of each sweep
LETTERS = ("A", "B")
REFINED = (RESOLUTION, OFFSET)
PREFERRED = "speed"  # the abscissa where both have it

Key = tuple[tuple[str, Value], ...]  # coordinates, by name


@dataclass(frozen=True)
class ComparedSweep:
    """One of two sweeps: its document and its runs, the finest last."""

    status: SweepStatus
    document: Mapping[str, Plain]
    cells: Sequence[GridCell]

    @property
    def scenario(self) -> str:
        return self.status.scenario

    @property
    def points(self) -> dict[Key, GridCell]:
        """The finest run of each point, without offset."""
        ordered = sorted(self.cells, key=lambda cell: (-_number(cell, OFFSET), _number(cell, RESOLUTION)))
        return {_key(cell): cell for cell in ordered if cell.value is not None}


@dataclass(frozen=True)
class SharedPoint:
    """A point that both sweeps have, with what each measured there."""

    place: Mapping[str, str]  # values of the axes that both vary, in words
    texts: tuple[str, str]  # with their error bars, in the unit that people read
    runs: tuple[str, str]  # ids
    difference: str  # second value less first, in per cent of the first, or "another outcome"


def shared_quantities(first: str, second: str) -> list[str]:
    """The quantities that both scenarios measure, in the order of the first."""
    return [name for name in quantities_of(first) if name in quantities_of(second)]


def shared_points(pair: Sequence[ComparedSweep], name: str) -> Iterator[SharedPoint]:
    """The points of the first sweep that the second has too, by the axes that both vary."""
    first, second = (sweep.points for sweep in pair)
    for key, cell in first.items():
        if key in second:
            cells = (cell, second[key])
            texts = tuple(_printed(each, name) for each in cells)
            yield SharedPoint(
                {axis: value_of(pair[0].scenario, axis, at) for axis, at in key},
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
    x = Scale(along, along.replace("_", " "), unit_of(pair[0].scenario, along) or "1")
    return Chart(quantity.title, x, Scale(name, quantity.title, quantity.unit), lines)


def _lines(letter: str, sweep: ComparedSweep, along: str) -> Iterator[Series]:
    """A line for each value of the other axes."""
    groups: dict[Key, list[tuple[float, GridCell]]] = {}
    for key, cell in sweep.points.items():
        at = dict(key)
        groups.setdefault(tuple(pair for pair in key if pair[0] != along), []).append((float(at[along] or 0.0), cell))
    for others, cells in groups.items():
        cells.sort(key=itemgetter(0))
        label = ", ".join(filter(None, (letter, in_words(sweep.scenario, dict(others)))))
        values, bars = (tuple(getattr(cell, part) for _, cell in cells) for part in ("value", "uncertainty"))
        yield Series("quantity", label, tuple(at for at, _ in cells), values, bars)


def _numeric(sweep: ComparedSweep) -> list[str]:
    """The axes of a sweep whose points have numbers on them."""
    keys = [dict(key) for key in sweep.points]
    return [name for name in (keys[0] if keys else ()) if all(isinstance(key.get(name), float | int) for key in keys)]


def _key(cell: GridCell) -> Key:
    return tuple(sorted((name, at) for name, at in cell.coordinates.items() if name not in REFINED))


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
