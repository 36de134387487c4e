"""The grid of a sweep: a page of its points in the sweep's own axes, with one measured quantity, and its figure.

Two axes are rows and columns; the others have a sheet for each of their values. A sweep whose points are no grid has a
list. Either shows at most ``MOST_CELLS`` points, whatever the size of the sweep.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from service.pages.charts import Chart, ChartLine
from service.records.jobs import GridCell, State
from studies import measurements, scenarios
from studies.measurements import Measurement
from studies.quantities.display import kind_of, printed_beside
from studies.quantities.parameters import Plain, Value, declared
from studies.quantities.units import readable
from studies.sweeps.reading import OFFSET, RESOLUTION

MOST_CELLS = 400
MOST_LISTED = 100  # points of a list
NO_CHART = Chart("", ("", "", None), ("", "", None), ())
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
class GridLayout:
    """The grid of a document; without dimensions its points are a list."""

    dimensions: tuple[GridAxis, ...]
    planned: int

    @property
    def places(self) -> tuple[int, ...]:
        """The distance of neighbours along each dimension in the order of the points, whose last axis is fastest."""
        lengths = [len(each.texts) for each in self.dimensions]
        return tuple(math.prod(lengths[k + 1 :]) for k in range(len(lengths)))

    @property
    def rows_and_columns(self) -> tuple[int, ...]:
        """The two dimensions of a sheet: the longest axes, and where there are too few, the resolutions; long first."""
        order = sorted(
            range(len(self.dimensions)),
            key=lambda k: (
                len(self.dimensions[k].texts) == 1,
                self.dimensions[k].name in (RESOLUTION, OFFSET),
                -len(self.dimensions[k].texts),
            ),
        )
        return tuple(sorted(order[:2], key=lambda k: -len(self.dimensions[k].texts)))


def layout_of(document: Mapping[str, Plain], planned: int) -> GridLayout:
    """The layout of a canonical document."""
    axes, resolutions, offsets = (document.get(key) for key in ("axes", "resolution", "offsets"))
    assert isinstance(axes, Mapping)
    lists = {name: values for name, values in axes.items() if isinstance(values, list)}
    if document.get("combine") != "grid" or len(lists) < len(axes):
        return GridLayout((), planned)
    dimensions = [GridAxis(name, tuple(map(_plain, values))) for name, values in lists.items()]
    if isinstance(resolutions, list):
        dimensions.append(GridAxis(RESOLUTION, tuple(map(_plain, resolutions))))
    if isinstance(offsets, int) and offsets > 1:
        dimensions.append(GridAxis(OFFSET, tuple(f"{k}/{offsets} cell" for k in range(offsets))))
    return GridLayout(tuple(dimensions), planned)


def _plain(value: Plain) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


@dataclass(frozen=True)
class GridSheet:
    """The part of a layout that a page shows."""

    layout: GridLayout
    at: tuple[int, ...]  # place on each dimension; on those of the sheet itself 0
    first: int = 0  # row, or point of a list

    @staticmethod
    def read(layout: GridLayout, text: str, first: int) -> "GridSheet":
        """The sheet that a query names by its places; the finest resolution where it names none."""
        lengths = [len(each.texts) for each in layout.dimensions]
        places = [int(part) for part in text.split(".") if part.isdecimal() and len(part) < 6]
        if len(places) != len(lengths):
            places = [len(each.texts) - 1 if each.name == RESOLUTION else 0 for each in layout.dimensions]
        own = layout.rows_and_columns
        at = tuple(0 if k in own else min(place, lengths[k] - 1) for k, place in enumerate(places))
        return GridSheet(layout, at, first)

    @property
    def rows(self) -> range:
        """The rows that are shown, of the whole sheet."""
        own = self.layout.rows_and_columns
        if not own:
            return range(self.first, min(self.layout.planned, self.first + MOST_LISTED))
        each = max(1, MOST_CELLS // (len(self.layout.dimensions[own[1]].texts) if len(own) > 1 else 1))
        count = len(self.layout.dimensions[own[0]].texts)
        first = min(self.first, count - 1)
        return range(first, min(count, first + each))

    @property
    def row_count(self) -> int:
        own = self.layout.rows_and_columns
        return len(self.layout.dimensions[own[0]].texts) if own else self.layout.planned

    @property
    def columns(self) -> range:
        own = self.layout.rows_and_columns
        return range(len(self.layout.dimensions[own[1]].texts)) if len(own) > 1 else range(1)

    @property
    def ordinals(self) -> list[list[int]]:
        """The points of each row."""
        own, places = self.layout.rows_and_columns, self.layout.places
        if not own:
            return [[row] for row in self.rows]
        begin = sum(at * place for at, place in zip(self.at, places, strict=True))
        across = places[own[1]] if len(own) > 1 else 0
        return [[begin + row * places[own[0]] + column * across for column in self.columns] for row in self.rows]

    @property
    def beside(self) -> range:
        """The runs beside the points of a grid: those that screen its models."""
        points = math.prod(len(each.texts) for each in self.layout.dimensions)
        return range(points, min(self.layout.planned, points + MOST_LISTED)) if self.layout.dimensions else range(0)

    def others(self) -> Iterator[tuple[str, list[tuple[str, str | None]]]]:
        """Of each other dimension its label, and its values, each with the word of its sheet; None: this one."""
        for k, dimension in enumerate(self.layout.dimensions):
            if k in self.layout.rows_and_columns or len(dimension.texts) < 2:
                continue
            words = [
                ".".join(str(n if j == k else at) for j, at in enumerate(self.at)) for n in range(len(dimension.texts))
            ]
            yield (
                dimension.label,
                [(text, None if n == self.at[k] else words[n]) for n, text in enumerate(dimension.texts)],
            )

    @property
    def word(self) -> str:
        """The sheet as a query names it."""
        return ".".join(map(str, self.at))


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
    if quantity.is_outcome:
        text = quantity.outcomes[round(cell.value)]
    else:
        text = printed_beside(cell.value, kind_of(quantity.unit), cell.uncertainty)
    shade = min(SHADES - 1, int((cell.value - low) / (high - low) * SHADES)) if high > low else 0
    return ShownCell(cell.run_id, cell.state, text, shade, place)


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
    unit = _unit_of(scenario, name)
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float | int):
        return readable(float(value), unit or "1")
    return "–" if value is None else str(value)


def _unit_of(scenario: str, name: str) -> str | None:
    parameter = declared(scenarios.load(scenario).parameters).get(name)
    return parameter.unit if parameter else None


def chart_of(sheet: GridSheet, cells: Sequence[GridCell], name: str, scenario: str) -> Chart:
    """The quantity of the cells over the rows of their sheet, a line for each column; empty where rows are words."""
    own = sheet.layout.rows_and_columns
    quantity = measurements.load(name)
    if not own or quantity.is_outcome:
        return NO_CHART
    along = sheet.layout.dimensions[own[0]]
    across = sheet.layout.dimensions[own[1]] if len(own) > 1 else None
    by_place = {cell.ordinal: cell for cell in cells}
    lines = []
    for column in sheet.columns:
        mine = [by_place[row[column]] for row in sheet.ordinals if row[column] in by_place]
        at = [(cell.coordinates.get(along.name), cell) for cell in mine]
        if not all(isinstance(value, float | int) for value, _ in at):
            return NO_CHART
        in_order = [cell for _, cell in sorted(at, key=lambda each: each[0])]  # type: ignore[arg-type, return-value]
        lines.append(
            ChartLine(
                label=f"{across.label} {across.texts[column]}" if across else quantity.title,
                x=[float(cell.coordinates[along.name]) for cell in in_order],
                y=[cell.value for cell in in_order],
                uncertainty=[cell.uncertainty for cell in in_order],
            )
        )
    x = along.name, along.label, _unit_of(scenario, along.name) or "1"
    return Chart(quantity.title, x, (name, quantity.title, quantity.unit), lines, marked=True)
