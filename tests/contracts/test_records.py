"""Every constant of a model has its unit beside it, and comes from somewhere."""

from typing import Any, get_type_hints

import pytest

from solver.registry import entries
from solver.units import FromMaterial, Unit, marked
from studies import materials
from studies.materials.schema import STIFFNESS
from studies.quantities.parameters import declared

FOLDERS = {
    "solver.grid.shapes": "SHAPE",
    "solver.matter.tension": "TENSION",
    "solver.matter.failure": "FAILURE",
    "solver.matter.strength": "STRENGTH",
    "solver.matter.eos": "EOS",
}
ENTRIES = [(folder, entry) for folder, kind in FOLDERS.items() for entry in entries(folder, kind).values()]
# A material file cannot name them: they are for verification, or need a detonation.
NOT_IN_FILES = {"ideal-gas", "jwl"}
models = pytest.mark.parametrize(
    ("folder", "entry"), ENTRIES, ids=[f"{folder.rpartition('.')[2]}-{entry.name}" for folder, entry in ENTRIES]
)


@models
def test_record__has_a_unit_for_every_real_number(folder: str, entry: Any) -> None:
    hints = get_type_hints(entry.record)
    numbers = {name for name, hint in hints.items() if hint in (float, float | None)}
    assert numbers <= marked(entry.record, Unit).keys()


@models
def test_record__can_be_filled_by_person_and_material(folder: str, entry: Any) -> None:
    """A shape function and a rule of tension have no constants of their own in a sweep."""
    described = set() if folder in ("solver.grid.shapes", "solver.matter.tension") else set(declared(entry.record))
    taken = marked(entry.record, FromMaterial)
    filled = described | set(taken) | set(entry.record._field_defaults)
    assert (filled == set(entry.record._fields)) == (entry.name not in NOT_IN_FILES)
    paths = materials.load("copper-ofhc").parameters
    assert {mark.path for mark in taken.values()} <= {*paths, STIFFNESS, "stiffness"}
