"""Forms of a sweep in a child process: the fields of a page as a document, and a document as fields.

A field holds what the document holds, as a person writes it: ``6 km/s``, ``3 km/s, 6 km/s``, ``2 km/s to 7 km/s step 1
km/s``, or the document's own YAML in brackets. A field with several values is an axis, and so is one value with a comma
behind it. What has no field of its own stands in the field ``more``, as YAML.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import islice
from pprint import pformat
from textwrap import indent
from typing import Any

import yaml

from service.api import reading
from service.api.reading import PARSERS, EstimatedSweep, Posted
from service.records.expansion import ExpandedSweep
from studies import scenarios
from studies.observations import written
from studies.quantities.findings import Finding, Findings, InvalidInput
from studies.quantities.parameters import Parameter, Value, declared
from studies.sweeps.reading import KEYS, RESOLUTION, SweepLimits
from studies.sweeps.sweep import Sweep

MORE = "more"  # the field of what has no field of its own
# Fields that hold a text of the document, and those of whole numbers.
OBSERVATIONS = "observations"
WORDS = ("title", "name", "combine", "accuracy", "model_part", OBSERVATIONS)
COUNTS = ("offsets", "points", "seed")
OF_PARAMETERS = ("fixed", "axes")
SAMPLED = ("latin-hypercube", "sobol")
LOW, HIGH = "low", "high"  # keys of a sampled axis
SAMPLES = "values"  # key of a sampled axis with what was drawn
RANGE = re.compile(r"(.+?)\s+to\s+(.+?)(?:\s+step\s+(.+))?")
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
YAML = "application/yaml"
PLACE = re.compile(r"line (\d+), column (\d+)")
LONGEST_NUMBER = 30  # digits of a whole one
WIDEST = 10_000  # letters in a line of YAML
BOOLEANS: Mapping[str, bool] = {"true": True, "false": False}


@dataclass(frozen=True)
class AskedSweep:
    """What a page says of the form that it shows."""

    fields: Mapping[str, str]
    yaml: str  # the document; empty where it is refused
    own_materials: tuple[str, ...]
    python: str  # the document as a dictionary of Python; empty where it is refused or submitted
    findings: tuple[Finding, ...]
    estimated: EstimatedSweep | None  # None where the form is refused, or submitted
    expanded: ExpandedSweep | None  # of a form that is submitted and accepted
    setup: tuple[str, str] | None  # drawing of the set-up and its alternative text


def asked(form: Any, posted: Posted) -> AskedSweep:
    """The sweep of a form: of ``fields``, and of a ``document`` that they change; expanded if it is to be submitted."""
    fields = {**fields_of(form["document"]), **form["fields"]}
    findings = Findings()
    document = findings.attempt(document_of, fields)
    sweep = None if document is None else findings.attempt(Sweep.parse, document, SweepLimits(posted.max_runs))
    cost = expanded = None
    if sweep is not None and form["submit"]:
        expanded = findings.attempt(reading.expanded, document, posted)
    if sweep is not None and expanded is None:
        cost = findings.attempt(reading.estimated, document, posted)
    return AskedSweep(
        fields=fields,
        yaml="" if cost is None and expanded is None else as_yaml(document),
        own_materials=tuple(map(str, sweep.materials)) if sweep else (),
        python="" if cost is None else pformat(document, width=100, sort_dicts=False),
        findings=tuple(dict.fromkeys(findings)),
        estimated=cost,
        expanded=expanded,
        setup=None if sweep is None or cost is None else _setup(sweep),
    )


# --- fields to document ---------------------------------------------------------------------------


def document_of(fields: Mapping[str, str]) -> dict[str, Any]:
    """The document of a form; empty fields are left out. Raises InvalidInput naming the fields.

    >>> fields = {"scenario": "thin_plate", "speed": "3 km/s, 6 km/s", "projectile_diameter": "8 mm", "offset": ""}
    >>> document_of(fields)
    {'scenario': 'thin_plate', 'fixed': {'projectile_diameter': '8 mm'}, 'axes': {'speed': ['3 km/s', '6 km/s']}}
    """
    findings = Findings()
    record = declared(scenarios.load(fields["scenario"]).parameters)
    # A tab at the end of a table is an empty cell.
    given = {
        name: text.strip(" \r\n" if name == OBSERVATIONS else None) for name, text in fields.items() if text.strip()
    }
    document: dict[str, Any] = {name: given[name] for name in WORDS if name in given}
    document |= {"scenario": fields["scenario"], "fixed": {}, "axes": {}}
    for name, parameter in record.items():
        if name in given:
            text = fields[name] if parameter.kind == "text" else given[name]
            value = findings.attempt(read_value, name, text, parameter)
            if isinstance(value, dict) and LOW in value and given.get("combine") not in SAMPLED:
                step = f"write {text} step and how far apart values are, or sample: set combine to sobol"
                findings.append(Finding(name, text, "several values, or a range with its step", step))
            document["axes" if isinstance(value, list | dict) else "fixed"][name] = value
    if RESOLUTION in record and "resolution" in given:
        document["resolution"] = findings.attempt(read_value, "resolution", given["resolution"], record[RESOLUTION])
    document |= {name: _number(given[name]) for name in COUNTS if name in given}
    if "materials" in given:
        document["materials"] = findings.attempt(_read_yaml, "materials", given["materials"])
    more = findings.attempt(_read_yaml, MORE, given[MORE]) if MORE in given else None
    findings.check()
    if isinstance(more, Mapping):
        document |= {name: _joined(document.get(name), part) for name, part in more.items()}
    elif more is not None:
        raise InvalidInput([Finding(MORE, "no mapping", "keys of a sweep with their values", "write laws: [...]")])
    _give_axis(document, record)
    ordered = {**{key: document[key] for key in KEYS if key in document}, **document}
    return {key: part for key, part in ordered.items() if part not in ({}, None)}


def read_value(field: str, text: str, parameter: Parameter) -> Any:
    """The value of a field as a document has it: one, a list, or a range; raises InvalidInput naming the field."""
    if parameter.kind == "text":
        return text
    if text[0] in "[{":
        return _read_yaml(field, text)
    ends = RANGE.fullmatch(text)
    if ends and parameter.kind in ("quantity", "integer"):
        low, high, step = ends.groups()
        if step is None:
            return {LOW: _number(low), HIGH: _number(high)}
        return {"start": _number(low), "stop": _number(high), "step": _number(step)}
    if "," in text:
        return [_one(part.strip(), parameter) for part in text.split(",") if part.strip()]
    return _one(text, parameter)


def _one(text: str, parameter: Parameter) -> Any:
    if parameter.kind == "boolean":
        return BOOLEANS.get(text.lower(), text)
    return _number(text) if parameter.kind in ("quantity", "integer") else text


def _number(text: str) -> Any:
    """A number as one, any other text as it is."""
    if not NUMBER.fullmatch(text):
        return text
    return int(text) if text.lstrip("+-").isdigit() and len(text) < LONGEST_NUMBER else float(text)


def _read_yaml(field: str, text: str) -> Any:
    """The content of a field in YAML; raises InvalidInput naming the field."""
    try:
        return PARSERS[YAML](f"value:\n{indent(text, ' ')}".encode())["value"]
    except InvalidInput as error:
        raise InvalidInput(
            Finding(field, PLACE.sub(_in_field, each.value), each.limit, each.cure) for each in error.findings
        ) from None


def _in_field(place: re.Match[str]) -> str:
    """A line and column of the text of a field, which is read a line below and a column to the right."""
    return f"line {int(place[1]) - 1}, column {int(place[2]) - 1}"


def _joined(part: Any, more: Any) -> Any:
    return {**part, **more} if isinstance(part, dict) and isinstance(more, dict) else more


def _give_axis(document: dict[str, Any], record: Mapping[str, Parameter]) -> None:
    """Make a value an axis of one, because a sweep has an axis: the first that is no text, else a default."""
    fixed = document["fixed"]
    if document["axes"] or not isinstance(fixed, dict):
        return
    name = next((name for name in fixed if name in record and record[name].kind != "text"), None)
    if name is not None:
        document["axes"] = {name: [fixed.pop(name)]}
        return
    numbers = (each for each in record.values() if each.kind in ("quantity", "integer") and each.default is not None)
    document["axes"] = {each.name: [written(each.default, each.unit)] for each in islice(numbers, 1)}


# --- document to fields ---------------------------------------------------------------------------


def fields_of(document: Mapping[str, Any]) -> dict[str, str]:
    """The fields of a document; what has none stands in the field ``more``."""
    if not document:
        return {}
    record = declared(scenarios.load(document["scenario"]).parameters)
    fields = {"scenario": str(document["scenario"])}
    more: dict[str, Any] = {}
    for key, part in document.items():
        if key == "axes" and document.get("combine") in SAMPLED and not _is_in_order(part, record):
            more[key] = {name: _without_samples(value) for name, value in part.items()}
        elif key in OF_PARAMETERS:
            known = {name: value for name, value in part.items() if _has_field(record.get(name), value)}
            fields |= {name: _written(value) for name, value in known.items()}
            more |= {key: left} if (left := {name: value for name, value in part.items() if name not in known}) else {}
        elif key == "materials":
            fields |= {key: as_yaml(part)} if part else {}
        elif key in (*WORDS, *COUNTS, "resolution") and (key != OBSERVATIONS or isinstance(part, str)):
            fields |= {} if part is None else {key: _written(part)}
        elif key not in ("scenario", "cells") and part not in (None, [], {}):  # the accuracy chooses cells anew
            more[key] = part
    return fields | ({MORE: as_yaml(more)} if more else {})


def _has_field(parameter: Parameter | None, value: Any) -> bool:
    """Whether a value can stand in the field of a parameter; several texts of lines cannot."""
    return parameter is not None and (parameter.kind != "text" or isinstance(value, str))


def _is_in_order(axes: Mapping[str, Any], record: Mapping[str, Parameter]) -> bool:
    """Whether axes are in the order that fields give them; which sample has which values depends on it."""
    return [*axes] == [*(name for name in record if name in axes), *(name for name in axes if name not in record)]


def _without_samples(value: Any) -> Any:
    return {key: part for key, part in value.items() if key != SAMPLES} if isinstance(value, Mapping) else value


def _written(value: Any) -> str:
    """A value, a list or a range as a person writes it into a field."""
    value = _without_samples(value)
    if isinstance(value, Mapping):
        if set(value) == {"start", "stop", "step"}:
            return f"{value['start']} to {value['stop']} step {value['step']}"
        return f"{value['low']} to {value['high']}" if set(value) == {"low", "high"} else _in_one_line(value)
    if isinstance(value, list):
        texts = [_written(each) for each in value]
        if any(set(text) & set(",[{") for text in texts):
            return _in_one_line(value)
        return ", ".join(texts) if len(texts) > 1 else f"{texts[0]},"  # of one value it stays an axis
    return str(value).lower() if isinstance(value, bool) else str(value)


def _in_one_line(value: Any) -> str:
    """A value as YAML in brackets."""
    return str(yaml.safe_dump(value, default_flow_style=True, sort_keys=False, width=WIDEST)).strip()


class _Dumper(yaml.SafeDumper):
    """Writes lists and ranges in one line, and texts of several lines as they are."""

    def represent_sequence(self, tag: str, sequence: Any, flow_style: bool | None = None) -> Any:
        return super().represent_sequence(tag, sequence, not any(isinstance(each, dict | list) for each in sequence))

    def represent_mapping(self, tag: str, mapping: Any, flow_style: bool | None = None) -> Any:
        return super().represent_mapping(tag, mapping, bool({"start", "low", "limit_of"} & {*mapping}))


def _represent_text(dumper: yaml.SafeDumper, text: str) -> Any:
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, "|" if "\n" in text else None)


_Dumper.add_representer(str, _represent_text)


def as_yaml(document: Any) -> str:
    """A document as YAML; every line of a text in it is indented."""
    text: str = yaml.dump(document, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=WIDEST)
    return text


# --- drawing --------------------------------------------------------------------------------------


def _setup(sweep: Sweep) -> tuple[str, str] | None:
    """The set-up of the first run as an image, with its alternative text; None where the scenario draws none."""
    from studies.reports.drawing.images import as_image
    from studies.reports.drawing.sketches import setup_sketch
    from studies.reports.setup import setup

    first = next(iter(sweep.every_run(1))).run.parameters
    materials = {role: [*names] for role, names in sweep.roles().items()}
    axes: dict[str, list[Value]] = {axis.name: [*axis.values] for axis in sweep.axes}
    document = setup(sweep.definition, {**{name: [value] for name, value in first.items()}, **materials, **axes})
    return (as_image(setup_sketch(document)), document["alt"]) if document else None
