"""Verification: problems whose answer is known exactly, with the answers of the solver beside them.

How to add one: a module here that offers a ``VerificationCase`` as ``CASE``, or a tuple of cases. ``case`` makes one of
a function that takes the numerics (a ``Recipe``) and yields rows (``studies.cases.rows``). Where a figure was known
when its tolerance, or what it gates, was decided, the line says so: ``contact`` (parting, sliding), ``vibrating-bar``
(the finest pair), ``sph-elastic-waves`` (the gentle wave), ``sph-patch`` (forces), ``sod`` (GIMP), ``energy`` (the
hottest share), ``absorbing`` (the burst), ``absorbing-block`` (its size).
Exact answers are functions of ``studies.cases.solutions``, and columns, collisions and impacts that several cases
compute are in ``studies.cases.setups``. A case loads the solver; this module does not.

``verify`` runs cases and ``whipple validate`` prints them. Each case is a claim of ``tests/claims`` by its own
sentence, and the test command runs the quick ones.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial

from solver.errors import WhippleError
from solver.registry import entries
from studies.cases.rows import Row, Verified, timed
from studies.quantities.findings import nearest_cure, refusal
from studies.quantities.numerical_defaults import RECIPES, Recipe

DEFAULT = RECIPES["whipple"]


Computation = Callable[[Recipe], Iterable[Row]]


@dataclass(frozen=True)
class VerificationCase:
    """A problem with a known answer."""

    name: str
    says: str  # the sentence that its rows prove
    source: str
    run: Computation
    quick: bool = True  # below ten seconds with kernels from the cache: part of the test command


def case(name: str, *, says: str, source: str, quick: bool = True) -> Callable[[Computation], VerificationCase]:
    """Make a case of the function that yields its rows."""
    return lambda run: VerificationCase(name, says, source, run, quick)


def names(*, quick: bool = False) -> list[str]:
    """All cases, or the quick ones, sorted."""
    return [name for name, case in entries(__name__, "CASE").items() if case.quick or not quick]


def load(name: str) -> VerificationCase:
    """The case of a name; raises InvalidInput with the nearest one."""
    cases: Mapping[str, VerificationCase] = entries(__name__, "CASE")
    if name not in cases:
        raise refusal("case", name, "a verification case", nearest_cure(name, cases))
    return cases[name]


def verify(chosen: Iterable[str], recipe: Recipe = DEFAULT) -> Iterator[Verified]:
    """Run cases one after the other; an error of the solver is a row that failed."""
    for name in chosen:
        case = load(name)
        yield from timed(name, case.says, partial(case.run, recipe), WhippleError)
