"""Equations of state: pressure as a function of density and internal energy.

A file adds one: a parameter record (a NamedTuple of floats and tables) under ``EOS``'s ``record``, with the
functions below as its methods, without ``if``, so that they act on eight points at a time. A material file
gives the fields that are ``Described``; ``Density``, ``HeatCapacity`` and ``RoomTemperature`` are those of the rest of
the material; ``make`` computes the others, which have defaults. A form with any other field is for verification alone.
``tests/contracts/test_eos.py`` then asks it for p(rho0, 0) = 0, for a sound speed equal to the derivative along the
isentrope, and for finite answers at the corners.

The pressure is handed out as its tangent in the energy, p = a + b e: where it is linear in it, as in Mie and
Grueneisen's forms, the energy equation is solved together with the pressure in closed form, and elsewhere by Newton's
rule. ``solve_pressure`` does both.
"""

from collections.abc import Callable
from typing import NamedTuple, Protocol

from solver.jit import Record, device, generic, overridable
from solver.vectors import alike, maximum


class EosRecord(Record, Protocol):
    """The parameters of an equation of state."""

    @property
    def density(self) -> float:
        """Density of the reference state, kg/m3."""

    @property
    def heat_capacity(self) -> float:
        """Heat capacity at constant volume, J/(kg K)."""

    @property
    def temperature(self) -> float:
        """Temperature of the reference state, K."""


class EosEntry(NamedTuple):
    """Entry that a file of this folder offers as ``EOS``."""

    name: str  # as a material file names it
    record: type  # parameter record; the device functions are chosen by it
    make: Callable[..., EosRecord]  # the complete record, from its fields without default
    kind: str = ""  # name of another form whose materials this one can compute too
    # As ``eos_form`` in a sweep names it: for materials of its kind, or of any where it needs no constant of its own.
    form: str = ""
    boils: bool = False  # its vapour bears no tension: melting has to end tension before


@generic
def pressure_terms(eos, density, energy):
    """(a, b) of the tangent p = a + b e, in Pa and kg/m3, at a density in kg/m3 and an energy in J/kg."""


@overridable
def linearisations(eos):
    """Number of tangents that it takes to solve for the energy; by default the pressure is linear in the energy."""
    return 1


@generic
def sound_speed_squared(eos, density, energy, pressure):
    """Square of the bulk sound speed dp/drho at constant entropy, m2/s2; not floored, may be negative in tension."""


@generic
def temperature_at(eos, density, energy):
    """Temperature in K of matter with a specific internal energy in J/kg; may fall below zero, the caller counts."""


@overridable
def outside_range(eos, density):
    """True where the form is continued beyond the densities it was measured for; by default nowhere."""
    return False


@overridable
def below_range(eos, density):
    """True where matter is so thin that the form holds on to a constant; by default nowhere."""
    return False


@overridable
def reference_density(eos):
    """Density without pressure at zero internal energy, kg/m3; by default the record's own."""
    return eos.density


@generic
def reference_sound_speed(eos):
    """Bulk sound speed of the reference state, m/s."""


@overridable
def burns(eos):
    """True for an explosive, whose particles are lit at times of their own (``Body.lighting``); by default False."""
    return False


@overridable
def burning(eos, table, p, lanes, time, spacing):
    """The parameters of eight particles from p on, with what has burnt at a time (s) in cells of a size (m).

    By default those of the body.
    """
    return eos


@device
def density_at_rest(eos, energy):
    """Density in kg/m3 of matter without pressure that has an energy in J/kg, by the stiffness of the cold matter."""
    cold = reference_density(eos)
    _, heat = pressure_terms(eos, alike(cold, energy), energy)
    modulus = cold * reference_sound_speed(eos) * reference_sound_speed(eos)
    return cold * modulus / (modulus + heat * maximum(energy, 0.0))


@device
def solve_pressure(eos, density, known, expansion, guess, floor):
    """Pressure p(rho, e) in Pa of the energy e = known - max(p, floor) expansion / 2 (J/kg), expansion in m3/kg.

    ``guess`` lies near e; the answer itself is not floored.
    """
    pressure = _by_tangent(eos, density, known, expansion, guess)
    for _ in range(1, linearisations(eos)):
        guess = known - 0.5 * maximum(pressure, floor) * expansion
        pressure = _by_tangent(eos, density, known, expansion, guess)
    return pressure


@device
def _by_tangent(eos, density, known, expansion, energy):
    """The pressure with p(e) replaced by its tangent at an energy."""
    a, b = pressure_terms(eos, density, energy)
    return (a + b * known) / (1.0 + 0.5 * b * expansion)
