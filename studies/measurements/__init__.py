"""Measurements: numbers read off a state of a run, each with its own parts of uncertainty and flags.

A family is a module in which its definitions stand together: the hole of an impact (``hole``), its crater (``crater``);
features offer theirs through entry points. ``view`` of a family makes its view of a snapshot, whatever the geometry; it
imports the solver, which compiles for seconds, only then. Arrays over bins are ``distributions``.

How to add one: a function in its family, ``measurement`` above it, and its name in the family's ``MEASUREMENT``. A new
family is a module here that offers one ``Measurement``, or a tuple of several, as ``MEASUREMENT``. A measurement reads
one state, or, of the course of a run (when contact ended, the largest pull), names other measurements that it
``follows`` and reads their ``History``. Contract tests give it states with a known answer (a drilled disc, a scooped
half space, a stretched bar) and shuffle the particles. ``version`` grows when the definition changes, that of its
uncertainty included: a stored state is then read again, not solved again.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Required, TypedDict, Unpack

from solver.registry import entries
from studies.quantities.measured import ERROR_UNKNOWN, numerical_parts

if TYPE_CHECKING:
    import numpy as np

# A shift of the plate against the grid by part of a cell moved prototype holes by 0.9, 0.3 and 0.2 mm at cells of 1,
# 0.5 and 0.25 mm: about one cell is what a single run cannot tell.
RESOLUTION_IN_CELLS = 1.0


class View:
    """A state as the measurements of a family see it."""


class OnGrid(View):
    """A view whose lengths are known to a cell."""

    cell: float  # m

    @property
    def resolution(self) -> float:
        """Standard uncertainty of a length that one run cannot see, m."""
        return RESOLUTION_IN_CELLS * self.cell


@dataclass(frozen=True)
class Reading:
    """A measurement at one time."""

    value: float  # NaN where the flags say why there is none
    # Parts of its standard uncertainty, in the same unit; that of its definition is no numerical one.
    parts: Mapping[str, float] = field(default_factory=dict)
    flags: tuple[str, ...] = ()


class NoValue(Exception):
    """A state, or a history, has no value of a measurement; the flags that say why are its arguments."""


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
    # The reading of a view of its family, or of the History of the measurements that it follows; raises NoValue.
    definition: Callable[..., Reading]
    version: int = 1
    follows: tuple[str, ...] = ()  # measurements of one state
    widest: float = math.inf  # uncertainty over value, above which a value is flagged ``WIDE_BAR``
    # Whether the mesh decides the value: flagged "mesh_determined", unless a cube has it on three grids.
    mesh_determined: bool = False
    # What the values 0 and 1 of an outcome mean, in words: a sweep may search for the limit between them.
    outcomes: tuple[str, ...] = ()

    def read(self, state: View | History) -> Reading:
        """The reading of a view, or of a history."""
        try:
            return self.definition(state)
        except NoValue as none:
            return Reading(math.nan, flags=none.args)

    @property
    def is_outcome(self) -> bool:
        """Whether it is 1 or 0."""
        return bool(self.outcomes)

    def is_wide(self, value: float | None, uncertainty: float | None) -> bool:
        """Whether the uncertainty of a value exceeds ``widest``."""
        return bool(value is not None and uncertainty and uncertainty > self.widest * abs(value))

    def uncertainty_by(self, parts: Mapping[str, float]) -> tuple[float | None, tuple[str, ...]]:
        """Uncertainty of a value by its parts, never 0; None where they tell none, and then the flag that says so."""
        size = math.hypot(*numerical_parts(parts).values())
        is_flagged = size > 0.0 or self.is_outcome or self.mesh_determined
        return size or None, () if is_flagged else (ERROR_UNKNOWN,)


class Fields(TypedDict, total=False):
    """The fields of a measurement besides its name and definition."""

    title: Required[str]
    unit: Required[str]
    meaning: Required[str]
    version: int
    follows: tuple[str, ...]
    widest: float
    outcomes: tuple[str, ...]


def measurement(**fields: Unpack[Fields]) -> Callable[[Callable[..., Reading]], Measurement]:
    """Make a function that reads a view, or a history, the measurement of its name with these fields."""
    return lambda definition: Measurement(name=definition.__name__, definition=definition, **fields)


def names() -> list[str]:
    """All measurements, sorted."""
    return list(entries(__name__, "MEASUREMENT"))


def load(name: str) -> Measurement:
    """The measurement of a name; KeyError for an unknown one."""
    return entries(__name__, "MEASUREMENT")[name]
