"""The rule that chooses a recipe, on studies made up for it."""

from typing import Any

import pytest

from docs.recipe_study.choice import candidates, eligible, missed, winner
from docs.recipe_study.variants import scan, variants

SPEEDS = ("2000", "4000", "6000")


def study(
    *,
    shape: str = "gimp",
    pressure: float = 0.0,
    rebound: float = 0.95,
    taylor: tuple[float, float] = (0.012, 0.004),
    noh: float = 0.5,
    scatter: float = 0.05,
    particles: int = 2,
    seconds: float = 10.0,
) -> dict[str, Any]:
    """Figures of a variant that is the same at all speeds."""
    sound = {"state": "succeeded", "energy_drift": 0.0, "flags": []}
    shock = {
        **{"state": "succeeded", "energy_drift": 0.0, "pressure": [0.0, pressure]},
        **{"shock_speed": [0.0], "particle_density": [0.0], "spacing_density": [0.0]},
        "scatter": [scatter],
    }
    holes = {cells: {**sound, "hole_diameter": 15e-3, "seconds": 10.0} for cells in ("16", "32")}
    return {
        "group": "base",
        "recipe": {"shape": shape, "particles_per_cell": particles},
        "shocks": {f"Cu on Cu, {speed}": dict(shock) for speed in SPEEDS},
        "bar": {"state": "succeeded", "time": 0.0, "rebound": rebound},
        "taylor": {"state": "succeeded", "changes": taylor, "mean_error": 0.5, "finest_error": 0.5},
        "noh": {"state": "succeeded", "part": noh},
        "coarse_hole": {"state": "succeeded", "seconds": seconds},
        "holes": {"2000": holes, "6000": holes},
        "crater": {**sound, "crater_depth": 14e-3, "crater_diameter": 25e-3},
    }


def final(coarse: float, middle: float, fine: float) -> dict[str, Any]:
    """Holes, mm, that scatter by a tenth of a millimetre."""
    grids = {
        cells: [1e-3 * (hole + shift) for shift in (-0.1, 0.0, 0.1)]
        for cells, hole in zip(("16", "32", "64"), (coarse, middle, fine), strict=True)
    }
    return {"holes": dict.fromkeys(SPEEDS, grids), "seconds": 10.0}


@pytest.mark.parametrize(
    ("figures", "gates"),
    [
        ({}, []),
        ({"pressure": 0.017}, []),
        ({"pressure": 0.021}, ["P"]),
        ({"pressure": 0.017, "shape": "quadratic-bspline"}, ["P"]),  # which is held closer
        ({"rebound": 0.92}, ["rebound"]),
        ({"taylor": (0.021, 0.004)}, ["Taylor"]),
        ({"taylor": (0.012, 0.011)}, ["Taylor"]),
        ({"noh": 1.01}, ["Noh"]),
    ],
)
def test_gates__are_those_of_the_verification(figures: dict[str, Any], gates: list[str]) -> None:
    assert missed(study(**figures)) == gates
    assert eligible(study(**figures)) is not bool(gates)


@pytest.mark.parametrize("problem", ["bar", "taylor", "noh"])
def test_gates__are_missed_by_what_failed(problem: str) -> None:
    assert missed({**study(), problem: {"state": "failed", "reason": "x"}})


def test_gates__look_at_both_bodies_of_every_shock() -> None:
    figures = study()
    figures["shocks"]["Cu on Cu, 4000"]["spacing_density"] = [0.0, -0.006]
    assert missed(figures) == ["spacing"]


def test_candidates__are_the_calmest_viscosity_of_each_kind__the_cheapest_first() -> None:
    results = {
        "three": study(particles=3, seconds=20.0),
        "rough": study(scatter=0.08),
        "calm": study(scatter=0.04),
        "calmest": study(scatter=0.01, taylor=(0.03, 0.004)),
        "spline": study(shape="quadratic-bspline", pressure=0.02),
    }
    assert candidates(results) == ["calm", "three"]


def test_choice__takes_the_cheapest_that_holds() -> None:
    results = {"cheap": study(), "dear": study(particles=3, seconds=20.0)}
    finals = {"cheap": final(15.2, 15.0, 14.8), "dear": final(16.0, 15.0, 15.0)}
    assert winner(results, finals) == "cheap"
    assert winner(results, {**finals, "cheap": final(15.2, 15.0, 14.6)}) == "dear"
    assert winner(results, {**finals, "cheap": final(16.5, 15.0, 15.0)}) == "dear"


@pytest.mark.parametrize(
    "fault", [{"state": "failed", "reason": "x"}, {"energy_drift": 0.02}, {"flags": ["runaway_particles"]}]
)
def test_choice__leaves_out_what_failed(fault: dict[str, Any]) -> None:
    broken = study()
    broken["crater"] = {**broken["crater"], **fault}
    assert not eligible(broken)
    with pytest.raises(ValueError, match="no candidate"):
        winner({"broken": broken}, {})


@pytest.mark.parametrize("asked", [variants, scan])
def test_variants__change_one_thing_under_one_name(asked: Any) -> None:
    all_variants = list(asked())
    assert len({variant.name for variant in all_variants}) == len(all_variants)
    assert len({variant.recipe for variant in all_variants}) == len(all_variants)
