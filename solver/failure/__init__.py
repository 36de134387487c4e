"""Failure: what breaks matter for good; a failed point bears neither shear nor tension.

A file adds one: a parameter record under ``FAILURE``, and ``grown_damage`` and ``floor_until_failure`` for its type. A
sweep chooses it by name in ``failure`` and gives a field x of it that is ``Described`` as ``failure_x``; other fields
are ``FromMaterial`` or have a default.
Damage 0 is whole and damage 1 has failed; between them it is a record of what happened and weakens nothing.
``tests/contracts/test_failure.py`` asks each member that damage stays within 0..1, never falls, and that what has
failed carries no shear and no tension.
"""

from typing import NamedTuple

from solver.jit import generic, implements


class FailureEntry(NamedTuple):
    """Entry that a file of this folder offers as ``FAILURE``."""

    name: str  # as ``failure`` in a sweep names it
    record: type


@generic
def grown_damage(failure, damage, plastic_strain, pressure, dt):
    """Damage 0..1 after a step of dt (s) that ends at a plastic strain and at a pressure (Pa, negative is tension).

    The pressure is the one that whole matter carries, not below ``floor_until_failure``.
    """


@generic
def floor_until_failure(failure, floor):
    """Lowest pressure in Pa that matter sustains until it fails, where the rule of tension says ``floor``."""


@implements(floor_until_failure, object)
def _(failure, floor):
    """By default as the rule of tension says."""
    return floor
