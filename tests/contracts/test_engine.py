"""What every engine must uphold; each test runs on the engine of this machine, and on a Dask cluster."""

import os
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from service.execution.local import LocalEngine
from service.records.jobs import Cause
from service.workers.attempt import Attempt, Ended
from service.workers.timings import Timings
from tests import samples
from tests.service.support.attempts import LIMIT, EngineUser, Place, attempt_in, checkpoint_step, pid_of, using
from tests.service.support.fakes import is_gone
from tests.service.support.processes import family, patiently
from tests.service.support.targets import STEPS

WORKERS = 2
PATIENT = Timings(stop=60.0)  # for a busy machine


@contextmanager
def here(_folder: Path, workers: int, timings: Timings) -> Iterator[Place]:
    """This machine."""
    yield Place(partial(using, partial(LocalEngine, workers, timings=timings)), lambda pid: pid, Cause.CRASH, set)


ENGINES = samples.joined("ENGINES", {"local": here}, "service")


@pytest.fixture(scope="module", params=ENGINES)
def place(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Place]:
    with ENGINES[request.param](tmp_path_factory.mktemp("engine"), WORKERS, PATIENT) as place:
        yield place


@pytest.fixture(scope="module")
def user(place: Place) -> Iterator[EngineUser]:
    with place.open() as opened:
        opened.wait_for_slots(WORKERS)
        yield opened


def test_runs__end_once_with_their_files_in_so_many_processes(user: EngineUser, tmp_path: Path) -> None:
    attempts = [attempt_in(tmp_path, number) for number in range(10)]
    endings = user.compute(*attempts)
    assert {ending.cause for ending in endings} == {None}
    assert [file.name for file in endings[0].files] == ["result.json", "state.npz", "log.txt"]
    ended = [message.key for message in user.receive() if isinstance(message, Ended)]
    assert all(ended.count(attempt.key) == 1 for attempt in attempts)
    assert len({pid_of(attempt) for attempt in attempts}) <= WORKERS


def test_progress__has_the_last_checkpoint(user: EngineUser, tmp_path: Path) -> None:
    attempt = attempt_in(tmp_path, seconds=1.2)
    user.compute(attempt)
    progress = user.progress_of(attempt)[-1]
    assert progress["checkpoint"] == STEPS
    assert {"fraction", "seconds", "measured"} <= progress.keys()


@pytest.mark.parametrize(
    ("behaviour", "limits", "cause", "failure"),
    [
        ("abort", {}, Cause.CRASH, "SIGABRT"),
        ("raise", {}, Cause.ERROR, "RuntimeError"),
        ("deaf", {"seconds_limit": 2.5}, Cause.TIME_LIMIT, "TimeLimit"),
        ("greedy", {"memory_limit": LIMIT}, Cause.MEMORY_LIMIT, "RuntimeError"),
        ("starved", {"memory_limit": LIMIT}, Cause.MEMORY_LIMIT, "SIGABRT"),
    ],
)
def test_failure__is_reported_with_its_cause(
    user: EngineUser, tmp_path: Path, behaviour: str, limits: dict[str, float], cause: Cause, failure: str
) -> None:
    attempt = replace(attempt_in(tmp_path, 1, behaviour), **limits)  # type: ignore[arg-type]
    [ending] = user.compute(attempt)
    assert (ending.cause, ending.failure) == (cause, failure)


@pytest.mark.parametrize("victim", ["process", "worker"])
def test_kill__is_reported_and_the_neighbour_goes_on(
    place: Place, user: EngineUser, tmp_path: Path, victim: str
) -> None:
    killed = attempt_in(tmp_path, 1, seconds=20.0)
    neighbour = attempt_in(tmp_path, 2, seconds=2.0)
    pid, other = user.begin(killed, neighbour)
    os.kill(place.worker_of(pid) if victim == "worker" else pid, signal.SIGKILL)
    assert user.end_of(killed).cause is (place.worker_lost if victim == "worker" else Cause.CRASH)
    assert user.end_of(neighbour).cause is None
    assert pid_of(neighbour) == other
    patiently(lambda: is_gone(pid))
    user.wait_for_slots(WORKERS)
    assert user.compute(attempt_in(tmp_path, 3))[0].cause is None


def test_stop__ends_that_attempt_alone(user: EngineUser, tmp_path: Path) -> None:
    stopped, other = attempt_in(tmp_path, 1, "deaf"), attempt_in(tmp_path, 2, seconds=1.5)
    pid, _ = user.begin(stopped, other)
    user.engine.stop([stopped.key])
    ending = user.end_of(stopped)
    assert (ending.cause, ending.failure) == (Cause.LOST, "Stopped")
    assert user.end_of(other).cause is None
    assert is_gone(pid)


def test_attempts__until_it_is_forgotten_and_lost_afterwards(user: EngineUser, tmp_path: Path) -> None:
    attempt = attempt_in(tmp_path, seconds=1.0)
    user.engine.submit(attempt)
    assert attempt.key in user.engine.attempts()
    user.end_of(attempt)  # and forget it
    assert attempt.key not in user.engine.attempts()
    never = attempt_in(tmp_path, 2)
    user.engine.follow(never.key)
    ending = user.end_of(never)
    assert (ending.cause, ending.failure) == (Cause.LOST, "Gone")


# --- the end -------------------------------------------------------------------------------------


def begin(user: EngineUser, *attempts: Attempt) -> list[int]:
    user.wait_for_slots(WORKERS)
    return user.begin(*attempts)


def test_close__lets_attempts_write_a_checkpoint_and_leave(place: Place, tmp_path: Path) -> None:
    with place.open() as user:
        attempts = [attempt_in(tmp_path, number, seconds=20.0) for number in range(WORKERS)]
        begin(user, *attempts)
        user.engine.close(30.0)
        for attempt in attempts:
            ending = user.end_of(attempt, forget=False)
            assert (ending.cause, ending.failure) == (Cause.LOST, "Left")
            assert ending.checkpoint == checkpoint_step(attempt)


def test_close__stops_attempts_that_do_not_leave(place: Place, tmp_path: Path) -> None:
    with place.open() as user:
        deaf = attempt_in(tmp_path, 1, "deaf")
        [pid] = begin(user, deaf)
        start = time.monotonic()
        user.engine.close(1.0)
        assert time.monotonic() - start < 60.0  # the run would go on for 600
        assert user.end_of(deaf, forget=False).failure == "Stopped"
        assert is_gone(pid)


def test_close__leaves_no_process(place: Place, tmp_path: Path) -> None:
    """Neither one that computes nor an idle one, nor an entry of one that ended and was not waited for."""
    before = set(family(os.getpid()))
    with place.open() as user:
        done, hangs = attempt_in(tmp_path, 1), attempt_in(tmp_path, 2, "hang")
        begin(user, done, hangs)
        user.end_of(done)
        user.engine.close(0.0)
        patiently(lambda: not set(family(os.getpid())) - before - place.foreign())
    assert is_gone(pid_of(hangs))
