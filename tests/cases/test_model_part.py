"""The stored model part: each metal has the runs behind it, and holds what other sourced models make of a shot."""

import math
from collections.abc import Callable
from typing import Any

import pytest

from docs.model_part import METALS, SHOTS, SPEEDS, class_of
from studies import materials
from studies.cases.rows import Row, at_least, at_most, equal, relative
from studies.cubes.models import BASE, classes, stored_shares
from studies.sweeps.screening import CONTRIBUTIONS, FAILURE, STRENGTH
from tests.cases.cubes import result_of

SPEED = SPEEDS.index(5e3)
HOLE = "hole_diameter"
KEPT = 1e-4  # digits that are stored
# The shot that was computed with each failure before the model part was: 2024-T3 on 2024-T3.
SHOT: dict[str, Any] = {
    **dict.fromkeys(("projectile", "target"), "al-2024-t3"),
    **{"projectile_diameter": 10e-3, "plate_thickness": 4e-3, "speed": 6.18e3, "cells_per_diameter": 24.0},
}
WIDEST = [
    *({"failure": "spall", "failure_time": time} for time in (10e-9, 20e-9, 50e-9, 100e-9, 1e-6)),
    *({"failure": "plastic-strain", "failure_strain": strain} for strain in (0.3, 1.0)),
]


@pytest.mark.parametrize("scenario", SHOTS)
def test_stored__is_there_for_every_metal_at_every_speed(scenario: str) -> None:
    mine = {each["material"]: each for each in classes() if each["scenario"] == scenario}
    assert set(mine) == set(METALS)
    families = {each["family"] for each in mine.values()}
    assert {load.family for load in map(materials.load, materials.names())} == families
    for each in mine.values():
        quantity = HOLE if scenario == "thin_plate" else "crater_depth"
        assert None not in each["quantities"][quantity][BASE]


@pytest.mark.claim("breaking", "model-part-runs", minutes=4.0)
@pytest.mark.parametrize("metal", METALS)
def test_model_part__is_what_its_runs_give(metal: str, compared: Callable[..., None]) -> None:
    """Each change of strength, failure and equation of state behind a metal's model part gives the stored hole."""
    (stored,) = [each for each in classes() if (each["scenario"], each["material"]) == ("thin_plate", metal)]
    answers = class_of("thin_plate", metal, SPEEDS[SPEED : SPEED + 1])["quantities"][HOLE]
    holes = {change: values[SPEED] for change, values in stored["quantities"][HOLE].items()}
    told = [change for change, hole in holes.items() if hole is not None]  # at this speed
    compared(equal(f"{metal}: changes", expected=told, got=list(answers)))
    for change, (value,) in answers.items():
        compared(relative(f"{metal}, {change}: hole (m)", expected=holes[change], got=value, within=KEPT))
    shares = stored_shares(stored, HOLE, SPEEDS[SPEED])
    compared(at_least(f"{metal}: share of strength", limit=KEPT, got=shares[STRENGTH]))
    if materials.load(metal).value_at("spall.strength") is not None:
        compared(at_least(f"{metal}: share of failure", limit=KEPT, got=shares[FAILURE]))
    for name in CONTRIBUTIONS:
        compared(Row(f"{metal}: {name}", "", shares.get(name, "not assessed"), passed=None))


@pytest.mark.claim("breaking", "model-part-widest", minutes=0.5)
def test_model_part__holds_what_failures_of_any_constant_make_of_a_shot(compared: Callable[..., None]) -> None:
    """The widest of seven failures with constants of a user lies inside the model part that a report prints."""

    def hole(**failure: object) -> float:
        return result_of("thin_plate", {**SHOT, **failure}).measurements[HOLE].value or math.nan

    base = hole()
    (stored,) = [each for each in classes() if (each["scenario"], each["material"]) == ("thin_plate", "al-2024-t3")]
    part = sum(share**2 for share in stored_shares(stored, HOLE, SHOT["speed"]).values()) ** 0.5
    for failure in WIDEST:
        got = abs(hole(**failure) / base - 1.0)
        compared(at_most(f"{failure}: difference from no failure", limit=part, got=got))
