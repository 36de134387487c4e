"""The supervisor of an attempt: the files it leaves, how it ends, how it is ended."""

import os
import signal
import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from service.files.artifacts import digest
from service.files.lost_results import list_in
from service.records.jobs import Cause, Keep, Kind, Outcome
from service.workers import supervisor
from service.workers.attempt import Attempt, Publication
from service.workers.timings import DEFAULT
from studies.quantities.files import SWEEP_FILES
from tests.service.support.attempts import (
    LIMIT,
    SLOT,
    attempt_at,
    log_of,
    process_of,
    result_of,
    supervise,
    surroundings,
    under_way,
    with_checkpoint,
)
from tests.service.support.fakes import DEADLINE, is_gone, run_id, wait_until
from tests.service.support.targets import MEBIBYTE


@pytest.fixture(autouse=True, scope="module")
def _end_idle_process() -> Iterator[None]:
    yield
    SLOT.close()


@pytest.mark.parametrize(
    ("keep", "names"),
    [
        # Another sweep may ask for the final state meanwhile: garbage collection removes it.
        (Keep.NUMBERS, ["result.json", "state.npz", "log.txt"]),
        (Keep.FILM, ["result.json", "state.npz", "film.npz", "log.txt"]),
    ],
)
def test_run__leaves_what_is_retained_with_size_and_digest(tmp_path: Path, keep: Keep, names: list[str]) -> None:
    ending = supervise(replace(attempt_at(tmp_path), keep=keep))
    assert ending.cause is None
    assert [file.name for file in ending.files] == names
    for file in ending.files:
        assert file.path == str(tmp_path / "a1-token" / file.name)
        assert (file.size, file.sha256) == (Path(file.path).stat().st_size, digest(Path(file.path)))
    assert {file.name for file in (tmp_path / "a1-token").iterdir()} == {*names, "pid"}
    assert surroundings(ending)["numba_threads"] == "1"  # set before Python starts


def test_complete_attempt__is_not_computed_again(tmp_path: Path) -> None:
    """Dask repeats a task when the worker dies that holds its answer."""
    first = supervise(attempt_at(tmp_path))
    assert supervise(attempt_at(tmp_path, "hang")).files == first.files


def publication(folder: Path, *outcomes: Outcome) -> Attempt:
    """An attempt to publish runs with these outcomes."""
    spec: Publication = {"document": {"name": "s"}, "outcomes": outcomes}
    return replace(attempt_at(folder), kind=Kind.PUBLISH, spec=spec)


DIED: Outcome = {"run_id": run_id(2), "state": "failed", "reason": "died", "path": None, "sha256": None}


def test_publication__gets_results_and_reasons_however_many(tmp_path: Path) -> None:
    good = supervise(attempt_at(tmp_path)).files[0]
    done: Outcome = {**DIED, "run_id": run_id(1), "state": "succeeded", "path": good.path, "sha256": good.sha256}
    more: list[Outcome] = [{**DIED, "run_id": run_id(number)} for number in range(2, 10_000)]
    ending = supervise(publication(tmp_path, done, *more))
    names = [file.name for file in ending.files]
    assert names == [*SWEEP_FILES, "log.txt"]
    published = result_of(ending)
    assert [published[run_id(number)]["state"] for number in (1, 2)] == ["succeeded", "failed"]
    assert len(published) == 9_999


def test_publication__lists_results_that_are_lost_or_damaged(tmp_path: Path) -> None:
    good = supervise(attempt_at(tmp_path)).files[0]
    damaged: Outcome = {**DIED, "run_id": run_id(3), "path": good.path, "sha256": "00" * 32}
    gone: Outcome = {**DIED, "run_id": run_id(4), "path": f"{good.path}.gone", "sha256": good.sha256}
    attempt = publication(tmp_path, DIED, damaged, gone)
    ending = supervise(attempt)
    assert (ending.cause, ending.failure) == (Cause.ERROR, "ResultsLost")
    assert run_id(3) in ending.reason
    listed = list_in(Path(attempt.directory))
    assert [loss.run_id for loss in listed] == [run_id(3), run_id(4)]


def test_ending__without_the_files_names_them_and_the_free_space(tmp_path: Path) -> None:
    ending = supervise(attempt_at(tmp_path, "silent"))
    assert (ending.cause, ending.failure) == (Cause.ERROR, "MissingFile")
    assert ending.reason == "the process ended without result.json"
    assert ending.free is not None


def test_broken_worker__costs_the_run_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder that cannot be made, a disk that is away, a stale mount, no process."""
    occupied = attempt_at(tmp_path / "1")
    Path(occupied.directory).touch()
    away = tmp_path / "share" / "run" / "a1-token"
    for attempt, failure in (
        (occupied, "FileExistsError"),
        (replace(attempt_at(tmp_path / "2"), directory=str(away)), "FileNotFoundError"),
        (attempt_at(tmp_path / "3", "stale"), "OSError"),
    ):
        ending = supervise(attempt)
        assert (ending.cause, ending.failure) == (Cause.LOST, failure)
        assert "the worker cannot compute" in ending.reason
    assert not (tmp_path / "share").exists()  # made by whoever has the disk
    SLOT.close()
    monkeypatch.setattr(sys, "executable", "/bin/false")
    ending = supervise(attempt_at(tmp_path / "4"))
    assert (ending.cause, ending.failure) == (Cause.LOST, "ChildProcessError")


def test_broken_worker__pauses_unless_it_is_asked_to_leave(tmp_path: Path) -> None:
    away = replace(attempt_at(tmp_path), directory=str(tmp_path / "share" / "run" / "a1-token"))
    with under_way(away, replace(DEFAULT, broken_worker_pause=10 * DEADLINE)) as running:
        assert not running.is_over()
        running.supervisor.leave(seconds=60)
        assert running.end().cause is Cause.LOST


def test_stall__ends_a_frozen_process_and_the_next_attempt_goes_on(tmp_path: Path) -> None:
    attempt = replace(with_checkpoint(tmp_path, seconds=2.0), stall_seconds=1.0)
    with under_way(attempt) as running:
        wait_until(lambda: running.progress)
        pid = running.pid()
        os.kill(pid, signal.SIGSTOP)
        ending = running.end()
    assert (ending.cause, ending.failure) == (Cause.STALLED, "Stalled")
    assert "no progress for" in ending.reason
    assert is_gone(pid)
    assert supervise(with_checkpoint(tmp_path, seconds=0.1)).cause is None


def test_stall__is_no_freeze_of_process_and_supervisor_together(tmp_path: Path) -> None:
    """As of a container, a machine or a virtual one."""
    attempt = replace(attempt_at(tmp_path, seconds=1.0), stall_seconds=1.5)
    frozen: list[int] = []

    def freeze(_progress: Mapping[str, Any]) -> None:
        if not frozen:
            frozen.append(int((tmp_path / "a1-token" / "pid").read_text()))
            os.kill(frozen[0], signal.SIGSTOP)
            time.sleep(2 * attempt.stall_seconds)
            os.kill(frozen[0], signal.SIGCONT)

    assert supervise(attempt, freeze).cause is None
    assert frozen


def test_memory_limit__is_that_of_each_attempt(tmp_path: Path) -> None:
    endings = []
    for number, limit in enumerate([LIMIT, LIMIT // 4, LIMIT, None]):
        attempt = attempt_at(tmp_path / str(number), "greedy", mebibytes=400)
        endings.append(supervise(replace(attempt, memory_limit=limit)))
    assert [ending.cause for ending in endings] == [None, Cause.MEMORY_LIMIT, None, None]
    assert "out of memory" in endings[1].reason
    assert "a run may use 0.268 GB" in endings[1].reason


@pytest.mark.parametrize("seconds_to_leave", [None, 0.5])
def test_stop__ends_the_process_and_what_it_started(tmp_path: Path, seconds_to_leave: float | None) -> None:
    with under_way(attempt_at(tmp_path, "litter")) as running:
        pids = [running.pid(), running.pid("litter")]
        if seconds_to_leave is None:
            running.supervisor.stop()
        else:
            running.supervisor.leave(seconds_to_leave)
        ending = running.end()
    assert (ending.cause, ending.failure, ending.checkpoint) == (Cause.LOST, "Stopped", None)
    wait_until(lambda: all(is_gone(pid) for pid in pids))


def test_signal_to_leave__from_outside_is_ignored(tmp_path: Path) -> None:
    with under_way(attempt_at(tmp_path, "busy")) as running:
        for wish in (signal.SIGTERM, signal.SIGINT):  # the service gets it too, and leaves in order
            os.kill(running.pid(), wish)
        assert running.end().cause is None


def test_crash__with_a_fork_that_lives_on_is_noticed(tmp_path: Path) -> None:
    with under_way(attempt_at(tmp_path, "orphan")) as running:
        forked = running.pid("litter")
        wait_until(running.is_over)
        assert running.end().failure == "SIGABRT"
    wait_until(lambda: is_gone(forked))


def test_log__has_the_trace_of_a_failure(tmp_path: Path) -> None:
    for behaviour, trace in (
        ("abort", "Fatal Python error: Aborted"),
        ("raise", "RuntimeError: something that nobody foresaw"),
    ):
        supervise(attempt_at(tmp_path, behaviour))
        assert trace in log_of(attempt_at(tmp_path))


def test_log__that_gets_too_long_loses_its_middle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(supervisor, "LOG_BYTES", 4 * MEBIBYTE)
    ending = supervise(attempt_at(tmp_path, "roar", mebibytes=20))
    [log] = [file for file in ending.files if file.name == "log.txt"]
    assert 2 * MEBIBYTE < log.size < 3 * MEBIBYTE
    text = log_of(attempt_at(tmp_path))
    assert text.startswith("begins at step 0\nfirst words")
    assert "the log was too long" in text
    assert text.endswith("last words\n")
    assert digest(Path(log.path)) == log.sha256


def test_log__of_each_attempt_is_its_own_and_closed_behind_it(tmp_path: Path) -> None:
    loud = supervise(attempt_at(tmp_path / "1", "noise"))
    quiet = supervise(attempt_at(tmp_path / "2"))
    assert process_of(loud) == process_of(quiet)
    text = log_of(attempt_at(tmp_path / "1"))
    for line in ("not a JSON line", "nor is this", "nor this, which a library holds back"):
        assert line in text
    assert log_of(attempt_at(tmp_path / "2")) == "begins at step 0\n"
    descriptors = Path(f"/proc/{process_of(loud)}/fd")
    open_files = [os.readlink(file) for file in descriptors.iterdir()]
    assert not [name for name in open_files if name.startswith(str(tmp_path))]
