"""Checked parameters: values that a person wrote, against the annotations and limits of a record.

A record is a frozen dataclass whose fields are annotated with a unit alias, ``str``, ``int``, ``bool``, a ``Literal``,
``MaterialName``, or one of these ``| None``, and with ``Described``, which gives its meaning and bounds. A model of the
solver is a NamedTuple: its ``Described`` fields are parameters, the others are computed. A record may hold other
records, and lists of them (``Places``): at the door their fields stand beside its own (``flat``, ``nested``).
"""

import dataclasses
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass
from datetime import date
from decimal import Decimal
from functools import cache
from itertools import chain, zip_longest
from types import MappingProxyType, NoneType, UnionType
from typing import Annotated, Literal, TypeAlias, TypeVar, Union, get_args, get_origin, get_type_hints

from solver.units import Described, Unit, marked
from studies.quantities.findings import Finding, Findings, InvalidInput, nearest_cure, refusal, unknown_keys
from studies.quantities.units import (
    Bounds,
    a_quantity,
    exact_number,
    is_number,
    parse_quantity,
    readable,
    round_quantity,
)

Value = float | int | bool | str | None
# What JSON, YAML and TOML hold; a date is of YAML alone, a decimal of TOML.
Plain: TypeAlias = "Value | Decimal | date | Sequence[Plain] | Mapping[str, Plain]"
Record = TypeVar("Record")
Mark = TypeVar("Mark")
Number = TypeVar("Number", float | None, Value)
ParameterKind = Literal["quantity", "integer", "boolean", "text", "choice", "material"]

LONGEST_WORD = 200  # characters of a text parameter that says no more


class _MaterialMark:
    """Marks a text that names a material."""


MaterialName = Annotated[str, _MaterialMark()]


@dataclass(frozen=True)
class LongText:
    """Marks a text of several lines, such as an input file, and the most characters that it has."""

    longest: int


@dataclass(frozen=True)
class Choice:
    """Marks a text that is one of the names that a function lists, such as the entries of a registry."""

    names: Callable[[], Iterable[str]]


@dataclass(frozen=True)
class Places:
    """Marks a tuple of records by the names of their places, such as "bumper_2".

    At the door the name of its place stands before that of a field, or for the ``head`` with which that begins
    ("bumper_2_thickness" for "bumper_thickness"); "{place}" in its meaning is filled in. A document may have them as a
    list, too (``by_place``).
    """

    names: tuple[str, ...]
    head: str
    key: str  # of the list
    example: str  # an element of it

    def door(self, record: type) -> Iterator[tuple[str, dict[str, str]]]:
        """The name of each place, and at the door those of the fields there."""
        for place in self.names:
            yield place, {name: self._at(place, name) for name in declared(record)}

    def _at(self, place: str, name: str) -> str:
        return place if name == self.head else f"{place}_{name.removeprefix(f'{self.head}_')}"


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One field that a person may set: what it holds and what it allows."""

    name: str
    kind: ParameterKind
    unit: str | None = None  # SI symbol, "1" for a plain number; None for words
    meaning: str = ""
    minimum: float | None = None  # SI, inclusive, at the 12 digits of what it bounds
    maximum: float | None = None  # SI, inclusive, likewise
    choices: tuple[str, ...] = ()
    longest: int = LONGEST_WORD  # characters of a text
    optional: bool = False  # null is an answer
    required: bool = True  # there is no default
    default: Value = None

    @property
    def bounds(self) -> Bounds:
        """The allowed numbers."""
        return Bounds(self.minimum, self.maximum)

    def limit(self) -> str:
        """The allowed values as a text."""
        if self.choices:
            return "one of " + ", ".join(self.choices)
        if self.kind == "text":
            return f"a text of at most {self.longest} characters"
        if self.unit is None:
            return _WORDS[self.kind]
        what = "a whole number" if self.kind == "integer" else a_quantity(self.unit)
        return what + _between(self.minimum, self.maximum, self.unit)


@cache
def declared(record: type) -> Mapping[str, Parameter]:
    """The parameters that a record declares, by name; TypeError for an annotation of no use."""
    if dataclasses.is_dataclass(record):
        names = [field.name for field in dataclasses.fields(record)]
        defaults = {f.name: f.default for f in dataclasses.fields(record) if f.default is not MISSING}
    else:
        names = list(marked(record, Described))
        defaults = record._field_defaults  # type: ignore[attr-defined]
    hints: dict[str, type] = get_type_hints(record)
    parts, lists, parameters = _parts(record), _lists(record), dict[str, Parameter]()
    for name in names:
        if name in lists:
            parameters |= dict(_declared_at(*lists[name]))
        else:
            parameters |= (
                declared(parts[name]) if name in parts else {name: _parameter(record, name, hints[name], defaults)}
            )
    return MappingProxyType(parameters)


def _declared_at(places: Places, record: type) -> Iterator[tuple[str, Parameter]]:
    """The parameters of the records of a list, each at its place."""
    for place, names in places.door(record):
        for field, name in names.items():
            inner = declared(record)[field]
            meaning = inner.meaning.format(place=place.replace("_", " "))
            yield name, dataclasses.replace(inner, name=name, meaning=meaning)


def grouped(record: type) -> Mapping[str, tuple[str, ...]]:
    """The names of a record's parameters by the field whose record holds them; of its own, under an empty name."""
    groups = {name: tuple(declared(part)) for name, part in _parts(record).items()}
    inside = {name for names in groups.values() for name in names}
    own = tuple(name for name in declared(record) if name not in inside)
    return {**({"": own} if own else {}), **groups}


def marks(record: type, kind: type[Mark]) -> Mapping[str, Mark]:
    """The mark of a kind of each parameter that carries one."""
    wanted: type = kind
    inside = [marked(record, wanted), *(marks(part, kind) for part in _parts(record).values())]
    for places, part in _lists(record).values():
        of_part = marks(part, kind)
        inside += [{names[field]: mark for field, mark in of_part.items()} for _, names in places.door(part)]
    return {name: mark for found in inside for name, mark in found.items()}


def flat(record: Record) -> dict[str, Value]:
    """The values of a record by name, those of the records inside it in their places; None where a list has none."""
    kind: type = type(record)
    parts, lists, values = _parts(kind), _lists(kind), dict[str, Value]()
    for name, value in vars(record).items():
        if name in lists:
            places, part = lists[name]
            for (_, names), inner in zip_longest(places.door(part), value):
                values |= {door: getattr(inner, field, None) for field, door in names.items()}
        else:
            values |= flat(value) if name in parts else {name: value}
    return values


def nested(record: type[Record], values: Mapping[str, Value]) -> Record:
    """A record from its ``flat`` values; what is left out has its default. TypeError for a name that it has not."""
    own = dict(values)
    return record(
        **{name: _listed(*part, own) for name, part in _lists(record).items()},  # type: ignore[arg-type]
        **{
            name: nested(part, {n: own.pop(n) for n in declared(part) if n in own})
            for name, part in _parts(record).items()  # type: ignore[arg-type]
        },
        **own,
    )


def _listed(places: Places, record: type[Record], values: dict[str, Value]) -> tuple[Record, ...]:
    """The records of a list, of values that are taken out; the last one has some."""
    given = [
        {field: value for field, name in names.items() if (value := values.pop(name, None)) is not None}
        for _, names in places.door(record)
    ]
    count = max((number for number, own in enumerate(given, 1) if own), default=0)
    return tuple(record(**own) for own in given[:count])


@cache
def lists_of(record: type) -> Mapping[str, tuple[Places, type]]:
    """The lists of records of a record, and of those inside it, by their key in a document."""
    inside = (lists_of(part).items() for part in _parts(record).values())
    own = ((places.key, (places, part)) for places, part in _lists(record).values())
    return dict(chain(own, *inside))


def by_place(values: Mapping[str, Plain], path: str, *records: type) -> dict[str, Plain]:
    """Values of parameters, those of each list of the records in their places; raises InvalidInput."""
    placed = dict(values)
    for key, (places, part) in {key: found for record in records for key, found in lists_of(record).items()}.items():
        if key in placed:
            for name, value, field in _in_places(placed.pop(key), join(path, key), places, part):
                if name in placed:
                    raise refusal(field, value, "each value once", f"remove {name}")
                placed[name] = value
    return placed


def _in_places(elements: Plain, field: str, places: Places, part: type) -> Iterator[tuple[str, Plain, str]]:
    """The name at the door of each value in a list, the value, and its path in the document."""
    limit = f"a list of at most {len(places.names)} {places.head}s, each with {', '.join(declared(part))}"
    if isinstance(elements, str) or not isinstance(elements, Sequence) or len(elements) > len(places.names):
        raise refusal(field, elements, limit, f"write [{places.example}]")
    for number, ((_, names), element) in enumerate(zip(places.door(part), elements, strict=False)):
        path = f"{field}[{number}]"
        if not isinstance(element, Mapping):
            raise refusal(path, element, limit, f"write {places.example}")
        if findings := [*unknown_keys(element, names, path, f"a word of a {places.head}")]:
            raise InvalidInput(findings)
        for word, value in element.items():
            yield names[word], value, f"{path}.{word}"


def parse_parameters(record: type, raw: Mapping[str, Plain], path: str = "", *, si: bool = False) -> dict[str, Value]:
    """All parameters of a record, checked, in SI, defaults filled in also where null is written.

    ``path`` goes before each field name in a finding; with ``si`` a bare number on a field with a unit is taken as SI
    (a value that was parsed before). Raises InvalidInput with every finding.
    """
    parameters = declared(record)
    findings = Findings()
    values = parse_values(parameters, raw, path, findings, si=si)
    for parameter in parameters.values():
        if parameter.name not in raw and parameter.required:
            findings.append(missing(parameter, path))
        if raw.get(parameter.name) is None and not parameter.required:
            values[parameter.name] = _rounded(parameter.default)
    findings.check()
    return {name: values[name] for name in parameters}


def parse_values(
    parameters: Mapping[str, Parameter],
    raw: Mapping[str, Plain],
    path: str,
    findings: Findings,
    *,
    materials: Collection[str] = (),
    si: bool = False,
) -> dict[str, Value]:
    """The valid values; the errors of the others are added to ``findings``."""

    def read(name: str, value: Plain) -> None:
        parameter = find(parameters, name, path)
        values[name] = parse_value(parameter, value, join(path, name), materials=materials, si=si)

    values: dict[str, Value] = {}
    for item in raw.items():
        findings.attempt(read, *item)
    return values


def parse_value(
    parameter: Parameter, raw: Plain, field: str, *, materials: Collection[str] = (), si: bool = False
) -> Value:
    """One value, checked, in SI, at 12 significant digits; raises InvalidInput."""
    if raw is None:
        if parameter.optional:
            return None
        raise refusal(field, raw, parameter.limit(), "give a value, or leave the field out")
    if parameter.kind == "quantity":
        if si and is_number(raw):
            exact = exact_number(raw, field)
        elif parameter.unit == "1":
            exact = exact_number(raw, field, readable(parameter.bounds.nearest(0.5), "1"))
        else:
            exact = parse_quantity(raw, parameter.unit or "1", field, parameter.bounds)
        return _within(round_quantity(exact), parameter, raw, field)
    if parameter.kind == "integer":
        number = exact_number(raw, field, str(parameter.bounds.nearest(1)))
        if number != number.to_integral_value():
            raise refusal(field, raw, parameter.limit(), f"write {parameter.bounds.nearest(round(number))}")
        return int(_within(int(number), parameter, raw, field))
    if parameter.kind == "boolean":
        if not isinstance(raw, bool):
            raise refusal(field, raw, parameter.limit(), "write true or false")
        return raw
    if parameter.kind == "text":
        if not isinstance(raw, str) or not raw.strip() or len(raw) > parameter.longest:
            raise refusal(field, raw, parameter.limit(), "write a text")
        # Lines of a file keep their numbers.
        return raw.strip() if parameter.longest == LONGEST_WORD else raw
    names, limit = parameter.choices, parameter.limit()
    if parameter.kind == "material":
        names = tuple(materials)
        limit = "a material that ships or that the sweep brings" if raw and isinstance(raw, str) else limit
    if not isinstance(raw, str) or not raw or (names and raw not in names):
        raise refusal(field, raw, limit, nearest_cure(raw, names))
    return raw


def find(parameters: Mapping[str, Parameter], name: object, path: str = "") -> Parameter:
    """The parameter of a name; raises InvalidInput with the nearest one."""
    if isinstance(name, str) and name in parameters:
        return parameters[name]
    raise refusal(join(path, name), name, "a name of a parameter", nearest_cure(name, parameters))


def missing(parameter: Parameter, path: str = "") -> Finding:
    """The error for a required parameter that is missing."""
    cure = f"give {parameter.meaning}" if parameter.meaning else f"give {parameter.name}"
    return Finding(join(path, parameter.name), "nothing", parameter.limit(), cure)


def join(path: str, name: object) -> str:
    """A dotted path: "fixed" and "speed" make "fixed.speed"."""
    return f"{path}.{name}" if path else str(name)


def _rounded(value: Number) -> Number:
    return round_quantity(value) if isinstance(value, float) else value


@cache
def _parts(record: type) -> Mapping[str, type]:
    """The records inside a record, by field."""
    hints: dict[str, type] = get_type_hints(record)
    return {name: hint for name, hint in hints.items() if dataclasses.is_dataclass(hint)}


@cache
def _lists(record: type) -> Mapping[str, tuple[Places, type]]:
    """The lists of records inside a record, by field: their places, and the record of each."""
    hints = get_type_hints(record)
    return {name: (places, get_args(hints[name])[0]) for name, places in marked(record, Places).items()}


def _parameter(record: type, name: str, hint: type, defaults: Mapping[str, Value]) -> Parameter:
    inside = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    inner = [part for part in inside if part is not NoneType]
    kind = _kind(record, name, inner)
    about = marked(record, Described).get(name, Described(""))
    choices = marked(record, Choice)[name].names() if name in marked(record, Choice) else get_args(inner[0])
    return Parameter(
        name=name,
        kind=kind,
        unit=marked(record, Unit)[name].symbol if kind == "quantity" else "1" if kind == "integer" else None,
        meaning=about.meaning,
        minimum=_rounded(about.minimum),
        maximum=_rounded(about.maximum),
        choices=tuple(choices) if kind == "choice" else (),
        longest=marked(record, LongText)[name].longest if name in marked(record, LongText) else LONGEST_WORD,
        optional=NoneType in inside,
        required=name not in defaults,
        default=defaults.get(name),
    )


def _kind(record: type, name: str, inner: Sequence[type]) -> ParameterKind:
    """The kind of a field with one of some types, and its marks."""
    if name in marked(record, _MaterialMark):
        return "material"
    if name in marked(record, Choice) or get_origin(inner[0]) is Literal:
        return "choice"
    if name in marked(record, Unit):
        return "quantity"
    plain: dict[type, ParameterKind] = {int: "integer", bool: "boolean", str: "text"}
    if len(inner) > 1 or inner[0] not in plain:
        raise TypeError(f"{name}: {inner} is not a unit alias, int, bool, str, Literal or MaterialName")
    return plain[inner[0]]


def _within(value: float, parameter: Parameter, raw: Plain, field: str) -> float:
    nearest = parameter.bounds.nearest(value)
    if nearest != value:
        assert parameter.unit is not None
        cure = f"the nearest allowed value is {readable(nearest, parameter.unit)}"
        raise refusal(field, raw, parameter.limit(), cure)
    return value


def _between(minimum: float | None, maximum: float | None, unit: str) -> str:
    """The bounds as a text with a leading space; empty without bounds."""
    texts = [
        f"{side} {readable(bound, unit)}" for side, bound in (("from", minimum), ("to", maximum)) if bound is not None
    ]
    return " " + " ".join(texts) if texts else ""


def describe(parameters: Iterable[Parameter]) -> list[dict[str, Plain]]:
    """Parameters as plain objects, for a catalogue."""
    return [dataclasses.asdict(parameter) | {"limit": parameter.limit()} for parameter in parameters]


_WORDS: dict[ParameterKind, str] = {"boolean": "true or false", "material": "the name of a material"}
