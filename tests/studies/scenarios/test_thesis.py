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
from collections.abc import Callable, Mapping
from functools import cache
from itertools import pairwise
from typing import Any

import pytest

from studies.runs.results import RunResult
from tests.cases.cubes import result_of
from tests.claims.rows import Row, relative

THREADS = 2
SPEEDS = (2, 6)  # km/s
F90_HOLE = {(2, 0.5): 14.81, (6, 0.5): 18.97, (2, 1.0): 15.29, (6, 1.0): 21.15}  # (km/s, mm cells): mm

# c of a longitudinal wave in E = 117 GPa, nu = 0.35, 8930 kg/m3: MPM3D-F90's time step is 0.1 h / c.
ELASTIC_WAVE = math.sqrt(117e9 * 0.65 / (1.35 * 0.30) / 8930.0)
DIAMETER = (6.0 * 0.5e-3 / (math.pi * 8930.0)) ** (1.0 / 3.0)  # of half a gram of copper
COMMON = {"recipe": "thesis", "edges": "fixed", "thermal_softening": False, "tension": "unlimited", "stop": "end_time"}

Compared = Callable[[Row], None]


@cache
def thin(speed: int, cell: float, geometry: str) -> RunResult:
    """The thin plate: c0 = 3.6 km/s, cubic, quadratic viscosity only, no temperature, no tensile limit, fixed edges."""
    plate = {"projectile_diameter": 8e-3, "plate_thickness": 2e-3, "plate_radius": 25e-3, "end_time": 30e-6}
    numerics = {"viscosity_linear": 0.0, "viscosity_quadratic": 1.5, "fixed_dt": 0.1 * cell / ELASTIC_WAVE}
    own = {"speed": speed * 1e3, "geometry": geometry, "cells_per_diameter": 8e-3 / cell, "eos_form": "cubic"}
    return executed("thin_plate", "copper-thesis-jc", {**COMMON, **plate, **numerics, **own})


def thick(geometry: str, cell: float) -> RunResult:
    """Thesis 3.2.1: a copper sphere of 0.5 g at 6 km/s on 80 x 80 x 40 mm, perfect plasticity, 32 us."""
    block = {"projectile_diameter": DIAMETER, "target_depth": 40e-3, "target_radius": 40e-3, "end_time": 32e-6}
    own = {"speed": 6e3, "geometry": geometry, "cells_per_diameter": DIAMETER / cell}
    return executed("thick_plate", "copper-thesis-plastic", {**COMMON, **block, **own})


def executed(scenario: str, material: str, parameters: Mapping[str, Any]) -> RunResult:
    roles = dict.fromkeys(("projectile", "target"), material)
    result = result_of(scenario, {**roles, **parameters}, threads=THREADS)
    assert result.state == "succeeded", result.reason
    return result


def millimetres(result: RunResult, name: str) -> float:
    value = result.measurements[name].value
    return math.nan if value is None else value * 1e3


@pytest.mark.claim("thesis", "thesis-deck-particles", minutes=1.0)
def test_thin_plate__has_the_particles_of_the_thesis(compared: Compared) -> None:
    """The thesis' thin plate has its 10 544 particles at 1 mm cells."""
    count = int(thin(2, 1e-3, "quarter").numbers["particles"])
    compared(Row("particles, quarter model, 1 mm cells", 10544, count, count == 10544))


@pytest.mark.claim("thesis", "thesis-deck-hole", minutes=10.0)
def test_thin_plate__has_the_hole_of_another_program(compared: Compared) -> None:
    """The thesis' deck gives MPM3D-F90's hole within 8 % at 0.5 mm cells."""
    for (speed, cell), expected in F90_HOLE.items():
        result = thin(speed, cell * 1e-3, "quarter")
        got, text = millimetres(result, "hole_diameter"), f"hole_diameter, {speed} km/s, {cell} mm cells (mm)"
        if cell == 0.5:
            compared(relative(text, expected=expected, got=got, within=0.08))
        else:
            compared(Row(text, f"{expected} (20 %)", round(got, 2), None))
        areal = millimetres(result, "hole_diameter_areal")
        compared(Row(f"diameter by areal density, {speed} km/s, {cell} mm (mm)", expected, round(areal, 2), None))
        drift = result.numbers["largest_energy_drift"]
        compared(Row(f"energy drift, {speed} km/s, {cell} mm", "", f"{drift:+.2%}", None))


@pytest.mark.claim("thesis", "thesis-deck-axisymmetric", minutes=10.0)
def test_thin_plate__in_axisymmetry_converges_and_agrees(compared: Compared) -> None:
    """The same physics in axisymmetry converges and agrees with 3-D."""
    for speed in SPEEDS:
        series = {
            cells: millimetres(thin(speed, 8e-3 / cells, "axisymmetric"), "hole_diameter") for cells in (8, 16, 32, 64)
        }
        text = ", ".join(f"{cells}: {value:.2f}" for cells, value in series.items())
        steps = [abs(fine - coarse) for coarse, fine in pairwise(series.values())]
        shrinking = all(later < earlier for earlier, later in pairwise(steps))
        got = ", ".join(f"{step:.2f}" for step in steps)
        compared(Row(f"D by cells per diameter, {speed} km/s (mm): {text}", "differences shrink", got, shrinking))
        solid = millimetres(thin(speed, 0.5e-3, "quarter"), "hole_diameter")
        text = f"axisymmetric against 3-D at 16 cells, {speed} km/s (mm)"
        compared(relative(text, expected=solid, got=series[16], within=0.06))


@pytest.mark.claim("thesis", "thesis-crater", minutes=5.0)
def test_thick_plate__has_the_crater_of_the_thesis(compared: Compared) -> None:
    """The thesis' crater at 6 km/s: depth 14 mm, diameter 25 mm at its resolution."""
    result = thick("half", 1e-3)
    depth, diameter = (millimetres(result, name) for name in ("crater_depth", "crater_diameter"))
    text = "crater depth, 3-D, 1 mm cells (mm); experiment 14 / 25.4, MPM3D-F90 14.5 / 25.5"
    compared(Row(text, "14 +- 1.5", round(depth, 2), abs(depth - 14) <= 1.5))
    compared(Row("crater diameter, 3-D, 1 mm cells (mm)", "25 +- 2", round(diameter, 2), abs(diameter - 25) <= 2))
    compared(Row("energy drift, 3-D", "", f"{result.numbers['largest_energy_drift']:+.2%}", None))
    for cell in (1e-3, 0.5e-3):
        flat = thick("axisymmetric", cell)
        both = [round(millimetres(flat, name), 2) for name in ("crater_depth", "crater_diameter")]
        compared(Row(f"depth, diameter, axisymmetric, {cell * 1e3:g} mm cells (mm)", "14 / 25.4", both, None))
