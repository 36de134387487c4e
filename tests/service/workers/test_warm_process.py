"""The warm process of a slot: order after order, nothing leaks from one to the next, nothing survives."""

import errno
import io
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from service.records.attempt import Attempt
from service.records.jobs import Cause
from service.workers import supervisor, warm
from service.workers import warm_process as worker
from studies.runs.run import resolve
from studies.values.files import ANSWER
from tests.service.support.attempts import (
    LIMIT,
    SLOT,
    nobody,
    seen,
    supervise,
    ticket,
    under_way,
)
from tests.service.support.fakes import is_gone, wait_until

ROOT = Path(__file__).parents[3]


@pytest.fixture(autouse=True)
def _no_process_is_left() -> Iterator[None]:
    """Processes without an order end with the test that made them."""
    yield
    SLOT.close()


# --- order after order ---------------------------------------------------------------------------


def test_process__is_the_same_for_order_after_order(tmp_path: Path) -> None:
    processes = {
        seen(supervise(ticket(tmp_path / str(number)), nobody))["process"] for number in range(5)
    }
    assert len(processes) == 1


def test_order__says_how_many_threads_the_run_may_use(tmp_path: Path) -> None:
    order = replace(ticket(tmp_path), threads=3)
    assert seen(supervise(order, nobody))["threads"] == 3


def test_process__is_replaced_after_so_many_orders(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(warm, "ORDERS_OF_A_CHILD", 2)
    processes = [
        seen(supervise(ticket(tmp_path / str(number)), nobody))["process"] for number in range(4)
    ]
    assert processes[0] == processes[1] != processes[2] == processes[3]
    assert is_gone(int(processes[0]))


@pytest.mark.parametrize("behaviour", ["abort", "raise", "greedy"])
def test_process__is_replaced_after_an_accident(tmp_path: Path, behaviour: str) -> None:
    before = seen(supervise(ticket(tmp_path / "1"), nobody))["process"]
    supervise(replace(ticket(tmp_path / "2", behaviour), memory_limit=LIMIT), nobody)
    after = seen(supervise(ticket(tmp_path / "3"), nobody))["process"]
    assert before != after
    assert is_gone(int(before))


def test_process__is_replaced_when_an_order_left_something_running(tmp_path: Path) -> None:
    order = ticket(tmp_path / "1", "litter", seconds=0.1)
    first = seen(supervise(order, nobody))["process"]
    litter = int((tmp_path / "1" / "a1-token" / "litter").read_text())
    wait_until(lambda: is_gone(litter))
    assert seen(supervise(ticket(tmp_path / "2"), nobody))["process"] != first


def test_process__that_dies_between_two_orders_is_replaced_unseen(tmp_path: Path) -> None:
    first = int(seen(supervise(ticket(tmp_path / "1"), nobody))["process"])
    os.kill(first, signal.SIGKILL)
    ending = supervise(ticket(tmp_path / "2"), nobody)
    assert ending.cause is None
    assert int(seen(ending)["process"]) != first


def test_process__that_dies_before_it_takes_its_order_is_replaced_unseen(tmp_path: Path) -> None:
    first = int(seen(supervise(ticket(tmp_path / "1"), nobody))["process"])
    os.kill(first, signal.SIGSTOP)  # it cannot take the order, and dies of it
    with under_way(ticket(tmp_path / "2")) as attempt:
        os.kill(first, signal.SIGKILL)
        ending = attempt.end()
    assert ending.cause is None
    assert int(seen(ending)["process"]) != first


def test_process__that_cannot_start_costs_the_run_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(supervisor, "PAUSE_SECONDS", 0.0)
    monkeypatch.setattr(warm, "_environment", lambda: {"PYTHONHOME": "/nowhere"})
    ending = supervise(ticket(tmp_path), nobody)
    assert (ending.cause, ending.failure) == (Cause.LOST, "ChildProcessError")


def test_state__of_one_order_does_not_reach_the_next(tmp_path: Path) -> None:
    before = seen(supervise(ticket(tmp_path / "1"), nobody))
    supervise(ticket(tmp_path / "2", "soil"), nobody)
    after = seen(supervise(ticket(tmp_path / "3"), nobody))
    assert before.pop("folder") == str(tmp_path / "1" / "a1-token")
    assert after.pop("folder") == str(tmp_path / "3" / "a1-token")
    assert after == before  # the same process, and nothing in it has changed
    modes = {(tmp_path / str(number) / "a1-token" / "log.txt").stat().st_mode for number in (1, 3)}
    assert len(modes) == 1


def test_log__that_cannot_be_written_is_not_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    class Full(io.StringIO):
        def flush(self) -> None:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(sys, "stdout", Full())
    worker._say("t = 1 us  step 100")


def test_log__that_cannot_be_written_hides_no_error(tmp_path: Path) -> None:
    order = ticket(tmp_path, "raise")
    (tmp_path / "a1-token").mkdir()
    (tmp_path / "a1-token" / "log.txt").symlink_to("/dev/full")
    assert supervise(order, nobody).failure == "RuntimeError"


def test_run__that_another_version_was_asked_for_fails_and_says_how_to_go_on(
    tmp_path: Path,
) -> None:
    """The content of a run gives another id under another physics, or under other defaults."""
    spec = resolve("elastic_bar", {}, {}).as_json()
    order = replace(ticket(tmp_path), targets=None, spec=spec, run="0" * 32)
    ending = supervise(order, nobody)
    assert ending.cause is None
    result = json.loads((Path(order.directory) / ANSWER).read_text())
    assert (result["run_id"], result["state"]) == ("0" * 32, "failed")
    assert result["failure"] == "OtherPhysics"
    assert "submit the sweep again" in result["reason"]


def test_idle_process__holds_no_folder(tmp_path: Path) -> None:
    process = seen(supervise(ticket(tmp_path), nobody))["process"]
    assert os.readlink(f"/proc/{process}/cwd") == "/"


# --- life and death ------------------------------------------------------------------------------


def start_supervisor(order: Attempt) -> "subprocess.Popen[bytes]":
    """A supervisor in a process of its own."""
    program = (
        "import json, sys, time; from service.records.attempt import Ticket; "
        "from service.workers.supervisor import Supervisor; from service.workers.warm import Slot; slot = Slot(); "
        "Supervisor(Ticket(**json.loads(sys.argv[1])), print).run(slot); print('over', flush=True); "
        "time.sleep(600)"
    )
    command = [sys.executable, "-c", program, json.dumps(vars(order))]
    return subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE)


@pytest.mark.parametrize("behaviour", ["hang", "deaf"])
def test_supervisor_killed__the_process_goes_with_it(tmp_path: Path, behaviour: str) -> None:
    order = ticket(tmp_path, behaviour)
    with start_supervisor(order) as process:
        try:
            file = Path(order.directory) / "pid"
            pid = int(wait_until(lambda: file.is_file() and file.read_text()))
        finally:
            process.kill()
    wait_until(lambda: is_gone(pid))


def test_supervisor_killed__the_idle_process_goes_with_it(tmp_path: Path) -> None:
    with start_supervisor(ticket(tmp_path)) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == b"over\n"
            pid = int((tmp_path / "a1-token" / "pid").read_text())
            assert not is_gone(pid)
        finally:
            process.kill()
    wait_until(lambda: is_gone(pid))


def start_worker() -> "subprocess.Popen[bytes]":
    command = [sys.executable, "-m", "service.workers.warm_process"]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=ROOT)


def test_life_line__its_end_ends_the_process(tmp_path: Path) -> None:
    order = ticket(tmp_path, "hang")
    with start_worker() as process:
        assert process.stdin is not None
        process.stdin.write(json.dumps({"order": vars(order)}).encode() + b"\n")
        process.stdin.flush()
        wait_until((tmp_path / "a1-token" / "pid").is_file)
        process.stdin.close()
        assert process.wait(60) == worker.STATUS_ORPHAN


def test_life_line__no_order_no_work() -> None:
    with start_worker() as process:
        assert process.stdin is not None
        process.stdin.close()
        assert process.wait(60) == worker.STATUS_ORPHAN


def test_dismissed__an_idle_process_ends(tmp_path: Path) -> None:
    process = int(seen(supervise(ticket(tmp_path), nobody))["process"])
    SLOT.close()
    assert is_gone(process)


def test_parent_side__loads_neither_web_nor_database_nor_solver() -> None:
    program = (
        "import sys, service.workers.supervisor; "
        "print([m for m in ('fastapi', 'sqlalchemy', 'distributed', 'numpy') if m in sys.modules])"
    )
    said = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, check=True, capture_output=True, text=True
    )
    assert said.stdout.strip() == "[]"
