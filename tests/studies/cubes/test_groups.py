"""The groups of a cube: a small root for each scenario, and a small file of many points."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from studies import measurements, scenarios
from studies.cubes import audit, cube
from studies.cubes.groups import as_tree, joined
from studies.cubes.variable import GROUPS
from studies.quantities.parameters import declared
from studies.runs.results import RunResult
from studies.sweeps.axes import Axis
from studies.sweeps.sweep import Sweep
from tests.claims.marked import Compared
from tests.claims.rows import at_most
from tests.contracts.test_scenarios import SMALL
from tests.studies.support import fakes

MOST = 40  # variables at the root
POINTS, LARGEST, LONGEST = (100, 20), 16.0, 12.0  # MB; s of a core


def of_scenario(name: str) -> tuple[Sweep, dict[str, RunResult]]:
    """A sweep of two runs with every measurement and every number of the audit."""
    parameters, fixed = declared(scenarios.load(name).parameters), dict(SMALL[name])
    varied = [key for key, value in fixed.items() if isinstance(value, float) and key != "cells_per_diameter"]
    axis = varied[0] if varied else "courant"
    value = fixed.pop(axis, 0.4)
    values = Axis(axis, parameters[axis].unit, (value, 1.25 * value))
    sweep = Sweep(name=name, title=name, scenario=name, fixed=fixed, axes=(values,), combine="grid", resolutions=())
    return sweep, {point.run.id: measured(point.run.id, name) for point in sweep.runs()}


def measured(id: str, name: str, scale: Callable[[], float] = lambda: 1.0) -> RunResult:
    values = {
        each: fakes.measured(1.0 if measurements.load(each).is_outcome else 0.01 * scale())
        for each in scenarios.load(name).measurements
    }
    numbers = {number.name: 0.1 * scale() for number in audit.audit_numbers()}
    return RunResult(id, "succeeded", measurements=values, numbers=numbers, stop="settled", provenance=fakes.PROVENANCE)


@pytest.mark.claim("contract", "root")
@pytest.mark.parametrize("name", scenarios.names())
def test_root__has_at_most_forty_variables_and_the_tree_all_of_them(name: str, compared: Compared) -> None:
    """The root of a cube has at most 40 variables, whatever the scenario measures; the tree has every variable."""
    dataset = cube.build(*of_scenario(name))
    tree = as_tree(dataset)
    compared(
        at_most(f"{name}: variables of {len(dataset.variables)}", limit=MOST, got=len(tree.to_dataset().variables))
    )
    xr.testing.assert_equal(joined(tree), dataset)
    assert {*tree.children} <= {*GROUPS}
    assert {"run_state", "run_flags"} < {*tree.data_vars}


@pytest.mark.claim("contract", "two-thousand-points", minutes=0.3)
def test_cube__of_two_thousand_points_is_small_and_made_soon(compared: Compared, tmp_path: Path) -> None:
    """The cube of 2 000 points with every measurement and history is below 16 MB, and made in 12 s of a core."""
    random = np.random.default_rng(1)
    speeds, thicknesses = (np.linspace(*ends) for ends in ((2e3, 7e3, POINTS[0]), (1e-3, 4e-3, POINTS[1])))
    sweep = fakes.sweep_of(
        Axis("speed", "m s-1", tuple(speeds.tolist())), Axis("plate_thickness", "m", tuple(thicknesses.tolist()))
    )
    names = [history.name for history in audit.HISTORIES if history.by_body]
    results = {}
    for point in sweep.runs():
        result = measured(point.run.id, "thin_plate", lambda: 1.0 + 0.1 * random.normal())
        times = result.measurements["hole_diameter"].history["time"]
        energies = {name: random.normal(size=(2, len(times))).tolist() for name in names}
        histories = {"time": times, "bodies": ["projectile", "target"], **energies}
        results[point.run.id] = replace(result, histories=histories)
    begin = time.process_time()
    file = cube.write(cube.build(sweep, results), tmp_path / "cube.nc")
    seconds = time.process_time() - begin
    compared(at_most("size (MB)", limit=LARGEST, got=file.stat().st_size / 1e6))
    compared(at_most("time of a core (s)", limit=LONGEST, got=seconds))
