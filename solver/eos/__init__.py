"""Equations of state: pressure as a function of density and internal energy.

A file adds one: a parameter record (a NamedTuple of floats and tables) under ``EOS``'s ``record``, and the device
functions below implemented for its type. ``tests/contracts/test_eos.py`` then asks it for p(rho0, 0) = 0, for a sound
speed equal to the derivative along the isentrope, and for finite answers at the corners.

The pressure is linear in the energy, p = a(rho) + b(rho) e, which is what lets the energy equation be solved together
with the pressure in closed form.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from solver.jit import generic


class EosEntry(NamedTuple):
    """What a file of this folder offers as ``EOS``."""

    name: str
    record: type  # parameter record; the device functions are chosen by it
    make: Callable[
        ..., Any
    ]  # the record from density, heat capacity, temperature and the form's own constants


@generic
def pressure_terms(eos, density):
    """(a, b) of p = a + b e, in Pa and kg/m3, at a density in kg/m3."""


@generic
def sound_speed_squared(eos, density, energy, pressure):
    """Square of the bulk sound speed dp/drho at constant entropy, m2/s2; not floored, may be negative in tension."""


@generic
def temperature(eos, density, energy):
    """Temperature in K of matter with a specific internal energy in J/kg; may fall below zero, the caller counts."""


@generic
def outside_range(eos, density):
    """True where the form is continued beyond the densities it was measured for."""


@generic
def below_range(eos, density):
    """True where matter is so thin that the form holds on to a constant."""


@generic
def reference_density(eos):
    """Density without pressure at zero internal energy, kg/m3."""


@generic
def reference_sound_speed(eos):
    """Bulk sound speed of the reference state, m/s."""
