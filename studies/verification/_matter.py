"""Matter of the exact problems, for the solver: solids without strength, linear elastic bodies, ideal gases."""

import math
from typing import TYPE_CHECKING, Any

from studies.verification._hugoniot import Solid
from studies.verification._waves import Isotropic

if TYPE_CHECKING:
    from solver.problem import Matter

ROOM = 300.0  # K; temperature acts on nothing here
HEAT_CAPACITY = 383.0  # J/(kg K); nor does this


def fluid(solid: Solid) -> "Matter":
    """A Mie-Grueneisen solid that bears no shear."""
    from solver.eos.mie_grueneisen import mie_grueneisen

    eos = mie_grueneisen(
        density=solid.density,
        c0=solid.c0,
        s=solid.s,
        gamma0=solid.gamma0,
        heat_capacity=HEAT_CAPACITY,
        temperature=ROOM,
    )
    return matter_of(eos, shear_modulus=0.0)


def elastic(isotropic: Isotropic) -> "Matter":
    """Linear elastic matter that never yields or parts."""
    from solver.eos.linear_elastic import LinearElastic

    eos = LinearElastic(
        density=isotropic.density,
        bulk_modulus=isotropic.bulk_modulus,
        heat_capacity=HEAT_CAPACITY,
        temperature=ROOM,
    )
    return matter_of(eos, shear_modulus=isotropic.shear_modulus)


def gas(gamma: float, *, densest: float, sound_speed: float) -> "Matter":
    """An ideal gas; its limits of a physical state hang on the largest density (kg/m3) and sound speed (m/s) given."""
    from solver.eos.ideal_gas import IdealGas

    eos = IdealGas(
        density=densest,
        sound_speed=sound_speed,
        gamma=gamma,
        heat_capacity=HEAT_CAPACITY,
        temperature=ROOM,
    )
    return matter_of(eos, shear_modulus=0.0)


def matter_of(eos: Any, *, shear_modulus: float = 0.0) -> "Matter":
    """Matter of an equation of state that never yields, parts or melts."""
    from solver.problem import Matter
    from solver.strength.elastic import Elastic
    from solver.tension.unlimited import UnlimitedTension

    return Matter(
        eos=eos,
        strength=Elastic(),
        tension=UnlimitedTension(),
        shear_modulus=shear_modulus,
        room_temperature=ROOM,
        melt_temperature=math.inf,
    )
