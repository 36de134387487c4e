"""The probability that a simulated wall fails, in a report: from equations and shots."""

from dataclasses import replace
from typing import Any

import pytest

from studies.reports.wording import MOST_WORDS
from studies.shields.section import WallRun
from studies.shields.shots.answers import answer
from studies.shields.shots.chance import probability
from studies.shields.shots.inverse import resized
from studies.shields.shots.records import Size
from studies.sweeps.sweep import Sweep
from tests.studies.shields.made import (
    PLAIN,
    SHIELD,
    SHOT,
    computed,
    part_of,
    record_of,
    result_of,
    rows_of,
    shots_of,
    sweep_of,
)
from tests.studies.support import fakes

LIMITS = {"none": lambda speed: 5e-3, "johnson-cook": lambda speed: 3e-3}  # made up, m
FIXED = {**SHIELD, **SHOT}
WALLS = {name: value for name, value in FIXED.items() if name != "wall_thickness"}
ONE = {"axes": {"failure": ["none"]}, "fixed": FIXED}


def runs_of(sweep: Sweep, results: Any = None) -> list[tuple[float, WallRun]]:
    """Each run with its speed."""
    return [(row.speed, run) for row in rows_of(sweep, results) for run in row.runs]


def test_runs__have_the_probability_of_their_shot() -> None:
    sweep = sweep_of(PLAIN)
    [first, *_] = shots_of(sweep)
    runs = runs_of(sweep)
    assert len(runs) == 9
    for speed, run in runs:
        chance = probability(replace(first, speed=speed, projectile_diameter=run.diameter))
        assert run.probability == chance is not None


# What a report opens with, by changes of a sweep of one diameter, and the made-up limit in mm.
EASIER = "one easier shot failed. At 10\u202f% risk: a sphere of 3.08 mm, or a wall of 5.27 mm."
OPENINGS: dict[str, tuple[dict[str, Any], float, str]] = {
    "one shot, perforated": (ONE, 3.0, f"22\u202f% to fail (12 to 38), perforated in simulation; {EASIER}"),
    # How many failures such simulations find has no room beside it, so that it is not said to hold.
    "one shot, held": (ONE, 9.0, f"22\u202f% to fail (12 to 38); {EASIER}"),
    "several, held": (
        *({**ONE, "axes": {"wall_thickness": ["2 mm", "5 mm"]}, "fixed": WALLS}, 9.0),
        "7 km/s, wall thickness 2 mm, 4 mm: 38\u202f% to fail (23 to 55), simulation cannot tell (finds 7 of 17 "
        "failures); 11\u202f% at wall thickness 5 mm.",
    ),
    "another rule of tension": (
        *({**ONE, "axes": {"wall_thickness": ["2 mm", "5 mm"]}, "fixed": {**WALLS, "tension": "opening"}}, 9.0),
        "7 km/s, wall thickness 2 mm, 4 mm: 38\u202f% to fail (23 to 55), simulation cannot tell (never tested); "
        "11\u202f% at wall thickness 5 mm.",
    ),
    "models disagree": (
        *({**ONE, "axes": {"failure": ["none", "johnson-cook"]}}, -1.0),
        f"22\u202f% to fail (12 to 38); {EASIER}",
    ),
    "outside of all shots": (
        *({"axes": {"speed": ["12 km/s"]}, "fixed": {**SHIELD, "projectile_diameter": "4 mm"}}, 3.0),
        "12 km/s: perforated from 4 mm; Christiansen (JSC) 3.81 mm, Christiansen (NNO) 3.81 mm; one easier shot "
        "failed.",
    ),
}


@pytest.mark.parametrize("name", OPENINGS)
def test_opening__is_the_probability_with_shots_and_safe_sizes(name: str) -> None:
    changes, limit, said = OPENINGS[name]
    sweep = sweep_of([], **changes)
    runs = [point.run for point in sweep.runs()]
    limits = {run.id: LIMITS[str(run.parameters["failure"])] if limit < 0.0 else lambda _: 1e-3 * limit for run in runs}
    opening = part_of(sweep, {run.id: result_of(run, limits[run.id]) for run in runs}).opening
    assert opening == said
    assert len(opening.split()) <= MOST_WORDS


def test_sizes__have_the_risk_that_they_are_named_with() -> None:
    sweep = sweep_of([], **ONE)
    [shot] = shots_of(sweep)
    beside, expected = record_of(part_of(sweep)).beside, answer(shot)
    assert beside is not None
    for each in beside.safe:
        if each.risk and each.value:
            chance = probability(resized(shot, Size(each.size), each.value))
            assert chance is not None
            assert chance.value == pytest.approx(each.risk, rel=1e-3)
    assert (beside.easier.shots, beside.easier.contrary) == (expected.easier.shots, expected.easier.contrary)
    assert (beside.harder.shots, beside.harder.contrary) == (expected.harder.shots, expected.harder.contrary)
    assert [*beside.nearest] == [*expected.nearest[:3]]
    assert beside.failed + beside.held > 0


@pytest.mark.parametrize(
    ("projectile", "reason"),
    [("steel-304", "the projectile is steel, all shots are of aluminium"), ("al-6061-t6", "v = 12 km/s, shots end at")],
)
def test_shot__outside_of_all_shots_has_no_probability_and_the_record_says_why(projectile: str, reason: str) -> None:
    axes = {"speed": ["12 km/s"], "projectile_diameter": ["4 mm"]}
    [(_, run)] = runs_of(sweep_of([], axes=axes, fixed={**SHIELD, "projectile": projectile}), {})
    assert run.probability is None
    assert run.outside.startswith(reason)


@pytest.mark.parametrize("lengths", [["4 mm", "20 mm"], ["20 mm", "4 mm"]])
def test_rod__does_not_have_the_probability_of_a_short_cylinder(lengths: list[str]) -> None:
    fixed = {**FIXED, "projectile_shape": "cylinder"}
    rows = rows_of(sweep_of([], axes={"projectile_length": lengths}, fixed=fixed))
    assert {row.at["projectile_length"] for row in rows if row.runs[0].probability} == {4e-3}


def test_held_run__that_may_still_be_perforated_is_open() -> None:
    sweep = sweep_of(["4 mm"])
    results = computed(sweep)
    for id, each in results.items():
        wall = replace(each.measurements["wall_perforated"], flags=("still_attached",))
        results[id] = replace(each, measurements={"wall_perforated": wall})
    told = {(run.perforated, run.says, run.doubts) for _, run in runs_of(sweep, results)}
    assert told == {(None, False, ("still_attached",)), (True, True, ())}


def test_search_on_several_grids__has_a_probability_of_each_run() -> None:
    sweep = sweep_of({"limit_of": "wall_perforated", "between": ["1 mm", "9 mm"], "until": "10 %"}, resolution=[40, 54])
    rows = rows_of(sweep, fakes.searched(sweep, result_of))
    assert all(row.upper <= 1.11 * row.lower for row in rows if row.upper and row.lower)
    assert all(run.probability for row in rows for run in row.runs if run.diameter <= 9e-3)
