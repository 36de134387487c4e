"""The real service: ``whipple serve`` as a process of its own, real workers, real kills."""

from pathlib import Path

import pytest

from studies.sweeps import examples
from studies.sweeps.document import read_yaml
from tests.service.support.fakes import is_gone, wait_until
from tests.service.support.processes import family
from tests.service.support.serving import serving

START_SECONDS = 60.0  # deadlines, for machines that are busy with something else
SWEEP_SECONDS = 900.0  # each worker compiles kernels, where none are kept
LEAVE_SECONDS = 10.0
NEVER_MAPPED = ("llvmlite", "_netcdf4", "/numba/")
SMOKE = read_yaml(examples.text("smoke"), "smoke")


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


def test_sigterm__ends_the_service_in_time_and_leaves_no_process(tmp_path: Path) -> None:
    targets = "tests.service.support.targets"
    environment = {"WHIPPLE_TARGETS_MODULE": targets, "WHIPPLE_TEST_SECONDS": "40", "WHIPPLE_WORKERS": "1"}
    with serving(tmp_path / "data", **environment) as busy:  # its runs take longer than it has to leave
        with busy.client() as client:
            sweep = client.submit(SMOKE)
            wait_until(lambda: sweep.status().counts["running"] > 0, seconds=START_SECONDS)
        started = family(busy.pid)
        assert busy.leave() == 0  # before the run would end, or it raises
        wait_until(lambda: all(map(is_gone, started)), seconds=LEAVE_SECONDS)
