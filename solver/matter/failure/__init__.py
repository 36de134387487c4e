"""Failure: what breaks matter for good; a failed point bears no tension, and no shear but the friction of rubble.

A file adds one: a parameter record under ``FAILURE`` with methods ``grown_damage`` and ``floor_until_failure``. A
sweep chooses it by name in ``failure`` and gives a field x of it that is ``Described`` as ``failure_x``; other fields
are ``FromMaterial`` or have a default. A material with which matter fails at its first slip is refused.
Damage 0 is whole and damage 1 has failed. Between them it is a record of what happened, and weakens only where a file
gives ``weakens`` and ``integrity``: there the yield stress is that of the strength times the integrity, its hardening
counts each plastic strain times the integrity, and pressure and elastic stiffness stay those of whole matter; or opens
where a file gives ``opens`` and ``void_fraction``: there the pressure is that of the matter between the voids.
``tests/contracts/test_failure.py`` asks each member that damage stays within 0..1, never falls, and that what has
failed carries no tension, and no shear without a ``rubble_friction`` of its matter.
"""

import math
from typing import NamedTuple

from solver.jit import device, generic, overridable
from solver.vectors import where


class FailureEntry(NamedTuple):
    """Entry that a file of this folder offers as ``FAILURE``."""

    name: str  # as ``failure`` in a sweep names it
    record: type


class PointLoading(NamedTuple):
    """What a point bears in a step, as failures see it."""

    plastic_strain: float  # at the end of the step
    slip: float  # plastic strain of the step
    # Pa, negative in tension: the one that the point carries, not below ``floor_until_failure``.
    pressure: float
    # Mean over equivalent stress, positive in tension: the stress that the point carries, weakened or not.
    triaxiality: float
    strain_rate: float  # equivalent, of the total deviatoric strain, 1/s
    homologous: float  # (T - T_room) / (T_melt - T_room) within 0..1
    dt: float  # s
    coherent: float = 1.0  # part of the cold strength that melting leaves, as of ``melting.coherence``


@generic
def grown_damage(failure, damage, loading):
    """Damage 0..1 after a step with a ``PointLoading``."""


@overridable
def weakens(failure):
    """True where damage weakens strength before matter has failed; by default it does not."""
    return False


@overridable
def integrity(failure, damage):
    """Part 0..1 of the yield stress that damage leaves; by default all of it."""
    return 1.0


@overridable
def opens(failure):
    """True where damage is voids, which take up volume under tension; by default it is not."""
    return False


@overridable
def void_fraction(failure, damage):
    """Part 0..1 of the volume that is voids while matter bears tension; by default none."""
    return 0.0


@overridable
def floor_until_failure(failure, floor):
    """Lowest pressure in Pa until matter fails; by default the ``floor`` of the rule of tension."""
    return floor


@device
def without_floor(floor):
    """No lowest pressure but that of molten matter, which is 0: for failures that limit tension themselves."""
    return where(floor < 0.0, -math.inf, floor)
