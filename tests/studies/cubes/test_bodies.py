"""Runs of one sweep with different bodies: each has its place by name, and what a run does not have is missing."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from studies.cubes import cube
from studies.cubes.opening import whole_cube
from studies.reports.page import appendix, page
from studies.runs.execution import execute
from studies.sweeps.sweep import Sweep
from tests.claims.rows import Row, absolute, equal
from tests.samples import needs
from tests.studies.support import fakes

ROUND_OFF = 1e-12


def computed(plain: dict[str, Any], directory: Path) -> xr.Dataset:
    """The cube of a sweep, computed here, written and read again."""
    sweep = Sweep.parse(plain)
    results = {point.run.id: execute(point.run, directory / point.run.id, threads=1) for point in sweep.runs()}
    path = cube.write(cube.build(sweep, results), directory / "cube.nc")
    return whole_cube(path)


def reported(dataset: xr.Dataset) -> dict[str, Any]:
    """The report of a cube, made as a page too."""
    report = fakes.document_of(dataset)
    assert page(report)
    assert appendix(report)
    return report


def starts(dataset: xr.Dataset, kind: str) -> dict[tuple[str, str], float]:
    """The first value of a history by run, its coordinate as a text, and body."""
    [axis] = dataset.attrs["axes"].split()
    first = dataset[f"body_{kind}_history"].isel(sample=0)
    labels = [str(value).splitlines()[0] for value in dataset[axis].values]
    return {
        (label, str(body)): float(first.isel({axis: place}).sel(body=body))
        for place, label in enumerate(labels)
        for body in dataset.body.values
    }


def table(expected: dict[tuple[str, str], float], got: dict[tuple[str, str], float]) -> list[Row]:
    """Each cell of a table beside what is expected; NaN is expected of what is missing."""
    assert got.keys() == expected.keys()
    return [
        equal(f"{run}, {body}", expected="missing", got="missing" if np.isnan(got[at]) else got[at])
        if np.isnan(value)
        else absolute(f"{run}, {body}", expected=value, got=got[at], within=ROUND_OFF * abs(value))
        for at, value in expected.items()
        for run, body in [at]
    ]


@needs("plugging", "sph-fem")
@pytest.mark.claim("mend-again", "sweep-over-methods", minutes=1.5)
def test_sweep_over_methods__is_the_hand_made_table(tmp_path: Path, compared: Callable[[Row], None]) -> None:
    """A sweep over methods has the bodies of each run by name, in the cube and in the report."""
    dataset = computed(
        {
            "scenario": "plugging",
            "fixed": {
                "geometry": "quarter",
                "speed": "300 m/s",
                "plate_radius": "40 mm",
                "gap": "4 mm",
                "end_time": "2 us",
            },
            "axes": {"method": ["mpm", "sph", "sph-fem"]},
            "resolution": 10,
        },
        tmp_path,
    )
    # A cylinder of arne-elastic, 20 mm by 80 mm, 7838 kg/m3, at 300 m/s.
    mass, speed, none = 7838.0 * np.pi * 0.01**2 * 0.08, 300.0, np.nan
    bodies = ("projectile", "target", "target-elements")
    for kind, moving in (("kinetic_energy", 0.5 * mass * speed**2), ("axial_momentum", mass * speed)):
        rows = {"mpm": (moving, 0, none), "sph": (moving, 0, none), "sph-fem": (moving, 0, 0)}
        expected = {
            (method, body): value for method, row in rows.items() for body, value in zip(bodies, row, strict=True)
        }
        for row in table(expected, starts(dataset, kind)):
            compared(row)
    report = reported(dataset)
    for number, (contact, method) in enumerate((("gap", "mpm"), ("repulsion", "sph"), ("repulsion", "sph-fem"))):
        run = report["runs"]["runs"][number]
        got = (run["state"], run["at"]["method"], str(dataset.contact.values[number]))
        compared(equal(f"run {number}", expected=("succeeded", method, contact), got=got))
    compared(equal("methods set beside", expected="mpm", got=report["methods"]["first"]))
