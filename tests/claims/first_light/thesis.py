"""The problems of Ma (2005), chapter 3, in the thesis' numerics, against MPM3D-F90 (commit 367e024) and the experiment.

MPM3D-F90's figures are its output on the same decks, read by its own recipe: slow plate particles stamped on a 0.25 mm
raster, equal-area diameter of the empty area about the axis, at 30 us.

``hole_diameter`` is the clear diameter since its version 4; ``hole_diameter_areal`` is the former. In 3-D on 1 mm at
8 km/s the state is that of commit dc548a6: with this deck both trees read 23.165 mm by areal density (now clear:
23.157), with the recipe's own viscosity and step 23.494 and 23.496 (now clear: 23.729). None is converged: in
axisymmetry that recipe gives 22.98, 20.95, 19.56 and 19.33 mm on 1, 0.5, 0.25 and 0.125 mm (by areal density 22.98,
21.23, 20.23 and 19.95).
"""

import math
import tempfile
from collections.abc import Iterator, Mapping
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

from studies.materials import load
from studies.runs.execution import execute
from studies.runs.run import resolve
from studies.values.results import RunResult
from tests.claims import Row, claim, relative

THREADS = 2
F90_HOLE = {(2, 0.5): 14.81, (6, 0.5): 18.97, (2, 1.0): 15.29, (6, 1.0): 21.15}  # (km/s, mm cells): mm

# c of a longitudinal wave in E = 117 GPa, nu = 0.35, 8930 kg/m3: MPM3D-F90's time step is 0.1 h / c.
ELASTIC_WAVE = math.sqrt(117e9 * 0.65 / (1.35 * 0.30) / 8930.0)


def _deck(speed: int, cell: float, geometry: str) -> dict[str, Any]:
    """The thin plate: c0 = 3.6 km/s, cubic, quadratic viscosity only, no temperature, no tensile limit, fixed edges."""
    return {
        "speed": speed * 1e3,
        "projectile_diameter": 8e-3,
        "plate_thickness": 2e-3,
        "plate_radius": 25e-3,
        "projectile": "copper-thesis-jc",
        "target": "copper-thesis-jc",
        "geometry": geometry,
        "recipe": "thesis",
        "cells_per_diameter": 8e-3 / cell,
        "edges": "fixed",
        "eos_form": "cubic",
        "thermal_softening": False,
        "tension": "unlimited",
        "viscosity_linear": 0.0,
        "viscosity_quadratic": 1.5,
        "fixed_dt": 0.1 * cell / ELASTIC_WAVE,
        "end_time": 30e-6,
        "stop": "end_time",
    }


@cache
def _thin(speed: int, cell: float, geometry: str) -> RunResult:
    return _execute("thin_plate", _deck(speed, cell, geometry))


def _execute(scenario: str, parameters: Mapping[str, Any]) -> RunResult:
    materials = {role: load(str(parameters[role])) for role in ("projectile", "target")}
    run = resolve(scenario, parameters, materials)
    with tempfile.TemporaryDirectory() as folder:
        result = execute(run, Path(folder), threads=THREADS)
    assert result.state == "succeeded", result.reason
    return result


def _millimetres(result: RunResult, name: str) -> float:
    value = result.measurements[name].value
    return math.nan if value is None else value * 1e3


@claim("thesis-deck-particles", says="the thesis' thin plate has its 10 544 particles at 1 mm cells")
def particles() -> Row:
    count = int(_thin(2, 1e-3, "quarter").numbers["particles"])
    return Row("particles, quarter model, 1 mm cells", 10544, count, count == 10544)


@claim("thesis-deck-hole", says="the thesis' deck gives MPM3D-F90's hole within 8 % at 0.5 mm cells")
def hole() -> Iterator[Row]:
    for speed in (2, 6):
        for cell, gate in ((1.0, None), (0.5, 0.08)):
            result = _thin(speed, cell * 1e-3, "quarter")
            got = _millimetres(result, "hole_diameter")
            expected = F90_HOLE[speed, cell]
            text = f"hole_diameter, {speed} km/s, {cell} mm cells (mm)"
            if gate:
                yield relative(text, expected=expected, got=got, within=gate)
            else:
                yield Row(text, f"{expected} (20 %)", round(got, 2), None)
            areal = _millimetres(result, "hole_diameter_areal")
            yield Row(f"diameter by areal density, {speed} km/s, {cell} mm (mm)", expected, round(areal, 2), None)
            drift = result.numbers["largest_energy_drift"]
            yield Row(f"energy drift, {speed} km/s, {cell} mm", "", f"{drift:+.2%}", None)


@claim("thesis-deck-axisymmetric", says="the same physics in axisymmetry converges and agrees with 3-D")
def axisymmetric() -> Iterator[Row]:
    for speed in (2, 6):
        series = {
            cells: _millimetres(_thin(speed, 8e-3 / cells, "axisymmetric"), "hole_diameter")
            for cells in (8, 16, 32, 64)
        }
        text = ", ".join(f"{cells}: {value:.2f}" for cells, value in series.items())
        values = list(series.values())
        steps = [abs(fine - coarse) for coarse, fine in pairwise(values)]
        shrinking = all(later < earlier for earlier, later in pairwise(steps))
        yield Row(
            f"D by cells per diameter, {speed} km/s (mm): {text}",
            "differences shrink",
            ", ".join(f"{step:.2f}" for step in steps),
            shrinking,
        )
        solid = _millimetres(_thin(speed, 0.5e-3, "quarter"), "hole_diameter")
        yield relative(
            f"axisymmetric against 3-D at 16 cells, {speed} km/s (mm)", expected=solid, got=series[16], within=0.06
        )


def _block(geometry: str, cell: float) -> dict[str, Any]:
    """Thesis 3.2.1: a copper sphere of 0.5 g at 6 km/s on 80 x 80 x 40 mm, perfect plasticity, 32 us."""
    diameter = (6.0 * 0.5e-3 / (math.pi * 8930.0)) ** (1.0 / 3.0)
    return {
        "speed": 6e3,
        "projectile_diameter": diameter,
        "target_depth": 40e-3,
        "target_radius": 40e-3,
        "projectile": "copper-thesis-plastic",
        "target": "copper-thesis-plastic",
        "geometry": geometry,
        "recipe": "thesis",
        "cells_per_diameter": diameter / cell,
        "edges": "fixed",
        "thermal_softening": False,
        "tension": "unlimited",
        "end_time": 32e-6,
        "stop": "end_time",
    }


@claim("thesis-crater", says="the thesis' crater at 6 km/s: depth 14 mm, diameter 25 mm at its resolution")
def crater() -> Iterator[Row]:
    result = _execute("thick_plate", _block("half", 1e-3))
    depth, diameter = (_millimetres(result, name) for name in ("crater_depth", "crater_diameter"))
    references = "experiment 14 / 25.4, MPM3D-F90 14.5 / 25.5"
    yield Row(f"crater depth, 3-D, 1 mm cells (mm); {references}", "14 +- 1.5", round(depth, 2), abs(depth - 14) <= 1.5)
    yield Row("crater diameter, 3-D, 1 mm cells (mm)", "25 +- 2", round(diameter, 2), abs(diameter - 25) <= 2)
    yield Row("energy drift, 3-D", "", f"{result.numbers['largest_energy_drift']:+.2%}", None)
    for cell in (1e-3, 0.5e-3):
        flat = _execute("thick_plate", _block("axisymmetric", cell))
        both = [round(_millimetres(flat, name), 2) for name in ("crater_depth", "crater_diameter")]
        yield Row(f"depth, diameter, axisymmetric, {cell * 1e3:g} mm cells (mm)", "14 / 25.4", both, None)
