"""The grid of a sweep: a page of its points in the sweep's own axes, with one measured quantity, and its figure.

Two axes are rows and columns; the others have a sheet for each of their values. A sweep whose points are no grid has a
list. Either shows at most ``MOST_CELLS`` points, whatever the size of the sweep.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import itemgetter

from service.pages.charts import Chart
from service.records.jobs import GridCell, State
from studies import measurements, scenarios
from studies.measurements import Measurement
from studies.quantities.display import kind_of, printed_beside
from studies.quantities.parameters import Plain, Value, declared
from studies.quantities.units import readable
from studies.reports.figure import Scale, Series
from studies.sweeps.reading import OFFSET, RESOLUTION

MOST_CELLS = 400
MOST_LISTED = 100  # points of a list
NO_CHART = Chart("", Scale("", "", None), Scale("", "", None), ())
SHADES = 5  # of the colour of a value, between the smallest and the largest that are shown


@dataclass(frozen=True)
class GridAxis:
    """An axis of a grid, or its resolutions or offsets."""

    name: str  # as in coordinates
    texts: tuple[str, ...]  # of its values

    @property
    def label(self) -> str:
        return "resolution" if self.name == RESOLUTION else _in_words(self.name)


@dataclass(frozen=True)
class GridSheet:
    """The part of a grid that a page shows; a list where the points are no grid."""

    dimensions: tuple[GridAxis, ...]  # of the whole grid; of a list none
    planned: int  # points
    at: tuple[int, ...]  # place on each dimension; on those of the sheet itself 0
    shown: tuple[int, ...]  # the dimensions of its rows and of its columns, as far as there are any
    first: int  # row, or point of a list

    @property
    def row_axis(self) -> GridAxis | None:
        return self.dimensions[self.shown[0]] if self.shown else None

    @property
    def column_axis(self) -> GridAxis | None:
        return self.dimensions[self.shown[1]] if len(self.shown) > 1 else None

    @property
    def row_count(self) -> int:
        """The rows of the whole sheet."""
        return len(self.row_axis.texts) if self.row_axis else self.planned

    @property
    def columns(self) -> range:
        return range(len(self.column_axis.texts) if self.column_axis else 1)

    @property
    def rows(self) -> range:
        """The rows that are shown, of the whole sheet."""
        most = max(1, MOST_CELLS // len(self.columns)) if self.dimensions else MOST_LISTED
        first = min(self.first, self.row_count - 1)
        return range(first, min(self.row_count, first + most))

    @property
    def ordinals(self) -> list[list[int]]:
        """The points of each row, in the order of the sweep, whose last axis is fastest."""
        lengths = [len(axis.texts) for axis in self.dimensions]
        distances = [math.prod(lengths[k + 1 :]) for k in range(len(lengths))]  # of neighbours along each dimension
        begin = sum(at * distance for at, distance in zip(self.at, distances, strict=True))
        down, across = [*(distances[k] for k in self.shown), 1, 0][:2]
        return [[begin + row * down + column * across for column in self.columns] for row in self.rows]

    @property
    def beside(self) -> range:
        """The runs beside the points of a grid: those that screen its models."""
        points = math.prod(len(axis.texts) for axis in self.dimensions)
        return range(points, min(self.planned, points + MOST_LISTED)) if self.dimensions else range(0)

    def others(self) -> Iterator[tuple[str, list[tuple[str, str | None]]]]:
        """The label of each dimension beside those of the sheet, and its values.

        Beside a value stands the ``word`` of the sheet that has it; None for this sheet.
        """
        for k, dimension in enumerate(self.dimensions):
            if k in self.shown or len(dimension.texts) < 2:
                continue
            sheets = [replace(self, at=(*self.at[:k], n, *self.at[k + 1 :])) for n in range(len(dimension.texts))]
            words = [None if sheet == self else sheet.word for sheet in sheets]
            yield dimension.label, [*zip(dimension.texts, words, strict=True)]

    @property
    def word(self) -> str:
        """The sheet as a query names it."""
        return ".".join(map(str, self.at))


def sheet_of(document: Mapping[str, Plain], planned: int, text: str, first: int) -> GridSheet:
    """The sheet of a canonical document that a query names by its places; the finest resolution where it names none.

    Its rows and columns are the longest axes, and where there are too few, the resolutions; the longer one has rows.
    """
    dimensions = _dimensions(document)
    lengths = [len(axis.texts) for axis in dimensions]
    is_numerical = [axis.name in (RESOLUTION, OFFSET) for axis in dimensions]
    order = sorted(range(len(lengths)), key=lambda k: (lengths[k] == 1, is_numerical[k], -lengths[k]))
    shown = tuple(sorted(order[:2], key=lambda k: -lengths[k]))
    places = [int(part) for part in text.split(".") if part.isdecimal() and len(part) < 6]
    if len(places) != len(lengths):
        places = [len(axis.texts) - 1 if axis.name == RESOLUTION else 0 for axis in dimensions]
    at = tuple(0 if k in shown else min(place, lengths[k] - 1) for k, place in enumerate(places))
    return GridSheet(dimensions, planned, at, shown, first)


def _dimensions(document: Mapping[str, Plain]) -> tuple[GridAxis, ...]:
    """The dimensions of the grid of a document; none where its points are no grid."""
    axes, resolutions, offsets = (document.get(key) for key in ("axes", "resolution", "offsets"))
    assert isinstance(axes, Mapping)
    lists = {name: values for name, values in axes.items() if isinstance(values, list)}
    if document.get("combine") != "grid" or len(lists) < len(axes):
        return ()
    dimensions = [GridAxis(name, tuple(map(_plain, values))) for name, values in lists.items()]
    if isinstance(resolutions, list):
        dimensions.append(GridAxis(RESOLUTION, tuple(map(_plain, resolutions))))
    if isinstance(offsets, int) and offsets > 1:
        dimensions.append(GridAxis(OFFSET, tuple(f"{k}/{offsets} cell" for k in range(offsets))))
    return tuple(dimensions)


def _plain(value: Plain) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


@dataclass(frozen=True)
class ShownCell:
    """A cell as the page prints it."""

    run_id: str
    state: State
    text: str
    shade: int | None  # of its value, 0 to SHADES - 1
    place: str  # its coordinates in words


def quantities_of(scenario: str) -> tuple[str, ...]:
    """The measured quantities of a scenario, the main one first."""
    return scenarios.load(scenario).measurements


def shown_cells(cells: Sequence[GridCell], quantity: Measurement, scenario: str) -> dict[int, ShownCell]:
    """Cells as they are printed, by their places in the order of the sweep."""
    values = [cell.value for cell in cells if cell.value is not None]
    low, high = min(values, default=0.0), max(values, default=0.0)
    return {cell.ordinal: _shown(cell, quantity, scenario, low, high) for cell in cells}


def _shown(cell: GridCell, quantity: Measurement, scenario: str, low: float, high: float) -> ShownCell:
    place = in_words(scenario, cell.coordinates)
    if cell.value is None:
        percent = cell.state is State.RUNNING and cell.fraction is not None
        text = f"{cell.fraction:.0%}" if percent else "no value" if cell.state is State.SUCCEEDED else cell.state.value
        return ShownCell(cell.run_id, cell.state, text, None, place)
    shade = min(SHADES - 1, int((cell.value - low) / (high - low) * SHADES)) if high > low else 0
    return ShownCell(cell.run_id, cell.state, printed(quantity, cell.value, cell.uncertainty), shade, place)


def printed(quantity: Measurement, value: float | None, uncertainty: float | None) -> str:
    """A measured value as people read it, in the words of an outcome or the unit of its column."""
    if quantity.is_outcome and value is not None:
        return quantity.outcomes[round(value)]
    return printed_beside(value, kind_of(quantity.unit), uncertainty)


def in_words(scenario: str, coordinates: Mapping[str, Value]) -> str:
    """Coordinates (SI) for people, to four digits: "speed 6 km/s, plate thickness 2 mm"."""
    return ", ".join(
        f"{_in_words(name)} {value_of(scenario, name, float(f'{at:.4g}') if isinstance(at, float) else at)}"
        for name, at in coordinates.items()
    )


def _in_words(name: str) -> str:
    return "grid offset" if name == OFFSET else name.replace("_", " ")


def value_of(scenario: str, name: str, value: Value) -> str:
    """A value of a parameter (SI) for people."""
    unit = unit_of(scenario, name)
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float | int):
        return readable(float(value), unit or "1")
    return "–" if value is None else str(value)


def unit_of(scenario: str, name: str) -> str | None:
    parameter = declared(scenarios.load(scenario).parameters).get(name)
    return parameter.unit if parameter else None


def chart_of(sheet: GridSheet, cells: Sequence[GridCell], name: str, scenario: str) -> Chart:
    """The quantity of the cells over the rows of their sheet, a line for each column; empty where rows are words."""
    quantity, along, across = measurements.load(name), sheet.row_axis, sheet.column_axis
    if along is None or quantity.is_outcome:
        return NO_CHART
    by_place = {cell.ordinal: cell for cell in cells}
    lines = []
    for column in sheet.columns:
        mine = [by_place[row[column]] for row in sheet.ordinals if row[column] in by_place]
        points = [
            (float(at), cell.value, cell.uncertainty)
            for cell in mine
            if isinstance(at := cell.coordinates.get(along.name), float | int)
        ]
        if len(points) < len(mine):
            return NO_CHART
        points.sort(key=itemgetter(0))
        label = f"{across.label} {across.texts[column]}" if across else quantity.title
        x, y, bars = (tuple(point[k] for point in points) for k in range(3))
        lines.append(Series("quantity", label, x, y, bars))
    across_rows = Scale(along.name, along.label, unit_of(scenario, along.name) or "1")
    return Chart(quantity.title, across_rows, Scale(name, quantity.title, quantity.unit), lines)
