"""Observations: measured shots, published or the user's own, with uncertainty and source; none ship.

A sweep brings its shots as a table, one row a shot: ``quantity`` ("hole_diameter"), ``value``, ``uncertainty`` (may be
empty), ``source``, and a column for each parameter that the shot states. The unit stands in the header, "speed [km/s]",
or beside each number, "6 km/s". ``sweeps`` reads and writes them; users find this under "Your own shots" in README.md.
"""

import csv
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

from studies.values.errors import Finding, Findings, InvalidInput
from studies.values.nearest import nearest_cure, shown
from studies.values.parameters import Parameter, Value, find, parse_value
from studies.values.quantities import is_number, readable, refusal

MOST_ROWS = 10_000  # a table of shots; more is another kind of file
MOST_LINES = 10 * MOST_ROWS  # lines of a text, with empty lines and remarks
LONGEST_NUMBER = 80  # characters; as LONGEST_TEXT of a quantity
OWN_COLUMNS = ("quantity", "value", "uncertainty", "source")
NEEDED_COLUMNS = ("quantity", "value", "source")
COLUMNS = (
    "give the columns quantity, value, uncertainty, source, and one for each parameter, as "
    "'Your own shots' in README.md has them"
)

# Each matches a text in one way only, so that a long text that does not match is refused at once.
_HEADER = re.compile(r"([\w.]+)\s*(?:\[([^\[\]]*)\])?")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


@dataclass(frozen=True)
class Observation:
    """One measured shot."""

    quantity: str  # what was measured: "hole_diameter"
    value: float  # SI
    uncertainty: float | None  # SI; None where none is stated
    source: str
    # SI, by the names of the scenario.
    parameters: Mapping[str, Value] = field(default_factory=dict)

    def document(self, allowed: "AllowedNames") -> dict[str, Any]:
        """The shot as a row that ``read_observations`` reads as itself."""
        unit = allowed.quantities[self.quantity]
        row: dict[str, Any] = {
            name: written(value, allowed.parameters[name].unit)
            for name, value in self.parameters.items()
        }
        row |= {"quantity": self.quantity, "value": written(self.value, unit)}
        if self.uncertainty is not None:
            row["uncertainty"] = written(self.uncertainty, unit)
        return row | {"source": self.source}


@dataclass(frozen=True)
class AllowedNames:
    """The names that a sweep and its table of shots may use."""

    quantities: Mapping[str, str]  # of the scenario, with their SI units
    parameters: Mapping[str, Parameter]
    materials: Collection[str] = ()  # names of materials; empty: any


def written(value: Value, unit: str | None) -> Any:
    """A value as a person writes it: a quantity with its unit, everything else unchanged."""
    if unit is None or unit == "1" or value is None:
        return value
    return readable(float(value), unit)


def read_observations(
    raw: object, allowed: AllowedNames, path: str = "observations"
) -> tuple[Observation, ...]:
    """The shots of a CSV text, or of a list of mappings; raises InvalidInput naming each row."""
    rows = list(islice(_rows(raw, path), MOST_ROWS + 1))
    if not rows:
        raise refusal(path, "no shot", "at least one row", "leave observations out")
    if len(rows) > MOST_ROWS:
        raise refusal(
            path, f"more than {MOST_ROWS} rows", f"at most {MOST_ROWS} rows", "split the table"
        )
    read: list[Observation] = []
    findings = Findings()
    for where, row in rows:
        try:
            read.append(_observation(row, allowed, where))
        except InvalidInput as error:
            findings.extend(error.findings)
    if findings:
        raise InvalidInput(findings)
    return tuple(read)


def _rows(raw: object, path: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
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


def _observation(row: Mapping[str, Any], allowed: AllowedNames, where: str) -> Observation:
    """One row; raises InvalidInput with every finding in it."""
    findings = Findings()
    cells: dict[str, Any] = {}
    for header, raw in row.items():
        try:
            name, cell = _cell(header, raw, where)
            if name not in OWN_COLUMNS:
                cell = _parameter(name, cell, allowed, where)
            if name in cells:
                raise refusal(
                    f"{where}.{name}", header, "each column once", "remove one of the two"
                )
            cells[name] = cell
        except InvalidInput as error:
            findings.extend(error.findings)
    findings.extend(
        Finding(
            f"{where}: {name}", "nothing", f"a column {name!r}", f"give the {name} of each shot"
        )
        for name in NEEDED_COLUMNS
        if cells.get(name) in (None, "")
    )
    if findings:
        raise InvalidInput(findings)
    return _checked(cells, allowed, where)


def _cell(header: object, raw: Any, where: str) -> tuple[str, Any]:
    """The name of a column, and a cell with the unit of the column beside a bare number."""
    match = _HEADER.fullmatch(header.strip()) if isinstance(header, str) else None
    unit = match[2].strip() if match and match[2] is not None else None
    if match is None or unit == "":
        raise refusal(f"{where}: {shown(header)}", header, "name [unit]", "write 'speed [km/s]'")
    cell = raw.strip() if isinstance(raw, str) else raw
    is_bare = is_number(cell) or (
        isinstance(cell, str) and len(cell) <= LONGEST_NUMBER and _NUMBER.fullmatch(cell)
    )
    return match[1], f"{cell} {unit}" if is_bare and unit not in (None, "1", "-") else cell


def _parameter(name: str, cell: Any, allowed: AllowedNames, where: str) -> Value:
    """A parameter of the shot; an empty cell states nothing."""
    parameter = find(allowed.parameters, name, f"{where}:")
    if cell in (None, ""):
        return None
    return parse_value(parameter, cell, f"{where}: {name}", materials=allowed.materials)


def _checked(cells: Mapping[str, Any], allowed: AllowedNames, where: str) -> Observation:
    quantity, source = cells["quantity"], cells["source"]
    if quantity not in allowed.quantities:
        cure = nearest_cure(quantity, allowed.quantities)
        raise refusal(f"{where}: quantity", quantity, "what the scenario measures", cure)
    if not isinstance(source, str):
        raise refusal(f"{where}: source", source, "a text", "name the publication of the shot")
    unit = allowed.quantities[quantity]
    uncertainty = cells.get("uncertainty")
    return Observation(
        quantity,
        _size("value", cells["value"], unit, where),
        None if uncertainty in (None, "") else _size("uncertainty", uncertainty, unit, where),
        source,
        {n: v for n, v in cells.items() if n not in OWN_COLUMNS and v is not None},
    )


def _size(name: str, cell: Any, unit: str, where: str) -> float:
    """A measured size: zero or more."""
    size = Parameter(name=name, kind="quantity", unit=unit, meaning=name, minimum=0.0)
    value = parse_value(size, cell, f"{where}: {name}")
    assert isinstance(value, float)
    return value
