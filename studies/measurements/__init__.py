"""Measurements: numbers read off a state of a run, each with its own parts of uncertainty and flags.

How to add one: a module here that offers a ``Measurement`` as ``MEASUREMENT``, or a tuple of them where one quantity
is read of several bodies; modules whose name starts with an underscore are shared. A measurement reads one state,
through the view of its family of scenarios: an impact (``_impact``), its debris
(``_cloud``), a bar (``_bar``), two plates (``_plates``). A view
hides whether the model was a body of revolution or a quarter in three dimensions. A measurement of the course of a run
(when contact ended, the largest pull) names other measurements that it ``follows`` and reads their ``History``.
Contract tests give it states with a known answer (a drilled disc, a scooped half space, a stretched bar) and shuffle
the particles. ``version`` grows when the definition changes, that of its uncertainty included: a stored state is then
read again, not solved again.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from solver.registry import entries
from studies.values.results import ERROR_UNKNOWN, numerical_parts

if TYPE_CHECKING:
    import numpy as np

# A shift of the plate against the grid by part of a cell moved prototype holes by 0.9, 0.3 and 0.2 mm at cells of 1,
# 0.5 and 0.25 mm: about one cell is what a single run cannot tell.
RESOLUTION_IN_CELLS = 1.0


@dataclass(frozen=True)
class Reading:
    """A measurement at one time."""

    value: float  # NaN where the flags say why there is none
    # Parts of its standard uncertainty, in the same unit; that of its definition is no numerical one.
    parts: Mapping[str, float] = field(default_factory=dict)
    flags: tuple[str, ...] = ()


@dataclass(frozen=True)
class History:
    """Readings of other measurements at each observation so far."""

    times: "np.ndarray"  # (n,) s
    values: Mapping[str, "np.ndarray"]  # (n,) of each measurement, NaN where it had none


@dataclass(frozen=True)
class Measurement:
    """A quantity that can be measured: its name, unit, meaning and definition."""

    name: str
    title: str
    unit: str
    meaning: str
    version: int
    read: Callable[[Any], Reading]  # reads a view, or the History of the measurements that it follows
    follows: tuple[str, ...] = ()  # measurements of one state
    widest: float = math.inf  # uncertainty over value, above which a value is flagged "wide_bar"
    # Whether the mesh decides the value: flagged "mesh_determined", unless a cube has it on three grids.
    mesh_determined: bool = False
    # Whether it is 1 or 0, so that a sweep may search for the limit between them.
    is_outcome: bool = False

    def uncertainty_by(self, parts: Mapping[str, float]) -> tuple[float | None, tuple[str, ...]]:
        """Uncertainty of a value by its parts, and the flag of a value of which none of them tells any.

        Never 0: the mesh decides every number but the 1 or 0 of an outcome, which has no uncertainty.
        """
        size = math.hypot(*numerical_parts(parts).values())
        is_flagged = size > 0.0 or self.is_outcome or self.mesh_determined
        return size or None, () if is_flagged else (ERROR_UNKNOWN,)


def names() -> list[str]:
    """All measurements, sorted."""
    return list(entries(__name__, "MEASUREMENT"))


def load(name: str) -> Measurement:
    """The measurement of a name; KeyError for an unknown one."""
    measurement: Measurement = entries(__name__, "MEASUREMENT")[name]
    return measurement
