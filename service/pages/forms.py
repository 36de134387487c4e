"""Forms of a sweep in a child process: the fields of a page as a document, and a document as fields.

A field holds YAML, as the document does: ``6 km/s``, or ``{start: 2 km/s, stop: 7 km/s, step: 1 km/s}``. Several values
with commas between them are an axis, and so is a list: ``[6 km/s]``. Titles, decks and tables of shots are texts. What
has no field of its own stands in the field ``more``.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import islice
from pprint import pformat

import yaml

from service.api.documents import read_yaml
from service.api.reading import expanded_sweep
from service.estimates.estimate import EstimatedSweep, estimated_sweep
from service.records.expansion import ExpandedSweep
from studies import scenarios
from studies.observations import written
from studies.quantities.findings import Finding, Findings, InvalidInput, refusal
from studies.quantities.parameters import Parameter, Plain, Value, declared
from studies.sweeps.document import WIDEST, yaml_of
from studies.sweeps.reading import KEYS, SweepLimits
from studies.sweeps.sweep import Sweep

MORE = "more"  # the field of what has no field of its own
OBSERVATIONS = "observations"
# The other fields: texts, single values, and mappings of several lines.
TEXTS = ("title", "name", OBSERVATIONS)
VALUES = ("combine", "accuracy", "model_part", "resolution", "offsets", "points", "seed")
MAPPINGS = ("materials", MORE)
OF_DOCUMENT = (*TEXTS, *VALUES, *MAPPINGS)
SAMPLED = ("latin-hypercube", "sobol")
SAMPLES = "values"  # key of a sampled axis with what was drawn


@dataclass(frozen=True)
class AskedSweep:
    """What a page says of the form that it shows."""

    scenario: str
    fields: Mapping[str, str]
    yaml: str  # the document; empty where it is refused
    own_materials: tuple[str, ...]
    python: str  # the document as a dictionary of Python; empty where it is refused or submitted
    findings: tuple[Finding, ...]
    estimated: EstimatedSweep | None  # None where the form is refused, or submitted
    expanded: ExpandedSweep | None  # of a form that is submitted and accepted
    setup: tuple[str, str] | None  # drawing of the set-up and its alternative text


def asked(
    scenario: str, changes: Mapping[str, str], beginning: Mapping[str, Plain], is_submitted: bool, max_runs: int
) -> AskedSweep:
    """The sweep of a form, priced, or expanded if it is to be submitted.

    The form begins with the fields of a document, and has ``changes``.
    """
    fields = {**fields_of(beginning), **changes}
    findings = Findings()
    document = findings.attempt(document_of, scenario, fields)
    sweep = None if document is None else findings.attempt(Sweep.parse, document, SweepLimits(max_runs))
    cost = expanded = None
    if sweep is not None and is_submitted:
        expanded = findings.attempt(expanded_sweep, sweep)
    if sweep is not None and expanded is None:
        cost = findings.attempt(estimated_sweep, sweep, max_runs)
    return AskedSweep(
        scenario=scenario,
        fields=fields,
        yaml="" if document is None or (cost is None and expanded is None) else yaml_of(document),
        own_materials=tuple(map(str, sweep.materials)) if sweep else (),
        python="" if cost is None else pformat(document, width=100, sort_dicts=False),
        findings=tuple(dict.fromkeys(findings)),
        estimated=cost,
        expanded=expanded,
        setup=None if sweep is None or cost is None else _setup(sweep),
    )


def document_of(scenario: str, fields: Mapping[str, str]) -> dict[str, Plain]:
    """The document of a form; empty fields are left out. Raises InvalidInput naming the fields.

    >>> document_of("thin_plate", {"speed": "3 km/s, 6 km/s", "projectile_diameter": "8 mm", "title": ""})
    {'scenario': 'thin_plate', 'fixed': {'projectile_diameter': '8 mm'}, 'axes': {'speed': ['3 km/s', '6 km/s']}}
    """
    record = declared(scenarios.load(scenario).parameters)
    findings = Findings()
    read: dict[str, Plain] = {}
    for name in (*record, *OF_DOCUMENT):
        text = fields.get(name, "")
        if text.strip() and name in TEXTS:
            read[name] = text.strip(" \r\n")  # a tab at the end of a table is an empty cell
        elif text.strip() and name in record and record[name].kind == "text":
            read[name] = text  # lines of a deck keep their numbers
        elif text.strip():
            read[name] = findings.attempt(_read_mapping if name in MAPPINGS else read_value, name, text)
    findings.check()
    more = read.pop(MORE, {})
    assert isinstance(more, dict)
    axes: dict[str, Plain] = {
        name: value for name, value in read.items() if name in record and isinstance(value, list | dict)
    }
    fixed = {name: value for name, value in read.items() if name in record and name not in axes}
    document: dict[str, Plain] = {"scenario": scenario, "fixed": fixed, "axes": axes}
    document |= {name: value for name, value in read.items() if name not in record}
    for key, part in more.items():
        before = document.get(key)
        document[key] = {**before, **part} if isinstance(before, dict) and isinstance(part, dict) else part
    given = document["fixed"]
    if not document["axes"] and isinstance(given, dict):  # a sweep has one
        document |= _with_an_axis(given, record)
    return {key: document[key] for key in dict.fromkeys((*KEYS, *document)) if document.get(key) not in (None, {})}


def _with_an_axis(fixed: Mapping[str, Plain], record: Mapping[str, Parameter]) -> dict[str, Plain]:
    """The parameters of a form without an axis: its first value that is no text becomes one, else a default."""
    values = {name: value for name, value in fixed.items() if name in record and record[name].kind != "text"}
    numbers = (number for number in record.values() if number.unit is not None and number.default is not None)
    values |= {number.name: written(number.default, number.unit) for number in numbers if number.name not in values}
    axes: dict[str, Plain] = {name: [value] for name, value in islice(values.items(), 1)}
    return {"axes": axes, "fixed": {name: value for name, value in fixed.items() if name not in axes}}


def read_value(name: str, text: str) -> Plain:
    """The value of a field, or its values with commas between them; raises InvalidInput naming it."""
    try:
        values = read_yaml(f"value: [\n{text}\n]".encode())["value"]
    except InvalidInput:
        values = []
    if not isinstance(values, list) or not values:
        limit = "a value, or several with commas between them, in YAML"
        raise refusal(name, text, limit, "close each bracket and quote, and put quotes around long texts")
    return values if len(values) > 1 else values[0]


def _read_mapping(name: str, text: str) -> Plain:
    """The content of a field of several lines; raises InvalidInput naming it."""
    try:
        return read_yaml(text.encode(), "names, each with a colon and what it has")
    except InvalidInput as error:
        raise InvalidInput(replace(finding, field=name) for finding in error.findings) from None


def fields_of(document: Mapping[str, Plain]) -> dict[str, str]:
    """The fields of a document; what has none stands in the field ``more``."""
    record = declared(scenarios.load(str(document["scenario"])).parameters) if document else {}
    fields: dict[str, str] = {}
    more: dict[str, Plain] = {}
    for key, part in document.items():
        if key in ("fixed", "axes") and isinstance(part, Mapping):
            # Which sample has which values depends on the order of the axes, which fields do not keep.
            has_fields = key == "fixed" or document.get("combine") not in SAMPLED
            known = {name: value for name, value in part.items() if has_fields and _fits(record.get(name), value)}
            others = {name: value for name, value in part.items() if name not in known}
            for name, value in others.items():
                if isinstance(value, Mapping):
                    others[name] = {key: inner for key, inner in value.items() if key != SAMPLES}
            fields |= {name: _written(record[name].kind == "text", value) for name, value in known.items()}
            more |= {key: others} if others else {}
        elif key == "cells" or part in (None, [], {}):  # the accuracy chooses cells anew
            continue
        elif key in ("materials", *VALUES) or (key in TEXTS and isinstance(part, str)):
            fields[key] = yaml_of(part) if key in MAPPINGS else _written(key in TEXTS, part)
        elif key != "scenario":
            more[key] = part
    return fields | ({MORE: yaml_of(more)} if more else {})


def _fits(parameter: Parameter | None, value: Plain) -> bool:
    """Whether a value can stand in the field of a parameter; several texts of lines cannot."""
    return parameter is not None and (parameter.kind != "text" or isinstance(value, str))


def _written(is_text: bool, value: Plain) -> str:
    """A value as its field has it, which reads it as itself."""
    if is_text:
        return str(value)
    values = value if isinstance(value, list) and len(value) > 1 else [value]
    text: str = yaml.safe_dump(values, default_flow_style=True, sort_keys=False, allow_unicode=True, width=WIDEST)
    return text.strip()[1:-1]


def _setup(sweep: Sweep) -> tuple[str, str] | None:
    """The set-up of the first run as an image, with its alternative text; None where the scenario draws none."""
    from studies.pictures.shown import setup
    from studies.pictures.sketches import setup_sketch
    from studies.reports.drawing.images import as_image

    first = next(iter(sweep.every_run(1))).run.parameters
    materials = {role: [*names] for role, names in sweep.roles().items()}
    axes: dict[str, list[Value]] = {axis.name: [*axis.values] for axis in sweep.axes}
    drawn = setup(sweep.definition, {**{name: [value] for name, value in first.items()}, **materials, **axes})
    return (as_image(setup_sketch(drawn)), drawn.alt) if drawn else None
