"""The rule that chooses a recipe, on studies made up for it."""

from typing import Any

import pytest

from studies.recipe_study.__main__ import table
from studies.recipe_study.choice import eligible, score, winner
from studies.recipe_study.variants import variants


def study(
    *, pressure: float = 0.0, holes: tuple[float, float] = (16e-3, 15e-3), seconds: float = 10.0
) -> dict[str, Any]:
    """Figures of a variant that is the same at both speeds."""
    sound = {"state": "succeeded", "energy_drift": 0.0, "flags": []}
    shock = {"state": "succeeded", "pressure": pressure, "shock_speed": 0.0, "scatter": 0.05}
    both = {
        cells: {**sound, "hole_diameter": hole, "seconds": seconds}
        for cells, hole in zip(("16", "32"), holes, strict=True)
    }
    return {
        "shocks": {"2000": {**shock, "drift": 0.0}, "6000": {**shock, "drift": 0.0}},
        "holes": {"2000": both, "6000": both},
        "crater": {**sound, "crater_depth": 14e-3, "crater_diameter": 25e-3},
    }


def test_choice__wants_the_shocks_right_first() -> None:
    results = {"rough": study(pressure=0.02, holes=(15e-3, 15e-3)), "fine": study()}
    assert not eligible(results["rough"])
    assert winner(results) == "fine"


def test_choice__takes_the_smallest_change_of_the_hole() -> None:
    results = {"far": study(holes=(17e-3, 15e-3)), "near": study(holes=(15.5e-3, 15e-3))}
    assert winner(results) == "near"
    assert score(results["near"]) == pytest.approx(2.0 * 0.5 / 15.0)


def test_choice__takes_the_cheaper_of_equals() -> None:
    results = {"dear": study(seconds=20.0), "cheap": study(holes=(16.01e-3, 15e-3))}
    assert winner(results) == "cheap"


@pytest.mark.parametrize(
    "fault",
    [{"state": "failed", "reason": "x"}, {"energy_drift": 0.02}, {"flags": ["runaway_particles"]}],
)
def test_choice__leaves_out_what_failed(fault: dict[str, Any]) -> None:
    broken = study()
    broken["crater"] = {**broken["crater"], **fault}
    assert not eligible(broken)
    with pytest.raises(ValueError, match="no variant"):
        winner({"broken": broken})


def test_table__has_a_line_for_each_variant() -> None:
    assert len(table({"a": study(), "b": study()}).splitlines()) == 4


def test_variants__change_one_thing_under_one_name() -> None:
    found = list(variants())
    assert len({variant.name for variant in found}) == len(found)
    assert len({variant.recipe for variant in found}) == len(found)
