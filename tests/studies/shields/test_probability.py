"""The probability that a simulated wall fails, in a report: without its simulation, and joined with it."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, astuple, replace
from pathlib import Path
from typing import Any

import pytest

from studies.reports.wording import MOST_WORDS
from studies.shields.section import Apart, NotJoined, WallRun
from studies.shields.shots import drawn
from studies.shields.shots.answers import answer
from studies.shields.shots.chance import probability
from studies.shields.shots.drawn import DrawnShots, Joint
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

GAIN, NO_GAIN = DrawnShots(17, 0.02, 0.01, 8, 3), DrawnShots(17, 0.02, 0.03, 8, 6)
ADDED = {
    "none, one grid": Joint(2.0, -1.0, ((0.1, 0.0), (0.0, 0.2)), 50, (GAIN,) * 3),
    "johnson-cook, one grid": Joint(2.0, -1.0, ((0.1, 0.0), (0.0, 0.2)), 50, (NO_GAIN,) * 3),
}
LIMITS = {"none": lambda speed: 5e-3, "johnson-cook": lambda speed: 3e-3}  # made up, m
FINE = 40  # cells: at least six through the bumper up to 6.7 mm
FIXED = {**SHIELD, **SHOT}
WALLS = {name: value for name, value in FIXED.items() if name != "wall_thickness"}
ONE = {"axes": {"failure": ["none"]}, "fixed": FIXED}


@pytest.fixture(autouse=True)
def _simulated(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """Constants of made-up simulated shots, without failure and on one grid."""
    monkeypatch.setattr(drawn, "STORED", tmp_path / "joined.json")
    store(ADDED)
    yield
    drawn.stored.cache_clear()


def store(joints: Mapping[str, Joint]) -> None:
    drawn.STORED.write_text(json.dumps({name: asdict(each) for name, each in joints.items()}))
    drawn.stored.cache_clear()


def runs_of(sweep: Sweep, results: Any = None) -> list[tuple[float, WallRun]]:
    """Each run with its speed."""
    return [(row.speed, run) for row in rows_of(sweep, results) for run in row.runs]


def test_runs__have_the_probability_before_and_after() -> None:
    sweep = sweep_of(PLAIN, resolution=FINE)
    [first, *_] = shots_of(sweep)
    runs = runs_of(sweep)
    assert len(runs) == 9
    for speed, run in runs:
        before = probability(replace(first, speed=speed, projectile_diameter=run.diameter))
        assert before is not None
        assert run.before is not None
        assert run.joined is not None
        after = ADDED["none, one grid"].probability(before, "perforated" if run.perforated else "held")
        assert astuple(run.before) == astuple(before)
        assert astuple(run.joined) == astuple(after)
        assert (after.value > before.value) is run.perforated


# What a report opens with, by changes of a sweep of one diameter, the made-up limit in mm, and stored constants.
STALE = {name: replace(each, ranges=(NO_GAIN,) * 3) for name, each in ADDED.items()}
EASIER = "one easier shot failed. At 10\u202f% risk: a sphere of 3.08 mm, or a wall of 5.27 mm."
OPENINGS: dict[str, tuple[dict[str, Any], float, Mapping[str, Joint], str]] = {
    "one shot, joined": (
        *({**ONE, "resolution": FINE}, 3.0, ADDED),
        f"68\u202f% to fail (44 to 85), 22\u202f% without simulation; {EASIER}",
    ),
    "one shot, perforated": (*(ONE, 3.0, STALE), f"22\u202f% to fail (12 to 38), perforated in simulation; {EASIER}"),
    # How many failures such simulations find has no room beside it, so that it is not said to hold.
    "one shot, held": (*(ONE, 9.0, STALE), f"22\u202f% to fail (12 to 38); {EASIER}"),
    "several, held": (
        *({**ONE, "axes": {"wall_thickness": ["2 mm", "5 mm"]}, "fixed": WALLS}, 9.0, STALE),
        "7 km/s, wall thickness 2 mm, 4 mm: 38\u202f% to fail (23 to 55), held in simulation (finds 12 of 16 "
        "failures); 11\u202f% at wall thickness 5 mm.",
    ),
    "models disagree": (
        *({**ONE, "axes": {"failure": ["none", "johnson-cook"]}}, -1.0, {}),
        f"22\u202f% to fail (12 to 38); {EASIER}",
    ),
    "outside of all shots": (
        *({"axes": {"speed": ["12 km/s"]}, "fixed": {**SHIELD, "projectile_diameter": "4 mm"}}, 3.0, ADDED),
        "12 km/s: perforated from 4 mm; Christiansen (JSC) 3.81 mm, Christiansen (NNO) 3.81 mm; one easier shot "
        "failed.",
    ),
}


@pytest.mark.parametrize("name", OPENINGS)
def test_opening__is_the_probability_with_shots_and_safe_sizes(name: str) -> None:
    changes, limit, constants, said = OPENINGS[name]
    store(constants)
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
    ("changes", "reason", "value"),
    [
        ({"resolution": 16}, Apart.CELLS_ACROSS, 24.0),
        ({"fixed": {**SHIELD, "failure": "johnson-cook"}}, Apart.NO_GAIN, "johnson-cook"),
        ({"fixed": {**SHIELD, "geometry": "quarter"}}, Apart.SETTING, "quarter"),
        ({"fixed": {**SHIELD, "recipe": "thesis"}}, Apart.SETTING, 2.0),
        ({"fixed": {**SHIELD, "cells_per_wall": 8}}, Apart.CELLS_THROUGH, 9.0),
        ({"resolution": [FINE, 48]}, Apart.NO_SUCH_SHOTS, "none"),
    ],
)
def test_simulation__is_not_joined_where_no_shots_were_simulated_like_it(
    changes: dict[str, Any], reason: Apart, value: float | str
) -> None:
    runs = runs_of(sweep_of(["4 mm"], **{"resolution": FINE, **changes}))
    assert [run.joined for _, run in runs] == [None] * 3
    assert {(run.apart.reason, run.apart.value) for _, run in runs if run.apart} == {(reason, value)}


def test_gain__decides_by_the_range_of_the_speed() -> None:
    """Where the lower bound of what is gained is above zero from 7 km/s on alone, slower shots are not joined."""
    store({"none, one grid": replace(ADDED["none, one grid"], ranges=(NO_GAIN, NO_GAIN, GAIN))})
    runs = runs_of(sweep_of(["4 mm"], resolution=FINE))
    assert {speed for speed, run in runs if run.joined} == {7e3}
    assert {run.apart for speed, run in runs if speed < 7e3} == {NotJoined(Apart.NO_GAIN, "failure", "none")}


@pytest.mark.parametrize(
    ("projectile", "reason"),
    [("steel-304", "the projectile is steel, all shots are of aluminium"), ("al-6061-t6", "v = 12 km/s, shots end at")],
)
def test_shot__outside_of_all_shots_has_no_probability_and_the_record_says_why(projectile: str, reason: str) -> None:
    axes = {"speed": ["12 km/s"], "projectile_diameter": ["4 mm"]}
    [(_, run)] = runs_of(sweep_of([], axes=axes, fixed={**SHIELD, "projectile": projectile}), {})
    assert (run.before, run.joined) == (None, None)
    assert run.outside.startswith(reason)


@pytest.mark.parametrize("lengths", [["4 mm", "20 mm"], ["20 mm", "4 mm"]])
def test_rod__does_not_have_the_probability_of_a_short_cylinder(lengths: list[str]) -> None:
    fixed = {**FIXED, "projectile_shape": "cylinder"}
    rows = rows_of(sweep_of([], axes={"projectile_length": lengths}, fixed=fixed, resolution=FINE))
    assert {row.at["projectile_length"] for row in rows if row.runs[0].before} == {4e-3}


def test_open_run__leaves_the_probability_as_it_was() -> None:
    sweep = sweep_of(["4 mm"], resolution=FINE)
    results = computed(sweep)
    del results[sweep.runs()[0].run.id]
    [run] = [run for _, run in runs_of(sweep, results) if run.perforated is None]
    assert run.joined == run.before


def test_held_run__that_may_still_be_perforated_is_open() -> None:
    sweep = sweep_of(["4 mm"], resolution=FINE)
    results = computed(sweep)
    for id, each in results.items():
        wall = replace(each.measurements["wall_perforated"], flags=("still_attached",))
        results[id] = replace(each, measurements={"wall_perforated": wall})
    runs = [run for _, run in runs_of(sweep, results)]
    told = {(run.perforated, run.says, run.doubts) for run in runs}
    assert told == {(None, False, ("still_attached",)), (True, True, ())}
    assert all(run.joined == run.before or run.perforated for run in runs)


def test_search_on_several_grids__is_joined_by_what_such_simulations_add() -> None:
    store({"none, several grids": ADDED["none, one grid"]})
    sweep = sweep_of({"limit_of": "wall_perforated", "between": ["1 mm", "9 mm"], "until": "10 %"}, resolution=[40, 54])
    rows = rows_of(sweep, fakes.searched(sweep, result_of))
    assert all(row.upper <= 1.11 * row.lower for row in rows if row.upper and row.lower)
    runs = [run for row in rows for run in row.runs if run.diameter <= 9e-3]
    assert {run.joined.value > run.before.value for run in runs if run.joined and run.before} == {True, False}
    assert all(run.joined for run in runs)
