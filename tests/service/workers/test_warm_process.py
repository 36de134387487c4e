"""The warm process of a slot: attempt after attempt, nothing leaks from one to the next, nothing survives."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from service.workers import warm_process
from service.workers.warm import MOST_ATTEMPTS
from studies.runs.run import resolve
from tests.service.support.attempts import SLOT, attempt_at, process_of, result_of, supervise, surroundings, under_way
from tests.service.support.fakes import is_gone, wait_until

ROOT = Path(__file__).parents[3]


@pytest.fixture(autouse=True, scope="module")
def _end_idle_process() -> Iterator[None]:
    yield
    SLOT.close()


def test_process__computes_so_many_attempts_and_ends_with_its_slot(tmp_path: Path) -> None:
    SLOT.close()
    first = process_of(supervise(attempt_at(tmp_path / "1")))
    process = SLOT.acquire()
    process.attempts = MOST_ATTEMPTS - 1
    SLOT.release(process)
    assert process_of(supervise(attempt_at(tmp_path / "last"))) == first
    assert is_gone(first)
    other = process_of(supervise(attempt_at(tmp_path / "beyond")))
    assert other != first
    SLOT.close()
    assert is_gone(other)


def test_process__is_replaced_when_an_attempt_left_something_running(tmp_path: Path) -> None:
    first = process_of(supervise(attempt_at(tmp_path / "1", "litter", seconds=0.1)))
    litter = int((tmp_path / "1" / "a1-token" / "litter").read_text())
    wait_until(lambda: is_gone(litter))
    assert process_of(supervise(attempt_at(tmp_path / "2"))) != first


@pytest.mark.parametrize("has_attempt", [False, True])
def test_process__that_dies_before_it_accepts_an_attempt_is_replaced(tmp_path: Path, has_attempt: bool) -> None:
    first = process_of(supervise(attempt_at(tmp_path / "1")))
    if has_attempt:
        os.kill(first, signal.SIGSTOP)  # it cannot accept the attempt, and dies of it
        with under_way(attempt_at(tmp_path / "2")) as running:
            os.kill(first, signal.SIGKILL)
            ending = running.end()
    else:
        os.kill(first, signal.SIGKILL)
        ending = supervise(attempt_at(tmp_path / "2"))
    assert ending.cause is None
    assert process_of(ending) != first


def test_state__of_one_attempt_does_not_reach_the_next(tmp_path: Path) -> None:
    before = surroundings(supervise(attempt_at(tmp_path / "1")))
    supervise(attempt_at(tmp_path / "2", "soil"))
    after = surroundings(supervise(attempt_at(tmp_path / "3")))
    assert before.pop("folder") == str(tmp_path / "1" / "a1-token")
    assert after.pop("folder") == str(tmp_path / "3" / "a1-token")
    assert after == before  # the same process, and nothing in it has changed
    assert os.readlink(f"/proc/{after['process']}/cwd") == "/"


def test_run__of_another_version_fails_and_its_reason_names_the_cure(tmp_path: Path) -> None:
    """The content of a run gives another id under another physics, or under other defaults."""
    spec = resolve("elastic_bar", {}, {}).as_json()
    ending = supervise(replace(attempt_at(tmp_path), targets=None, spec=spec, run="0" * 32))
    assert ending.cause is None
    result = result_of(ending)
    assert (result["run_id"], result["state"]) == ("0" * 32, "failed")
    assert result["failure"] == "OtherPhysics"
    assert "retry the sweep" in result["reason"]


@pytest.mark.parametrize("has_attempt", [False, True])
def test_stdin__its_end_ends_the_process(tmp_path: Path, has_attempt: bool) -> None:
    command = [sys.executable, "-m", "service.workers.warm_process"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=ROOT) as process:
        assert process.stdin is not None
        if has_attempt:
            message = {"attempt": vars(attempt_at(tmp_path, "hang"))}
            process.stdin.write(json.dumps(message).encode() + b"\n")
            process.stdin.flush()
            wait_until((tmp_path / "a1-token" / "pid").is_file)
        process.stdin.close()
        assert process.wait(60) == warm_process.STATUS_ORPHAN
