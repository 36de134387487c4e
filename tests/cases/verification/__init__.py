"""Problems whose answer is known exactly, with the answers of the solver beside them.

How to add one: a module here that offers a ``VerificationCase`` as ``CASE``, or a tuple of cases. ``case`` makes one of
a function that takes the numerics (a ``Recipe``) and yields rows (``tests.claims.rows``). Where a figure was known
when its tolerance, or what it gates, was decided, the line says so: ``contact`` (parting, sliding), ``vibrating-bar``
(the finest pair), ``sph-elastic-waves`` (the gentle wave), ``sph-patch`` (forces), ``sod`` (GIMP), ``energy`` (the
hottest share), ``absorbing`` (the burst), ``absorbing-block`` (its size).
Exact answers are functions of ``solutions``; columns, collisions and impacts that several cases compute are in
``setups``. Each case is a claim by its own sentence (``tests/cases/test_verification.py``): ``make claims cases``.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from solver.registry import entries
from studies.quantities.numerical_defaults import RECIPES, Recipe
from tests.claims.rows import Row

DEFAULT = RECIPES["whipple"]

Computation = Callable[[Recipe], Iterable[Row]]


@dataclass(frozen=True)
class VerificationCase:
    """A problem with a known answer."""

    name: str
    says: str  # the sentence that its rows prove
    source: str
    run: Computation


def case(name: str, *, says: str, source: str) -> Callable[[Computation], VerificationCase]:
    """Make a case of the function that yields its rows."""
    return lambda run: VerificationCase(name, says, source, run)


def cases() -> Mapping[str, VerificationCase]:
    """All cases by name, sorted."""
    return entries(__name__, "CASE")
