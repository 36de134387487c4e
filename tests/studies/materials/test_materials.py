"""Material documents: read exactly, refused with file and key, changed by dotted path."""

from pathlib import Path
from typing import Any

import pytest

from studies import materials
from studies.materials import Material, Model
from studies.values.errors import InvalidInput

STRENGTH = {"A": 90e6, "B": 292e6, "n": 0.31, "C": 0.025, "m": 1.09, "reference_rate": 1.0}


@pytest.fixture
def copper() -> Material:
    return materials.load("copper-ofhc")


@pytest.fixture
def document(copper: Material) -> dict[str, Any]:
    return copper.document()


def refused(document: Any) -> str:
    with pytest.raises(InvalidInput) as caught:
        materials.load(document)
    return str(caught.value)


def test_load__converts_to_si(copper: Material) -> None:
    assert copper.density == 8930.0
    assert copper.strength == Model("johnson-cook", STRENGTH)


def test_load__of_an_unknown_name_gives_the_nearest() -> None:
    with pytest.raises(InvalidInput, match="copper-ofhc"):
        materials.load("copper-ohfc")


def test_load__of_a_file_names_file_and_key(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text('name = "mine"\ntitle = "Mine"\nfamily = "lead"\n[density]\nvalue = 11\n')
    with pytest.raises(InvalidInput, match=r"mine\.toml: density"):
        materials.load(file)


def test_simulated__leaves_out_what_no_simulation_reads(copper: Material) -> None:
    resolved = copper.resolved()
    renamed = {**resolved, "title": "another", "yield_stresses": []}
    assert materials.simulated(renamed) == materials.simulated(resolved)
    stronger = copper.with_value("strength.A", 1e8).resolved()
    assert materials.simulated(stronger) != materials.simulated(resolved)


def test_with_value__changes_one_constant_and_its_source(copper: Material) -> None:
    stronger = copper.with_value("strength.A", 1e8)
    assert stronger.strength == Model("johnson-cook", {**STRENGTH, "A": 1e8})
    assert stronger.sources["strength.A"].confidence == "user"
    assert copper.value_at("strength.A") == 90e6


@pytest.mark.parametrize("path", ["strength.a", "strenght.A", "strength", "name", "eos.kind"])
def test_with_value__of_an_unknown_path_gives_the_nearest(copper: Material, path: str) -> None:
    with pytest.raises(InvalidInput, match=r"did you mean|use one of"):
        copper.with_value(path, 1.0)


@pytest.mark.parametrize(
    ("path", "value", "word"),
    [
        ("density.value", True, "density.value"),
        ("density.value", float("nan"), "finite"),
        ("density.value", -1.0, "density from"),
        ("density.value", "none", "plain number"),
        ("density.unit", "kg", "density"),
        ("density.unit", "1", "kg m-3"),
        ("density.source", "", "density.source"),
        ("density.confidence", "sure", "memory"),
        ("density", 8930, "with unit and source"),
        ("density.uncertainty", 1, "a key of a number"),
        ("strength.kind", "johnson-cock", "did you mean 'johnson-cook'"),
        ("strength.a", {}, "did you mean 'A'"),
        ("strength.A", None, "with unit and source"),
        ("thermal", [], "section"),
        ("eos.s.unit", "mm", "eos.s.unit"),
        ("elasticity", {}, "did you mean 'elastic'"),
        ("name", "a b", "letters"),
        ("family", 3, "family"),
        ("yield_stresses", 3, "list"),
        ("yield_stresses", [{"value": 1}], "label"),
    ],
)
def test_load__refuses_with_the_key(
    document: dict[str, Any], path: str, value: object, word: str
) -> None:
    *parents, last = path.split(".")
    place = document
    for parent in parents:
        place = place[parent]
    place[last] = value
    message = refused(document)
    assert word in message
    assert path.split(".")[0] in message


def test_load__tells_everything_at_once(document: dict[str, Any]) -> None:
    del document["eos"]
    document["density"]["unit"] = "m"
    document["strength"].pop("n")
    message = refused(document)
    assert all(key in message for key in ("eos", "density", "strength.n"))


@pytest.mark.parametrize("given", [None, 3, "[]", []])
def test_read_document__of_no_mapping_is_refused(given: Any) -> None:
    with pytest.raises(InvalidInput):
        materials.read_document(given)
