"""Published problems, computed as ordinary sweeps, with the numbers of experiments and other codes beside.

How to add one: a module here that offers a ``ValidationCase`` as ``CASE``, and beside it a CSV file of its name with
the published numbers. ``sweeps`` gives the documents of a level:
``quick`` for a glance on coarse grids (all cases together take a core half a minute), ``thesis`` on the meshes of the
source, ``fine`` on three grids, which give the value without a mesh and its error bar. ``rows`` compares the cubes
with the table; its tolerances are stated before a run and belong to the mesh of the source: part of a published
agreement is its mesh, so that the converged value stands beside it as a report. Nothing is tuned.

The table has the columns ``note`` ("experiment", or the code that computed), ``source`` and ``confidence``, the
parameters and the quantities, with their units in the header (``studies.observations``). ``studies.cases.compared``
makes comparisons of a cube. Each case is a claim by its own sentence (``tests/studies/cases/test_published.py``).
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Literal, get_args

import xarray as xr

from solver.errors import WhippleError
from solver.registry import entries
from studies import observations, scenarios
from studies.cases.compared import Picture, PublishedNumber
from studies.quantities.comparison import Comparison
from studies.quantities.findings import nearest_cure, refusal
from studies.quantities.parameters import Plain
from studies.sweeps.reading import published_shots, vocabulary

ValidationLevel = Literal["quick", "thesis", "fine"]
LEVELS: tuple[ValidationLevel, ...] = get_args(ValidationLevel)
Cubes = Mapping[str, xr.Dataset]  # by the names of a case's sweeps
Document = Mapping[str, Plain]  # of a sweep


@dataclass(frozen=True, kw_only=True)
class ValidationCase:
    """A published problem."""

    name: str
    says: str  # the sentence that its rows prove
    source: str
    sweeps: Callable[[ValidationLevel], Mapping[str, Document]]  # documents by name
    rows: Callable[[ValidationLevel, Cubes], Iterable[Comparison]]
    pictures: Callable[[Cubes], Iterable[Picture]] = lambda cubes: ()

    def documents(self, level: ValidationLevel) -> Mapping[str, Document]:
        """Its sweeps by name, each with its own name in the document."""
        return {name: {"name": name, **document} for name, document in self.sweeps(level).items()}

    def compared(self, level: ValidationLevel, cubes: Cubes) -> Iterator[Comparison]:
        """Its comparisons one after the other; an error of the solver is one that failed."""
        try:
            yield from self.rows(level, cubes)
        except WhippleError as error:
            yield Comparison(self.says, "no error", f"{type(error).__name__}: {error}", passed=False)


def names() -> list[str]:
    """All cases, sorted."""
    return list(entries(__name__, "CASE"))


def load(name: str) -> ValidationCase:
    """The case of a name; raises InvalidInput with the nearest one."""
    cases: Mapping[str, ValidationCase] = entries(__name__, "CASE")
    if name not in cases:
        raise refusal("case", name, "a validation case", nearest_cure(name, cases))
    return cases[name]


def numbers_of(table: str, scenario: str) -> list[PublishedNumber]:
    """The numbers of a table beside a case, in its order; raises InvalidInput."""
    text = files(__package__).joinpath(f"{table}.csv").read_text(encoding="utf-8")
    terms = vocabulary(scenario, dict.fromkeys(scenarios.load(scenario).materials, ()), {})
    return [PublishedNumber(shot.note, shot) for shot in observations.read_observations(text, terms, table)]


def of_observations(table: str, scenario: str, by: str) -> list[PublishedNumber]:
    """The numbers of a published table of shots, all of them by the same."""
    return [PublishedNumber(by, shot) for shot in published_shots(table, scenario)]
