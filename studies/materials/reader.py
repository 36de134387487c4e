"""A material document (TOML file, or the same schema inline) becomes a checked ``Material``."""

import re
import tomllib
from collections.abc import Mapping
from decimal import Decimal
from typing import Any

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
    section_of,
)
from studies.quantities.findings import Finding, Findings, InvalidInput, nearest_cure, refusal, shown
from studies.quantities.parameters import Parameter, declared, join, missing, parse_value
from studies.quantities.units import convert, exact_number, round_quantity

STATED = "stated by the user"  # the source of a number that names none
NUMBER_KEYS = ("value", "unit", "source", "confidence")
LONGEST_TEXT = 200  # characters of a title
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")


def read_toml(text: str, file: str) -> dict[str, Any]:
    """A TOML text with exact decimals; raises InvalidInput that names the file."""
    try:
        return tomllib.loads(text, parse_float=Decimal)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise refusal(file, str(error), "a TOML document", "correct the line named") from None


def read_document(document: Any, *, name: str | None = None, path: str = "", base: Material | None = None) -> Material:
    """The material of a document; ``name`` where the document stands under a name of its own.

    ``path`` goes before each key in a finding; ``base`` gives what the document leaves out. Raises InvalidInput with
    every finding.
    """
    if not isinstance(document, Mapping):
        limit, cure = "a material: names and values", "name a material that ships as its base"
        raise refusal(path or "material", document, limit, cure)
    return _MaterialReading(document, name, path, base).material()


def _changed(base: Mapping[str, Any], document: Mapping[str, Any]) -> dict[str, Any]:
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

    def __init__(self, document: Mapping[str, Any], name: str | None, path: str, base: Material | None):
        taken = {} if base is None else base.document()
        taken = {key: value for key, value in taken.items() if key not in ("name", "title")}
        named = {} if name is None else {"name": name}
        self.document = _changed(taken | named, document)
        self.name = name
        self.path = path
        self.findings = Findings()
        self.sources: dict[str, Constant] = {}

    def material(self) -> Material:
        """The whole document."""
        self._refuse_unknown(self.document, (*TEXTS, *declared(Scalars), *SECTIONS, "yield_stresses"), "")
        self.document.setdefault("title", self.document.get("name"))
        self.document.setdefault("family", self.document.get("name"))
        self.document.setdefault("alloy", self.document.get("name"))
        self._refuse_absent()
        texts: dict[str, Any] = {text: self._text(text) for text in TEXTS}
        scalars: dict[str, Any] = self._record(Scalars, self.document, "")
        sections: dict[str, Any] = {section: self._section(section) for section in SECTIONS if section in self.document}
        yields = self._yield_stresses()
        if self.findings:
            raise InvalidInput(self.findings)
        return Material(**texts, **scalars, **sections, yield_stresses=yields, sources=self.sources)

    def _at(self, key: str) -> str:
        return f"{self.path} {key}" if self.path.endswith(":") else join(self.path, key)

    def _find(self, error: InvalidInput) -> None:
        self.findings.extend(error.findings)

    def _refuse_unknown(self, raw: Mapping[str, Any], keys: tuple[str, ...], path: str) -> None:
        for key in raw:
            if key not in keys:
                where = self._at(join(path, key))
                sections = [] if path else self._sections_with(str(key).rpartition(".")[2])
                cure = f"write it under {' or '.join(sections)}"
                cure = cure if sections else nearest_cure(key, keys)
                self.findings.append(Finding(where, shown(key), "a key of a material", cure))

    def _sections_with(self, constant: str) -> list[str]:
        """The sections that have a constant of a name: in the kind that the document gives, else in any."""
        sections = []
        for section, record in SECTIONS.items():
            given = self.document.get(section)
            kind = given.get("kind") if isinstance(given, Mapping) else None
            records = [record] if isinstance(record, type) else []
            if not records:
                kinds = models(section)
                records = [model.record for name, model in kinds.items() if kind in (None, name)]
            if any(constant in declared(each) for each in records):
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
            where = self.path.removesuffix(":") or "material"
            self.findings.append(Finding(where, value, limit, cure))

    def _text(self, key: str) -> str:
        raw = self.document.get(key)
        limit = "a name of letters, digits, - and _" if key == "name" else "a text"
        right = isinstance(raw, str) and 0 < len(raw.strip()) <= LONGEST_TEXT
        if right and key == "name":
            right = _NAME.fullmatch(str(raw)) is not None
            if self.name not in (None, raw):
                right, limit = False, f"{self.name}, under which it stands"
        if not right:
            cure = f"give the material a {key}"
            self.findings.append(Finding(self._at(key), shown(raw), limit, cure))
        return str(raw).strip()

    def _section(self, section: str) -> Any:
        """One section's record; None where it was refused."""
        raw = self.document[section]
        if not isinstance(raw, Mapping):
            limit, cure = "the names and values of its constants", f"give {section} with them"
            self.findings.append(Finding(self._at(section), shown(raw), limit, cure))
            return None
        kind = raw.get("kind")
        try:
            record = record_of(section, kind, self._at(section))
        except InvalidInput as error:
            self._find(error)
            return None
        keys = () if record is SECTIONS[section] else ("kind",)
        self._refuse_unknown(raw, (*keys, *declared(record)), section)
        before = len(self.findings)
        values = self._record(record, raw, section)
        return section_of(section, kind, values) if len(self.findings) == before else None

    def _record(self, record: type, raw: Mapping[str, Any], path: str) -> dict[str, float | None]:
        """The numbers of one record by field name; a field with a default may be left out."""
        values: dict[str, float | None] = {}
        absent: list[Parameter] = []
        for parameter in declared(record).values():
            if parameter.name in raw:
                values[parameter.name] = self._number(parameter, raw, join(path, parameter.name))
            elif parameter.required and path:
                absent.append(parameter)
        if len(absent) == 1:
            self.findings.append(missing(absent[0], self._at(path)))
        elif absent:
            names = ", ".join(parameter.name for parameter in absent)
            limit = "; ".join(f"{p.name}: {p.meaning}, {p.limit()}" for p in absent)
            self.findings.append(Finding(self._at(path), f"nothing for {names}", limit, "give them"))
        return values

    def _number(self, parameter: Parameter, raw: Mapping[str, Any], path: str) -> float | None:
        """One number with its source, noted; None where it was refused, or where it is "none"."""
        try:
            quantity = _quantity(parameter, raw[parameter.name], self._at(path))
        except InvalidInput as error:
            self._find(error)
            return None
        self.sources[path] = quantity
        return quantity.value

    def _yield_stresses(self) -> tuple[YieldStress, ...]:
        raw = self.document.get("yield_stresses", [])
        if not isinstance(raw, list):
            limit, cure = "a list of yield stresses", "give each with label and value"
            self.findings.append(Finding(self._at("yield_stresses"), shown(raw), limit, cure))
            return ()
        read = [self._yield_stress(stress, index) for index, stress in enumerate(raw)]
        return tuple(stress for stress in read if stress is not None)

    def _yield_stress(self, raw: Any, index: int) -> YieldStress | None:
        where = self._at(f"yield_stresses[{index}]")
        try:
            label = _label(raw, where)
            if f"yield_stresses.{label}" in self.sources:
                raise refusal(f"{where}.label", label, "each label once", "give it another label")
            numbers = {key: value for key, value in raw.items() if key != "label"}
            quantity = _quantity(declared(YieldStress)["value"], numbers, where)
        except InvalidInput as error:
            self._find(error)
            return None
        assert quantity.value is not None
        self.sources[f"yield_stresses.{label}"] = quantity
        return YieldStress(label, quantity.value)


def _label(raw: Any, where: str) -> str:
    label = raw.get("label") if isinstance(raw, Mapping) else None
    if not isinstance(label, str) or not label.strip():
        raise refusal(f"{where}.label", label, "a short label", "give it a label such as 'Y = 240 MPa'")
    return label.strip()


def _quantity(parameter: Parameter, raw: Any, where: str) -> Constant:
    """A checked number of a material, in SI, plain or with its source; raises InvalidInput with every error."""
    if not isinstance(raw, Mapping):
        return Constant(_plain(parameter, raw, where), parameter.unit or "1", STATED, "user")
    findings = Findings()
    for key in raw:
        if key not in NUMBER_KEYS:
            cure = nearest_cure(key, NUMBER_KEYS)
            findings.append(Finding(join(where, key), shown(key), "a key of a number", cure))
    source, confidence = raw.get("source", STATED), raw.get("confidence", "user")
    if not isinstance(source, str) or not source.strip():
        cure = "name the source of the number, or leave it out"
        findings.append(Finding(f"{where}.source", shown(source), "a citation", cure))
    if not isinstance(confidence, str) or confidence not in CONFIDENCES:
        limit, cure = "one of " + ", ".join(CONFIDENCES), nearest_cure(confidence, CONFIDENCES)
        findings.append(Finding(f"{where}.confidence", shown(confidence), limit, cure))
    value = None
    try:
        value = _value(parameter, raw, where)
    except InvalidInput as error:
        findings.extend(error.findings)
    if findings:
        raise InvalidInput(findings)
    return Constant(value, parameter.unit or "1", str(source).strip(), str(confidence))


def _value(parameter: Parameter, raw: Mapping[str, Any], where: str) -> float | None:
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


def _plain(parameter: Parameter, raw: Any, where: str, *, si: bool = False) -> float | None:
    """A number that stands alone, with its unit in it: "900 MPa"; None where it is "none"."""
    value = parse_value(parameter, None if raw == "none" and parameter.optional else raw, where, si=si)
    assert value is None or isinstance(value, float)
    return value
