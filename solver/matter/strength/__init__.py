"""Strength: the yield stress as a function of plastic strain, its rate and the homologous temperature.

A file adds one: a parameter record under ``STRENGTH``, whose ``Described`` fields a material file gives ("none" becomes
infinity where a field allows None), with the method ``hardening`` and, where more than melting matters,
``rate_and_heat``: sigma_y = hardening(eps_p) * rate_and_heat(rate, T*, G / G0). Two factors, because the return to the
yield surface (written once, in ``stress.py``) iterates on the first, with its slope, and needs the logarithm and the
power of the second only once. A form of which plastic work does not all become heat gives ``stored_part``. A form that
knows how the shear modulus follows the state says so in ``stiffness``, and one that depends on the pressure in
``under_pressure``; all melt by the curve of ``matter/melting.py``. ``tests/contracts/test_strength.py`` asks each
member never to be negative, to return to its surface, to dissipate and to be objective.
"""

from typing import NamedTuple

from solver.jit import device, generic, overridable
from solver.vectors import minimum, where


class StrengthEntry(NamedTuple):
    """Entry that a file of this folder offers as ``STRENGTH``."""

    name: str  # as a material file names it
    record: type
    melts: bool = False  # whether it was fitted with a melting point, which is then a constant of its own


@generic
def hardening(strength, plastic_strain):
    """Yield stress at the reference rate, room temperature and rest, and its slope over plastic strain; both in Pa.

    The stress must not fall with plastic strain, and the slope must not grow; one that is infinite counts as zero.
    """


@overridable
def rate_and_heat(strength, strain_rate, homologous, stiff):
    """Factor of the yield stress; rate in 1/s, homologous = (T - T_room) / (T_melt - T_room) within 0..1.

    ``stiff`` is the ``stiffness`` of the same state. By default 1 until matter melts.
    """
    return solid(homologous)


@device
def solid(homologous):
    """1 below the melting point, 0 at and above it."""
    return where(homologous >= 1.0, 0.0, 1.0)


@overridable
def stiffness(strength, density_ratio, pressure, kelvin):
    """Shear modulus over that at rest, above 0; density_ratio = rho / rho0, pressure in Pa, temperature in K.

    By default constant, and less where matter is thin.
    """
    return minimum(density_ratio, 1.0)


@overridable
def under_pressure(strength, eos, density, energy):
    """The parameters at a density (kg/m3) and an energy (J/kg); by default the same at every pressure."""
    return strength


@overridable
def stored_part(strength):
    """Part 0..1 of the plastic work that stays in the matter and does not become heat; by default none."""
    return 0.0


@device
def yield_stress(strength, plastic_strain, strain_rate, homologous, stiff=1.0):
    """Yield stress in Pa."""
    stress, _ = hardening(strength, plastic_strain)
    return stress * rate_and_heat(strength, strain_rate, homologous, stiff)
