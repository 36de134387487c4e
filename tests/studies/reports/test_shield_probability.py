"""The probability that a simulated wall fails, in a report: without its simulation, and joined with it."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import pytest

from studies.observations.shields import drawn
from studies.observations.shields.answers import shown
from studies.observations.shields.drawn import DrawnShots
from studies.observations.shields.joined import NOT_JOINED, Joint
from studies.observations.shields.probability import Probability, probability
from studies.reports.words import MOST_WORDS
from studies.sweeps.sweep import Sweep
from tests.studies.reports.test_ballistic_limit import PLAIN, SHIELD, computed, document_of, result_of, sweep_of
from tests.studies.support import fakes

GAIN, NO_GAIN = DrawnShots(17, 0.02, 0.01, 8, 3), DrawnShots(17, 0.02, 0.03, 8, 6)
ADDED = {
    "none, one grid": Joint(2.0, -1.0, ((0.1, 0.0), (0.0, 0.2)), 50, (GAIN,) * 3),
    "johnson-cook, one grid": Joint(2.0, -1.0, ((0.1, 0.0), (0.0, 0.2)), 50, (NO_GAIN,) * 3),
}
FOUND = "such simulations found 6 of 16 walls that were perforated"  # from 3 km/s on, without failure
SHOT = {"speed": "7 km/s", "projectile_diameter": "4 mm"}
LIMITS = {"none": lambda speed: 5e-3, "johnson-cook": lambda speed: 3e-3}  # made up, m
FINE = 40  # cells: at least six through the bumper up to 6.7 mm


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


def rows_of(sweep: Sweep, **how: Any) -> list[Mapping[str, Any]]:
    limits = document_of(sweep, computed(sweep, **how))["ballistic_limit"]
    rows: list[Mapping[str, Any]] = limits["probability"]["rows"]
    return rows


def test_rows__have_the_probability_before_and_after_each_run() -> None:
    sweep = sweep_of(PLAIN, resolution=FINE)
    [first, *_] = sweep.shots()
    rows = rows_of(sweep)
    assert len(rows) == 9
    for row in rows:
        before = probability(replace(first, speed=row["speed"], projectile_diameter=row["diameter"]))
        assert before is not None
        after = ADDED["none, one grid"].probability(before, "perforated" if row["perforated"] else "held")
        assert row["before"] == vars(before)
        assert row["joined"] == vars(after)
        assert (after.value > before.value) is row["perforated"]


def test_headline__of_one_diameter_is_the_probability() -> None:
    sweep = sweep_of(["5 mm"], resolution=FINE)
    document = document_of(sweep, computed(sweep))
    row = max(document["ballistic_limit"]["probability"]["rows"], key=lambda row: row["joined"]["value"])
    after, before = (shown(Probability(**row[key])) for key in ("joined", "before"))
    speed = f"{row['speed'] / 1e3:g} km/s"
    assert document["headline"] == f"{speed}, 5 mm: {after} to fail; {before} without simulation; one mesh."
    assert len(document["headline"].split()) <= MOST_WORDS


def test_shot__is_told_once_with_what_each_failure_says() -> None:
    store({})
    sweep = sweep_of(["4 mm"], axes={"failure": ["none", "johnson-cook"]}, fixed={**SHIELD, **SHOT}, resolution=FINE)
    runs = [point.run for point in sweep.runs()]
    document = document_of(sweep, {run.id: result_of(run, LIMITS[str(run.parameters["failure"])]) for run in runs})
    sentence, *_ = document["ballistic_limit"]["probability"]["sentences"]
    begin = (
        "At 7 km/s, 4 mm is held with failure none (no published shots were simulated like this) and perforates with "
    )
    assert sentence.startswith(f"{begin}failure johnson-cook: ")
    assert document["headline"].startswith("7 km/s, 4 mm: undecided in simulation (models disagree); ")
    assert len(document["headline"].split()) <= MOST_WORDS


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"resolution": 16}, "on at least 24 cells across"),
        (
            {"resolution": FINE, "fixed": {**SHIELD, "failure": "johnson-cook"}},
            "with failure johnson-cook, one grid are not seen to improve P",
        ),
        ({"resolution": FINE, "fixed": {**SHIELD, "geometry": "quarter"}}, "with geometry quarter"),
        ({"resolution": FINE, "fixed": {**SHIELD, "recipe": "thesis"}}, "with particles per cell 2"),
        ({"resolution": FINE, "fixed": {**SHIELD, "cells_per_wall": 8}}, "on at least 9 cells through the wall"),
        ({"resolution": [FINE, 48]}, "on several grids with one failure alone"),
    ],
)
def test_simulation__is_not_joined_where_no_shots_were_simulated_like_it(changes: dict[str, Any], why: str) -> None:
    sweep = sweep_of(["4 mm"], **changes)
    document = document_of(sweep, {point.run.id: result_of(point.run) for point in sweep.runs()})
    rows = document["ballistic_limit"]["probability"]["rows"]
    assert [row["joined"] for row in rows] == [None] * 3
    assert all(row["why"].startswith(NOT_JOINED) and why in row["why"] for row in rows)
    assert "in simulation; " in document["headline"]
    assert any(why in sentence for sentence in document["ballistic_limit"]["probability"]["sentences"])


def test_gain__decides_by_the_range_of_the_speed() -> None:
    """Where the lower bound of what is gained is above zero from 7 km/s on alone, slower shots are not joined."""
    store({"none, one grid": replace(ADDED["none, one grid"], ranges=(NO_GAIN, NO_GAIN, GAIN))})
    rows = rows_of(sweep_of(["4 mm"], resolution=FINE))
    assert {row["speed"] for row in rows if row["joined"]} == {7e3}
    assert all("are not seen to improve P" in row["why"] for row in rows if row["speed"] < 7e3)


@pytest.mark.parametrize(
    ("projectile", "reason"),
    [("steel-304", "the projectile is steel, all shots are of aluminium"), ("al-6061-t6", "v = 12 km/s, shots end at")],
)
def test_shot__outside_of_all_shots_has_no_probability_and_the_report_says_why(projectile: str, reason: str) -> None:
    axes = {"speed": ["12 km/s"], "projectile_diameter": ["4 mm"]}
    sweep = sweep_of([], axes=axes, fixed={**SHIELD, "projectile": projectile}, resolution=FINE)
    document = document_of(sweep, computed(sweep, limit=lambda speed: 9e-3))
    limits = document["ballistic_limit"]
    assert limits["probability"]["rows"] == []
    [sentence] = limits["probability"]["sentences"]
    assert sentence.startswith(f"No probability at 12 km/s: {reason}")
    assert "to fail" not in document["headline"]


def test_wall_that_holds__has_beside_it_how_many_failures_such_simulations_find() -> None:
    store({name: replace(each, ranges=(NO_GAIN, *each.ranges[1:])) for name, each in ADDED.items()})
    sweep = sweep_of(["4 mm"], axes={"failure": ["none"]}, fixed={**SHIELD, **SHOT}, resolution=16)
    document = document_of(sweep, computed(sweep, limit=lambda speed: 9e-3))
    limits = document["ballistic_limit"]
    assert "held in simulation (finds 6 of 16 failures)" in document["headline"]
    assert len(document["headline"].split()) <= MOST_WORDS
    assert f"4 mm is held with failure none ({FOUND}):" in limits["probability"]["sentences"][0]
    assert limits["probability"]["rows"][0]["does"] == f"is held ({FOUND})"
    assert f"the limit is above 4 mm (7 km/s, failure none); {FOUND}." in limits["regimes"][0]["sentence"]
    [stated] = [each for each in document["outcomes"] if each["quantity"] == "wall_perforated"]
    assert [row["reason"] for row in stated["rows"]] == [f"one grid; {FOUND}"]


def test_each_shield__is_named_beside_its_probability() -> None:
    walls = {name: value for name, value in SHIELD.items() if name != "wall_thickness"}
    axes = {"wall_thickness": ["2 mm", "5 mm"], "bumper_2_thickness": ["0 mm", "1 mm"]}
    fixed = {**walls, **SHOT, "bumper_2": "al-6061-t6", "bumper_2_stand_off": "5 cm"}
    sweep = sweep_of([], axes=axes, fixed=fixed, resolution=FINE)
    document = document_of(sweep, computed(sweep, limit=lambda speed: 3e-3))
    thin, thick, without = document["ballistic_limit"]["probability"]["sentences"]
    assert thin.startswith("At 7 km/s, wall thickness 2 mm, 4 mm perforates: ")
    assert thick.startswith("At 7 km/s, wall thickness 5 mm, 4 mm perforates: ")
    assert "not counted" not in thick  # its wall has more cells by default
    assert without.count("bumper 2 thickness 1 mm") == 2


@pytest.mark.parametrize("lengths", [["4 mm", "20 mm"], ["20 mm", "4 mm"]])
def test_rod__does_not_have_the_probability_of_a_short_cylinder(lengths: list[str]) -> None:
    fixed = {**SHIELD, **SHOT, "projectile_shape": "cylinder"}
    sweep = sweep_of([], axes={"projectile_length": lengths}, fixed=fixed, resolution=FINE)
    [row] = document_of(sweep, computed(sweep))["ballistic_limit"]["probability"]["rows"]
    assert row["at"] == {"projectile_length": 4e-3}


def test_simulation__is_not_joined_before_any_shot_was_simulated() -> None:
    store({})
    assert [row["joined"] for row in rows_of(sweep_of(["4 mm"], resolution=FINE))] == [None] * 3


def test_open_run__leaves_the_probability_as_it_was() -> None:
    sweep = sweep_of(["4 mm"], resolution=FINE)
    results = computed(sweep)
    lost = sweep.runs()[0].run.id
    del results[lost]
    rows = document_of(sweep, results)["ballistic_limit"]["probability"]["rows"]
    [row] = [row for row in rows if row["perforated"] is None]
    assert row["joined"] == row["before"]


def test_held_run__that_may_still_be_perforated_is_open() -> None:
    sweep = sweep_of(["4 mm"], resolution=FINE)
    results = computed(sweep)
    for id, each in results.items():
        wall = replace(each.measurements["wall_perforated"], flags=("still_attached",))
        results[id] = replace(each, measurements={"wall_perforated": wall})
    limits = document_of(sweep, results)["ballistic_limit"]
    runs = [run for row in limits["rows"] for run in row["runs"]]
    assert {run["perforated"] for run in runs} == {None, True}
    assert {run["why"] for run in runs} == {"", "wall holds, but still attached"}
    for row in limits["probability"]["rows"]:
        assert row["joined"] == row["before"] or row["perforated"]


def test_search_on_several_grids__is_joined_by_what_such_simulations_add() -> None:
    store({"none, several grids": ADDED["none, one grid"]})
    sweep = sweep_of({"limit_of": "wall_perforated", "between": ["1 mm", "9 mm"], "until": "10 %"}, resolution=[40, 54])
    limits = document_of(sweep, fakes.searched(sweep, result_of))["ballistic_limit"]
    for row in limits["rows"]:
        assert row["upper"] <= 1.11 * row["lower"]
    chances = [row for row in limits["probability"]["rows"] if row["diameter"] <= 9e-3]
    assert chances
    assert all(row["joined"] is not None for row in chances)
    assert {row["joined"]["value"] > row["before"]["value"] for row in chances} == {True, False}
