"""Runs of one sweep with different bodies: each has its place by name, and what a run does not have is missing."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from studies.cubes import cube
from studies.cubes.opening import whole_cube
from studies.reports.page import appendix, page
from studies.runs.execution import execute
from studies.sweeps.sweep import Sweep
from tests.claims.rows import Row, absolute, equal
from tests.samples import needs
from tests.studies.support import fakes

ROUND_OFF = 1e-12


@needs("plugging", "sph-fem")
@pytest.mark.claim("mend-again", "sweep-over-methods", minutes=1.5)
def test_sweep_over_methods__is_the_hand_made_table(tmp_path: Path, compared: Callable[[Row], None]) -> None:
    """A sweep over methods has the bodies of each run by name, in the cube and in the report."""
    fixed = {"geometry": "quarter", "speed": "300 m/s", "plate_radius": "40 mm", "gap": "4 mm", "end_time": "2 us"}
    methods = ("mpm", "sph", "sph-fem")
    sweep = Sweep.parse({"scenario": "plugging", "fixed": fixed, "axes": {"method": [*methods]}, "resolution": 10})
    results = {point.run.id: execute(point.run, tmp_path / point.run.id, threads=1) for point in sweep.runs()}
    dataset = whole_cube(cube.write(cube.build(sweep, results), tmp_path / "cube.nc"))
    # A cylinder of arne-elastic, 20 mm by 80 mm, 7838 kg/m3, at 300 m/s.
    mass, speed = 7838.0 * np.pi * 0.01**2 * 0.08, 300.0
    assert dataset.body.values.tolist() == ["projectile", "target", "target-elements"]
    for kind, moving in (("kinetic_energy", 0.5 * mass * speed**2), ("axial_momentum", mass * speed)):
        first = dataset[f"body_{kind}_history"].isel(sample=0)
        for method in methods:
            at_rest = dict.fromkeys(("target", "target-elements")[: 2 if method == "sph-fem" else 1], 0.0)
            expected = {"projectile": moving, **at_rest}
            for body in dataset.body.values.tolist():
                got = float(first.sel(method=method, body=body))
                is_there = body in expected
                compared(equal(f"{method}, {body}: {kind} missing", expected=not is_there, got=bool(np.isnan(got))))
                if is_there:
                    within = ROUND_OFF * expected[body]
                    compared(absolute(f"{method}, {body}: {kind}", expected=expected[body], got=got, within=within))
    report = fakes.document_of(dataset)
    assert page(report)
    assert appendix(report)
    for number, (contact, method) in enumerate(zip(("gap", "repulsion", "repulsion"), methods, strict=True)):
        run = report["runs"]["runs"][number]
        got = (run["state"], run["at"]["method"], str(dataset.contact.values[number]))
        compared(equal(f"run {number}", expected=("succeeded", method, contact), got=got))
    compared(equal("methods set beside", expected="mpm", got=report["methods"]["first"]))
