"""What must hold exactly, or to a stated error, before any experiment is looked at."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from solver.problem import ArtificialViscosity
from solver.simulation import simulate
from studies.materials import load
from studies.results import ENERGY_DRIFT_LIMIT
from studies.runs.execution import setting_of
from studies.runs.run import resolve
from tests.claims import Row, at_most, claim
from tests.verification.fields import expansion_error, force_of_uniform_pressure

ROUND_OFF = 1e-12


@claim(
    "viscosity-work",
    says="switching off the work of the artificial viscosity makes the energy audit see it",
    quick=True,
)
def viscosity_work() -> Iterator[Row]:
    parameters = {
        "speed": 4e3,
        "projectile_diameter": 8e-3,
        "plate_thickness": 2e-3,
        "projectile": "copper-ofhc",
        "target": "copper-ofhc",
        "cells_per_diameter": 16.0,
    }
    copper = load("copper-ofhc")
    run = resolve("thin_plate", parameters, {"projectile": copper, "target": copper})
    problem = replace(setting_of(run).problem, end_time=8e-6)
    cold = ArtificialViscosity(problem.viscosity.linear, problem.viscosity.quadratic, heating=0.0)
    sound = simulate(problem).audit.energy_drift
    blind = simulate(replace(problem, viscosity=cold)).audit.energy_drift
    yield at_most("energy drift with the work (of the initial energy)", limit=0.01, got=abs(sound))
    seen = abs(blind) > ENERGY_DRIFT_LIMIT
    yield Row(
        "energy drift without it",
        f"beyond {ENERGY_DRIFT_LIMIT:.0%}: flagged",
        f"{blind:+.2%}",
        seen,
    )


@claim(
    "uniform-pressure",
    says="a uniform pressure leaves inner nodes without force in both geometries",
    quick=True,
)
def uniform_pressure() -> Iterator[Row]:
    for geometry in ("cartesian", "axisymmetric"):
        largest = force_of_uniform_pressure(geometry)
        yield at_most(f"largest nodal force over p h^2, {geometry}", limit=ROUND_OFF, got=largest)


@claim(
    "uniform-expansion",
    says="a uniform expansion is exact in 3-D, and within 1 % beyond three cells from the axis",
    quick=True,
)
def uniform_expansion() -> Iterator[Row]:
    error = expansion_error("cartesian")
    yield at_most(
        "error of the volume rate, 3-D", limit=ROUND_OFF, got=float(np.max(error.relative))
    )
    error = expansion_error("axisymmetric")
    far = error.cells_from_axis > 3.0
    yield at_most(
        "error beyond three cells from the axis", limit=0.01, got=float(np.max(error.relative[far]))
    )
    near = float(np.max(error.relative[~far]))
    yield Row(
        "error within three cells of the axis",
        "",
        f"{near:.2%}",
        None if math.isfinite(near) else False,
    )
