"""Tension: what whole matter does when it is pulled.

A file adds one: a parameter record under ``TENSION`` with the method ``pressure_floor``. A sweep chooses it by name in
``tension``; its fields are ``FromMaterial`` or have a default. A material that goes without such a number bears any
tension. Where a file gives ``linking`` matter parts (``opening.py``).
"""

from typing import NamedTuple

from solver.jit import generic, overridable


class TensionEntry(NamedTuple):
    """Entry that a file of this folder offers as ``TENSION``."""

    name: str  # as ``tension`` in a sweep names it
    record: type
    molten: bool = False  # whether molten matter bears tension too
    opens: bool = False  # whether matter parts, and melts over a range of temperatures


@generic
def pressure_floor(tension, homologous, coherent):
    """Lowest pressure in Pa that matter sustains (negative is tension).

    It has a homologous temperature, and the part ``coherent`` of its cold strength (``melting.coherence``).
    """


@overridable
def linking(tension):
    """Void fraction at which voids link, so that matter has parted until they close; by default 1, and none does."""
    return 1.0


@overridable
def void_growth(tension, loading):
    """Logarithm of the factor by which plastic flow makes voids grow in a step with a ``PointLoading``; none."""
    return 0.0


@overridable
def opens_by_flow(tension, grown):
    """Whether voids link that flow has made grow by the exponential of ``grown``; by default never."""
    return grown < 0.0
