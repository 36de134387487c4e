"""The real service: ``whipple serve`` as a process of its own, real workers, real kills."""

import os
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from studies import examples
from studies.sweep_document import read_yaml
from tests.acceptance.serving import ROOT, Service, serving
from tests.service.api import until

START_SECONDS = 60.0  # deadlines, for machines that are busy with something else
SWEEP_SECONDS = 900.0  # each worker compiles kernels, where none are kept
LEAVE_SECONDS = 10.0
NEVER_MAPPED = ("llvmlite", "_netcdf4", "/numba/")
FAKE = {"WHIPPLE_TARGETS_MODULE": "tests.service.targets"}
SMOKE = read_yaml(examples.text("smoke"), "smoke")


def family(service: Service) -> list[psutil.Process]:
    """The process of a service and all of its children."""
    assert service.process is not None
    own = psutil.Process(service.process.pid)
    return [own, *own.children(recursive=True)]


def is_gone(process: psutil.Process) -> bool:
    """Whether a process has ended; one that nobody has waited for yet counts."""
    try:
        return not process.is_running() or process.status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:  # it went between the two questions
        return True


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
        maps = Path(f"/proc/{family(service)[0].pid}/maps").read_text().lower()
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
        started = family(service)
        service.kill()
    until(lambda: all(map(is_gone, started)), seconds=LEAVE_SECONDS)
    with serving(tmp_path / "data", **slow) as service, service.client() as client:
        status = client.sweep(id).wait(timeout=SWEEP_SECONDS)
        assert (status.state, status.counts["succeeded"]) == ("succeeded", 7)
        client.sweep(id).fetch(tmp_path / "out")


def test_sigterm__ends_the_service_in_time_and_leaves_no_process(tmp_path: Path) -> None:
    slow = {**FAKE, "WHIPPLE_TEST_SECONDS": "60"}
    with serving(tmp_path / "data", **slow) as service, service.client() as client:
        id = client.submit(SMOKE).id
        until(lambda: client.sweep(id).status().counts["running"] > 0, seconds=START_SECONDS)
        started = family(service)
        assert service.leave() == 0  # in half of the time that the run takes, or it raises
    until(lambda: all(map(is_gone, started)), seconds=LEAVE_SECONDS)


def test_second_service__on_the_same_data_refuses_in_one_sentence(tmp_path: Path) -> None:
    with serving(tmp_path / "data", **FAKE) as service:
        second = whipple("serve", "--port", "0", "--data", tmp_path / "data", **FAKE)
        assert second.returncode == 1
        assert str(family(service)[0].pid) in second.stderr
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
