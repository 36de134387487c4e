"""A material document (TOML file, or the same schema inline) becomes a checked ``Material``."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace

from studies.materials.schema import (
    CONFIDENCES,
    OPTIONAL,
    SECTIONS,
    TEXTS,
    Constant,
    Material,
    Scalars,
    YieldStress,
    models,
    record_of,
)
from studies.quantities.findings import Finding, Findings, nearest_cure, refusal, shown, unknown_keys
from studies.quantities.parameters import Parameter, Plain, Value, declared, join, missing, parse_value
from studies.quantities.units import convert, exact_number, round_quantity

STATED = "stated by the user"  # the source of a number that names none
NUMBER_KEYS = ("value", "unit", "source", "confidence")
LONGEST_TEXT = 200  # characters of a title
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")


def read_document(
    document: Plain, *, name: str | None = None, path: str = "", base: Material | None = None
) -> Material:
    """The material of a document, upon a ``base``; ``path`` goes before each key of a finding. Raises InvalidInput."""
    if not isinstance(document, Mapping):
        limit, cure = "a material: names and values", "name a material that ships as its base"
        raise refusal(path or "material", document, limit, cure)
    return _MaterialReading(document, name, path, base).material()


def _changed(base: Mapping[str, Plain], document: Mapping[str, Plain]) -> dict[str, Plain]:
    """The document of a base with what another one gives; a section of another kind is another section."""
    changed = {**base, **document}
    for section in SECTIONS:
        before, given = base.get(section), document.get(section)
        if isinstance(before, Mapping) and isinstance(given, Mapping):
            is_alike = given.get("kind", before.get("kind")) == before.get("kind")
            changed[section] = {**before, **given} if is_alike else given
    return changed


class _MaterialReading:
    """A document being read: the numbers with their sources, and the findings."""

    def __init__(self, document: Mapping[str, Plain], name: str | None, path: str, base: Material | None):
        taken = {} if base is None else base.document()
        taken = {key: value for key, value in taken.items() if key not in ("name", "title")}
        self.document = _changed(taken if name is None else {**taken, "name": name}, document)
        self.name = name
        self.path = path
        self.findings = Findings()
        self.sources: dict[str, Constant] = {}

    def material(self) -> Material:
        """The whole document."""
        self._refuse_unknown(self.document, (*TEXTS, *declared(Scalars), *SECTIONS, "yield_stresses"), "")
        for text in ("title", "family", "alloy"):
            self.document.setdefault(text, self.document.get("name"))
        self._refuse_absent()
        plain: dict[str, Plain] = {text: self._text(text) for text in TEXTS}
        plain |= self._record(Scalars, self.document, "")
        plain |= {section: self._section(section) for section in SECTIONS if section in self.document}
        plain["yield_stresses"] = self._yield_stresses()
        self.findings.check()
        return replace(Material.from_resolved(plain), sources=self.sources)

    def _at(self, key: str) -> str:
        return join(self.path, key)

    def _refuse(self, key: str, value: Plain, limit: str, cure: str) -> None:
        self.findings.append(Finding(self._at(key), shown(value), limit, cure))

    def _refuse_unknown(self, raw: Iterable[str], keys: tuple[str, ...], path: str) -> None:
        for key in raw:
            if key not in keys:
                sections = [] if path else self._sections_with(str(key).rpartition(".")[2])
                cure = f"write it under {' or '.join(sections)}" if sections else nearest_cure(key, keys)
                self._refuse(join(path, key), key, "a key of a material", cure)

    def _sections_with(self, constant: str) -> list[str]:
        """The sections that have a constant of a name: in the kind that the document gives, else in any."""
        sections = []
        for section, record in SECTIONS.items():
            given = self.document.get(section)
            kind = given.get("kind") if isinstance(given, Mapping) else None
            kinds = {} if isinstance(record, type) else models(section)
            records = [model.record for name, model in kinds.items() if kind in (None, name)]
            if any(constant in declared(one) for one in ([record] if isinstance(record, type) else records)):
                sections.append(section)
        return sections

    def _refuse_absent(self) -> None:
        """What a material without base has to have, in one finding."""
        needed = [name for name, scalar in declared(Scalars).items() if scalar.required]
        needed += [section for section in SECTIONS if section not in OPTIONAL]
        absent = [name for name in needed if name not in self.document]
        if absent:
            limit = f"a material with {', '.join(needed)}"
            cure = "give them, or name a material that ships as its base"
            value = f"nothing for {', '.join(absent)}"
            self.findings.append(Finding(self.path or "material", value, limit, cure))

    def _text(self, key: str) -> str:
        raw = self.document.get(key)
        limit = "a name of letters, digits, - and _" if key == "name" else "a text"
        right = isinstance(raw, str) and 0 < len(raw.strip()) <= LONGEST_TEXT
        if right and key == "name":
            right = _NAME.fullmatch(str(raw)) is not None
            if self.name not in (None, raw):
                right, limit = False, f"{self.name}, under which it stands"
        if not right:
            self._refuse(key, raw, limit, f"give the material a {key}")
        return str(raw).strip()

    def _section(self, section: str) -> dict[str, Plain]:
        """The constants of a section, and its kind where it has kinds; empty where it was refused."""
        raw = self.document[section]
        if not isinstance(raw, Mapping):
            self._refuse(section, raw, "the names and values of its constants", f"give {section} with them")
            return {}
        record = self.findings.attempt(record_of, section, raw.get("kind"), self._at(section))
        if record is None:
            return {}
        kind = {} if record is SECTIONS[section] else {"kind": raw["kind"]}
        self._refuse_unknown(raw, (*kind, *declared(record)), section)
        return {**kind, **self._record(record, raw, section)}

    def _record(self, record: type, raw: Mapping[str, Plain], path: str) -> dict[str, Value]:
        """The numbers of one record by field name; a field with a default may be left out."""
        values: dict[str, Value] = {}
        absent: list[Parameter] = []
        for parameter in declared(record).values():
            if parameter.name in raw:
                place = join(path, parameter.name)
                constant = self.findings.attempt(_constant, parameter, raw[parameter.name], self._at(place))
                if constant is not None:
                    self.sources[place] = constant
                    values[parameter.name] = constant.value
            elif parameter.required and path:
                absent.append(parameter)
        if len(absent) == 1:
            self.findings.append(missing(absent[0], self._at(path)))
        elif absent:
            names = ", ".join(parameter.name for parameter in absent)
            limit = "; ".join(f"{p.name}: {p.meaning}, {p.limit()}" for p in absent)
            self.findings.append(Finding(self._at(path), f"nothing for {names}", limit, "give them"))
        return values

    def _yield_stresses(self) -> list[Plain]:
        raw = self.document.get("yield_stresses", [])
        if not isinstance(raw, list):
            self._refuse("yield_stresses", raw, "a list of yield stresses", "give each with label and value")
            return []
        read = [self.findings.attempt(self._yield_stress, stress, index) for index, stress in enumerate(raw)]
        return [stress for stress in read if stress is not None]

    def _yield_stress(self, raw: Plain, index: int) -> dict[str, Value]:
        where = self._at(f"yield_stresses[{index}]")
        label = raw.get("label") if isinstance(raw, Mapping) else None
        if not isinstance(raw, Mapping) or not isinstance(label, str) or not label.strip():
            raise refusal(f"{where}.label", label, "a short label", "give it a label such as 'Y = 240 MPa'")
        label = label.strip()
        if f"yield_stresses.{label}" in self.sources:
            raise refusal(f"{where}.label", label, "each label once", "give it another label")
        numbers = {key: value for key, value in raw.items() if key != "label"}
        constant = _constant(declared(YieldStress)["value"], numbers, where)
        self.sources[f"yield_stresses.{label}"] = constant
        return {"label": label, "value": constant.value}


def _constant(parameter: Parameter, raw: Plain, where: str) -> Constant:
    """A checked number of a material, in SI, plain or with its source; raises InvalidInput with every error."""
    if not isinstance(raw, Mapping):
        return Constant(_plain(parameter, raw, where), parameter.unit or "1", STATED, "user")
    findings = Findings()
    findings.extend(unknown_keys(raw, NUMBER_KEYS, where, "a key of a number"))
    source, confidence = raw.get("source", STATED), raw.get("confidence", "user")
    if not isinstance(source, str) or not source.strip():
        cure = "name the source of the number, or leave it out"
        findings.append(Finding(f"{where}.source", shown(source), "a citation", cure))
    if not isinstance(confidence, str) or confidence not in CONFIDENCES:
        limit, cure = "one of " + ", ".join(CONFIDENCES), nearest_cure(confidence, CONFIDENCES)
        findings.append(Finding(f"{where}.confidence", shown(confidence), limit, cure))
    value = findings.attempt(_value, parameter, raw, where)
    findings.check()
    return Constant(value, parameter.unit or "1", str(source).strip(), str(confidence))


def _value(parameter: Parameter, raw: Mapping[str, Plain], where: str) -> float | None:
    """The value of a number whose unit stands beside it, or in it."""
    value, unit = raw.get("value"), raw.get("unit", "1")
    if value == "none" or "unit" not in raw:
        return _plain(parameter, value, f"{where}.value")
    number = exact_number(value, f"{where}.value")
    if unit != parameter.unit:
        if not isinstance(unit, str) or unit in ("", "1") or parameter.unit == "1":
            limit = f"a unit of {parameter.meaning}: {parameter.unit}"
            raise refusal(f"{where}.unit", unit, limit, f"the unit is {parameter.unit!r}")
        number = convert(number, unit, parameter.unit or "1", where)
    return _plain(parameter, round_quantity(number), where, si=True)


def _plain(parameter: Parameter, raw: Plain, where: str, *, si: bool = False) -> float | None:
    """A number that stands alone, with its unit in it: "900 MPa"; None where it is "none"."""
    value = parse_value(parameter, None if raw == "none" and parameter.optional else raw, where, si=si)
    assert value is None or isinstance(value, float)
    return value
