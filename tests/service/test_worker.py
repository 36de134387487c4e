"""A process for each attempt: how it ends, how it is ended, and that nothing survives."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from service import worker
from service.jobs import Cause, Kind
from service.worker import Ending, Ticket, supervise
from tests.service.doubles import is_gone, run_id, wait_until
from tests.service.targets import Run

ROOT = Path(__file__).parents[2]


def ticket(folder: Path, behaviour: str = "fine", *, limit: float = 60.0, **more: Any) -> Ticket:
    run = Run(run_id(1), {"behaviour": behaviour, **more})
    directory = str(folder / "a1-token")
    targets = "tests.service.targets"
    return Ticket("key", Kind.RUN, directory, run.as_json(), limit, targets)


def nobody(_words: Mapping[str, Any]) -> None:
    """Nobody listens."""


def in_background(order: Ticket) -> tuple[threading.Thread, list[Ending]]:
    endings: list[Ending] = []
    thread = threading.Thread(target=lambda: endings.append(supervise(order, nobody)))
    thread.start()
    return thread, endings


def pid_of(folder: Path, name: str = "pid") -> int:
    file = folder / "a1-token" / name
    return int(wait_until(lambda: file.is_file() and file.read_text()))


def test_fine__its_files_come_with_size_and_digest(tmp_path: Path) -> None:
    ending = supervise(ticket(tmp_path), nobody)
    assert ending.cause is None
    [file] = ending.files
    assert file.path == str(tmp_path / "a1-token" / "result.json")
    assert file.size == Path(file.path).stat().st_size
    assert len(file.sha256) == 64
    assert ending.seconds > 0


def test_environment__one_thread_before_python_starts(tmp_path: Path) -> None:
    [file] = supervise(ticket(tmp_path), nobody).files
    assert json.loads(Path(file.path).read_text())["numbers"] == {"threads": 1.0}


def test_verdict__is_a_result(tmp_path: Path) -> None:
    ending = supervise(ticket(tmp_path, "verdict"), nobody)
    assert ending.cause is None
    assert json.loads(Path(ending.files[0].path).read_text())["state"] == "failed"


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


def test_log__has_the_trace_and_what_others_print(tmp_path: Path) -> None:
    supervise(ticket(tmp_path, "abort"), nobody)
    log = tmp_path / "a1-token" / "log.txt"
    assert "Fatal Python error: Aborted" in log.read_text()
    ending = supervise(ticket(tmp_path, "noise"), nobody)
    assert ending.cause is None
    assert "nor is this" in log.read_text()


def test_no_space_for_its_folder__is_said(tmp_path: Path) -> None:
    (tmp_path / "a1-token").touch()
    ending = supervise(ticket(tmp_path), nobody)
    assert (ending.cause, ending.failure) == (Cause.ERROR, "FileExistsError")


def test_progress__is_told_at_most_so_often(tmp_path: Path) -> None:
    told: list[Mapping[str, Any]] = []
    ending = supervise(ticket(tmp_path, seconds=2.5), told.append)
    assert 1 <= len(told) <= 1 + ending.seconds / worker.TELL_INTERVAL
    assert 0 < told[0]["fraction"] <= 1
    assert told[0]["seconds"] > 0
    assert set(told[0]["measured"]) == {"hole_diameter"}


@pytest.mark.parametrize("behaviour", ["hang", "deaf"])
def test_time_limit__ends_it_even_if_it_does_not_listen(tmp_path: Path, behaviour: str) -> None:
    ending = supervise(ticket(tmp_path, behaviour, limit=1.5), nobody)
    assert (ending.cause, ending.reason) == (
        Cause.TIME_LIMIT,
        "stopped after the limit of 1.5 s",
    )
    assert is_gone(pid_of(tmp_path))


@pytest.mark.parametrize("behaviour", ["hang", "deaf"])
def test_stop__ends_it_within_a_second_or_so(tmp_path: Path, behaviour: str) -> None:
    thread, endings = in_background(ticket(tmp_path, behaviour))
    pid = pid_of(tmp_path)
    begin = time.monotonic()
    worker.stop(["another"])
    worker.stop(["key"])
    thread.join(60)
    # Patience and two ticks are 0.7 s; the rest is for a busy machine.
    assert time.monotonic() - begin < 5
    assert endings[0].cause is Cause.LOST
    assert is_gone(pid)


def test_kill__takes_what_the_process_started_along(tmp_path: Path) -> None:
    thread, _ = in_background(ticket(tmp_path, "litter"))
    litter = pid_of(tmp_path, "litter")
    worker.stop()
    thread.join(60)
    wait_until(lambda: is_gone(litter))


def test_killed_from_outside__is_a_crash(tmp_path: Path) -> None:
    thread, endings = in_background(ticket(tmp_path, "hang"))
    os.kill(pid_of(tmp_path), signal.SIGKILL)
    thread.join(60)
    assert (endings[0].cause, endings[0].failure) == (Cause.CRASH, "SIGKILL")


def test_supervisor_killed__the_process_goes_with_it(tmp_path: Path) -> None:
    order = ticket(tmp_path, "deaf")
    program = (
        "import json, sys; from service.worker import Ticket, supervise; "
        "supervise(Ticket(**json.loads(sys.argv[1])), print)"
    )
    supervisor = subprocess.Popen(
        [sys.executable, "-c", program, json.dumps(vars(order))], cwd=ROOT
    )
    try:
        pid = pid_of(tmp_path)
    finally:
        supervisor.kill()
        supervisor.wait()
    wait_until(lambda: is_gone(pid))


def test_life_line__its_end_ends_the_process(tmp_path: Path) -> None:
    order = ticket(tmp_path, "hang")
    (tmp_path / "a1-token").mkdir()
    process = subprocess.Popen(
        [sys.executable, "-m", "service.worker"], stdin=subprocess.PIPE, cwd=ROOT
    )
    assert process.stdin is not None
    process.stdin.write(json.dumps(vars(order)).encode() + b"\n")
    process.stdin.flush()
    pid_of(tmp_path)
    process.stdin.close()
    assert process.wait(60) == worker.STATUS_ORPHAN


def test_life_line__no_order_no_work() -> None:
    process = subprocess.run(
        [sys.executable, "-m", "service.worker"], stdin=subprocess.DEVNULL, cwd=ROOT, check=False
    )
    assert process.returncode == worker.STATUS_ORPHAN


def test_publish__answers_are_results_or_reasons_and_damage_is_seen(tmp_path: Path) -> None:
    good = supervise(ticket(tmp_path), nobody).files[0]
    lost = {"run_id": run_id(2), "state": "failed", "reason": "died", "path": None, "sha256": None}
    outcomes = [
        {**lost, "run_id": run_id(1), "state": "succeeded", "path": good.path}
        | {"sha256": good.sha256},
        lost,
        {**lost, "run_id": run_id(3), "path": good.path, "sha256": "00" * 32},
    ]
    spec = {"document": {"name": "s"}, "outcomes": outcomes}
    order = replace(ticket(tmp_path), kind=Kind.PUBLISH, spec=spec)
    ending = supervise(order, nobody)
    assert [file.name for file in ending.files] == ["cube.nc", "report.html", "report.json"]
    said = json.loads(Path(ending.files[0].path).read_text())
    assert [said[run_id(number)]["state"] for number in (1, 2, 3)] == [
        *("succeeded", "failed", "failed")
    ]
    assert "lost or damaged" in said[run_id(3)]["reason"]


def test_order__a_large_one_arrives_whole(tmp_path: Path) -> None:
    outcome = {"state": "cancelled", "reason": "x" * 100, "path": None, "sha256": None}
    outcomes = [{**outcome, "run_id": run_id(number)} for number in range(10_000)]
    spec = {"document": {"name": "s"}, "outcomes": outcomes}
    ending = supervise(replace(ticket(tmp_path), kind=Kind.PUBLISH, spec=spec), nobody)
    assert len(json.loads(Path(ending.files[0].path).read_text())) == 10_000


def test_parent_side__loads_neither_web_nor_database_nor_solver() -> None:
    program = (
        "import sys, service.worker; "
        "print([m for m in ('fastapi', 'sqlalchemy', 'distributed', 'numpy') if m in sys.modules])"
    )
    answer = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, check=True, capture_output=True, text=True
    )
    assert answer.stdout.strip() == "[]"
