"""Computing a run: its files and numbers, the same after a break, when it stops, and what an observer says."""

import dataclasses
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from solver.errors import Interrupted
from studies import scenarios
from studies.measurements import Reading
from studies.quantities.measured import ENERGY_DRIFT_LIMIT
from studies.runs.execution import _flags, execute, observer_of
from studies.runs.observer import RunObserver
from studies.runs.results import Progress, RunControl, RunResult
from studies.runs.run import PHYSICS_VERSION, Run
from studies.scenarios import OBSERVATIONS_PER_WINDOW
from studies.scenarios.parts.impact import LEAST_CELLS
from tests.contracts.test_scenarios import asked as small
from tests.samples import needs
from tests.studies.runs.solved import BROKEN_OFF_AFTER, RUNS, after, asked, solved, stored


def without_provenance(directory: Path) -> str:
    return json.dumps({name: value for name, value in stored(directory).items() if name != "provenance"})


@pytest.fixture(params=list(RUNS))
def scenario(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def results() -> dict[str, RunResult]:
    return {name: RunResult.from_json(stored(solved(name))) for name in RUNS}


# Files and numbers


def test_result__has_all_that_its_scenario_measures(results: dict[str, RunResult], scenario: str) -> None:
    result = results[scenario]
    assert (result.run_id, result.state, result.reason, result.failure) == (asked(scenario).id, "succeeded", None, None)
    assert list(result.measurements) == list(scenarios.load(scenario).measured_in(asked(scenario).parameters))
    for measured in result.measurements.values():
        assert len(measured.history["time"]) == len(measured.history["value"])
        assert (measured.value is None) <= bool(measured.flags)
        assert measured.uncertainty != 0.0
    files = sorted(file.name for file in solved(scenario).iterdir())
    assert files == ["result.json", "sections.npz", "state.npz"]
    assert result.as_json() == stored(solved(scenario))


def test_result__says_how_good_it_is_and_what_computed(results: dict[str, RunResult], scenario: str) -> None:
    """A bar has no rim from which anything could be separated, nor a resolution that an impact needs."""
    numbers, flags, provenance = results[scenario].numbers, results[scenario].flags, results[scenario].provenance
    impact = scenario == "thin_plate"
    assert ("separated_mass_fraction" in numbers) == ("fast_mass_fraction" in numbers) == impact
    # Four or six cells across every diameter.
    assert ("under_resolved" in flags) == (scenario in ("thin_plate", "debris_cloud"))
    assert all(math.isfinite(number) for number in numbers.values())
    assert abs(numbers["largest_energy_drift"]) < 0.01
    assert numbers["momentum_error"] < 1e-10
    assert numbers["mass_error"] < 1e-12
    assert provenance["physics_version"] == str(PHYSICS_VERSION)
    assert provenance["threads"] == 1
    assert {"whipple", "python", "numpy", "numba", "cpu", "started", "seconds"} <= set(provenance)


LIMITS = {  # of the numbers that flag a run beyond them, as docs/limits.md and the messages of the flags state them
    "largest_energy_drift": (ENERGY_DRIFT_LIMIT, "energy_drift"),
    "hottest_energy_share": (0.5, "runaway_particles"),
    "expanding_mass_fraction": (0.01, "still_expanding"),
    "vaporised_mass_fraction": (1e-3, "vaporised"),
    "below_zero_kelvin": (0.0, "below_zero_kelvin"),
    "beyond_hugoniot": (0.0, "beyond_hugoniot"),
    "discarded": (0.0, "discarded_particles"),
}


@pytest.mark.parametrize("number", LIMITS)
def test_flag__is_set_beyond_its_limit_and_not_at_it(number: str) -> None:
    limit, flag = LIMITS[number]
    numbers = {**dict.fromkeys(LIMITS, 0.0), "cells_per_diameter": 16.0, "cells_per_thickness": 4.0}
    assert _flags({**numbers, number: limit}, LEAST_CELLS) == ()
    assert _flags({**numbers, number: math.nextafter(limit, math.inf)}, LEAST_CELLS) == (flag,)
    for cells in ("cells_per_diameter", "cells_per_thickness"):
        assert _flags({**numbers, cells: 0.99 * numbers[cells]}, LEAST_CELLS) == ("under_resolved",)


def test_result__histories_sum_to_the_audited_energy_and_momentum(results: dict[str, RunResult]) -> None:
    result, whole = results["thin_plate"], 2.0 * math.pi
    histories = result.histories
    assert histories["bodies"] == ["projectile", "target"]
    energy = sum(np.sum(histories[f"{kind}_energy"], axis=0) for kind in ("kinetic", "internal", "departed"))
    energy = energy + histories["contact_energy"] + histories["otherwise_removed_energy"]
    assert energy[-1] == pytest.approx(energy[0] * (1.0 + result.numbers["energy_drift"]), rel=1e-12)
    with np.load(solved("thin_plate") / "state.npz") as state:
        on_grid = whole * 0.5 * (state["mass"] * (state["velocity"] ** 2).sum(axis=1)).sum()
    assert np.sum(histories["kinetic_energy"], axis=0)[-1] == pytest.approx(on_grid, rel=1e-12)
    momentum = np.sum(histories["axial_momentum"], axis=0) - histories["axial_impulse"]
    momentum += np.sum(histories["departed_axial_momentum"], axis=0)
    assert momentum == pytest.approx(momentum[0], rel=1e-9)


def test_progress__is_told_at_each_observation(tmp_path: Path) -> None:
    reports: list[Progress] = []
    result = execute(asked("thin_plate"), tmp_path, RunControl(progress=reports.append), threads=1)
    fractions = [progress.fraction for progress in reports]
    # Five observations in each window of 5 us: in 4 us four, and the start.
    assert len(reports) == 1 + round(4e-6 / (5e-6 / OBSERVATIONS_PER_WINDOW))
    assert (fractions[0], fractions[-1]) == (0.0, 1.0)
    assert fractions == sorted(fractions)
    assert all(json.dumps(dataclasses.asdict(progress), allow_nan=False) for progress in reports)
    times = [progress.time for progress in reports]
    assert result.histories["time"] == times
    assert all(measured.history["time"] == times for measured in result.measurements.values())
    assert without_provenance(tmp_path) == without_provenance(solved("thin_plate"))


@needs("taylor_bar")
def test_result__of_a_bar_that_lost_its_answer_says_so(tmp_path: Path) -> None:
    result = execute(asked("taylor_bar", bar="lead", speed=1000.0), tmp_path, threads=1)
    assert (result.state, result.measurements["final_length"].value) == ("succeeded", None)
    assert "lost_particles" in result.flags
    assert str(result.reason).startswith("lost_particles: no final_length")


# Failures


def test_execute__of_an_unphysical_run_leaves_a_failed_result_with_its_reason(tmp_path: Path) -> None:
    """A constant step that is twenty times too long."""
    result = execute(asked("thin_plate", fixed_dt=1e-6, end_time=1e-4), tmp_path, threads=1)
    assert (result.state, result.failure, result.measurements) == ("failed", "UnphysicalState", {})
    assert "particle" in str(result.reason)
    assert "t = " in str(result.reason)
    assert [file.name for file in tmp_path.iterdir()] == ["result.json"]
    assert RunResult.from_json(stored(tmp_path)).as_json() == result.as_json()


# After a break


def test_resume__gives_the_result_of_a_run_that_never_stopped(scenario: str, tmp_path: Path) -> None:
    run, folder, file = asked(scenario), tmp_path / "resumed", tmp_path / "checkpoint"
    for _ in range(2):
        with pytest.raises(Interrupted):
            execute(run, folder, RunControl(must_stop=after(BROKEN_OFF_AFTER)), threads=1, checkpoint=file)
        assert not (folder / "result.json").exists()
    resumed = execute(run, folder, threads=1, checkpoint=file)
    assert "from the checkpoint" in str(resumed.provenance["checkpoint"])
    assert without_provenance(folder) == without_provenance(solved(scenario))
    assert (solved(scenario) / "state.npz").read_bytes() == (folder / "state.npz").read_bytes()
    assert "checkpoint" not in stored(solved(scenario))["provenance"]


# Growth, and when a run has settled


def settling(**changes: Any) -> Run:
    """A crater that is judged by a generous measure of growth."""
    block = {"target_depth": 24e-3, "target_radius": 24e-3, "end_time": 40e-6}
    return small("thick_plate", **{**block, "settled_window": 3e-6, "settled_growth": 0.2, **changes})


def test_stop__says_settled_where_growth_has_ended(tmp_path: Path) -> None:
    result = execute(settling(), tmp_path, threads=1)
    assert result.stop == "settled"
    assert 6e-6 <= result.numbers["end_time"] < 40e-6
    for name in ("crater_depth", "crater_diameter"):
        measured = result.measurements[name]
        assert measured.value is not None
        assert "still_growing" not in measured.flags
        assert measured.parts["growth"] < 0.2 * measured.value
    assert set(measured.parts) == {"resolution", "azimuth", "growth"}
    assert measured.uncertainty == pytest.approx(math.hypot(*measured.parts.values()))


def test_stop__at_the_end_of_time_flags_what_still_grows(tmp_path: Path) -> None:
    run = settling(stop="end_time", end_time=8e-6, settled_growth=1e-9, settled_window=2e-6)
    result = execute(run, tmp_path, threads=1)
    assert result.stop == "end_time"
    assert result.numbers["end_time"] >= 8e-6
    assert "still_growing" in result.measurements["crater_depth"].flags


def watched(history: Sequence[float], cells: float = 16.0) -> RunObserver:
    """An observer of a plate that has read a history of its hole, in mm, five times in each window."""
    observer = observer_of(asked("thin_plate", cells_per_diameter=cells))
    observer.times = [observer.rate.interval * count for count in range(len(history))]
    observer.readings = [{"hole_diameter": Reading(1e-3 * value, {"resolution": 0.5e-3}, ())} for value in history]
    return observer


STEADY = [math.nan] * 5 + [14.0] + [15.0] * 5  # two windows, of which the last begins at 14
HOLE = [0.0] * 5 + [1.0] * 6  # a window of a hole at the end


@pytest.mark.parametrize(
    ("history", "stop", "reason"),
    [
        (HOLE, "decided", "decided"),
        (HOLE[:-1], "decided", None),
        ([*HOLE[:-2], 0.0, 1.0], "decided", None),
        (HOLE, "settled", None),
    ],
)
def test_run__is_decided_once_a_wall_has_had_a_hole_for_a_window(
    history: Sequence[float], stop: str, reason: str | None
) -> None:
    observer = observer_of(small("whipple_shield", stop=stop))
    observer.setting = dataclasses.replace(observer.setting, settles=("wall_perforated", "wall_bulge"))
    observer.stages = [(observer.setting, 0)]
    observer.times = [observer.rate.interval * count for count in range(len(history))]
    bulges = [Reading(1e-3 * count, {}, ()) for count in range(len(history))]  # that still grow
    observer.readings = [
        {"wall_perforated": Reading(hole, {}, ()), "wall_bulge": bulge}
        for hole, bulge in zip(history, bulges, strict=True)
    ]
    assert observer.stop_reason() == reason


def test_growth__is_the_range_within_the_last_window_and_a_part_of_the_uncertainty() -> None:
    """A dent in the history counts although both of its ends are level."""
    observer = watched([*STEADY, 15.0, 15.3, 15.0, 15.0])
    assert observer.growth("hole_diameter") == pytest.approx(0.3e-3)
    hole = observer.measured_as("hole_diameter")
    assert hole.parts["growth"] == pytest.approx(0.3e-3)
    assert hole.uncertainty == pytest.approx(math.hypot(0.3e-3, 0.5e-3))


# A cell is 0.5 mm, and half a per cent of 15 mm is 0.075 mm: the quarter of a cell decides; on 64 cells the share does.
@pytest.mark.parametrize(
    ("cells", "dent", "settled"), [(16.0, 0.12, True), (16.0, 0.13, False), (64.0, 0.07, True), (64.0, 0.08, False)]
)
def test_settled__is_a_range_below_a_share_of_the_value_or_a_quarter_of_a_cell(
    cells: float, dent: float, settled: bool
) -> None:
    observer = watched([*STEADY, *[15.0] * 5, 15.0 - dent, *[15.0] * 5], cells)
    assert ("still_growing" not in observer.measured_as("hole_diameter").flags) == settled
