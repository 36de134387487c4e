"""What computing a run adds to solving it: the same result after a break, histories, numbers that fit the scenario."""

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from solver.errors import Interrupted
from solver.simulation import start
from studies import scenarios
from studies.measurements import Reading
from studies.runs.execution import execute, molten_fraction, observer_of
from studies.runs.observer import Observer
from studies.runs.remeasure import load_state
from studies.runs.run import materials_of
from studies.values.results import DEFINITION, Progress, RunControl, RunResult
from tests.solver.bodies import MELT, real_copper
from tests.studies.runs.solved import BROKEN_OFF_AFTER, RUNS, after, asked, solved


def without_provenance(directory: Path) -> str:
    plain = json.loads((directory / "result.json").read_text(encoding="utf-8"))
    del plain["provenance"]
    return json.dumps(plain)


@pytest.fixture(params=list(RUNS))
def scenario(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    return name


def test_resume__gives_the_result_of_a_run_that_never_stopped(scenario: str, tmp_path: Path) -> None:
    run, file = asked(scenario), tmp_path / "checkpoint"
    for _ in range(2):  # broken off twice
        with pytest.raises(Interrupted):
            execute(
                run,
                tmp_path / "resumed",
                threads=1,
                checkpoint=file,
                control=RunControl(must_stop=after(BROKEN_OFF_AFTER)),
            )
        assert not (tmp_path / "resumed" / "result.json").exists()
    resumed = execute(run, tmp_path / "resumed", threads=1, checkpoint=file)
    assert "from the checkpoint" in str(resumed.provenance["checkpoint"])
    assert without_provenance(tmp_path / "resumed") == without_provenance(solved(scenario))
    states = [(folder / "state.npz").read_bytes() for folder in (solved(scenario), tmp_path / "resumed")]
    assert states[0] == states[1]
    whole = json.loads((solved(scenario) / "result.json").read_text())
    assert "checkpoint" not in whole["provenance"]


def test_resume__of_another_run_begins_from_the_start(tmp_path: Path) -> None:
    file = tmp_path / "checkpoint"
    with pytest.raises(Interrupted):
        execute(
            asked("elastic_bar", speed=200.0),
            tmp_path / "other",
            threads=1,
            checkpoint=file,
            control=RunControl(must_stop=after(BROKEN_OFF_AFTER)),
        )
    result = execute(asked("elastic_bar"), tmp_path / "resumed", threads=1, checkpoint=file)
    assert "from the start" in str(result.provenance["checkpoint"])
    assert without_provenance(tmp_path / "resumed") == without_provenance(solved("elastic_bar"))


def test_saved__is_told_each_checkpoint_that_is_written_or_gone_on_from(tmp_path: Path) -> None:
    run, file = asked("elastic_bar"), tmp_path / "checkpoint"
    reported: list[int] = []
    for steps in (10, 20):
        with pytest.raises(Interrupted):
            execute(
                run,
                tmp_path,
                threads=1,
                checkpoint=file,
                control=RunControl(must_stop=after(steps), checkpointed=reported.append),
            )
    assert reported == [10, 10, 30]
    execute(run, tmp_path, threads=1, checkpoint=file, control=RunControl(checkpointed=reported.append))
    assert reported == [10, 10, 30, 30]


def test_saved__is_not_told_of_a_checkpoint_that_does_not_fit_or_could_not_be_written(tmp_path: Path) -> None:
    file, reported = tmp_path / "checkpoint", list[int]()
    file.write_text("damaged")
    execute(
        asked("elastic_bar"), tmp_path, threads=1, checkpoint=file, control=RunControl(checkpointed=reported.append)
    )
    nowhere = tmp_path / "nowhere" / "checkpoint"
    with pytest.raises(Interrupted):
        execute(
            asked("elastic_bar"),
            tmp_path,
            threads=1,
            checkpoint=nowhere,
            control=RunControl(must_stop=after(5), checkpointed=reported.append),
        )
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


def test_log__of_a_run_that_goes_on_says_where(tmp_path: Path) -> None:
    run, lines, file = asked("elastic_bar"), list[str](), tmp_path / "checkpoint"
    with pytest.raises(Interrupted):
        execute(run, tmp_path, threads=1, checkpoint=file, control=RunControl(must_stop=after(10)))
    result = execute(run, tmp_path, threads=1, checkpoint=file, control=RunControl(log=lines.append))
    assert result.provenance["checkpoint"] in lines


def test_observer__is_restored_from_its_text(scenario: str) -> None:
    first, second = observer_of(asked(scenario)), observer_of(asked(scenario))
    simulate_a_little(first)
    second.restore(first.as_text())
    assert second.times == first.times
    assert second.as_text() == first.as_text()
    assert [list(reading) for reading in second.readings] == [list(r) for r in first.readings]


def watched(history: Sequence[float], name: str = "hole_diameter", **changes: Any) -> Observer:
    """An observer of a plate that has read a history, in mm, five times in each window."""
    observer = observer_of(asked("thin_plate", **{"cells_per_diameter": 16.0, **changes}))
    observer.times = [observer.rate.interval * count for count in range(len(history))]
    parts = {"resolution": 0.5e-3}
    observer.readings = [{name: Reading(1e-3 * value, parts, ())} for value in history]
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
    observer = watched([15.0] * 11)
    assert "still_growing" not in observer.measured_as("hole_diameter").flags
    last = observer.readings[-1]
    last["hole_diameter"] = replace(last["hole_diameter"], flags=("closed_on_axis",))
    assert "still_growing" in observer.measured_as("hole_diameter").flags


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


def simulate_a_little(observer: Any) -> None:
    from solver.simulation import start

    simulation = start(observer.setting.problem, threads=1)
    for _ in range(3):
        observer(simulation.snapshot())
        simulation.advance()


@pytest.fixture(scope="module")
def results() -> dict[str, RunResult]:
    texts = {name: (solved(name) / "result.json").read_text() for name in RUNS}
    return {name: RunResult.from_json(json.loads(text)) for name, text in texts.items()}


def test_result__has_all_that_its_scenario_measures(results: dict[str, RunResult], scenario: str) -> None:
    result = results[scenario]
    assert result.state == "succeeded"
    assert list(result.measurements) == list(scenarios.load(scenario).measurements)
    for measured in result.measurements.values():
        assert len(measured.history["time"]) == len(measured.history["value"])
        assert (measured.value is None) <= bool(measured.flags)
        assert measured.uncertainty != 0.0


def test_result__of_a_bar_that_lost_its_answer_says_so(tmp_path: Path) -> None:
    run = asked("taylor_bar", speed=1000.0)
    result = execute(run, tmp_path, threads=1)
    assert (result.state, result.measurements["final_length"].value) == ("succeeded", None)
    assert "lost_particles" in result.flags
    assert result.reason is not None
    assert result.reason.startswith("lost_particles: no final_length")


def test_result__counts_what_is_loose_in_impacts_only(results: dict[str, RunResult], scenario: str) -> None:
    """A bar has no rim from which anything could be separated, nor a resolution that an impact needs."""
    numbers, flags = results[scenario].numbers, results[scenario].flags
    impact = scenario == "thin_plate"
    assert ("separated_mass_fraction" in numbers) == impact
    assert ("fast_mass_fraction" in numbers) == impact
    # Four or six cells across every diameter.
    assert ("under_resolved" in flags) == (scenario in ("thin_plate", "debris_cloud"))
    assert all(math.isfinite(number) for number in numbers.values())


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


class Clock:
    """Stands in for the module ``time``: a second passes at each look."""

    def __init__(self) -> None:
        self.now = 0.0

    def monotonic(self) -> float:
        self.now += 1.0
        return self.now


def shares_and_times_left(monkeypatch: pytest.MonkeyPatch, begun: float) -> list[tuple[float, float | None]]:
    """What an observer says that sees the rest of a run, twenty times in the whole of it, once a second."""
    reported: list[Progress] = []
    watched = observer_of(asked("thin_plate"), reported.append)
    monkeypatch.setattr("studies.runs.observer.time", Clock())
    snapshot = start(watched.setting.problem, threads=1).snapshot()
    end = watched.setting.problem.end_time
    for number in range(round(20 * begun), 21):
        watched(snapshot._replace(time=number / 20 * end))
    return [(each.fraction, each.eta_seconds) for each in reported]


@pytest.mark.parametrize("begun", [0.0, 0.5, 0.8])
def test_time_left__is_at_the_pace_of_this_process(monkeypatch: pytest.MonkeyPatch, begun: float) -> None:
    (_, first), *others = shares_and_times_left(monkeypatch, begun)
    assert first is None
    assert others
    for share, left in others:
        assert left == pytest.approx(20.0 * (1.0 - share), abs=1e-9)


@pytest.mark.parametrize("scenario", ["elastic_bar", "plate_impact"])
def test_estimate__is_near_the_real_number_of_steps(results: dict[str, RunResult], scenario: str) -> None:
    run = asked(scenario)
    chosen = scenarios.load(scenario)
    size = chosen.estimate(chosen.parameters(**run.parameters), materials_of(run))
    assert 0.5 < size.steps / results[scenario].numbers["steps"] < 2.0


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
