"""An axis of a sweep: a parameter and the values it takes, by list or by start, stop and step."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import TypeVar

from studies.observations import written
from studies.quantities.findings import Findings, refusal, unknown_keys
from studies.quantities.parameters import Parameter, Plain, Value, parse_value
from studies.quantities.units import exact_number, parse_quantity, readable, round_quantity
from studies.sweeps.search import Search

Item = TypeVar("Item")

RANGE_KEYS = ("start", "stop", "step")
FORMS = "a list of values, or start, stop and step"
EXAMPLE = "write [2 mm, 3 mm] or {start: 2 mm, stop: 4 mm, step: 1 mm}"

# Of a step: how near stop must be to a whole number of steps. Lengths are exact decimals, an angle
# in degrees is not.
HIT = Decimal("1e-9")


@dataclass(frozen=True)
class Axis:
    """A parameter that varies."""

    name: str  # as a user writes it: "target.strength.A"
    unit: str | None  # SI symbol; None for words
    values: tuple[Value, ...]  # SI, in the order given
    bounds: tuple[float, float] | None = None  # of an axis that is sampled; SI
    search: Search | None = None  # of an axis whose further values follow from results

    def document(self) -> Plain:
        """The axis as a document writes it: its values, and the ends of its range where it is sampled."""
        if self.search:
            return self.search.document()
        values = [written(value, self.unit) for value in self.values]
        if self.bounds is None:
            return values
        low, high = (written(end, self.unit) for end in self.bounds)
        return {"low": low, "high": high, "values": values}


@dataclass(frozen=True)
class AxisReader:
    """Turns a document's axis into an ``Axis``."""

    most_values: int
    materials: Collection[str]  # names that an axis over materials may take

    def read(self, parameter: Parameter, name: str, raw: Plain, field: str) -> Axis:
        """One axis, every value checked; raises InvalidInput with every finding."""
        if isinstance(raw, Mapping):
            values = self._range(parameter, raw, field)
        elif isinstance(raw, list | tuple):
            values = self._list(parameter, raw, field)
        else:
            raise refusal(field, raw, FORMS, EXAMPLE)
        return Axis(name, parameter.unit, tuple(values))

    def _list(self, parameter: Parameter, raw: Sequence[Plain], field: str) -> list[Value]:
        self._check_count(len(raw), field)
        findings = Findings()
        values = [findings.attempt(self._value, parameter, value, f"{field}[{at}]") for at, value in enumerate(raw)]
        findings.check()
        return values

    def _value(self, parameter: Parameter, raw: Plain, field: str) -> Value:
        if raw is None:
            raise refusal(field, raw, parameter.limit(), "give a value")
        return parse_value(parameter, raw, field, materials=self.materials)

    def _range(self, parameter: Parameter, raw: Mapping[str, Plain], field: str) -> list[Value]:
        if parameter.kind not in ("quantity", "integer"):
            raise refusal(field, raw, "a list of values", "write [first, second]")
        findings = Findings()
        findings.extend(unknown_keys(raw, RANGE_KEYS, field, FORMS))
        bounds = [findings.attempt(_bound, parameter, key, raw, field) for key in RANGE_KEYS]
        findings.check()
        start, stop, step = (bound for bound in bounds if bound is not None)
        unit = parameter.unit or "1"
        steps = (stop - start) / step if step else Decimal(-1)
        if steps < 0:
            limit = "a step that leads from start to stop"
            raise refusal(f"{field}.step", readable(float(step), unit), limit, "change the sign of the step")
        self._check_count(int(steps) + 1, field)
        if abs(steps - round(steps)) > HIT:
            below = readable(float(start + step * int(steps)), unit)
            above = readable(float(start + step * (int(steps) + 1)), unit)
            limit = "start plus a whole number of steps"
            cure = f"write stop: {below} or stop: {above}, or another step"
            raise refusal(f"{field}.stop", readable(float(stop), unit), limit, cure)
        values = [start + step * number for number in range(round(steps) + 1)]
        return [parse_value(parameter, round_quantity(value), field, si=True) for value in values]

    def _check_count(self, count: int, field: str) -> None:
        if count == 0:
            raise refusal(field, "no value", FORMS, "give at least one value")
        if count > self.most_values:
            limit = f"at most {self.most_values} values on an axis"
            raise refusal(field, f"{count} values", limit, "use fewer values, or split the sweep")


def repeated(values: Iterable[Item]) -> Iterator[Item]:
    """The values that stand a second time."""
    earlier: set[Item] = set()
    for value in values:
        if value in earlier:
            yield value
        earlier.add(value)


def _bound(parameter: Parameter, key: str, raw: Mapping[str, Plain], field: str) -> Decimal:
    """Start, stop or step, exact, in SI."""
    where = f"{field}.{key}"
    if raw.get(key) is None:
        raise refusal(where, None, FORMS, f"give {key}")
    if key != "step":
        parse_value(parameter, raw[key], where)  # the bounds of the parameter
    if parameter.kind == "integer":
        return exact_number(raw[key], where)
    return parse_quantity(raw[key], parameter.unit or "1", where)
