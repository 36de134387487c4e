"""Data of an older physics with half a sweep, opened by this version: what was accepted is finished, by one physics."""

import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from solver import PHYSICS_VERSION
from studies.sweeps import examples
from studies.sweeps.document import read_yaml
from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.service.support.fakes import wait_until
from tests.service.support.processes import ROOT
from tests.service.support.serving import Service, http

OLDER = "import solver\n\nsolver.PHYSICS_VERSION -= 1\n"  # of every Python process that finds it
SPEEDS = ["3 km/s", "3.5 km/s", "4 km/s", "4.5 km/s", "5 km/s", "6 km/s"]
SWEEP = {**read_yaml(examples.text("smoke"), "smoke"), "axes": {"speed": SPEEDS}}
SWEEP_SECONDS = 600.0  # compiles kernels, where none are kept
KILLS = 3  # of the new version, while it renews


def status_of(service: Service, id: str) -> Any:
    return http().get(f"{service.url}/v1/sweeps/{id}", timeout=30).json()


def all_sweeps(service: Service) -> Any:
    return http().get(f"{service.url}/v1/sweeps", timeout=30).json()["items"]


def done(service: Service, id: str) -> int:
    return int(status_of(service, id)["counts"]["succeeded"])


def cube_of(service: Service, id: str, folder: Path) -> Any:
    from studies.cubes.opening import whole_cube

    file = folder / f"{id}.nc"
    file.write_bytes(http().get(f"{service.url}/v1/sweeps/{id}/cube.nc", timeout=60).content)
    return whole_cube(file)


def printed(service: Service, *arguments: str) -> str:
    """What a command of this version prints about a service."""
    command = [sys.executable, "-m", "service", *arguments, "--url", service.url]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60, check=True).stdout


def of_the_older_physics(folder: Path) -> Mapping[str, str]:
    """The environment of a service whose physics is one version older."""
    hook = folder / "older"
    hook.mkdir()
    (hook / "sitecustomize.py").write_text(OLDER)
    return {"PYTHONPATH": f"{hook}:{ROOT}"}


@pytest.mark.claim("mend", "upgrade-finishes", minutes=1.0)
def test_upgrade__of_the_physics_finishes_what_was_accepted(tmp_path: Path, compared: Compared) -> None:
    """Half a sweep of an older physics is finished by the present one in all its points, through kills at its begin."""
    service = Service(tmp_path / "data", {"WHIPPLE_WORKERS": "1"})
    try:
        service.start(**of_the_older_physics(tmp_path))
        service.wait_until_listening()
        version = http().get(f"{service.url}/version", timeout=30).json()["physics_version"]
        id = service.submit(SWEEP)
        wait_until(lambda: done(service, id) >= len(SPEEDS) // 2, seconds=SWEEP_SECONDS)
        service.kill()
        for _ in range(KILLS):
            service.start()
            service.wait_until_listening()
            service.kill()
        service.start()
        service.wait_until_listening()
        wait_until(lambda: status_of(service, id)["state"] == "succeeded", seconds=SWEEP_SECONDS)
        status = status_of(service, id)
        wait_until(lambda: status_of(service, status["older"])["state"] == "cancelled", seconds=SWEEP_SECONDS)
        cube, before = (cube_of(service, each, tmp_path) for each in (id, status["older"]))
        computed = before.hole_diameter.notnull()
        words = f"physics {PHYSICS_VERSION} computes all its points"
        compared(
            equal("physics that began", expected=PHYSICS_VERSION - 1, got=version),
            equal("points that the present physics computed", expected=len(SPEEDS), got=status["counts"]["succeeded"]),
            equal("holes in its cube", expected=len(SPEEDS), got=int(cube.hole_diameter.notnull().sum())),
            equal("physics of its cube", expected=[f"{PHYSICS_VERSION}"], got=physics_in(cube)),
            equal("sweeps: it, and its older results", expected=2, got=len(all_sweeps(service))),
            equal("older results: at least half", expected=True, got=int(computed.sum()) >= len(SPEEDS) // 2),
            equal("physics of their cube", expected=[f"{PHYSICS_VERSION - 1}"], got=physics_in(before)),
            equal("runs of both", expected=0, got=len({*cube.run_id.values} & {*before.run_id.values})),
            equal(
                "holes that differ, where both computed them (the physics is the same)",
                expected=0,
                got=int((cube.hole_diameter != before.hole_diameter).where(computed, other=False).sum()),
            ),
            equal("whipple status of it says so", expected=True, got=words in printed(service, "status", id)),
            equal("whipple status of all sweeps says so", expected=True, got=words in printed(service, "status")),
        )
    finally:
        service.end()


def physics_in(cube: Any) -> list[str]:
    """The versions of the physics that computed the runs of a cube."""
    return list(json.loads(cube.attrs["software"])["physics_version"])
