"""Steinberg, Cochran and Guinan at one point: shear modulus, yield stress and melting where pressed, hot, or thin.

The point is sheared without a change of volume, in many small steps, in a state that is held.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from solver.eos.mie_grueneisen import mie_grueneisen
from solver.problem import Matter
from solver.strength.steinberg_guinan import SteinbergGuinan
from solver.stress import PointState
from studies.values.recipes import Recipe
from studies.verification import Case, Row, absolute, at_most, relative
from studies.verification._matter import matter_of, sheared

# Copper: Steinberg (1996), UCRL-MA-106439, as transcribed in the Uintah material files.
Y0, Y_MAX, BETA, N = 120e6, 640e6, 36.0, 0.45
A, B, SMALL_A, GAMMA0 = 28.3e-12, 3.77e-4, 1.5, 2.02  # 1/Pa, 1/K
ROOM, MELT = 300.0, 1790.0
DENSITY, SHEAR_MODULUS = 8930.0, 47.7e9

STRAINS = (0.02, 2.0)  # hardening, and beyond its limit
# The stress lies on the surface up to the solver's own tolerance of the plastic strain (1e-5 of the trial stress).
ON_SURFACE = 1e-4


@dataclass(frozen=True)
class ThermodynamicState:
    """The state at which a point is held."""

    name: str
    density_ratio: float
    pressure: float  # Pa
    temperature: float  # K


STATES = (
    ThermodynamicState("at rest", 1.0, 0.0, 300.0),
    ThermodynamicState("1000 K", 1.0, 0.0, 1000.0),
    ThermodynamicState("1330 K, at 0.93 of the density", 0.93, 0.0, 1330.0),
    ThermodynamicState("1450 K, at 0.93 of the density: molten", 0.93, 0.0, 1450.0),
    ThermodynamicState("cold, with gaps", 0.6, -1e9, 300.0),
    ThermodynamicState("50 GPa", 1.22, 50e9, 800.0),
    ThermodynamicState("250 GPa, 4000 K", 1.5, 250e9, 4000.0),
    ThermodynamicState("4000 K at rest: molten", 1.0, 0.0, 4000.0),
)


def shear_modulus(state: ThermodynamicState) -> float:
    """The law itself, Pa; what is thinner than a solid can be is softer in proportion.

    >>> shear_modulus(ThermodynamicState("", 1.0, 0.0, 300.0)) / 1e9
    47.7
    >>> round(shear_modulus(ThermodynamicState("", 1.0, 1e9, 300.0)) / 1e9 - 47.7, 2)  # A G0 = 1.35
    1.35
    """
    pressed = A * state.pressure / math.cbrt(state.density_ratio)
    return SHEAR_MODULUS * (1.0 + pressed - B * (state.temperature - 300.0)) * min(state.density_ratio / 0.93, 1.0)


def melting_temperature(density_ratio: float) -> float:
    """Lindemann's law, K; a solid is at most as thin as heat makes it.

    Copper that melts at 1 bar has been stretched by 7 % by its heat; measured are 1356 K there:

    >>> melting_temperature(1.0), round(melting_temperature(0.93), -1)
    (1790.0, 1390.0)
    """
    density_ratio = max(density_ratio, 0.93)
    growth = math.exp(2.0 * SMALL_A * (1.0 - 1.0 / density_ratio))
    return MELT * growth * density_ratio ** (2.0 * (GAMMA0 - SMALL_A - 1.0 / 3.0))


def yield_stress(strain: float, state: ThermodynamicState) -> float:
    """The law itself, Pa.

    >>> yield_stress(0.0, STATES[0]) / 1e6, yield_stress(9.0, STATES[0]) / 1e6
    (120.0, 640.0)
    """
    if state.temperature >= melting_temperature(state.density_ratio):
        return 0.0
    hardened = min(Y0 * (1.0 + BETA * strain) ** N, Y_MAX)
    return hardened * shear_modulus(state) / SHEAR_MODULUS


def _run(recipe: Recipe) -> Iterator[Row]:
    for state in STATES:
        for total in STRAINS:
            strain, stress = _sheared(state, total)
            exact = yield_stress(strain, state)
            where = f"{state.name}, strain {total:g}"
            claim = f"{where}: equivalent stress (MPa)"
            if exact > 0.0:
                yield relative(claim, expected=exact / 1e6, got=stress / 1e6, within=ON_SURFACE)
            else:
                yield at_most(claim, limit=0.0, got=stress / 1e6)
            elastic = stress / (3.0 * shear_modulus(state))
            yield absolute(
                f"{where}: plastic and elastic strain", expected=total, got=strain + elastic, within=ON_SURFACE * total
            )


def _sheared(state: ThermodynamicState, total: float) -> tuple[float, float]:
    """Plastic strain and equivalent stress after a strain at a held state."""
    density = state.density_ratio * DENSITY
    point = PointState(density, 0.0, state.pressure, 0.0, (0.0,) * 6, 0.0, state.temperature)
    held = {"density": density, "energy": 0.0, "pressure": state.pressure, "temperature": state.temperature}
    return sheared(_copper(), point, held, strain=total)


def _copper() -> Matter:
    eos = mie_grueneisen(density=DENSITY, c0=3940.0, s=1.489, gamma0=GAMMA0, heat_capacity=383.0, temperature=ROOM)
    return matter_of(
        eos,
        shear_modulus=SHEAR_MODULUS,
        strength=SteinbergGuinan(Y0, Y_MAX, BETA, N, A, B, SMALL_A, GAMMA0),
        room_temperature=ROOM,
        melt_temperature=MELT,
    )


CASE = Case(
    name="steinberg-guinan",
    says="a point follows Steinberg, Cochran and Guinan's modulus, yield stress and melting curve",
    source="Steinberg, Cochran and Guinan (1980); Steinberg (1996), UCRL-MA-106439",
    run=_run,
    quick=False,
)
