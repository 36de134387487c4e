"""The ballistic limit of a shield in a report: intervals of made-up walls, and equations beside them."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from studies.answers.question import read_question
from studies.cubes import cube
from studies.laws import load
from studies.quantities.findings import InvalidInput
from studies.reports.compare import compare
from studies.reports.figure import FAILED, HELD, INTERVAL, RUN_HELD, RUN_PERFORATED, RUN_UNDECIDED
from studies.reports.records import Outcome
from studies.reports.section import Part, Source
from studies.reports.wording import MOST_WORDS
from studies.runs.run import Run
from studies.shields.laws._shields import ShieldCode
from studies.shields.limit import name_of
from studies.shields.section import SECTION, Incomparable
from studies.shields.shield import CRITICAL_DIAMETER
from studies.shields.shots.judged import equations
from studies.sweeps.sweep import Sweep
from tests.claims.rows import equal
from tests.samples import needs
from tests.studies.shields.made import (
    FACTORS,
    PLAIN,
    SHIELD,
    SPEEDS,
    Limit,
    computed,
    exact,
    part_of,
    record_of,
    result_of,
    rows_of,
    sweep_of,
)
from tests.studies.support import fakes

TOLERANCE = 0.2e-3
SEARCH = {"limit_of": "wall_perforated", "between": ["1 mm", "9 mm"], "tolerance": "0.2 mm"}
WALLS = {"speed": SPEEDS, "projectile_diameter": PLAIN, "wall_thickness": ["2 mm", "3 mm"]}
WITHOUT = {name: value for name, value in SHIELD.items() if name != "wall_thickness"}


def bumpers(count: int) -> dict[str, str]:
    """A shield with further bumpers."""
    of = {"": "al-6061-t6", "_thickness": "0.5 mm", "_stand_off": "50 mm"}
    return SHIELD | {f"bumper_{n}{name}": value for n in range(2, count + 1) for name, value in of.items()}


def marks(part: Part, label: str) -> set[tuple[Any, Any]]:
    [panel] = part.figures[0].panels
    return {(x, y) for each in panel.series if each.label == label for x, y in zip(each.x, each.y, strict=True)}


# What a report opens with, by diameters, changes of the sweep, the made-up limit in mm, and flags.
OPENINGS: dict[str, tuple[Any, dict[str, Any], float, tuple[str, ...], str]] = {
    "both ends": (
        *(["3.1 mm", "3.5 mm"], {}, 3.2, ()),
        "7 km/s: held to 3.1 mm, perforated from 3.5 mm (finds 7 of 17 failures); Christiansen (NNO) 5.45 mm, "
        "Schaefer (SRL) 2.96 mm. At 10\u202f% risk: 3.08 mm.",
    ),
    "all perforated": (
        *(PLAIN, {}, 0.0, ()),
        "7 km/s: perforated from 2 mm; Christiansen (NNO) 5.45 mm, Schaefer (SRL) 2.96 mm; 12 harder shots held. "
        "At 10\u202f% risk: a sphere of 3.08 mm.",
    ),
    "all held": (
        *(PLAIN, {}, 9.0, ()),
        "2 km/s: held to 6 mm (finds 2 of 2 failures); Reimerdes 3.14 mm, Christiansen (modNNO) 2.86 mm. "
        "At 10\u202f% risk: a sphere of 2.53 mm.",
    ),
    "several shields": (
        *([], {"axes": WALLS, "fixed": WITHOUT}, 3.0, ()),
        "7 km/s, wall thickness 3 mm: held to 2 mm, perforated from 4 mm (finds 7 of 17 failures); Christiansen (NNO) "
        "5.45 mm. At 10\u202f% risk: 3.08 mm.",
    ),
    "flagged": (
        *(PLAIN, {}, 3.0, ("under_resolved",)),
        "7 km/s: held to 2 mm, perforated from 4 mm (finds 7 of 17 failures), runs under resolved; Schaefer (SRL) "
        "2.96 mm. At 10\u202f% risk: 3.08 mm.",
    ),
    "two bumpers": (
        *(PLAIN, {"fixed": bumpers(2)}, 3.0, ()),
        "7 km/s: held to 2 mm, perforated from 4 mm (finds 7 of 17 failures); Schaefer (SRL, three walls) 4.76 mm.",
    ),
}


@pytest.mark.parametrize("name", OPENINGS)
def test_opening__says_the_interval_and_the_nearest_equations(name: str) -> None:
    diameters, changes, limit, flags, said = OPENINGS[name]
    sweep = sweep_of(diameters, **changes)
    opening = part_of(sweep, computed(sweep, lambda speed: 1e-3 * limit, flags)).opening
    assert opening == said
    assert len(opening.split()) <= MOST_WORDS


def test_opening__of_a_larger_projectile_that_is_held_says_so() -> None:
    sweep = sweep_of(["2 mm", "4 mm"])
    limit: dict[float, Limit] = {2e-3: lambda speed: 1e-3, 4e-3: lambda speed: 9e-3}
    runs = [point.run for point in sweep.runs()]
    results = {run.id: result_of(run, limit[float(run.parameters["projectile_diameter"] or 0.0)]) for run in runs}
    part = part_of(sweep, results)
    assert part.opening.startswith("7 km/s: a larger projectile is held than one that perforates; ")
    reasons = {each.reason for row in record_of(part).rows for each in row.equations}
    assert reasons == {Incomparable.NO_END}


def test_cube__asks_the_equations_about_each_shield() -> None:
    sweep = sweep_of(PLAIN)
    question = read_question(sweep.document())
    assert [*sweep.shots()] == [question.shot(point) for point in question.points()]
    dataset = cube.build(sweep, {})
    name = CRITICAL_DIAMETER
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
    assert [reason.code for reason in said.reasons] == [ShieldCode.NO_YIELD_STRESS]
    assert [row.equations for row in rows_of(sweep)] == [(), (), ()]


def test_constant__of_a_bumper_without_a_material_is_refused() -> None:
    with pytest.raises(InvalidInput, match="give bumper_2"):
        sweep_of(PLAIN, fixed={**SHIELD, "bumper_2.density": "2.7 g/cm3"}).runs()


@pytest.mark.parametrize(("count", "expected"), [(2, {"whipple_srl_three_walls"}), (3, set())])
def test_shield__of_several_bumpers_has_the_equations_about_as_many(count: int, expected: set[str]) -> None:
    part = part_of(sweep_of(PLAIN, fixed=bumpers(count)))
    assert [{each.law for each in row.equations} for row in record_of(part).rows] == [expected] * len(SPEEDS)
    assert not marks(part, HELD) | marks(part, FAILED)  # all published shots are on one bumper


@pytest.mark.claim(
    "report", "shield-limit", says="A report calls each equation of a shield what a known limit makes it."
)
def test_record__calls_each_equation_what_the_exact_limit_makes_it(compared: Callable[..., None]) -> None:
    sweep = sweep_of(SEARCH)
    [first, *_] = sweep_of(PLAIN).shots()
    for row in rows_of(sweep, fakes.searched(sweep, result_of)):
        d = exact(row.speed)
        assert row.lower is not None
        assert row.upper is not None
        assert row.lower <= d < row.upper <= row.lower + TOLERANCE * (1.0 + 1e-9)
        said = {each.law: each for each in row.equations}
        assert {*said} == {law.name for law in equations()}
        for law in equations():
            value = law.evaluate(replace(first, speed=row.speed)).value
            if abs(value - d) > TOLERANCE:
                expected = Outcome.HIGH if value > d else Outcome.LOW
                compared(equal(f"{law.name} at {row.speed:g} m/s", expected=expected, got=said[law.name].outcome))
                beyond = value / (row.upper if value > d else row.lower) - 1.0
                assert said[law.name].difference == pytest.approx(beyond, rel=1e-9)
        expected = {2e3: Outcome.LOW, 5e3: Outcome.WITHIN, 7e3: Outcome.HIGH}[row.speed]
        assert said["whipple_nno"].outcome is expected


def test_figure__has_intervals_runs_equations_and_shots() -> None:
    sweep = sweep_of(SEARCH)
    part = part_of(sweep, fakes.searched(sweep, result_of))
    [figure] = part.figures
    [panel] = figure.panels
    [bars] = [each for each in panel.series if each.label == INTERVAL]
    rows = record_of(part).rows
    assert list(zip(bars.x, bars.low, bars.high, strict=True)) == [(row.speed, row.lower, row.upper) for row in rows]
    assert {each.label for each in panel.series if each.kind == "curve"} == {
        name_of(law.name, law.title) for law in equations()
    }
    assert marks(part, FAILED)
    assert marks(part, HELD)
    assert "factor of 1.5" in figure.caption
    assert "276 MPa" in figure.caption


def test_plain_sweep__has_a_mark_for_each_run_and_what_they_decide() -> None:
    sweep = sweep_of(PLAIN)
    results = computed(sweep)
    del results[sweep.runs()[1].run.id]  # 4 mm at 2 km/s
    part = part_of(sweep, results)
    sizes = [2e-3, 4e-3, 6e-3]
    every = {(speed, size) for speed in FACTORS for size in sizes} - {(2e3, 4e-3)}
    assert marks(part, RUN_HELD) == {(speed, size) for speed, size in every if size <= exact(speed)}
    assert marks(part, RUN_PERFORATED) == {(speed, size) for speed, size in every if size > exact(speed)}
    assert marks(part, RUN_UNDECIDED) == {(2e3, 4e-3)}
    ends = {row.speed: (row.lower, row.upper) for row in record_of(part).rows}
    for speed in (5e3, 7e3):
        held, failed = ([d for d in sizes if (d > exact(speed)) is fails] for fails in (False, True))
        assert ends[speed] == (max(held, default=None), min(failed, default=None))
    assert ends[2e3] == (2e-3, 6e-3)  # the lost run widens the interval


@pytest.mark.parametrize(("limit", "outcome"), [(0.0, Outcome.HIGH), (9.0, Outcome.LOW)])
def test_one_end__judges_what_it_contradicts(limit: float, outcome: Outcome) -> None:
    sweep = sweep_of(PLAIN)
    every = [each for row in rows_of(sweep, computed(sweep, lambda speed: limit)) for each in row.equations]
    assert {each.outcome for each in every} <= {outcome, Outcome.NOT_COMPARABLE}
    assert {each.reason for each in every} <= {None, Incomparable.ONE_END}


def test_flagged_runs__judge_nothing() -> None:
    sweep = sweep_of(SEARCH)
    rows = rows_of(sweep, fakes.searched(sweep, lambda run: result_of(run, flags=("under_resolved",))))
    assert {each.reason for row in rows for each in row.equations} == {Incomparable.FLAGGED}
    assert {row.flags for row in rows} == {("under_resolved",)}


def test_grids_that_disagree__leave_a_point_undecided() -> None:
    sweep = sweep_of(PLAIN, resolution=[16, 24])

    def finer_holds(run: Run) -> Any:
        return result_of(run, lambda speed: 5e-3 if run.parameters["cells_per_diameter"] == 24.0 else 3e-3)

    rows = rows_of(sweep, {point.run.id: finer_holds(point.run) for point in sweep.runs()})
    assert {(row.lower, row.upper) for row in rows} == {(2e-3, 6e-3)}
    told = {run.grids for row in rows for run in row.runs if run.perforated is None}
    assert told == {"wall holds with 24 cells; wall perforated with 16 cells"}


def test_each_shield__has_a_panel() -> None:
    sweep = sweep_of([], fixed=WITHOUT, axes=WALLS)
    [figure] = part_of(sweep).figures
    assert [panel.at for panel in figure.panels] == [{"wall_thickness": 2e-3}, {"wall_thickness": 3e-3}]
    thin, thick = (
        max(y or 0.0 for each in panel.series if each.kind == "curve" for y in each.y) for panel in figure.panels
    )
    assert thin < thick


def test_cylinder__is_compared_by_the_sphere_of_its_volume() -> None:
    fixed = {**SHIELD, "projectile_shape": "cylinder", "projectile_length": "4 mm"}
    sweep = sweep_of(["4 mm", "5 mm"], fixed=fixed)
    [run, _] = rows_of(sweep)[0].runs
    assert run.diameter == pytest.approx(next(iter(sweep.shots())).projectile_diameter)


@needs("elastic_bar")
def test_other_scenarios__have_none() -> None:
    sweep = Sweep.parse({"scenario": "elastic_bar", "axes": {"speed": ["100 m/s"]}, "resolution": 8})
    dataset = cube.build(sweep, {})
    assert SECTION.part(Source(dataset, compare(dataset), {})) is None
