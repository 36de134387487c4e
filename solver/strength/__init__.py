"""Strength: the yield stress as a function of plastic strain, its rate and the homologous temperature.

A file adds one: a parameter record under ``STRENGTH`` and, for its type, the two factors of the yield stress,
``hardening`` and ``rate_and_heat``: sigma_y = hardening(eps_p) * rate_and_heat(rate, T*). Two factors, because the
return to the yield surface (written once, in ``stress.py``) iterates on the first and needs the logarithm and the
power of the second only once. ``tests/contracts/test_strength.py`` asks each member never to be negative, to return
to its surface, to dissipate and to be objective.
"""

from typing import NamedTuple

from solver.jit import device, generic


class StrengthEntry(NamedTuple):
    """What a file of this folder offers as ``STRENGTH``."""

    name: str
    record: type


@generic
def hardening(strength, plastic_strain):
    """Yield stress in Pa at the reference rate and room temperature; must not fall with plastic strain."""


@generic
def rate_and_heat(strength, strain_rate, homologous):
    """Factor of the yield stress; rate in 1/s, homologous = (T - T_room) / (T_melt - T_room) within 0..1."""


@device
def yield_stress(strength, plastic_strain, strain_rate, homologous):
    """Yield stress in Pa."""
    return hardening(strength, plastic_strain) * rate_and_heat(strength, strain_rate, homologous)


@device
def solid(homologous):
    """1 below the melting point, 0 at and above it."""
    if homologous >= 1.0:
        return 0.0
    return 1.0
