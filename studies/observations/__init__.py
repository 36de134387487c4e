"""Observations: measured shots, published or the user's own, with uncertainty and source.

A sweep brings its shots as a table, one row a shot, wide or long: docs/own-shots.md. ``sweeps`` reads and writes them.

How to add a published table: a CSV file in this folder, named after the shots, which a sweep names in place of its own
file, ``observations: craters``. Its ``confidence`` is a word of ``studies.materials.schema.CONFIDENCES``; facts that
have no column stand in its ``note``, and shots that no scenario computes in remarks. What was published as a range
alone is written as one, "27.5 to 34.5", and a material as "aluminium of unknown alloy" where its source names none:
such shots are listed and drawn, and nothing is compared with them.
"""

import csv
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from itertools import islice
from typing import Any

from studies.quantities.findings import Finding, Findings, nearest_cure, refusal, shown
from studies.quantities.parameters import Parameter, Value, parse_value
from studies.quantities.units import is_number, readable

MOST_ROWS = 10_000  # a table of shots; more is another kind of file
MOST_LINES = 10 * MOST_ROWS  # lines of a text, with empty lines and remarks
LONGEST_NUMBER = 80  # characters; as LONGEST_TEXT of a quantity
LONG_COLUMNS = ("quantity", "value", "uncertainty")  # of a long table
TEXT_COLUMNS = ("source", "confidence", "note")
OWN_COLUMNS = (*LONG_COLUMNS, *TEXT_COLUMNS)
UNCERTAINTY = "_uncertainty"  # hole_diameter_uncertainty: the column of a wide table beside hole_diameter
COLUMNS = (
    "give a column for each measured quantity (or quantity, value, uncertainty), the source, and one for each "
    "parameter; confidence and note may be left out: docs/own-shots.md"
)

# Each matches a text in one way only, so that a long text that does not match is refused at once.
_HEADER = re.compile(r"([\w.]+)\s*(?:\[([^\[\]]*)\])?")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
TO = " to "  # between the bounds of a range: "27.5 to 34.5"
UNKNOWN_ALLOY = " of unknown alloy"  # behind the metal, in place of the name of a material


@dataclass(frozen=True)
class Observation:
    """One measured shot."""

    quantity: str  # what was measured: "hole_diameter"
    value: float | None  # SI; None of a range
    uncertainty: float | None  # SI; None where none is stated
    source: str
    # SI, by the names of the scenario.
    parameters: Mapping[str, Value] = field(default_factory=dict)
    confidence: str = ""  # how well the number is known to be the source's
    note: str = ""
    bounds: tuple[float, float] | None = None  # SI, of what was published as a range alone

    def document(self, allowed: "AllowedNames") -> dict[str, Any]:
        """The shot as a row that ``read_observations`` reads as itself."""
        unit = allowed.quantities[self.quantity]
        row: dict[str, Any] = {
            name: written(value, allowed.parameters[name].unit) for name, value in self.parameters.items()
        }
        sizes = [written(size, unit) for size in self.bounds or (self.value,)]
        value = sizes[0] if self.bounds is None else TO.join(map(str, sizes))
        row |= {"quantity": self.quantity, "value": value}
        if self.uncertainty is not None:
            row["uncertainty"] = written(self.uncertainty, unit)
        texts = {"source": self.source, "confidence": self.confidence, "note": self.note}
        return row | {name: text for name, text in texts.items() if text}


@dataclass(frozen=True)
class AllowedNames:
    """The names that a sweep and its table of shots may use."""

    quantities: Mapping[str, str]  # of the scenario, with their SI units
    parameters: Mapping[str, Parameter]
    materials: Collection[str] = ()  # names of materials; empty: any


def names() -> list[str]:
    """The published tables that ship, sorted."""
    return sorted(file.name.removesuffix(".csv") for file in files(__package__).iterdir() if file.name.endswith(".csv"))


def text(name: str) -> str:
    """The CSV text of a published table; raises InvalidInput with the nearest name."""
    if name not in names():
        cure = f"{nearest_cure(name, names())}; or give the table itself as CSV text"
        raise refusal("observations", name, "a table of shots that ships", cure)
    return files(__package__).joinpath(f"{name}.csv").read_text(encoding="utf-8")


def is_name(raw: object) -> bool:
    """Whether a sweep names a table, and does not bring one: a text of a single line without a comma."""
    return isinstance(raw, str) and bool(raw.strip()) and not set("\n,") & set(raw.strip())


def written(value: Value, unit: str | None) -> Any:
    """A value as a person writes it: a quantity with its unit, everything else unchanged."""
    if unit is None or unit == "1" or value is None:
        return value
    return readable(float(value), unit)


def read_observations(raw: object, allowed: AllowedNames, path: str = "observations") -> tuple[Observation, ...]:
    """The shots of a CSV text, of a list of mappings, or of the published table of a name.

    Raises InvalidInput naming each row.
    """
    if isinstance(raw, str) and is_name(raw):
        raw = text(raw.strip())
    rows = list(islice(rows_of(raw, path), MOST_ROWS + 1))
    if not rows:
        raise refusal(path, "no shot", "at least one row", "leave observations out")
    if len(rows) > MOST_ROWS:
        raise refusal(path, f"more than {MOST_ROWS} rows", f"at most {MOST_ROWS} rows", "split the table")
    read: list[Observation] = []
    findings = Findings()
    for where, row in rows:
        read.extend(findings.attempt(tuple, _observations(row, allowed, where)) or ())
    findings.check()
    return tuple(read)


def rows_of(raw: object, path: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Each row with its place: the line in a text, the position in a list."""
    if isinstance(raw, str):
        yield from _rows_of_text(raw, path)
    elif isinstance(raw, list | tuple):
        for number, row in enumerate(raw):
            if not isinstance(row, Mapping):
                raise refusal(f"{path}[{number}]", row, "a mapping", "write speed: 6 km/s, ...")
            yield f"{path}[{number}]", row
    else:
        raise refusal(path, raw, "CSV text or a list of shots", COLUMNS)


def _rows_of_text(text: str, path: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """The lines of a CSV text without empty lines and remarks, which begin with #."""
    header: list[str] | None = None
    lines = text.splitlines()
    if len(lines) > MOST_LINES:
        limit = f"at most {MOST_LINES} lines"
        raise refusal(path, f"{len(lines)} lines", limit, "leave empty lines and remarks out")
    reader = csv.reader(lines, skipinitialspace=True, strict=True)
    for cells in _cells(reader, path):
        where = f"{path}, line {reader.line_num}"
        if not any(cell.strip() for cell in cells) or cells[0].lstrip().startswith("#"):
            continue
        if header is None:
            header = cells
        elif len(cells) != len(header):
            limit = f"{len(header)} cells, as in the header"
            raise refusal(where, f"{len(cells)} cells", limit, "quote a text that has a comma")
        else:
            yield where, dict(zip(header, cells, strict=True))
    if header is None:
        raise refusal(path, "no header", "a header and a row a shot", "leave observations out")


def _cells(reader: Any, path: str) -> Iterator[list[str]]:
    try:
        yield from reader
    except csv.Error as error:
        where = f"{path}, line {reader.line_num}"
        raise refusal(where, str(error), "CSV text", "correct this line") from None


def _observations(row: Mapping[str, Any], allowed: AllowedNames, where: str) -> Iterator[Observation]:
    """The shots of a row, one for each measured quantity; raises InvalidInput with every finding in it."""
    findings = Findings()
    cells: dict[str, Any] = {}

    def read(header: str, raw: Any) -> None:
        name, cell = cell_of(header, raw, where)
        if name not in OWN_COLUMNS and not _is_measured(name, allowed):
            cell = _parameter(name, cell, allowed, where)
        if name in cells:
            raise refusal(f"{where}.{name}", header, "each column once", "remove one of the two")
        cells[name] = cell

    for item in row.items():
        findings.attempt(read, *item)
    measured = [name for name in cells if name in allowed.quantities]
    # A refused column of a wide table may be the one that is measured: its own finding says which is meant.
    if not findings or measured or not {*LONG_COLUMNS}.isdisjoint(cells):
        findings.extend(_missing(cells, measured, where))
    if measured:
        findings.extend(
            Finding(f"{where}: {name}", name, "a table with one way to name quantities", COLUMNS)
            for name in LONG_COLUMNS
            if name in cells
        )
    findings.check()
    yield from _checked(cells, measured, allowed, where)


def _is_measured(name: str, allowed: AllowedNames) -> bool:
    """Whether a column of a wide table has a measured quantity, or its uncertainty."""
    return name in allowed.quantities or name.removesuffix(UNCERTAINTY) in allowed.quantities


def _missing(cells: Mapping[str, Any], measured: Sequence[str], where: str) -> Iterator[Finding]:
    """A finding for each thing that a row needs and does not have."""
    needed = ("source",) if measured else ("quantity", "value", "source")
    for name in needed:
        if cells.get(name) in (None, ""):
            limit = f"a column {name!r}"
            yield Finding(f"{where}: {name}", "nothing", limit, f"give the {name} of each shot")
    if measured and all(cells[name] in (None, "") for name in measured):
        cure = "remove the row, or give what was measured"
        yield Finding(f"{where}: {measured[0]}", "nothing", "one measured quantity a row", cure)


def cell_of(header: object, raw: Any, where: str) -> tuple[str, Any]:
    """The name of a column, and a cell with the unit of the column beside a bare number."""
    match = _HEADER.fullmatch(header.strip()) if isinstance(header, str) else None
    unit = match[2].strip() if match and match[2] is not None else None
    if match is None or unit == "":
        raise refusal(f"{where}: {shown(header)}", header, "name [unit]", "write 'speed [km/s]'")
    cell = raw.strip() if isinstance(raw, str) else raw
    is_bare = is_number(cell) or (
        isinstance(cell, str)
        and len(cell) <= LONGEST_NUMBER
        and all(_NUMBER.fullmatch(side.strip()) for side in cell.split(TO))
    )
    if not is_bare or unit in (None, "1", "-"):
        return match[1], cell
    return match[1], TO.join(f"{side} {unit}" for side in str(cell).split(TO))


def _parameter(name: str, cell: Any, allowed: AllowedNames, where: str) -> Value:
    """A parameter of the shot; an empty cell states nothing."""
    if name not in allowed.parameters:
        columns = {*allowed.parameters, *allowed.quantities, *TEXT_COLUMNS}
        limit = "a column named after a parameter or a measured quantity of the scenario"
        raise refusal(f"{where}: {name}", name, limit, nearest_cure(name, columns))
    parameter = allowed.parameters[name]
    if cell in (None, ""):
        return None
    if parameter.kind == "material" and isinstance(cell, str) and cell.endswith(UNKNOWN_ALLOY):
        return cell
    return parse_value(parameter, cell, f"{where}: {name}", materials=allowed.materials)


def _checked(
    cells: Mapping[str, Any], measured: Sequence[str], allowed: AllowedNames, where: str
) -> Iterator[Observation]:
    """The shots of a row whose columns are complete."""
    texts = {name: _text(name, cells.get(name), where) for name in TEXT_COLUMNS}
    parameters = {name: cell for name, cell in cells.items() if name in allowed.parameters and cell is not None}
    columns: list[tuple[Any, str, str]] = [(name, name, f"{name}{UNCERTAINTY}") for name in measured]
    for quantity, value, uncertainty in columns or [(cells["quantity"], "value", "uncertainty")]:
        if quantity not in allowed.quantities:
            cure = nearest_cure(quantity, allowed.quantities)
            raise refusal(f"{where}: quantity", quantity, "what the scenario measures", cure)
        assert isinstance(quantity, str)
        bounds = _bounds(value, cells[value], allowed.quantities[quantity], where)
        size = None
        if bounds is None:
            size = _size(value, cells[value], allowed.quantities[quantity], where)
        plus_minus = _size(uncertainty, cells.get(uncertainty), allowed.quantities[quantity], where)
        if size is not None or bounds is not None:
            yield Observation(quantity, size, plus_minus, parameters=parameters, bounds=bounds, **texts)


def _text(name: str, cell: Any, where: str) -> str:
    if cell is not None and not isinstance(cell, str):
        cure = "name the publication of the shot" if name == "source" else "quote it, or leave it out"
        raise refusal(f"{where}: {name}", cell, "a text", cure)
    return cell or ""


def _bounds(name: str, cell: Any, unit: str, where: str) -> tuple[float, float] | None:
    """The bounds of a range, "27.5 mm to 34.5 mm"; None of any other cell."""
    if not isinstance(cell, str) or cell.count(TO) != 1:
        return None
    low, high = (_size(name, side.strip(), unit, where) for side in cell.split(TO))
    if low is None or high is None or low >= high:
        cure = "write the smaller bound first, or the value alone"
        raise refusal(f"{where}: {name}", cell, "two bounds that ascend", cure)
    return low, high


def _size(name: str, cell: Any, unit: str, where: str) -> float | None:
    """A measured size: zero or more; None where the cell is empty."""
    if cell in (None, ""):
        return None
    size = Parameter(name=name, kind="quantity", unit=unit, meaning=name, minimum=0.0)
    value = parse_value(size, cell, f"{where}: {name}")
    assert isinstance(value, float)
    return value
