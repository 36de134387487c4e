"""The ballistic limit of a shield in a report: intervals of made-up walls, and equations beside them."""

import json
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from studies.cases.rows import equal
from studies.cubes import cube
from studies.laws import CRITICAL, Code, Shot, load
from studies.observations.shields.judged import equations
from studies.quantities.findings import InvalidInput
from studies.quantities.measured import Measured
from studies.reports.answers.question import read_question
from studies.reports.figure import FAILED, HELD, INTERVAL, RUN_HELD, RUN_PERFORATED, RUN_UNDECIDED
from studies.reports.publish import publish_sweep
from studies.reports.words import MOST_WORDS
from studies.runs.results import RunResult
from studies.runs.run import Run
from studies.sweeps.sweep import Sweep
from tests.studies.support import fakes
from tests.studies.support.printed import at, read_page, undrawn

SHIELD = {
    **{"projectile": "al-2017-t4", "bumper": "al-6061-t6", "wall": "al-6061-t6"},
    **{"bumper_thickness": "1 mm", "stand_off": "100 mm", "wall_thickness": "3 mm"},
}
SPEEDS = ["2 km/s", "5 km/s", "7 km/s"]
TOLERANCE = 0.2e-3
# The made-up limit over that of Christiansen's equation, by speed: it is too careful, agrees and is unsafe.
FACTORS = {2e3: 1.25, 5e3: 1.0, 7e3: 0.8}


def sweep_of(diameters: Any, **changes: Any) -> Sweep:
    axes = {"speed": SPEEDS, "projectile_diameter": diameters}
    return Sweep.parse({"scenario": "whipple_shield", "fixed": SHIELD, "axes": axes, "resolution": 16, **changes})


SEARCH = {"limit_of": "wall_perforated", "between": ["1 mm", "9 mm"], "tolerance": "0.2 mm"}
PLAIN = ["2 mm", "4 mm", "6 mm"]


@cache
def exact(speed: float) -> float:
    """The made-up limit, m."""
    [shot, *_] = sweep_of(PLAIN).shots()
    return FACTORS[speed] * load("whipple_nno").evaluate(replace(shot, speed=speed)).value


def result_of(run: Run, limit: Callable[[float], float] = exact, flags: tuple[str, ...] = ()) -> RunResult:
    value = float(float(run.parameters["projectile_diameter"] or 0.0) > limit(float(run.parameters["speed"] or 0.0)))
    measured = {"wall_perforated": Measured(value, None, {}, (), {}, 1)}
    return RunResult(run.id, "succeeded", measurements=measured, flags=flags, stop="settled")


def document_of(sweep: Sweep, results: Mapping[str, RunResult]) -> dict[str, Any]:
    return fakes.document_of(cube.build(sweep, results))


def searched(**how: Any) -> dict[str, Any]:
    """The report of a search."""
    sweep = sweep_of(SEARCH)
    return document_of(sweep, fakes.searched(sweep, partial(result_of, **how)))


@cache
def of_search() -> dict[str, Any]:
    return searched()


def computed(sweep: Sweep, **how: Any) -> dict[str, RunResult]:
    return {point.run.id: result_of(point.run, **how) for point in sweep.runs()}


def marks(document: Mapping[str, Any], label: str) -> set[tuple[float, float]]:
    [panel] = document["figures"][0]["panels"]
    return {
        (x, y) for each in panel["series"] if each["label"] == label for x, y in zip(each["x"], each["y"], strict=True)
    }


def test_cube__asks_the_equations_about_each_shield() -> None:
    sweep = sweep_of(PLAIN)
    question = read_question(sweep.document())
    assert [*sweep.shots()] == [question.shot(point) for point in question.points()]
    dataset = cube.build(sweep, {})
    name = CRITICAL["wall_perforated"]
    for law in equations():
        answers = dataset[f"{name}_by_law"].sel({f"{name}_law": law.name}).values.ravel()
        expected = [law.evaluate(shot).value for shot in sweep.shots()]
        np.testing.assert_allclose(answers, expected, rtol=1e-12)
    assert not dataset[f"{name}_by_law_reason"].sel({f"{name}_law": "whipple_nno"}).values.any()
    assert load("whipple_nno").source in dataset.attrs["references"]


def test_shot__of_a_wall_without_a_yield_stress_has_no_answer() -> None:
    soft = {"soft": {"base": "al-6061-t6", "yield_stresses": []}}
    sweep = sweep_of(PLAIN, materials=soft, fixed={**SHIELD, "wall": "soft"})
    said = load("whipple_nno").evaluate(next(iter(sweep.shots())))
    assert math.isnan(said.value)
    assert [reason.code for reason in said.reasons] == [Code.NO_YIELD_STRESS]
    document = document_of(sweep, computed(sweep))
    assert [row["equations"] for row in document["ballistic_limit"]["rows"]] == [[], [], []]


def test_constant__of_a_bumper_without_a_material_is_refused() -> None:
    with pytest.raises(InvalidInput, match="give bumper_2"):
        sweep_of(PLAIN, fixed={**SHIELD, "bumper_2.density": "2.7 g/cm3"}).runs()


@pytest.mark.parametrize(("bumpers", "expected"), [(2, {"whipple_srl_three_walls"}), (3, set())])
def test_shield__of_several_bumpers_has_the_equations_about_as_many(bumpers: int, expected: set[str]) -> None:
    further = {
        name: value
        for place in range(2, bumpers + 1)
        for name, value in (
            (f"bumper_{place}", "al-6061-t6"),
            (f"bumper_{place}_thickness", "0.5 mm"),
            (f"bumper_{place}_stand_off", "50 mm"),
        )
    }
    sweep = sweep_of(PLAIN, fixed={**SHIELD, **further})
    document = document_of(sweep, computed(sweep))
    rows = document["ballistic_limit"]["rows"]
    assert [{each["law"] for each in row["equations"]} for row in rows] == [expected] * len(SPEEDS)
    assert not marks(document, HELD) | marks(document, FAILED)  # all published shots are on one bumper
    assert ("no equation is about such a shield" in document["headline"]) == (not expected)


@pytest.mark.claim(
    "report", "shield-limit", says="A report calls each equation of a shield what a known limit makes it."
)
def test_verdict__calls_each_equation_what_the_exact_limit_makes_it(compared: Callable[..., None]) -> None:
    document = of_search()
    limits = document["ballistic_limit"]
    [first, *_] = sweep_of(PLAIN).shots()
    for row in limits["rows"]:
        d = exact(row["speed"])
        assert row["lower"] <= d < row["upper"] <= row["lower"] + TOLERANCE * (1.0 + 1e-9)
        shot = replace(first, speed=row["speed"])
        said = {each["law"]: each["word"] for each in row["equations"]}
        assert {*said} == {law.name for law in equations()}
        for law in equations():
            away = law.evaluate(shot).value - d
            if abs(away) > TOLERANCE:
                expected = "unsafe" if away > 0.0 else "careful"
                compared(equal(f"{law.name} at {row['speed']:g} m/s", expected=expected, got=said[law.name]))
        assert said["whipple_nno"] == {2e3: "careful", 5e3: "agrees", 7e3: "unsafe"}[row["speed"]]
    regimes = {each["regime"]: each["sentence"] for each in limits["regimes"]}
    assert list(regimes) == ["below 3 km/s", "3 to 7 km/s", "from 7 km/s"]
    [at_seven] = [row for row in limits["rows"] if row["speed"] == 7e3]
    nno = replace(first, speed=7e3)
    high = 100.0 * (load("whipple_nno").evaluate(nno).value / at_seven["upper"] - 1.0)
    assert f"({high:.0f}\u202f% high)" in regimes["from 7 km/s"].partition("too careful")[0]
    assert "agrees: Christiansen (NNO)" in regimes["3 to 7 km/s"]


def test_headline__names_the_equation_that_is_unsafe_by_most() -> None:
    document = of_search()
    assert len(document["headline"].split()) <= MOST_WORDS
    [row] = [row for row in document["ballistic_limit"]["rows"] if row["speed"] == 7e3]
    held = f"{1e3 * row['lower']:.3g}-{1e3 * row['upper']:.3g} mm"
    said = next(1e3 * each["diameter"] for each in row["equations"] if each["law"] == "whipple_nno")
    text = (
        f"At 7 km/s spheres up to {held} are held (finds 7 of 17 failures); Christiansen (NNO) says {said:.3g} mm: "
        "unsafe, 2 more too; one mesh."
    )
    assert document["headline"] == text


def test_figure__comes_first_with_intervals_runs_equations_and_shots() -> None:
    document = of_search()
    figure = document["figures"][0]
    assert figure["name"] == "ballistic_limit"
    [panel] = figure["panels"]
    [bars] = [each for each in panel["series"] if each["label"] == INTERVAL]
    rows = document["ballistic_limit"]["rows"]
    assert list(zip(bars["x"], bars["low"], bars["high"], strict=True)) == [
        (row["speed"], row["lower"], row["upper"]) for row in rows
    ]
    lines = {each["label"] for each in panel["series"] if each["kind"] == "curve"}
    assert lines == {law.title for law in equations()}
    assert marks(document, FAILED)
    assert marks(document, HELD)
    assert "0.4" in figure["caption"]
    assert "276 MPa" in figure["caption"]


def test_page__says_the_sentences_and_the_numbers_of_the_document(tmp_path: Path) -> None:
    sweep = sweep_of(PLAIN)
    with undrawn():
        publish_sweep(sweep, computed(sweep), tmp_path)
    document = json.loads((tmp_path / "report.json").read_text())
    shown = read_page((tmp_path / "report.html").read_text())
    texts = {mark.text for mark in shown.marks}
    assert {each["sentence"] for each in document["ballistic_limit"]["regimes"]} <= texts
    chances = document["ballistic_limit"]["probability"]
    assert {*chances["sentences"]} <= texts
    mine = [mark for mark in shown.marks if mark.path.startswith("/ballistic_limit/rows") and mark.value is not None]
    assert len(mine) == 4 * len(SPEEDS) * len(equations())
    probable = "/ballistic_limit/probability/rows"
    mine += [mark for mark in shown.marks if mark.path.startswith(probable) and mark.value is not None]
    of_chances = sum(5 if row["joined"] is None else 8 for row in chances["rows"])
    assert len(mine) == 4 * len(SPEEDS) * len(equations()) + of_chances
    for mark in mine:
        value = at(document, mark.path)
        assert mark.value == ("" if value is None else json.dumps(value))
    assert re.findall(r"\d", shown.unmarked) == []


def test_plain_sweep__has_a_mark_for_each_run_and_what_they_decide() -> None:
    sweep = sweep_of(PLAIN)
    results: dict[str, Any] = computed(sweep)
    lost = sweep.runs()[1].run  # 4 mm at 2 km/s
    del results[lost.id]
    document = document_of(sweep, results)
    every = {(speed, size) for speed in FACTORS for size in (2e-3, 4e-3, 6e-3)} - {(2e3, 4e-3)}
    assert marks(document, RUN_HELD) == {(speed, size) for speed, size in every if size <= exact(speed)}
    assert marks(document, RUN_PERFORATED) == {(speed, size) for speed, size in every if size > exact(speed)}
    assert marks(document, RUN_UNDECIDED) == {(2e3, 4e-3)}
    rows = {row["speed"]: row for row in document["ballistic_limit"]["rows"]}
    for speed in (5e3, 7e3):
        sizes = [2e-3, 4e-3, 6e-3]
        assert rows[speed]["lower"] == max((d for d in sizes if d <= exact(speed)), default=None)
        assert rows[speed]["upper"] == min((d for d in sizes if d > exact(speed)), default=None)
    # The lost run widens the interval.
    assert (rows[2e3]["lower"], rows[2e3]["upper"]) == (2e-3, 6e-3)


@pytest.mark.parametrize(
    ("limit", "word", "does"),
    [(0.0, "unsafe", "from 2 mm on perforate"), (9.0, "careful", "up to 6 mm are held (finds 2 of 2 failures)")],
)
def test_one_end__judges_what_it_contradicts(limit: float, word: str, does: str) -> None:
    sweep = sweep_of(PLAIN)
    document = document_of(sweep, computed(sweep, limit=lambda speed: limit))
    said = {each["word"] for row in document["ballistic_limit"]["rows"] for each in row["equations"]}
    assert said <= {word, "open"}
    assert does in document["headline"]


def test_many_points__of_one_end_have_no_limit() -> None:
    speeds = ["3.5 km/s", "4.5 km/s", "5.5 km/s", "6.5 km/s"]
    sweep = sweep_of([], axes={"speed": speeds, "projectile_diameter": ["3 mm", "4 mm"]})
    held = document_of(sweep, computed(sweep, limit=lambda speed: 9e-3 if speed < 6e3 else 3.5e-3))
    [regime] = held["ballistic_limit"]["regimes"]
    assert (
        "the limit is 3-4 mm at 1 point and above 4 mm at 3 points; such simulations found 7 of 17"
        in regime["sentence"]
    )


def test_larger_projectile__that_is_held_leaves_no_verdict() -> None:
    sweep = sweep_of(["2 mm", "4 mm"])
    results = computed(sweep, limit=lambda speed: 1e-3)
    for point in sweep.runs():
        if point.run.parameters["projectile_diameter"] == 4e-3:
            results[point.run.id] = result_of(point.run, limit=lambda speed: 9e-3)
    said = "No verdict: a larger projectile is held than one that perforates."
    assert document_of(sweep, results)["headline"] == said


def test_flagged_runs__judge_nothing() -> None:
    document = searched(flags=("under_resolved",))
    words = {each["word"] for row in document["ballistic_limit"]["rows"] for each in row["equations"]}
    assert words == {"unjudged"}
    assert "no equation is judged" in document["headline"]
    assert "under resolved" in document["ballistic_limit"]["regimes"][0]["sentence"]


def test_grids_that_disagree__leave_a_point_undecided() -> None:
    sweep = sweep_of(PLAIN, resolution=[16, 24])

    def finer_holds(run: Run) -> RunResult:
        fine = run.parameters["cells_per_diameter"] == 24.0
        return result_of(run, limit=lambda speed: 5e-3 if fine else 3e-3)

    limits = document_of(sweep, {point.run.id: finer_holds(point.run) for point in sweep.runs()})["ballistic_limit"]
    assert {(row["lower"], row["upper"]) for row in limits["rows"]} == {(2e-3, 6e-3)}
    whys = {run["why"] for row in limits["rows"] for run in row["runs"] if run["perforated"] is None}
    assert whys == {"wall holds with 24 cells; wall perforated with 16 cells"}


def test_each_shield__has_a_panel_and_its_place_in_the_words() -> None:
    fixed = {name: value for name, value in SHIELD.items() if name != "wall_thickness"}
    axes = {"speed": SPEEDS, "projectile_diameter": PLAIN, "wall_thickness": ["2 mm", "3 mm"]}
    sweep = sweep_of(PLAIN, fixed=fixed, axes=axes)
    document = document_of(sweep, computed(sweep, limit=lambda speed: 3e-3))
    figure = document["figures"][0]
    assert [panel["at"] for panel in figure["panels"]] == [{"wall_thickness": 2e-3}, {"wall_thickness": 3e-3}]
    thin, thick = (
        max(y for each in panel["series"] if each["kind"] == "curve" for y in each["y"]) for panel in figure["panels"]
    )
    assert thin < thick
    assert "up to 2-4 mm are held (finds 7 of 17 failures)" in document["headline"]
    assert "(7 km/s, wall thickness 2 mm)" in document["ballistic_limit"]["regimes"][-1]["sentence"]
    careful = document_of(sweep, computed(sweep, limit=lambda speed: 9e-3))
    assert "up to 6 mm are held (finds 2 of 2 failures); Schaefer (SRL) says" in careful["headline"]


def test_wide_interval__leaves_all_equations_in_agreement() -> None:
    sweep = sweep_of(["1 mm", "9 mm"])
    document = document_of(sweep, computed(sweep))
    said = "At 7 km/s spheres up to 1-9 mm are held (finds 7 of 17 failures); "
    assert document["headline"] == f"{said}all {len(equations())} equations agree; one mesh."


def test_cylinder__is_compared_by_the_sphere_of_its_volume() -> None:
    fixed = {**SHIELD, "projectile_shape": "cylinder", "projectile_length": "4 mm"}
    sweep = sweep_of(["4 mm", "5 mm"], fixed=fixed)
    document = document_of(sweep, computed(sweep))
    shot: Shot = next(iter(sweep.shots()))
    [run, _] = document["ballistic_limit"]["rows"][0]["runs"]
    assert run["diameter"] == pytest.approx(shot.projectile_diameter)
    assert "projectiles" in document["headline"]


def test_other_scenarios__have_none() -> None:
    sweep = Sweep.parse({"scenario": "plugging", "axes": {"speed": ["100 m/s"]}, "resolution": 8})
    assert document_of(sweep, {})["ballistic_limit"] is None
