"""Observations: measured shots, published or the user's own, with uncertainty and source.

A sweep brings its shots as a table, one row a shot, wide or long: docs/own-shots.md. ``sweeps`` reads and writes them.

How to add a published table: a CSV file in this folder, named after the shots, which a sweep names in place of its own
file, ``observations: craters``. Its ``confidence`` is a word of ``studies.materials.schema.CONFIDENCES``; facts that
have no column stand in its ``note``, and shots that no scenario computes in remarks. What was published as a range
alone is written as one, "27.5 to 34.5", and a material as "aluminium of unknown alloy" where its source names none:
such shots are listed and drawn, and nothing is compared with them.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files

from studies.observations.table import (
    ABOVE,
    BELOW,
    TEXT_COLUMNS,
    TO,
    FindingsOfRows,
    exact,
    heading_of,
    is_nothing,
    rows_of,
    stated,
    yes_or_no,
)
from studies.quantities.findings import Finding, Findings, nearest_cure, refusal
from studies.quantities.parameters import Parameter, Plain, Value, parse_value
from studies.quantities.units import readable

LONG_COLUMNS = ("quantity", "value", "uncertainty")  # of a long table
OWN_COLUMNS = (*LONG_COLUMNS, *TEXT_COLUMNS)
UNCERTAINTY = "_uncertainty"  # hole_diameter_uncertainty: the column of a wide table beside hole_diameter
COLUMNS = (
    "give a column for each measured quantity (or quantity, value, uncertainty), the source, and one for each "
    "parameter; confidence and note may be left out: docs/own-shots.md"
)
UNKNOWN_ALLOY = " of unknown alloy"  # behind the metal, in place of the name of a material
OUTCOMES = ("perforated", "failed")  # ends of the names of quantities that say yes (1) or no (0)
OF_SIZES = ("m", "m3")  # units of sizes, of which none is 0

RangeBounds = tuple[float | None, float | None]  # SI, of a range; None where it is open


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
    bounds: RangeBounds | None = None  # of what was published as a range alone

    def document(self, allowed: "AllowedNames") -> dict[str, Plain]:
        """The shot as a row that ``read_observations`` reads as itself."""
        unit = allowed.quantities[self.quantity]
        row = {name: written(value, allowed.parameters[name].unit) for name, value in self.parameters.items()}
        value = written(self.value, unit) if self.bounds is None else written_bounds(self.bounds, unit)
        row |= {"quantity": self.quantity, "value": value, "uncertainty": written(self.uncertainty, unit)}
        row |= {name: getattr(self, name) for name in TEXT_COLUMNS}
        return {name: cell for name, cell in row.items() if name in self.parameters or cell not in (None, "")}


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


def written(value: Value, unit: str | None) -> Value:
    """A value as a person writes it: a quantity with its unit, everything else unchanged."""
    if unit is None or unit == "1" or value is None:
        return value
    return readable(float(value), unit)


def written_bounds(bounds: RangeBounds, unit: str) -> str:
    """A range as a person writes it, and as ``read_observations`` reads it.

    >>> written_bounds((0.0275, 0.0345), "m"), written_bounds((0.0183, None), "m")
    ('27.5 mm to 34.5 mm', '> 18.3 mm')
    """
    low, high = (None if bound is None else readable(bound, unit) for bound in bounds)
    if low is None or high is None:
        return f"{BELOW} {high}" if low is None else f"{ABOVE} {low}"
    return f"{low}{TO}{high}"


def read_observations(raw: object, allowed: AllowedNames, path: str = "observations") -> tuple[Observation, ...]:
    """The shots of a CSV text, of a list of mappings, or of the published table of a name.

    Raises InvalidInput with an error for each column that is refused, and the rows.
    """
    # A single line without a comma is a name.
    if isinstance(raw, str) and raw.strip() and not set("\n,") & set(raw.strip()):
        raw = text(raw.strip())
    rows = rows_of(raw, path, COLUMNS)
    if not rows:
        raise refusal(path, "no shot", "at least one row", "leave observations out")
    read: list[Observation] = []
    findings = FindingsOfRows(path)
    for where, row in rows:
        with findings.of(where):
            read.extend(_observations(row, allowed, where))
    findings.check()
    return tuple(read)


@dataclass(frozen=True)
class _Cell:
    """What stands in a column of a row."""

    raw: Plain
    unit: str | None  # of the column
    where: str


def _observations(row: Mapping[str, Plain], allowed: AllowedNames, where: str) -> list[Observation]:
    """The shots of a row, one for each measured quantity; raises InvalidInput with every finding in it."""
    findings = Findings()
    measurable = {name + end for name in allowed.quantities for end in ("", UNCERTAINTY)}
    columns = {*allowed.parameters, *measurable, *OWN_COLUMNS}
    cells: dict[str, _Cell] = {}
    parameters: dict[str, Value] = {}
    inexact: list[str] = []  # parameters that are stated with an uncertainty, for the note

    def read(heading: str, raw: Plain) -> None:
        name, unit = heading_of(heading, columns, where)
        if name in cells:
            raise refusal(f"{where}.{name}", heading, "each column once", "remove one of the two")
        text = raw.strip() if isinstance(raw, str) else raw
        cell = cells[name] = _Cell(None if is_nothing(raw) else text, unit, f"{where}: {name}")
        if name not in OWN_COLUMNS and name not in measurable:
            parameters[name], note = _parameter(name, cell, allowed)
            inexact.extend([note] if note else [])

    for item in row.items():
        findings.attempt(read, *item)
    measured = [name for name in cells if name in allowed.quantities]
    # A refused column of a wide table may be the one that is measured: its own finding says which is meant.
    incomplete: list[Finding] = []
    if not findings or measured or not {*LONG_COLUMNS}.isdisjoint(cells):
        incomplete += _missing(cells, measured, where)
    if measured:
        incomplete += (
            Finding(f"{where}: {name}", name, "a table with one way to name quantities", COLUMNS)
            for name in LONG_COLUMNS
            if name in cells
        )
    findings.extend(incomplete)
    known = {name: value for name, value in parameters.items() if value is not None}
    shots = None
    if not incomplete and (measured or "quantity" in cells):
        shots = findings.attempt(list, _checked(cells, measured, allowed, known, inexact))
    findings.check()
    return shots or []


def _missing(cells: Mapping[str, _Cell], measured: Sequence[str], where: str) -> Iterator[Finding]:
    """A finding for each thing that a row needs and does not have."""
    needed = ("source",) if measured else ("quantity", "value", "source")
    for name in needed:
        if name not in cells or cells[name].raw is None:
            limit = f"a column {name!r}"
            yield Finding(f"{where}: {name}", "nothing", limit, f"give the {name} of each shot")
    if measured and all(cells[name].raw is None for name in measured):
        cure = "remove the row, or give what was measured"
        yield Finding(f"{where}: {measured[0]}", "nothing", "one measured quantity a row", cure)


def _parameter(name: str, cell: _Cell, allowed: AllowedNames) -> tuple[Value, str]:
    """A parameter of the shot, and how it is stated where that is no exact number; an empty cell states nothing."""
    if name not in allowed.parameters:
        columns = {*allowed.parameters, *allowed.quantities, *TEXT_COLUMNS}
        limit = "a column named after a parameter or a measured quantity of the scenario"
        raise refusal(cell.where, name, limit, nearest_cure(name, columns))
    parameter = allowed.parameters[name]
    if cell.raw is None:
        return None, ""
    if parameter.kind == "material" and isinstance(cell.raw, str) and cell.raw.endswith(UNKNOWN_ALLOY):
        return cell.raw, ""
    return exact(parameter, cell.raw, cell.unit, cell.where, allowed.materials)


def _checked(
    cells: Mapping[str, _Cell],
    measured: Sequence[str],
    allowed: AllowedNames,
    parameters: Mapping[str, Value],
    inexact: Sequence[str],
) -> Iterator[Observation]:
    """The shots of a row whose columns are complete; raises InvalidInput with every finding."""
    texts = {name: _text(name, cells.get(name)) for name in TEXT_COLUMNS}
    findings = Findings()
    columns: list[tuple[Plain, str]] = [(name, name) for name in measured] or [(cells["quantity"].raw, "value")]
    for quantity, column in columns:
        if not isinstance(quantity, str) or quantity not in allowed.quantities:
            cure = nearest_cure(quantity, allowed.quantities)
            raise refusal(cells["quantity"].where, quantity, "what the scenario measures", cure)
        beside = cells.get(f"{quantity}{UNCERTAINTY}" if measured else "uncertainty")
        size = findings.attempt(_size, quantity, cells[column], beside, allowed.quantities[quantity])
        if size is not None:
            value, uncertainty, bounds, about = size
            notes = (texts["note"], *inexact, *([about] if about else []))
            note = "; ".join(dict.fromkeys(filter(None, notes)))
            yield Observation(
                quantity, value, uncertainty, **{**texts, "note": note}, parameters=parameters, bounds=bounds
            )
    findings.check()


def _text(name: str, cell: _Cell | None) -> str:
    if cell is None or cell.raw is None:
        return ""
    if not isinstance(cell.raw, str):
        cure = "name the publication of the shot" if name == "source" else "quote it, or leave it out"
        raise refusal(cell.where, cell.raw, "a text", cure)
    return cell.raw


def _size(
    quantity: str, cell: _Cell, beside: _Cell | None, unit: str
) -> tuple[float | None, float | None, RangeBounds | None, str] | None:
    """Value, uncertainty, bounds and a note of a measured quantity; None where nothing was measured.

    The uncertainty stands in the cell or in the column ``beside`` it. One that is about a number ("~6.7") has none but
    that of the column: nothing is tested by it.
    """
    is_beside = beside is not None and beside.raw is not None
    plus_minus = _number(beside, stated(beside.raw, beside.unit).value, unit) if beside and is_beside else None
    if cell.raw is None:
        return None
    if quantity.endswith(OUTCOMES) and not isinstance(cell.raw, float):
        return float(yes_or_no(cell.raw, cell.where)), plus_minus, None, ""
    number = stated(cell.raw, cell.unit)
    about = f"{quantity} {number.about}" if number.about and number.plus_minus is None else ""
    if number.bounds is not None:
        low, high = (None if side is None else _number(cell, side, unit) for side in number.bounds)
        if low is not None and high is not None and low >= high:
            cure = "write the smaller bound first, or the value alone"
            raise refusal(cell.where, cell.raw, "two bounds that ascend", cure)
        return None, plus_minus, (low, high), about
    value = _number(cell, number.value, unit)
    if unit in OF_SIZES and value == 0.0:
        cure = "leave it empty: a plate that held has no hole, and what has no size is compared with nothing"
        raise refusal(cell.where, cell.raw, "a measured size above 0", cure)
    if number.plus_minus is not None:
        if plus_minus is not None:
            raise refusal(cell.where, cell.raw, "one uncertainty", f"leave it here, or in the column beside {quantity}")
        plus_minus = _number(cell, number.plus_minus, unit)
    return value, plus_minus, None, about


def _number(cell: _Cell, raw: Plain, unit: str) -> float:
    """A number of a cell, SI: zero or more."""
    size = Parameter(name=cell.where, kind="quantity", unit=unit, meaning="", minimum=0.0)
    value = parse_value(size, raw, cell.where)
    assert isinstance(value, float)
    return value
