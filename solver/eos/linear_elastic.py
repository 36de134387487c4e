"""Linear elasticity of the volume, for verification: p = K (rho / rho0 - 1), whatever the heat.

What exceeds the energy of the isentrope, the integral of p drho / rho^2 = K / rho0 (ln x - 1 + 1 / x) with x = rho /
rho0, is heat; on the isentrope the temperature stays what it was.
"""

import math
from typing import NamedTuple

from solver.eos import (
    EosEntry,
    below_range,
    linear,
    linearisations,
    outside_range,
    pressure_terms,
    reference_density,
    reference_sound_speed,
    sound_speed_squared,
    temperature,
)
from solver.jit import implements
from solver.vectors import log


class LinearElastic(NamedTuple):
    """Parameters of the linear law; made by ``linear_elastic``."""

    density: float  # rho0, kg/m3
    bulk_modulus: float  # K, Pa
    heat_capacity: float  # cv, J/(kg K); inf: the temperature stays what it is
    temperature: float  # of the reference state, K


def linear_elastic(*, density, bulk_modulus, temperature, heat_capacity=math.inf):
    """The linear law of a bulk modulus."""
    return LinearElastic(density, bulk_modulus, heat_capacity, temperature)


EOS = EosEntry("linear_elastic", LinearElastic, linear_elastic)


@implements(pressure_terms, LinearElastic)
def _(eos, density, energy):
    return eos.bulk_modulus * (density / eos.density - 1.0), 0.0


@implements(sound_speed_squared, LinearElastic)
def _(eos, density, energy, pressure):
    return eos.bulk_modulus / eos.density


@implements(temperature, LinearElastic)
def _(eos, density, energy):
    x = density / eos.density
    cold = eos.bulk_modulus / eos.density * (log(x) - 1.0 + 1.0 / x)
    return eos.temperature + (energy - cold) / eos.heat_capacity


implements(linearisations, LinearElastic)(linear)


@implements(outside_range, LinearElastic)
def _(eos, density):
    return False


@implements(below_range, LinearElastic)
def _(eos, density):
    return False


@implements(reference_density, LinearElastic)
def _(eos):
    return eos.density


@implements(reference_sound_speed, LinearElastic)
def _(eos):
    return math.sqrt(eos.bulk_modulus / eos.density)
