"""A material document (TOML file, or the same schema inline) becomes a checked ``Material``."""

import re
import tomllib
from collections.abc import Mapping
from decimal import Decimal
from pathlib import Path
from typing import Any

from studies.materials.schema import (
    CONFIDENCES,
    OPTIONAL,
    SECTIONS,
    Constant,
    Material,
    Scalars,
    YieldStress,
    record_of,
    section_of,
)
from studies.values.errors import Finding, Findings, InvalidInput
from studies.values.nearest import nearest_cure, shown
from studies.values.parameters import Parameter, declared, join, missing, parse_value
from studies.values.quantities import convert, exact_number, refusal, round_quantity

NUMBER = "{value = ..., unit = ..., source = ..., confidence = ...}"
NUMBER_KEYS = ("value", "unit", "source", "confidence")
TEXTS = ("name", "title", "family")
LONGEST_TEXT = 200  # characters of a title
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")


def read_toml(text: str, file: str) -> dict[str, Any]:
    """A TOML text with exact decimals; raises InvalidInput that names the file."""
    try:
        return tomllib.loads(text, parse_float=Decimal)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise refusal(file, str(error), "a TOML document", "correct the line named") from None


def read_file(file: Path) -> Material:
    """The material of a TOML file; every error names the file and the key."""
    return read_document(
        read_toml(file.read_text(encoding="utf-8"), file.name), path=f"{file.name}:"
    )


def read_document(document: Any, *, name: str | None = None, path: str = "") -> Material:
    """The material of a document; ``name`` where the document stands under a name of its own.

    ``path`` goes before each key in a finding. Raises InvalidInput with every finding.
    """
    if not isinstance(document, Mapping):
        raise refusal(
            path or "material", document, "a material: keys and values", f"each number as {NUMBER}"
        )
    return _MaterialReading(document, name, path).material()


class _MaterialReading:
    """A document being read: the numbers with their sources, and the findings."""

    def __init__(self, document: Mapping[str, Any], name: str | None, path: str):
        self.document = dict(document) if name is None else {"name": name, **document}
        self.name = name
        self.path = path
        self.findings = Findings()
        self.sources: dict[str, Constant] = {}

    def material(self) -> Material:
        """The whole document."""
        self._refuse_unknown(
            self.document, (*TEXTS, *declared(Scalars), *SECTIONS, "yield_stresses"), ""
        )
        texts: dict[str, Any] = {text: self._text(text) for text in TEXTS}
        scalars: dict[str, Any] = self._record(Scalars, self.document, "")
        sections: dict[str, Any] = {section: self._section(section) for section in SECTIONS}
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
                cure = nearest_cure(key, keys)
                self.findings.append(Finding(where, shown(key), "a key of a material", cure))

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
        raw = self.document.get(section, {} if section in OPTIONAL else None)
        if not isinstance(raw, Mapping):
            limit = f"the section {section!r}"
            cure = f"give {section} with its numbers, each as {NUMBER}"
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
        for parameter in declared(record).values():
            if parameter.name in raw:
                values[parameter.name] = self._number(parameter, raw, join(path, parameter.name))
            elif parameter.required:
                self.findings.append(missing(parameter, self._at(path) if path else self.path))
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
            limit, cure = (
                "a list of yield stresses",
                f"write [[yield_stresses]] with label and {NUMBER}",
            )
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
        raise refusal(f"{where}.label", label, "a short label", "write label = 'Y = 240 MPa'")
    return label.strip()


def _quantity(parameter: Parameter, raw: Any, where: str) -> Constant:
    """A checked number of a material file, in SI; raises InvalidInput with every error."""
    if not isinstance(raw, Mapping):
        raise refusal(where, raw, "a number with unit and source", f"write {NUMBER}")
    findings = Findings()
    for key in raw:
        if key not in NUMBER_KEYS:
            cure = nearest_cure(key, NUMBER_KEYS)
            findings.append(Finding(join(where, key), shown(key), "a key of a number", cure))
    source, confidence = raw.get("source"), raw.get("confidence", "user")
    if not isinstance(source, str) or not source.strip():
        findings.append(
            Finding(f"{where}.source", shown(source), "a citation", "name the source of the number")
        )
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
    if raw.get("value") == "none" and parameter.optional:
        return None
    number = exact_number(raw.get("value"), f"{where}.value")
    unit = raw.get("unit", "1")
    if unit != parameter.unit:
        if not isinstance(unit, str) or unit in ("", "1") or parameter.unit == "1":
            limit = f"a unit of {parameter.meaning}: {parameter.unit}"
            raise refusal(f"{where}.unit", unit, limit, f"write unit = {parameter.unit!r}")
        number = convert(number, unit, parameter.unit or "1", where)
    value = parse_value(parameter, round_quantity(number), where, si=True)
    assert isinstance(value, float)
    return value
