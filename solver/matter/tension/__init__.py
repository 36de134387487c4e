"""Tension: what whole matter does when it is pulled.

A file adds one: a parameter record under ``TENSION`` with the method ``pressure_floor``. A sweep chooses it by name in
``tension``; its fields are ``FromMaterial`` or have a default. A material that goes without such a number bears any
tension.
"""

from typing import NamedTuple

from solver.jit import generic


class TensionEntry(NamedTuple):
    """Entry that a file of this folder offers as ``TENSION``."""

    name: str  # as ``tension`` in a sweep names it
    record: type
    molten: bool = False  # whether molten matter bears tension too


@generic
def pressure_floor(tension, homologous):
    """Lowest pressure in Pa that matter at a homologous temperature sustains (negative is tension)."""
