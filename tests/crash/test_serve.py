"""The real service: ``whipple serve`` as a process of its own, real workers, real kills."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from studies.sweeps import examples
from studies.sweeps.document import read_yaml
from tests.crash.support.serving import ROOT, Service, serving
from tests.service.support.cluster import family
from tests.service.support.fakes import is_gone, wait_until

START_SECONDS = 60.0  # deadlines, for machines that are busy with something else
SWEEP_SECONDS = 900.0  # each worker compiles kernels, where none are kept
LEAVE_SECONDS = 10.0
NEVER_MAPPED = ("llvmlite", "_netcdf4", "/numba/")
FAKE = {"WHIPPLE_TARGETS_MODULE": "tests.service.support.targets"}
SMOKE = read_yaml(examples.text("smoke"), "smoke")


def whipple(*arguments: object, **environment: str) -> "subprocess.CompletedProcess[str]":
    """Run the command in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "service", *map(str, arguments)],
        cwd=ROOT,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=SWEEP_SECONDS,
        check=False,
    )


@pytest.mark.slow
@pytest.mark.claim("queue", "main-job", minutes=0.2)
def test_main_job__goes_from_submission_to_cube_and_report(tmp_path: Path) -> None:
    """A sweep that is submitted to a service is solved and published, and the service never loads the solver."""
    import xarray

    # One worker: two would compile the same kernels at the same time.
    with serving(tmp_path / "data", WHIPPLE_WORKERS="1") as service, service.client() as client:
        handle = client.submit(SMOKE)
        status = handle.wait(timeout=SWEEP_SECONDS)
        assert (status.state, status.counts["succeeded"]) == ("succeeded", 2)
        folder = handle.fetch(tmp_path / "out")
        maps = Path(f"/proc/{service.pid}/maps").read_text().lower()
    cube = xarray.open_dataset(folder / "cube.nc")
    assert (cube.hole_diameter > 0.008).all()
    assert b"<html" in (folder / "report.html").read_bytes()
    assert not [library for library in NEVER_MAPPED if library in maps]


@pytest.fixture(scope="module")
def busy(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service whose runs take longer than it has to leave."""
    data = tmp_path_factory.mktemp("busy") / "data"
    with serving(data, **FAKE, WHIPPLE_TEST_SECONDS="40") as service:
        yield service


def test_second_service__on_the_same_data_refuses_in_one_sentence(busy: Service) -> None:
    second = whipple("serve", "--port", "0", "--data", busy.data, **FAKE)
    assert second.returncode == 1
    assert str(busy.pid) in second.stderr
    assert "Traceback" not in second.stderr


def test_cancel__ends_the_runs_and_publishes_what_there_is(busy: Service) -> None:
    with busy.client() as client:
        handle = client.submit(SMOKE)
        wait_until(lambda: handle.status().counts["running"] > 0, seconds=START_SECONDS)
        handle.cancel()
        status = handle.wait(timeout=START_SECONDS)
        assert (status.state, status.counts["cancelled"]) == ("cancelled", 2)


def test_sigterm__ends_the_service_in_time_and_leaves_no_process(busy: Service) -> None:
    with busy.client() as client:
        id = client.submit(SMOKE).id
        wait_until(lambda: client.sweep(id).status().counts["running"] > 0, seconds=START_SECONDS)
    started = family(busy.pid)
    assert busy.leave() == 0  # before the run would end, or it raises
    wait_until(lambda: all(map(is_gone, started)), seconds=LEAVE_SECONDS)
