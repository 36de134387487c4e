"""Computing a run: its files and numbers, the same after a break, when it stops, and what an observer says."""

import dataclasses
import json
import math
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from solver.errors import Interrupted
from solver.simulation import start
from solver.state import Departed, Particles
from studies import scenarios
from studies.measurements import Reading
from studies.quantities.measured import DEFINITION
from studies.runs.execution import execute, molten_fraction, observer_of
from studies.runs.observer import RunObserver
from studies.runs.remeasure import load_state
from studies.runs.results import Progress, RunControl, RunResult
from studies.runs.run import PHYSICS_VERSION, Run, estimate
from studies.scenarios import OBSERVATIONS_PER_WINDOW
from tests.contracts.test_scenarios import asked as small
from tests.solver.bodies import MELT, real_copper
from tests.studies.runs.solved import BROKEN_OFF_AFTER, RUNS, after, asked, solved


def stored(directory: Path) -> dict[str, Any]:
    """The result in a folder, which holds no number that JSON has not."""

    def refuse(constant: str) -> None:
        raise AssertionError(f"result.json holds {constant}")

    text = (directory / "result.json").read_text(encoding="utf-8")
    plain: dict[str, Any] = json.loads(text, parse_constant=refuse)
    return plain


def without_provenance(directory: Path) -> str:
    return json.dumps({name: value for name, value in stored(directory).items() if name != "provenance"})


def broken_off(run: Run, folder: Path, file: Path, *, steps: int = BROKEN_OFF_AFTER, **control: Any) -> None:
    """Compute a run until it is interrupted after some steps."""
    with pytest.raises(Interrupted):
        execute(run, folder, RunControl(must_stop=after(steps), **control), threads=1, checkpoint=file)


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
    assert list(result.measurements) == list(scenarios.load(scenario).measurements)
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


def test_state__holds_the_living_particles(results: dict[str, RunResult], scenario: str) -> None:
    state, numbers = np.load(solved(scenario) / "state.npz", allow_pickle=False), results[scenario].numbers
    records = {f"departed_{name}" for name in Departed._fields}
    assert set(state.files) == {"body", "time", *Particles._fields, *records} - {"alive"}
    assert float(state["time"]) == numbers["end_time"]
    assert state["mass"].size == state["body"].size <= numbers["particles"]
    assert all(np.isfinite(state[name]).all() for name in state.files)


def test_result__of_a_number_that_is_none_is_null_with_a_flag(tmp_path: Path) -> None:
    """A fifth of a microsecond is too short for a hole."""
    hole = execute(asked("thin_plate", end_time=2e-7), tmp_path, threads=1).measurements["hole_diameter"]
    assert (hole.value, hole.uncertainty, hole.flags) == (None, None, ("not_perforated",))
    assert stored(tmp_path)["measurements"]["hole_diameter"]["value"] is None


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


def test_result__of_a_bar_that_lost_its_answer_says_so(tmp_path: Path) -> None:
    result = execute(asked("taylor_bar", speed=1000.0), tmp_path, threads=1)
    assert (result.state, result.measurements["final_length"].value) == ("succeeded", None)
    assert "lost_particles" in result.flags
    assert str(result.reason).startswith("lost_particles: no final_length")


def test_result__of_a_bar_that_was_stopped_early_says_so(results: dict[str, RunResult]) -> None:
    taylor = results["taylor_bar"].measurements
    assert "still_growing" in taylor["final_length"].flags
    assert taylor["taylor_error"].flags == ("no_reference",)
    assert taylor["final_length"].value is not None


def test_result__follows_the_history_up_to_its_last_observation(results: dict[str, RunResult]) -> None:
    bar = results["elastic_bar"].measurements
    contact = bar["contact_time"]
    # Nothing is known while the bar stands at the wall, and nothing changes once it has left.
    values = contact.history["value"]
    present = [value for value in values if value is not None]
    assert values[: len(values) - len(present)] == [None] * (len(values) - len(present))
    assert contact.value == present[-1]
    assert bar["rebound_momentum"].history["value"][0] == pytest.approx(-1.0, abs=1e-12)


@pytest.mark.parametrize("scenario", ["elastic_bar", "plate_impact"])
def test_estimate__is_near_the_real_number_of_steps(results: dict[str, RunResult], scenario: str) -> None:
    assert 0.5 < estimate(asked(scenario)).steps / results[scenario].numbers["steps"] < 2.0


@pytest.mark.parametrize(
    ("cells", "thickness", "under_resolved"), [(15.0, 4e-3, True), (16.0, 1.9e-3, True), (16.0, 2e-3, False)]
)
def test_flags__under_resolved_below_16_cells_a_diameter_and_4_a_thickness(
    tmp_path: Path, cells: float, thickness: float, under_resolved: bool
) -> None:
    run = asked("thin_plate", end_time=1e-7, cells_per_diameter=cells, plate_thickness=thickness)
    assert ("under_resolved" in execute(run, tmp_path, threads=1).flags) == under_resolved


def test_result__has_the_molten_share_of_its_final_state(results: dict[str, RunResult]) -> None:
    stated = results["debris_cloud"].numbers["molten_mass_fraction"]
    final = load_state(solved("debris_cloud") / "state.npz")
    assert stated == molten_fraction(observer_of(asked("debris_cloud")).setting.problem.bodies, final)
    assert stated > 0.0


def test_molten_fraction__is_of_mass_and_counts_retired_debris() -> None:
    body = SimpleNamespace(matter=real_copper(), mass=np.array([1.0, 2.0, 3.0, 4.0]))
    density = np.full(3, body.matter.eos.density)
    snapshot = SimpleNamespace(
        body=np.zeros(3, int),
        particles=SimpleNamespace(
            mass=body.mass[:3], density=density, temperature=np.array([MELT, 0.99 * MELT, 2.0 * MELT])
        ),
        departed=SimpleNamespace(body=np.zeros(1, int), mass=body.mass[3:], temperature=np.array([1.1 * MELT])),
    )
    assert molten_fraction([body], snapshot) == pytest.approx((1.0 + 3.0 + 4.0) / 10.0)


# Failures


def test_execute__of_an_unphysical_run_leaves_a_failed_result_with_its_reason(tmp_path: Path) -> None:
    """A constant step that is twenty times too long."""
    result = execute(asked("thin_plate", fixed_dt=1e-6, end_time=1e-4), tmp_path, threads=1)
    assert (result.state, result.failure, result.measurements) == ("failed", "UnphysicalState", {})
    assert "particle" in str(result.reason)
    assert "t = " in str(result.reason)
    assert [file.name for file in tmp_path.iterdir()] == ["result.json"]
    assert RunResult.from_json(stored(tmp_path)).as_json() == result.as_json()


def test_execute__returns_whatever_limit_the_solver_finds_crossed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("solver.simulation.SPEED_FACTOR", 0.5)
    result = execute(asked("thin_plate"), tmp_path, threads=1)
    assert result.state == "failed"
    assert str(result.reason).startswith("speed = 3000 at particle ")


def test_execute__does_not_hide_a_mistake_in_the_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*arguments: Any) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("studies.runs.observer.RunObserver.__call__", broken)
    with pytest.raises(ZeroDivisionError):
        execute(asked("thin_plate"), tmp_path, threads=1)
    assert not (tmp_path / "result.json").exists()


# After a break


def test_resume__gives_the_result_of_a_run_that_never_stopped(scenario: str, tmp_path: Path) -> None:
    run, folder, file = asked(scenario), tmp_path / "resumed", tmp_path / "checkpoint"
    for _ in range(2):
        broken_off(run, folder, file)
        assert not (folder / "result.json").exists()
    resumed = execute(run, folder, threads=1, checkpoint=file)
    assert "from the checkpoint" in str(resumed.provenance["checkpoint"])
    assert without_provenance(folder) == without_provenance(solved(scenario))
    assert (solved(scenario) / "state.npz").read_bytes() == (folder / "state.npz").read_bytes()
    assert "checkpoint" not in stored(solved(scenario))["provenance"]


def test_resume__of_another_run_begins_from_the_start(tmp_path: Path) -> None:
    folder, file = tmp_path / "resumed", tmp_path / "checkpoint"
    broken_off(asked("elastic_bar", speed=200.0), tmp_path / "other", file)
    result = execute(asked("elastic_bar"), folder, threads=1, checkpoint=file)
    assert "from the start" in str(result.provenance["checkpoint"])
    assert without_provenance(folder) == without_provenance(solved("elastic_bar"))


def test_checkpointed__is_told_each_checkpoint_that_is_written_or_gone_on_from(tmp_path: Path) -> None:
    run, file, reported, lines = asked("elastic_bar"), tmp_path / "checkpoint", list[int](), list[str]()
    for steps in (10, 20):
        broken_off(run, tmp_path, file, steps=steps, checkpointed=reported.append)
    assert reported == [10, 10, 30]
    control = RunControl(checkpointed=reported.append, log=lines.append)
    result = execute(run, tmp_path, control, threads=1, checkpoint=file)
    assert reported == [10, 10, 30, 30]
    assert result.provenance["checkpoint"] in lines


def test_checkpointed__is_not_told_of_one_that_does_not_fit_or_could_not_be_written(tmp_path: Path) -> None:
    run, file, reported = asked("elastic_bar"), tmp_path / "checkpoint", list[int]()
    file.write_text("damaged")
    execute(run, tmp_path, RunControl(checkpointed=reported.append), threads=1, checkpoint=file)
    broken_off(run, tmp_path, tmp_path / "nowhere" / "checkpoint", steps=5, checkpointed=reported.append)
    assert reported == []


def test_log__has_the_question_a_line_an_observation_and_the_verdict(tmp_path: Path) -> None:
    run, lines = asked("elastic_bar"), list[str]()
    result = execute(run, tmp_path, threads=1, control=RunControl(log=lines.append))
    assert run.id in lines[0]
    assert f"  speed = {run.parameters['speed']}" in lines
    observed = [line for line in lines if line.startswith("t = ")]
    assert len(observed) == len(next(iter(result.measurements.values())).history["time"])
    assert f"succeeded: {result.stop}" in lines
    (contact,) = [line for line in lines if line.startswith("  contact_time = ")]
    assert contact.endswith("(mesh error unknown)")
    assert {f"  {name} = {number:.6g}" for name, number in result.numbers.items()} <= set(lines)


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


def test_stop__waits_for_two_windows_even_where_growth_is_slow_before(tmp_path: Path) -> None:
    result = execute(settling(settled_window=10e-6, settled_growth=0.5), tmp_path, threads=1)
    assert result.stop == "settled"
    assert result.numbers["end_time"] >= 20e-6


def test_stop__at_the_end_of_time_flags_what_still_grows(tmp_path: Path) -> None:
    run = settling(stop="end_time", end_time=8e-6, settled_growth=1e-9, settled_window=2e-6)
    result = execute(run, tmp_path, threads=1)
    assert result.stop == "end_time"
    assert result.numbers["end_time"] >= 8e-6
    assert "still_growing" in result.measurements["crater_depth"].flags


def watched(
    history: Sequence[float], name: str = "hole_diameter", *, flags: tuple[str, ...] = (), **changes: Any
) -> RunObserver:
    """An observer of a plate that has read a history, in mm, five times in each window; the last with flags."""
    observer = observer_of(asked("thin_plate", **{"cells_per_diameter": 16.0, **changes}))
    observer.times = [observer.rate.interval * count for count in range(len(history))]
    parts = {"resolution": 0.5e-3}
    observer.readings = [{name: Reading(1e-3 * value, parts, ())} for value in history]
    observer.readings[-1] = {name: Reading(1e-3 * history[-1], parts, flags)}
    return observer


STEADY = [math.nan] * 5 + [14.0] + [15.0] * 5  # two windows, of which the last begins at 14


def test_growth__of_a_hole_that_was_not_there_yet_is_the_whole_of_it() -> None:
    assert watched([math.nan] * 10 + [4.0]).growth("hole_diameter") == pytest.approx(4e-3)


def test_companion_of_a_hole__that_has_just_come_or_moves_is_still_growing() -> None:
    name = "hole_diameter_areal"
    for history in ([math.nan] * 10 + [15.0], [15.0] * 10 + [13.0, 15.0]):
        companion = watched(history, name).measured_as(name)
        assert "still_growing" in companion.flags
        assert companion.uncertainty is not None
        assert companion.uncertainty > 1.9e-3


def test_growth__is_the_range_within_the_last_window_and_a_part_of_the_uncertainty() -> None:
    """A dent in the history counts although both of its ends are level."""
    observer = watched([*STEADY, 15.0, 15.3, 15.0, 15.0])
    assert observer.growth("hole_diameter") == pytest.approx(0.3e-3)
    hole = observer.measured_as("hole_diameter")
    assert hole.parts["growth"] == pytest.approx(0.3e-3)
    assert hole.uncertainty == pytest.approx(math.hypot(0.3e-3, 0.5e-3))


def test_hole__that_a_film_still_closes_has_not_settled() -> None:
    for flags in ((), ("closed_on_axis",)):
        hole = watched([15.0] * 11, flags=flags).measured_as("hole_diameter")
        assert ("still_growing" in hole.flags) == bool(flags)


def test_growth__looks_at_as_many_observations_whichever_was_a_step_late() -> None:
    level = [15.0] * 6  # a window begins and ends with an observation
    for late in (-1, -6):
        observer = watched([*STEADY, 15.3, *level])
        observer.times[late] += 0.01 * observer.rate.interval
        assert observer.growth("hole_diameter") == 0.0
    assert watched([*STEADY, 15.3, *level[1:]]).growth("hole_diameter") == pytest.approx(0.3e-3)


# A cell is 0.5 mm, and half a per cent of 15 mm is 0.075 mm: the quarter of a cell decides; on 64 cells the share does.
@pytest.mark.parametrize(
    ("cells", "dent", "settled"), [(16.0, 0.12, True), (16.0, 0.13, False), (64.0, 0.07, True), (64.0, 0.08, False)]
)
def test_settled__is_a_range_below_a_share_of_the_value_or_a_quarter_of_a_cell(
    cells: float, dent: float, settled: bool
) -> None:
    level = [15.0] * 5
    observer = watched([*STEADY, *level, 15.0 - dent, *level[:4], 15.0], cells_per_diameter=cells)
    hole = observer.measured_as("hole_diameter")
    assert ("still_growing" not in hole.flags) == settled


def test_measured__on_fewer_than_two_cells_through_the_plate_has_no_error_bar() -> None:
    for cells, flags in ((7.0, ("too_coarse",)), (8.0, ())):
        hole = watched([*STEADY, *STEADY[5:]], cells_per_diameter=cells).measured_as("hole_diameter")
        assert [flag for flag in hole.flags if flag == "too_coarse"] == list(flags)
        assert (hole.uncertainty is None) == bool(flags)
        assert hole.value == pytest.approx(15e-3)


@pytest.mark.parametrize(("diameter", "flags"), [(4.9, ("wide_bar",)), (5.1, ())])
def test_hole_diameter__whose_bar_is_above_a_tenth_of_it_says_so(diameter: float, flags: tuple[str, ...]) -> None:
    assert watched([diameter] * 20).measured_as("hole_diameter").flags == flags


def test_few_particles__are_a_part_of_the_uncertainty_of_the_shape_that_was_measured() -> None:
    def part(**changes: Any) -> float | None:
        hole = watched([15.0] * 20, **changes).measured_as("hole_diameter")
        assert hole.uncertainty == pytest.approx(math.hypot(*hole.parts.values()))
        return hole.parts.get("particles")

    few = part(particles_per_cell=2)
    assert few is not None
    assert few > 15e-3 * 0.001
    assert part(geometry="quarter") == few
    assert part(particles_per_cell=3) is part(particles_per_cell=2, shape="linear") is None


def test_part_of_the_definition__is_stated_and_is_no_numerical_uncertainty() -> None:
    observer = watched([15.0] * 20)
    parts = {"resolution": 0.5e-3, DEFINITION: 0.2e-3}
    observer.readings[-1] = {"hole_diameter": Reading(15e-3, parts)}
    hole = observer.measured_as("hole_diameter")
    assert hole.parts[DEFINITION] == 0.2e-3
    assert hole.uncertainty == 0.5e-3


def test_observer__is_restored_from_its_text(scenario: str) -> None:
    first, second = observer_of(asked(scenario)), observer_of(asked(scenario))
    simulation = start(first.setting.problem, threads=1)
    for _ in range(3):
        first(simulation.snapshot())
        simulation.advance()
    second.restore(first.as_text())
    assert second.times == first.times
    assert second.as_text() == first.as_text()
    assert [list(reading) for reading in second.readings] == [list(r) for r in first.readings]


class Clock:
    """Stands in for the module ``time``: a second passes at each look."""

    def __init__(self) -> None:
        self.now = 0.0

    def monotonic(self) -> float:
        self.now += 1.0
        return self.now


@pytest.mark.parametrize("begun", [0.0, 0.5, 0.8])
def test_time_left__is_at_the_pace_of_this_process(monkeypatch: pytest.MonkeyPatch, begun: float) -> None:
    """An observer sees the rest of a run, twenty times in the whole of it, once a second."""
    reported: list[Progress] = []
    observer = observer_of(asked("thin_plate"), reported.append)
    monkeypatch.setattr("studies.runs.observer.time", Clock())
    problem = observer.setting.problem
    snapshot = start(problem, threads=1).snapshot()
    for number in range(round(20 * begun), 21):
        observer(snapshot._replace(time=number / 20 * problem.end_time))
    assert reported[0].eta_seconds is None
    assert [each.eta_seconds for each in reported[1:]] == pytest.approx(
        [20.0 * (1.0 - each.fraction) for each in reported[1:]], abs=1e-9
    )
