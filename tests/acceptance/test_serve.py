"""The real service: ``whipple serve`` as a process of its own, real workers, real kills."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import psutil
import pytest

from service.client import Client
from studies import examples
from studies.sweep_document import read_yaml
from tests.service.api import until

ROOT = Path(__file__).parents[2]
START_SECONDS = 60.0  # deadlines, for machines that are busy with something else
SWEEP_SECONDS = 240.0
LEAVE_SECONDS = 10.0
READY = re.compile(r"whipple serves (http://\S+)")
NEVER_MAPPED = ("llvmlite", "_netcdf4", "/numba/")
FAKE = {"WHIPPLE_TARGETS_MODULE": "tests.service.targets"}
SMOKE = read_yaml(examples.text("smoke"), "smoke")


@dataclass(frozen=True)
class Service:
    """A running ``whipple serve``."""

    url: str
    process: "subprocess.Popen[bytes]"

    def client(self) -> Client:
        return Client(self.url)

    def family(self) -> list[psutil.Process]:
        """The process and all of its children."""
        own = psutil.Process(self.process.pid)
        return [own, *own.children(recursive=True)]


@contextmanager
def serving(data: Path, **environment: str) -> Iterator[Service]:
    """Start a service on a free port, and leave no process of it behind."""
    said = data.with_suffix(".log")
    with said.open("wb") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "service", "serve", "--port", "0", "--data", data],
            cwd=ROOT,
            env={**os.environ, **environment},
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
        )

    def has_answered() -> bool:
        return process.poll() is not None or READY.search(said.read_text()) is not None

    try:
        until(has_answered, seconds=START_SECONDS)
        ready = READY.search(said.read_text())
        assert ready, said.read_text()
        yield Service(ready[1], process)
    finally:
        end(process)


def end(process: "subprocess.Popen[bytes]") -> int:
    """Ask a process to leave, and wait until it has."""
    process.terminate()
    try:
        return process.wait(timeout=3 * LEAVE_SECONDS)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        raise


def is_gone(process: psutil.Process) -> bool:
    """Whether a process has ended; one that nobody has waited for yet counts."""
    return not process.is_running() or process.status() == psutil.STATUS_ZOMBIE


def whipple(*words: object, **environment: str) -> "subprocess.CompletedProcess[str]":
    """Run the command in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "service", *map(str, words)],
        cwd=ROOT,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=SWEEP_SECONDS,
        check=False,
    )


@pytest.mark.slow
def test_main_job__goes_from_submission_to_cube_and_report(tmp_path: Path) -> None:
    import xarray

    with serving(tmp_path / "data") as service, service.client() as client:
        handle = client.submit(SMOKE)
        status = handle.wait(timeout=SWEEP_SECONDS)
        assert (status.state, status.counts["succeeded"]) == ("succeeded", 2)
        folder = handle.fetch(tmp_path / "out")
        maps = Path(f"/proc/{service.process.pid}/maps").read_text().lower()
    cube = xarray.open_dataset(folder / "cube.nc")
    assert (cube.hole_diameter > 0.008).all()
    assert b"<html" in (folder / "report.html").read_bytes()
    assert not [library for library in NEVER_MAPPED if library in maps]


def test_killed_service__finishes_what_it_accepted(tmp_path: Path) -> None:
    axes = {"speed": {"start": "3 km/s", "stop": "6 km/s", "step": "0.5 km/s"}}
    slow = {**FAKE, "WHIPPLE_TEST_SECONDS": "0.5"}
    with serving(tmp_path / "data", **slow) as service, service.client() as client:
        id = client.submit({**SMOKE, "axes": axes}).id
        until(lambda: client.sweep(id).status().counts["succeeded"] > 0, seconds=START_SECONDS)
        family = service.family()
        service.process.kill()
        service.process.wait()
    until(lambda: all(map(is_gone, family)), seconds=LEAVE_SECONDS)
    with serving(tmp_path / "data", **slow) as service, service.client() as client:
        status = client.sweep(id).wait(timeout=SWEEP_SECONDS)
        assert (status.state, status.counts["succeeded"]) == ("succeeded", 7)
        client.sweep(id).fetch(tmp_path / "out")


def test_sigterm__ends_the_service_in_time_and_leaves_no_process(tmp_path: Path) -> None:
    slow = {**FAKE, "WHIPPLE_TEST_SECONDS": "60"}
    with serving(tmp_path / "data", **slow) as service, service.client() as client:
        id = client.submit(SMOKE).id
        until(lambda: client.sweep(id).status().counts["running"] > 0, seconds=START_SECONDS)
        family = service.family()
        begin = time.monotonic()
        service.process.send_signal(signal.SIGTERM)
        assert service.process.wait(timeout=3 * LEAVE_SECONDS) == 0
        assert time.monotonic() - begin < LEAVE_SECONDS
    until(lambda: all(map(is_gone, family)), seconds=LEAVE_SECONDS)


def test_second_service__on_the_same_data_refuses_in_one_sentence(tmp_path: Path) -> None:
    with serving(tmp_path / "data", **FAKE) as service:
        second = whipple("serve", "--port", "0", "--data", tmp_path / "data", **FAKE)
        assert second.returncode == 1
        assert str(service.process.pid) in second.stderr
        assert "Traceback" not in second.stderr


def test_cancel__ends_the_runs_and_publishes_what_there_is(tmp_path: Path) -> None:
    slow = {**FAKE, "WHIPPLE_TEST_SECONDS": "60"}
    with serving(tmp_path / "data", **slow) as service, service.client() as client:
        handle = client.submit(SMOKE)
        until(lambda: handle.status().counts["running"] > 0, seconds=START_SECONDS)
        handle.cancel()
        status = handle.wait(timeout=START_SECONDS)
        assert (status.state, status.counts["cancelled"]) == ("cancelled", 2)


def test_sweep_without_service__resumes_where_it_was(tmp_path: Path) -> None:
    file, out = tmp_path / "smoke.yaml", tmp_path / "out"
    file.write_text(examples.text("smoke"))
    first = whipple("sweep", file, "--out", out, **FAKE)
    assert first.returncode == 0, first.stderr
    assert {"cube.nc", "report.html", "report.json"} <= {one.name for one in out.iterdir()}
    again = whipple("sweep", file, "--out", out, **FAKE, WHIPPLE_TEST_SECONDS="600")
    assert again.returncode == 0, again.stderr
    assert "2 succeeded" in again.stdout
