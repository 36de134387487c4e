"""Heat of debris behind a bumper, by its causes: shock, flow, tension and viscosity."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from solver.matter.strength.perfectly_plastic import PerfectlyPlastic
from solver.matter.tension.opening import OpeningTension
from solver.problem import Problem
from solver.simulation import simulate
from solver.state import DAMPED, HARDENED, PULLED, SHEARED
from studies.runs.run import resolve
from tests.claims.rows import Row, at_least, relative, reported

CELLS = 24
FLIGHT = 6.0  # projectile diameters until the debris is looked at
SOFT, WEAK = 1e6, 1e7  # Pa: yield stress and tension of matter that shocks alone heat
SHOCK = 0.15  # of the heat of shocks

SHOTS = {
    "2017 on 6061": {"projectile": "al-2017-t4", "bumper": "al-6061-t6"},
    "copper on copper": {"projectile": "copper-ofhc", "bumper": "copper-ofhc"},
}


class Heat(NamedTuple):
    """Mean specific energies of a sphere, J/kg."""

    internal: float
    shear: float
    tension: float
    viscosity: float


def stage(shot: str, speed: float, **changes: str) -> Problem:
    """The bumper's stage of a sphere of 5.41 mm on 1.283 mm, with its heat kept."""
    sizes = {
        "projectile_diameter": 5.41e-3,
        "bumper_thickness": 1.283e-3,
        "wall_thickness": 3.2e-3,
        "stand_off": 0.1016,
    }
    models = {"failure": "none", "tension": "opening", **changes}
    run = resolve(
        "whipple_shield",
        {**sizes, **SHOTS[shot], **models, "wall": "al-2219-t87", "speed": speed, "cells_per_diameter": CELLS},
    )
    problem: Problem = run.set_up.build(run.materials).problem
    return replace(problem, audits_heat=True, end_time=FLIGHT * 5.41e-3 / speed)


def heat_of(problem: Problem) -> Heat:
    """What heated the sphere."""
    snapshot = simulate(problem).snapshot
    assert snapshot.remembered is not None
    here, gone = snapshot.particles.alive == 1, snapshot.departed
    mine = np.concatenate([snapshot.body[here], gone.body]) == 0
    mass, energy = (
        np.concatenate([getattr(snapshot.particles, name)[here], getattr(gone, name)])[mine]
        for name in ("mass", "energy")
    )
    work = np.concatenate([snapshot.remembered[:, here], gone.remembered.T], axis=1)[:, mine]
    parts = (work[row - HARDENED] for row in (SHEARED, PULLED, DAMPED))
    return Heat(*(float(mass @ each / mass.sum()) for each in (energy, *parts)))


def by_shock_alone(problem: Problem) -> Problem:
    """The same of matter that bears next to no shear and no tension."""
    bodies = [
        replace(body, matter=body.matter._replace(strength=PerfectlyPlastic(SOFT), tension=OpeningTension(WEAK)))
        for body in problem.bodies
    ]
    return replace(problem, bodies=tuple(bodies))


@pytest.mark.claim("debris", "heat", minutes=2.0)
@pytest.mark.parametrize("shot", SHOTS)
@pytest.mark.parametrize("speed", [4e3, 5.5e3, 7e3])
def test_sphere__has_the_heat_of_shocks_behind_a_bumper(
    shot: str, speed: float, compared: Callable[[Row], None]
) -> None:
    """A sphere's heat behind the bumper is that of shocks alone within 15 %, but for the work of flow and tension.

    With that work it is not: matter that bears shear and tension is heated by them until it parts. Without opening
    tension heats it more.
    """
    problem = stage(shot, speed)
    heat, shock = heat_of(problem), heat_of(by_shock_alone(problem))
    where = f"{shot}, {1e-3 * speed:g} km/s"
    for name, value in zip(("flow", "tension", "viscosity"), heat[1:], strict=True):
        compared(reported(f"{where}: heat by {name} (J/kg)", value))
    rest = heat.internal - heat.shear - heat.tension
    compared(relative(f"{where}: heat but for flow and tension", expected=shock.internal, got=rest, within=SHOCK))
    compared(reported(f"{where}: heat, of that by shocks alone", heat.internal / shock.internal))
    before = heat_of(stage(shot, speed, tension="recoverable"))
    compared(at_least(f"{where}: heat by tension without opening", limit=heat.tension, got=before.tension))
