"""The JSON Schema of a sweep against the reader: it accepts what is read, and refuses mistakes at the same place."""

import re
from collections.abc import Iterator, Mapping
from itertools import groupby
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from studies import scenarios
from studies.quantities import units
from studies.quantities.findings import InvalidInput
from studies.quantities.units import parse_quantity, pattern_of
from studies.sweeps import examples
from studies.sweeps.document import read_yaml
from studies.sweeps.reading import KEYS
from studies.sweeps.schema import MODELINE, schema_of_sweep
from studies.sweeps.sweep import Sweep
from tests.claims.marked import Compared
from tests.claims.rows import at_least, equal
from tests.studies.sweeps.test_sweep import MISTAKES, changed

ROOT = Path(__file__).parents[3]
WHOLE = schema_of_sweep()
INSTALLED = {name for part, schema in WHOLE["$defs"].items() if part.endswith("Fixed") for name in schema["properties"]}
SCHEMA = jsonschema.Draft202012Validator(WHOLE)
SHIPPED = [read_yaml(examples.text(name), name) for name in examples.names()]
HOLES = SHIPPED[examples.names().index("holes")]
SHOT = {
    **{"speed": "6 km/s", "projectile": "al-2017-t4", "projectile_diameter": "5 mm", "target": "al-6061-t6"},
    **{"plate_thickness": ["1 mm", "2 mm"], "resolution": 8},
}


# Values as people write them.
WRITTEN: list[Any] = [
    *("2 mm", "3 furlongs", "1/8 in", "2mm", "-2 MPa", "1 N/mm2", " 5 ", "1e1", ".5", "5.", "3%", "fine", "sphere"),
    *(["6 km/s"], [8, 16.0, "24"], {"start": 8, "stop": 16, "step": 8}, {"low": "2 km/s", "high": "3 km/s"}),
]
# Mistakes besides those of the tests of the reader: a path, and what is wrong there; ``...`` takes it away.
FURTHER: list[tuple[str, Any]] = [
    ("scenario", ...),
    ("axes", ...),
    ("fixed/projectile_diameter", ...),
    ("fixed/strength.A", "90 MPa"),
    ("fixed/projectile_diameter", "8"),
    ("fixed/projectile_diameter", "8e-3"),
    ("fixed/projectile_diameter", ["8 mm"]),
    ("fixed/projectile", 7),
    ("fixed/friction", 11),
    ("fixed/friction", "none"),
    ("fixed/cells_per_diameter", {"start": 8}),
    ("axes/speed", "6 km/s"),
    ("axes/speed", {"start": "2 km/s", "stop": "7 km/s", "step": 1}),
    ("combine", "sobol"),
    ("seed", 7),
    ("resolution", "fine"),
    ("accuracy", "fein"),
    ("model_part", "screened"),
    ("observations", 7),
    ("materials", {"my-alloy": {"base": "al-6061-t6", "densty": "2.7 g/cm3"}}),
    ("materials", {"my-alloy": {"base": "al-6061-t6", "density": "2.7 mm"}}),
    ("materials", {"my-alloy": {"base": "al-6061-t6", "strength": {"A": 300}}}),
    ("laws", "hill"),
    ("ends", ["6 km/s"]),
]
OF_A_SHOT: list[tuple[str, Any]] = [
    ("speed", 6),
    ("projectile_diameter", ...),
    ("plate_thickness", ["1 mm", "2 km/s"]),
    ("plate_thicknes", "1 mm"),
]


def fields_of(document: Mapping[str, Any]) -> set[str]:
    """The places at which the schema refuses a document, as the service names them."""
    return {field for error in SCHEMA.iter_errors(document) for field in _fields(error)}


def _fields(error: jsonschema.ValidationError) -> Iterator[str]:
    path = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in error.absolute_path).lstrip(".")
    before = f"{path}." if path else ""
    if "propertyNames" in error.schema_path:
        yield f"{before}{error.instance}"
    elif error.validator in ("oneOf", "anyOf"):
        branches = [[*of] for _, of in groupby(error.context, key=lambda inner: inner.schema_path[0])]
        for inner in min(branches, key=_far):
            yield from _fields(inner)
    elif error.validator == "required":
        yield from (f"{before}{name}" for name in error.validator_value if name not in error.instance)
    elif error.validator == "additionalProperties":
        yield from (f"{before}{name}" for name in error.instance if name not in error.schema["properties"])
    else:
        yield path


def _far(branch: list[jsonschema.ValidationError]) -> tuple[bool, int]:
    """How little a branch of a union is meant: it is of another type, or has more errors."""
    return any(error.validator == "type" and not error.path for error in branch), len(branch)


def fields_of_service(document: Mapping[str, Any]) -> set[str]:
    try:
        Sweep.parse(document)
    except InvalidInput as error:
        return {finding.field for finding in error.findings}
    return set()


@pytest.mark.claim("contract", "schema-of-examples")
def test_schema__holds_for_every_document_that_ships(compared: Compared) -> None:
    """The schema of a sweep holds for each sweep that ships, and for those of the README and the documentation."""
    assert all(examples.text(name).startswith(MODELINE) for name in examples.names())
    told = [*written()]
    documents = [*SHIPPED, *(Sweep.parse(document).document() for document in SHIPPED), *told]
    refused = [(document, fields) for document in documents if (fields := fields_of(document))]
    compared(equal("documents that it refuses, with the fields", expected=[], got=refused))
    compared(at_least("documents of the README and the documentation", limit=12, got=len(told)))


def written() -> Iterator[dict[str, Any]]:
    """The sweeps of the README and the documentation; a part of one is put into one that ships."""
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))):
        text = page.read_text(encoding="utf-8")
        for fenced, typed in re.findall(r"```yaml\n(.*?)```|cat > \S+\.yaml <<'END'\n(.*?)END\n", text, re.DOTALL):
            block = yaml.safe_load(fenced or typed)
            if isinstance(block, dict) and {*block} <= {*KEYS, *WHOLE["$defs"]["ShotSweep"]["properties"]}:
                if (
                    not {*(block.get("fixed") or ())} <= INSTALLED
                    or block.get("scenario", HOLES["scenario"]) not in scenarios.names()
                ):
                    continue  # of a feature that was taken away
                whole = [block] if {"scenario", "speed"} & {*block} else [inside(each, block) for each in SHIPPED]
                yield next((each for each in whole if not fields_of(each)), whole[0])


def inside(document: Mapping[str, Any], block: Mapping[str, Any]) -> dict[str, Any]:
    """A document with a part of one."""
    whole = {key: value for key, value in document.items() if key != "resolution" or "accuracy" not in block}
    both = {key: {**whole[key], **part} for key, part in block.items() if isinstance(whole.get(key), dict)}
    return {**whole, **block, **both}


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("fixed/target.strength.A", "90 MPa"),
        ("axes/projectile.fracture.D1", [0.1, 0.2]),
        ("fixed/target", "a-material-of-another-distribution"),
        ("fixed/failure", "of-another-distribution"),
        ("fixed/projectile_diameter", '1/8"'),
        ("fixed/projectile_diameter", "0.3 furlongs"),
        ("fixed/particles_per_cell", "2"),
        ("fixed/end_time", None),
        ("axes/speed", {"limit_of": "perforated", "between": ["1 km/s", "2 km/s"], "until": "10 %"}),
        ("axes/speed", {"low": "1 km/s", "high": "2 km/s"}),
        ("observations", [{"speed": "6 km/s", "hole_diameter": "14 mm", "source": "mine"}]),
        (
            "materials",
            {
                "mine": {
                    "base": "lead",
                    "density": {"value": 11.3, "unit": "g/cm3"},
                    "tension": {"spall_strength": "none"},
                }
            },
        ),
        ("laws", [{"law": "mine"}]),
    ],
)
def test_schema__is_open_to_what_others_add_and_to_each_way_of_writing(path: str, value: Any) -> None:
    assert fields_of(changed(path, value, HOLES)) == set()


def test_pattern_of_a_quantity__refuses_the_usual_units_that_the_reader_refuses() -> None:
    usual = {name for name, _ in units._FACTORS} | {name for _, names in units._DIMENSIONS.values() for name in names}
    for unit in units._DIMENSIONS:
        pattern = re.compile(pattern_of(unit))
        for name in usual:
            assert bool(pattern.search(f"3e1 {name}")) == is_read(f"3e1 {name}", unit), (name, unit)


def is_read(text: str, unit: str) -> bool:
    try:
        parse_quantity(text, unit, "field")
    except InvalidInput:
        return False
    return True


PLACES = ["fixed", "axes", "axes/speed", "axes/speed/start", "fixed/target", "fixed/projectile_shape"]
PLACES += ["fixed/target.strength.A", "fixed/particles_per_cell", "materials", "observations", "resolution"]
PLACES += ["offsets", "accuracy"]
ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda some: st.lists(some, max_size=3) | st.dictionaries(st.text(max_size=8), some, max_size=3),
    max_leaves=6,
)


@given(st.sampled_from(PLACES), ANYTHING | st.sampled_from(WRITTEN))
def test_schema__holds_for_whatever_is_read(path: str, value: Any) -> None:
    """And reading refuses the rest, without any other error."""
    document = changed(path, value)
    if not fields_of_service(document):
        assert fields_of(document) == set()


@pytest.mark.claim("contract", "schema-of-mistakes")
def test_schema__refuses_mistakes_at_the_field_that_the_service_names(compared: Compared) -> None:
    """The schema refuses more than thirty mistakes in a sweep, each at a field that the service names."""
    told = [changed(path, value) for path, value in ((path, value) for path, value, _ in MISTAKES)]
    sure = [*(changed(*mistake) for mistake in FURTHER), *(changed(*mistake, SHOT) for mistake in OF_A_SHOT)]
    refused = [*sure, *(document for document in told if fields_of(document))]
    elsewhere = [document for document in refused if not set() < fields_of(document) <= fields_of_service(document)]
    compared(
        at_least("mistakes that it refuses", limit=50, got=len(refused)),
        equal("those that it refuses elsewhere", expected=[], got=elsewhere),
    )
