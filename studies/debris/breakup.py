"""Sizes of the pieces of matter that parts at a strain rate: Grady (1988), J. Mech. Phys. Solids 36, 353.

A balance of the energy that breaking takes and of that which matter holds while its volume grows at a rate d, as in a
public code of his equations, where s = 2 c t with the time t of fracture::

    brittle   s = (sqrt(24) K_c / (rho c d))^(2/3)     K_c the fracture toughness
    ductile   s = (8 Y eps_c / (rho d^2))^(1/2)        Y the yield stress, eps_c the strain at which voids join
    liquid    s = (48 gamma / (rho d^2))^(1/3)         gamma the surface tension: brittle with K_c^2 = 2 rho c^2 gamma

Solid metal breaks in the way that takes less stress, so with the smaller of the first two: the stress is rho c d s / 2
in both. A size is None where no source states the constant.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from studies.scenarios.parts.matter import yield_stress

if TYPE_CHECKING:
    from studies.materials import Material

# Strain at which voids join: 0.15, Grady (1988); the default of the Grady spall model in the manual of Ansys Explicit
# Dynamics, section 11.11.8 (read), which states it for aluminium.
VOID_STRAIN = 0.15


@dataclass(frozen=True)
class Breakup:
    """Constants with which a strain rate says how fine matter breaks; None where no source states one."""

    density: float  # kg/m3
    sound_speed: float  # m/s
    yield_stress: float | None  # Pa, of the first slip
    fracture_toughness: float | None  # Pa m^0.5
    surface_tension: float | None  # N/m


def breakup_of(material: "Material") -> Breakup:
    """How matter breaks."""
    return Breakup(
        density=material.density,
        sound_speed=material.sound_speed,
        yield_stress=yield_stress(material),
        fracture_toughness=material.tension.fracture_toughness,
        surface_tension=material.tension.surface_tension,
    )


def brittle(matter: Breakup, rate: float) -> float | None:
    """Size of pieces (m) where toughness decides, at a rate of growth of the volume (1/s)."""
    if matter.fracture_toughness is None:
        return None
    ratio = math.sqrt(24.0) * matter.fracture_toughness / (matter.density * matter.sound_speed * rate)
    return float(ratio ** (2.0 / 3.0))


def ductile(matter: Breakup, rate: float) -> float | None:
    """Size of pieces (m) where the yield stress decides."""
    if matter.yield_stress is None:
        return None
    return math.sqrt(8.0 * matter.yield_stress * VOID_STRAIN / matter.density) / rate


def liquid(matter: Breakup, rate: float) -> float | None:
    """Size of drops (m)."""
    if matter.surface_tension is None:
        return None
    return math.cbrt(48.0 * matter.surface_tension / (matter.density * rate**2))


def solid(matter: Breakup, rate: float) -> float | None:
    """Size of pieces of a solid (m): the smaller of brittle and ductile, of those that are known."""
    known = [size for size in (brittle(matter, rate), ductile(matter, rate)) if size is not None]
    return min(known, default=None)
