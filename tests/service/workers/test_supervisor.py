"""An order to a warm process: what it leaves, how it ends, how it is ended."""

import errno
import os
import signal
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from service.files import attempt_log
from service.files.artifacts import digest
from service.files.lost_results import list_in
from service.records.attempt import Attempt
from service.records.jobs import Cause, Keep, Kind
from service.workers import supervisor, warm
from service.workers.supervisor import Supervisor
from tests.service.support.attempts import (
    LIMIT,
    SLOT,
    RunningAttempt,
    answer,
    kept,
    log_of,
    nobody,
    seen,
    supervise,
    ticket,
    under_way,
)
from tests.service.support.fakes import DEADLINE, is_gone, run_id, wait_until
from tests.service.support.targets import MEBIBYTE, STEPS


@pytest.fixture(autouse=True)
def _no_process_is_left() -> Iterator[None]:
    """Processes without an order end with the test that made them."""
    yield
    SLOT.close()


@pytest.fixture
def no_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(supervisor, "PAUSE_SECONDS", 0.0)


# --- what an order leaves ------------------------------------------------------------------------


def test_fine__its_files_come_with_size_and_digest(tmp_path: Path) -> None:
    ending = supervise(ticket(tmp_path), nobody)
    assert ending.cause is None
    assert [file.name for file in ending.files] == ["result.json", "state.npz", "log.txt"]
    for file in ending.files:
        assert file.path == str(tmp_path / "a1-token" / file.name)
        assert file.size == Path(file.path).stat().st_size
        assert len(file.sha256) == 64
    assert ending.seconds > 0


@pytest.mark.parametrize(
    ("keep", "names"),
    [
        # A sweep may ask for the final state meanwhile: care removes what none keeps.
        (Keep.NUMBERS, ["result.json", "state.npz", "log.txt"]),
        (Keep.FINAL, ["result.json", "state.npz", "log.txt"]),
        (Keep.FILM, ["result.json", "state.npz", "film.npz", "log.txt"]),
    ],
)
def test_keep__says_what_is_left_of_a_run(tmp_path: Path, keep: Keep, names: list[str]) -> None:
    ending = supervise(replace(ticket(tmp_path), keep=keep), nobody)
    assert [file.name for file in ending.files] == names
    left = {file.name for file in (tmp_path / "a1-token").iterdir()}
    assert left == {*names, "pid"}


def test_environment__one_thread_before_python_starts(tmp_path: Path) -> None:
    ending = supervise(ticket(tmp_path), nobody)
    assert answer(ending)["numbers"] == {"threads": 1.0}


def test_verdict__is_a_result(tmp_path: Path) -> None:
    ending = supervise(ticket(tmp_path, "verdict"), nobody)
    assert ending.cause is None
    assert answer(ending)["state"] == "failed"


def test_order__that_was_carried_out_before_is_not_computed_again(tmp_path: Path) -> None:
    """Dask repeats a task when the worker dies that holds its answer."""
    first = supervise(ticket(tmp_path), nobody)
    again = supervise(ticket(tmp_path, "hang"), nobody)
    assert again.files == first.files


def publication(folder: Path, *outcomes: Mapping[str, Any]) -> Attempt:
    """The order to publish runs that ended so."""
    spec = {"document": {"name": "s"}, "outcomes": list(outcomes)}
    return replace(ticket(folder), kind=Kind.PUBLISH, spec=spec)


DIED = {"run_id": run_id(2), "state": "failed", "reason": "died", "path": None, "sha256": None}


def test_publish__answers_are_results_or_reasons(tmp_path: Path) -> None:
    good = supervise(ticket(tmp_path), nobody).files[0]
    done = {"run_id": run_id(1), "state": "succeeded", "path": good.path, "sha256": good.sha256}
    ending = supervise(publication(tmp_path, {**DIED, **done}, DIED), nobody)
    names = [file.name for file in ending.files]
    assert names == ["cube.nc", "report.html", "report.json", "log.txt"]
    said = answer(ending)
    assert [said[run_id(number)]["state"] for number in (1, 2)] == ["succeeded", "failed"]


def test_publish__says_which_results_are_lost_or_damaged(tmp_path: Path) -> None:
    good = supervise(ticket(tmp_path), nobody).files[0]
    damaged = {**DIED, "run_id": run_id(3), "path": good.path, "sha256": "00" * 32}
    gone = {**DIED, "run_id": run_id(4), "path": f"{good.path}.gone", "sha256": good.sha256}
    order = publication(tmp_path, DIED, damaged, gone)
    ending = supervise(order, nobody)
    assert (ending.cause, ending.failure) == (Cause.ERROR, "ResultsLost")
    assert run_id(3) in ending.reason
    listed = list_in(Path(order.directory))
    assert [one.run_id for one in listed] == [run_id(3), run_id(4)]


def test_order__a_large_one_arrives_whole(tmp_path: Path) -> None:
    outcome = {"state": "cancelled", "reason": "x" * 100, "path": None, "sha256": None}
    outcomes = [{**outcome, "run_id": run_id(number)} for number in range(10_000)]
    spec = {"document": {"name": "s"}, "outcomes": outcomes}
    ending = supervise(replace(ticket(tmp_path), kind=Kind.PUBLISH, spec=spec), nobody)
    assert len(answer(ending)) == 10_000


# --- how an order ends ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("behaviour", "cause", "failure", "reason"),
    [
        ("abort", Cause.CRASH, "SIGABRT", "the process died: SIGABRT"),
        ("raise", Cause.ERROR, "RuntimeError", "something that nobody foresaw"),
        ("silent", Cause.ERROR, "MissingFile", "the process ended without result.json"),
    ],
)
def test_ending__says_why(
    tmp_path: Path, behaviour: str, cause: Cause, failure: str, reason: str
) -> None:
    ending = supervise(ticket(tmp_path, behaviour), nobody)
    assert (ending.cause, ending.failure, ending.reason) == (cause, failure, reason)


def test_no_space_for_its_folder__is_said(tmp_path: Path, no_pause: None) -> None:
    order = ticket(tmp_path)
    (tmp_path / "a1-token").touch()
    ending = supervise(order, nobody)
    assert (ending.cause, ending.failure) == (Cause.LOST, "FileExistsError")


def test_no_process__costs_the_run_nothing(
    tmp_path: Path, no_pause: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_arguments: Any, **_words: Any) -> None:
        raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))

    SLOT.close()
    monkeypatch.setattr(warm.subprocess, "Popen", refuse)
    ending = supervise(ticket(tmp_path), nobody)
    assert (ending.cause, ending.failure) == (Cause.LOST, "BlockingIOError")
    assert "its worker cannot compute" in ending.reason


def test_worker_whose_disk_went_away__costs_the_run_nothing(tmp_path: Path, no_pause: None) -> None:
    ending = supervise(ticket(tmp_path, "stale"), nobody)
    assert (ending.cause, ending.failure) == (Cause.LOST, "OSError")


def test_worker_without_the_disk__makes_no_folders_of_its_own(
    tmp_path: Path, no_pause: None
) -> None:
    order = replace(ticket(tmp_path), directory=str(tmp_path / "share" / "run" / "a1-token"))
    ending = supervise(order, nobody)
    assert (ending.cause, ending.failure) == (Cause.LOST, "FileNotFoundError")
    assert not (tmp_path / "share").exists()


def test_worker_without_the_disk__pauses_unless_it_shall_leave(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pausing = threading.Event()
    monkeypatch.setattr(supervisor, "free_bytes", lambda _folder: pausing.set())
    order = replace(ticket(tmp_path), directory=str(tmp_path / "share" / "run" / "a1-token"))
    with under_way(order) as attempt:
        assert pausing.wait(DEADLINE)
        begin = time.monotonic()
        attempt.supervisor.leave(seconds=60)
        assert attempt.end().cause is Cause.LOST
        assert time.monotonic() - begin < supervisor.PAUSE_SECONDS / 2


def test_no_space_for_its_log__is_said(tmp_path: Path) -> None:
    (tmp_path / "a1-token" / "log.txt").mkdir(parents=True)
    ending = supervise(ticket(tmp_path), nobody)
    assert (ending.cause, ending.failure) == (Cause.ERROR, "IsADirectoryError")


@pytest.mark.parametrize("behaviour", ["hang", "deaf"])
def test_time_limit__ends_it_even_if_it_does_not_listen(tmp_path: Path, behaviour: str) -> None:
    supervise(ticket(tmp_path / "warm"), nobody)  # the limit holds for the start of a process too
    order = ticket(tmp_path / "late", behaviour, limit=3.0)
    with under_way(order) as attempt:
        pid = attempt.pid()
        ending = attempt.end()
    assert (ending.cause, ending.reason) == (Cause.TIME_LIMIT, "stopped after the limit of 3 s")
    assert is_gone(pid)


@pytest.mark.parametrize("behaviour", ["greedy", "starved"])
def test_memory_limit__ends_the_run_alone(tmp_path: Path, behaviour: str) -> None:
    ending = supervise(replace(ticket(tmp_path, behaviour), memory_limit=LIMIT), nobody)
    assert ending.cause is Cause.MEMORY_LIMIT
    assert "out of memory" in ending.reason
    assert "a run may use 1.07 GB" in ending.reason
    assert supervise(ticket(tmp_path), nobody).cause is None


def test_memory_limit__is_that_of_each_order(tmp_path: Path) -> None:
    causes = []
    for number, limit in enumerate([LIMIT, LIMIT // 4, LIMIT, None]):
        order = ticket(tmp_path / str(number), "greedy", mebibytes=400)
        causes.append(supervise(replace(order, memory_limit=limit), nobody).cause)
    assert causes == [None, Cause.MEMORY_LIMIT, None, None]


@pytest.mark.parametrize("behaviour", ["hang", "deaf"])
def test_stop__ends_it_within_a_second_or_so(tmp_path: Path, behaviour: str) -> None:
    with under_way(ticket(tmp_path, behaviour)) as attempt:
        pid = attempt.pid()
        begin = time.monotonic()
        attempt.supervisor.stop()
        ending = attempt.end()
        # Patience and two ticks are 0.7 s; the rest is for a busy machine.
        assert time.monotonic() - begin < DEADLINE
    assert (ending.cause, ending.failure) == (Cause.LOST, "Stopped")
    assert is_gone(pid)


def test_stop__before_it_began_ends_it_at_once(tmp_path: Path) -> None:
    order = ticket(tmp_path)
    waiting = Supervisor(order, nobody)
    waiting.stop()
    ending = waiting.run(SLOT)
    assert (ending.cause, ending.failure) == (Cause.LOST, "Stopped")
    assert not Path(order.directory).exists()


def test_kill__takes_what_the_process_started_along(tmp_path: Path) -> None:
    with under_way(ticket(tmp_path, "litter")) as attempt:
        litter = attempt.pid("litter")
        attempt.supervisor.stop()
        attempt.end()
    wait_until(lambda: is_gone(litter))


def test_killed_from_outside__is_a_crash(tmp_path: Path) -> None:
    with under_way(ticket(tmp_path, "hang")) as attempt:
        os.kill(attempt.pid(), signal.SIGKILL)
        ending = attempt.end()
    assert (ending.cause, ending.failure) == (Cause.CRASH, "SIGKILL")


@pytest.mark.parametrize("wish", [signal.SIGTERM, signal.SIGINT])
def test_wish_to_leave__is_not_meant_for_the_process_itself(
    tmp_path: Path, wish: signal.Signals
) -> None:
    with under_way(ticket(tmp_path, "busy")) as attempt:
        os.kill(attempt.pid(), wish)
        assert attempt.end().cause is None


def test_crash__what_it_forked_does_not_keep_it_alive(tmp_path: Path) -> None:
    order = ticket(tmp_path, "orphan")
    with under_way(order) as attempt:
        forked = attempt.pid("litter")
        wait_until(attempt.is_over)
        assert (attempt.end().cause, attempt.end().failure) == (Cause.CRASH, "SIGABRT")
    wait_until(lambda: is_gone(forked))


def test_ending__says_how_much_room_there_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(supervisor, "free_bytes", lambda _folder: 17)
    assert supervise(ticket(tmp_path, "raise"), nobody).free == 17


def test_process__that_does_not_even_die_is_left_alone(
    tmp_path: Path,
    no_pause: None,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    monkeypatch.setattr(warm, "KILL_SECONDS", 0.1)
    order = ticket(tmp_path, "deaf")
    attempt = RunningAttempt(order)
    pid = attempt.pid()
    with monkeypatch.context() as patch:
        patch.setattr(warm.os, "killpg", lambda _pid, _signal: None)
        attempt.supervisor.stop()
        try:
            wait_until(attempt.is_over, seconds=20)
        finally:
            os.kill(pid, signal.SIGKILL)
    assert (attempt.end().cause, attempt.end().failure) == (Cause.LOST, "Stuck")
    assert f"the process {pid} was killed, and does not end" in caplog.text


@pytest.mark.parametrize(("limit", "cause"), [(120.0, Cause.LOST), (1.0, Cause.TIME_LIMIT)])
def test_order__a_large_one_to_a_process_that_does_not_listen_can_be_ended(
    tmp_path: Path, limit: float, cause: Cause
) -> None:
    idle = int(seen(supervise(ticket(tmp_path / "1"), nobody))["process"])
    os.kill(idle, signal.SIGSTOP)
    order = ticket(tmp_path / "2", limit=limit, padding="x" * MEBIBYTE)
    attempt = RunningAttempt(order)
    try:
        wait_until(Path(order.directory).is_dir)  # it has begun
        if cause is Cause.LOST:
            attempt.supervisor.stop()
        wait_until(attempt.is_over, seconds=20)
    finally:
        with suppress(ProcessLookupError):
            os.kill(idle, signal.SIGKILL)
    assert attempt.end().cause is cause


# --- checkpoints ---------------------------------------------------------------------------------


def test_checkpoint__its_step_is_told_and_is_part_of_the_ending(tmp_path: Path) -> None:
    told: list[Mapping[str, Any]] = []
    ending = supervise(kept(tmp_path, seconds=1.0), told.append)
    assert ending.checkpoint == STEPS
    steps = [words["checkpoint"] for words in told]
    assert steps == sorted(steps)
    assert steps[-1] == STEPS
    assert all("fraction" in words for words in told)


def test_crash__says_behind_which_checkpoint(tmp_path: Path) -> None:
    (tmp_path / "checkpoint").write_text("7")
    ending = supervise(kept(tmp_path, behaviour="abort"), nobody)
    assert (ending.cause, ending.checkpoint) == (Cause.CRASH, 7)


def test_killed__it_goes_on_from_the_last_checkpoint(tmp_path: Path) -> None:
    with under_way(kept(tmp_path, seconds=20.0)) as attempt:
        wait_until(lambda: attempt.told)
        os.kill(attempt.pid(), signal.SIGKILL)
        step = attempt.end().checkpoint
    assert step is not None
    told: list[Mapping[str, Any]] = []
    assert supervise(kept(tmp_path, seconds=0.1), told.append).cause is None
    assert told[0]["step"] == step + 1


def test_leave__writes_a_checkpoint_and_spares_the_process(tmp_path: Path) -> None:
    with under_way(kept(tmp_path / "1", seconds=20.0)) as attempt:
        wait_until(lambda: attempt.told)
        attempt.supervisor.leave(seconds=60)
        ending = attempt.end()
    assert (ending.cause, ending.failure) == (Cause.LOST, "Left")
    assert ending.checkpoint == int((tmp_path / "1" / "checkpoint").read_text())
    # The word was for that order alone: the next one is carried out to its end.
    assert supervise(kept(tmp_path / "2", seconds=0.5), nobody).cause is None


@pytest.mark.parametrize("behaviour", ["hang", "deaf"])
def test_leave__who_cannot_is_stopped(tmp_path: Path, behaviour: str) -> None:
    with under_way(ticket(tmp_path, behaviour)) as attempt:
        pid = attempt.pid()
        attempt.supervisor.leave(seconds=0.5)
        ending = attempt.end()
    assert (ending.cause, ending.failure, ending.checkpoint) == (Cause.LOST, "Stopped", None)
    assert is_gone(pid)


def test_leave__who_is_done_in_time_is_done(tmp_path: Path) -> None:
    with under_way(ticket(tmp_path, "busy")) as attempt:
        attempt.pid()
        attempt.supervisor.leave(seconds=60)
        assert attempt.end().cause is None


# --- progress and log ----------------------------------------------------------------------------


def test_progress__is_told_at_most_so_often(tmp_path: Path) -> None:
    told: list[Mapping[str, Any]] = []
    ending = supervise(ticket(tmp_path, seconds=2.5), told.append)
    assert 1 <= len(told) <= 1 + ending.seconds / supervisor.TELL_INTERVAL
    assert 0 < told[0]["fraction"] <= 1
    assert told[0]["seconds"] > 0
    assert set(told[0]["measured"]) == {"hole_diameter"}
    assert "checkpoint" not in told[0]


def test_log__has_the_trace_and_what_others_print(tmp_path: Path) -> None:
    supervise(ticket(tmp_path, "abort"), nobody)
    assert "Fatal Python error: Aborted" in log_of(ticket(tmp_path))
    supervise(ticket(tmp_path, "raise"), nobody)
    assert "RuntimeError: something that nobody foresaw" in log_of(ticket(tmp_path))


def test_log__that_gets_too_long_loses_its_middle(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(attempt_log, "LOG_BYTES", 4 * MEBIBYTE)
    ending = supervise(ticket(tmp_path, "roar", mebibytes=20), nobody)
    [log] = [file for file in ending.files if file.name == "log.txt"]
    assert 2 * MEBIBYTE < log.size < 3 * MEBIBYTE
    words = log_of(ticket(tmp_path))
    assert words.startswith("first words")
    assert "the log was too long" in words
    assert words.endswith("last words\n")
    assert digest(Path(log.path)) == log.sha256


def test_log__each_order_has_its_own_and_it_is_closed_behind_it(tmp_path: Path) -> None:
    loud = supervise(ticket(tmp_path / "1", "noise"), nobody)
    quiet = supervise(ticket(tmp_path / "2"), nobody)
    assert seen(loud)["process"] == seen(quiet)["process"]
    words = log_of(ticket(tmp_path / "1"))
    for line in ("not a JSON line", "nor is this", "nor this, which a library holds back"):
        assert line in words
    assert log_of(ticket(tmp_path / "2")) == ""
    descriptors = Path(f"/proc/{seen(loud)['process']}/fd")
    open_files = [os.readlink(one) for one in descriptors.iterdir()]
    assert not [name for name in open_files if name.startswith(str(tmp_path))]
