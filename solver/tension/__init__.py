"""Tension: what whole matter does when it is pulled.

A file adds one: a parameter record under ``TENSION`` and ``pressure_floor`` for its type.
"""

from typing import NamedTuple

from solver.jit import generic


class TensionEntry(NamedTuple):
    """What a file of this folder offers as ``TENSION``."""

    name: str
    record: type


@generic
def pressure_floor(tension, homologous):
    """Lowest pressure in Pa that matter at a homologous temperature sustains (negative is tension)."""
