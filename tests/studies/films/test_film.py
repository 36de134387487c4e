"""The film of a run: its frames, its bound, and its frames over a restart."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from solver.errors import Interrupted
from solver.problem import Problem
from solver.simulation import simulate, start
from solver.state import Snapshot
from studies.films import film
from studies.runs.execution import execute, observer_of
from studies.runs.results import RunControl
from studies.runs.run import Run
from tests.samples import needs
from tests.studies.runs.solved import BROKEN_OFF_AFTER, after, asked

pytestmark = needs("elastic_bar")
MOST = film.FRAMES + 2


@pytest.fixture(scope="module")
def run() -> Run:
    return asked("elastic_bar")


@pytest.fixture(scope="module")
def whole(run: Run, tmp_path_factory: pytest.TempPathFactory) -> dict[str, np.ndarray]:
    folder = tmp_path_factory.mktemp("whole")
    execute(run, folder, threads=1, film=True)
    return read(folder / "film.npz")


def read(path: Path) -> dict[str, np.ndarray]:
    with np.load(path) as file:
        return dict(file)


def small_problem() -> Problem:
    return observer_of(asked("elastic_bar")).setting.problem


def states(count: int) -> list[Snapshot]:
    """States of a run at times 0, 1, 2 ..."""
    simulation = start(small_problem(), threads=1)
    return [simulation.snapshot()._replace(time=float(number)) for number in range(count)]


def test_film__has_frames_of_every_particle_from_the_first_to_the_last_state(whole: dict[str, Any]) -> None:
    begin = start(small_problem(), threads=1).particles
    order = np.argsort(begin.number)
    np.testing.assert_array_equal(whole["position"][0], begin.position[order].astype(np.float32))
    end = simulate(small_problem(), threads=1).snapshot
    order = np.argsort(end.particles.number)
    np.testing.assert_array_equal(whole["position"][-1], end.particles.position[order].astype(np.float32))
    assert whole["time"][-1] == end.time
    frames, count = whole["time"].size, whole["number"].size
    assert 10 < frames <= MOST
    assert whole["position"].shape == (frames, count, 3)
    for name in film.SCALARS:
        assert whole[name].shape == (frames, count)
        assert whole[name].dtype == whole["position"].dtype == np.float32
    assert whole["bodies"][whole["body"]].tolist() == ["bar"] * count
    assert bool(whole["whole"])
    assert int(whole["stride"]) == 1


# --- over a break --------------------------------------------------------------------------------


def test_resume__gives_the_film_of_a_run_that_never_stopped(run: Run, whole: dict[str, Any], tmp_path: Path) -> None:
    checkpoint, leaving = tmp_path / "checkpoint.npz", RunControl(must_stop=after(2 * BROKEN_OFF_AFTER))
    with pytest.raises(Interrupted):
        execute(run, tmp_path, threads=1, checkpoint=checkpoint, control=leaving, film=True)
    execute(run, tmp_path, threads=1, checkpoint=checkpoint, film=True)
    resumed = read(tmp_path / "film.npz")
    assert resumed.keys() == whole.keys()
    for name, values in whole.items():
        np.testing.assert_array_equal(resumed[name], values)
