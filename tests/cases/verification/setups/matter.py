"""Matter of the exact problems, for the solver: solids without strength, linear elastic bodies, ideal gases."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from solver.matter.eos.ideal_gas import IdealGas
from solver.matter.eos.linear_elastic import LinearElastic
from solver.matter.eos.mie_grueneisen import mie_grueneisen
from solver.matter.laws import Matter
from solver.matter.strength.elastic import Elastic
from solver.matter.stress import PointState, advance
from solver.matter.tension.unlimited import UnlimitedTension
from solver.matter.tensor import equivalent_stress
from solver.problem import ArtificialViscosity
from tests.cases.verification.solutions.hugoniot import Solid
from tests.cases.verification.solutions.waves import Isotropic

ROOM = 300.0  # K; temperature acts on nothing here
HEAT_CAPACITY = 383.0  # J/(kg K); nor does this
SHEAR_STEPS = 2000


def fluid(solid: Solid) -> Matter:
    """A Mie-Grueneisen solid that bears no shear."""
    eos = mie_grueneisen(
        density=solid.density,
        c0=solid.c0,
        s=solid.s,
        gamma0=solid.gamma0,
        heat_capacity=HEAT_CAPACITY,
        temperature=ROOM,
    )
    return matter_of(eos, shear_modulus=0.0)


def elastic(isotropic: Isotropic) -> Matter:
    """Linear elastic matter that never yields or parts."""
    eos = LinearElastic(
        density=isotropic.density, bulk_modulus=isotropic.bulk_modulus, heat_capacity=HEAT_CAPACITY, temperature=ROOM
    )
    return matter_of(eos, shear_modulus=isotropic.shear_modulus)


def gas(gamma: float, *, densest: float, sound_speed: float) -> Matter:
    """An ideal gas; its limits of a physical state hang on the largest density (kg/m3) and sound speed (m/s) given."""
    eos = IdealGas(density=densest, sound_speed=sound_speed, gamma=gamma, heat_capacity=HEAT_CAPACITY, temperature=ROOM)
    return matter_of(eos, shear_modulus=0.0)


def matter_of(
    eos: Any,
    *,
    shear_modulus: float = 0.0,
    strength: Any = None,
    room_temperature: float = ROOM,
    melt_temperature: float = math.inf,
) -> Matter:
    """Matter of an equation of state that never parts; without ``strength`` it never yields."""
    return Matter(
        eos=eos,
        strength=strength or Elastic(),
        tension=UnlimitedTension(),
        shear_modulus=shear_modulus,
        room_temperature=room_temperature,
        melt_temperature=melt_temperature,
    )


def sheared(
    matter: Matter, point: PointState, held: Mapping[str, Any], *, strain: float, rate: float = 1.0
) -> tuple[float, float]:
    """Plastic strain and equivalent stress (Pa) of a point after a strain at a rate (1/s), without a change of volume.

    The point is sheared in many small steps; ``held`` are the fields of its state that are set back after each.
    """
    # Stretching along one axis and half as much contraction along the others: the equivalent rate is the axial one.
    dt = strain / rate / SHEAR_STEPS
    gradient = np.diag([rate, -0.5 * rate, -0.5 * rate])
    for _ in range(SHEAR_STEPS):
        point = advance(matter, ArtificialViscosity(), 1.0, dt, gradient, point)[0]
        point = point._replace(**held)
    return point.plastic_strain, equivalent_stress(point.deviator)
