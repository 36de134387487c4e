"""Material documents: read exactly, refused with file and key, changed by dotted path."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from studies import materials
from studies.quantities.findings import InvalidInput

COPPER = materials.load("copper-ofhc")


def test_document__of_several_mistakes_is_told_all_at_once() -> None:
    document: Any = COPPER.document()
    del document["eos"]
    document["density"]["unit"] = "m"
    document["strength"].pop("n")
    with pytest.raises(InvalidInput) as caught:
        materials.read_own(document)
    assert all(key in str(caught.value) for key in ("eos", "density", "strength.n"))


HOW_TO = Path(__file__).parents[3] / "docs" / "how-to.md"


def typed() -> dict[str, Any]:
    """The steel of docs/how-to.md, as a person types it into a sweep."""
    (block,) = re.findall(r"```yaml\n(materials:\n.*?)```", HOW_TO.read_text("utf-8"), re.S)
    return yaml.safe_load(block)["materials"]["our-steel"]


def test_typed__is_a_material_whose_source_is_the_user() -> None:
    steel = materials.read_own(typed(), name="our-steel")
    assert (steel.density, steel.value_at("strength.A")) == (7850.0, 900e6)
    assert steel.value_at("tension.spall_strength") is None
    assert {(one.source, one.confidence) for one in steel.sources.values()} == {("stated by the user", "user")}
    assert materials.read_own(steel.document()) == steel


def test_base__gives_what_is_left_out() -> None:
    ours = materials.read_own({"base": "copper-ofhc", "strength": {"A": "95 MPa"}}, name="ours")
    assert ours.resolved() == {**COPPER.with_value("strength.A", 95e6).resolved(), "name": "ours", "title": "ours"}
    assert ours.sources["density"] == COPPER.sources["density"]


# Each mistake in the document of copper: path, value, and a word of what is said.
MISTAKES: list[tuple[str, Any, str]] = [
    ("density.value", True, "density.value"),
    ("density.value", float("nan"), "finite"),
    ("density.value", -1.0, "density from"),
    ("density.value", "none", "a density with its unit"),
    ("density.unit", "kg", "density"),
    ("density.confidence", "sure", "memory"),
    ("density.uncertainty", 1, "a key of a number"),
    ("strength.kind", "johnson-cock", "did you mean 'johnson-cook'"),
    ("strength.a", {}, "did you mean 'A'"),
    ("strength.A", None, "strength.A: null"),
    ("eos.s.unit", "mm", "eos.s.unit"),
    ("elasticity", {}, "did you mean 'elastic'"),
    ("family", 3, "family"),
    ("yield_stresses", [{"value": 1}], "label"),
]
# Each mistake in the typed steel: path, value (... removes it), and what its one finding says.
MISTYPED: list[tuple[str, Any, str]] = [
    ("strength.A", "900 MPA", "strength.A: '900 MPA'"),
    ("strength.A", ..., "give initial yield stress"),
    ("A", "900 MPa", "write it under strength"),
    ("strength.A_", "900 MPa", "did you mean 'A'?"),
    ("tension", ..., "name a material that ships as its base"),
    ("base", "steel-434", "base: 'steel-434'"),
    ("strength.kind", ..., "johnson-cook"),
    ("eos", {"kind": "tillotson"}, "nothing for a, b, A, B"),
]


@pytest.mark.parametrize(
    ("is_typed", "path", "value", "says"), [*((False, *row) for row in MISTAKES), *((True, *row) for row in MISTYPED)]
)
def test_material__with_a_mistake_is_refused_with_the_key(is_typed: bool, path: str, value: Any, says: str) -> None:
    place: Any = typed() if is_typed else COPPER.document()
    written = place
    *parents, last = path.split(".")
    for parent in parents:
        place = place[parent]
    place.pop(last, None) if value is ... else place.update({last: value})
    with pytest.raises(InvalidInput) as caught:
        materials.read_own(written, "materials.ours" if is_typed else "", "ours" if is_typed else None)
    assert says in str(caught.value)
    assert path.split(".")[0] in str(caught.value)
    assert len(caught.value.findings) == 1 or not is_typed
