"""Finite elements: plane impact, an elastic step wave, Sod's tube, Noh's plane, a turned block and a skewed patch."""

from collections.abc import Iterator

from studies.quantities.numerical_defaults import Recipe
from tests.cases.verification import case, elastic_waves, noh, patch, plate_impact, sod
from tests.claims.rows import Row


@case(
    "finite-elements",
    says="finite elements hold plane impact, an elastic wave, Sod's tube, Noh's plane and patches of skewed elements, "
    "and keep momentum and energy to round-off",
    source="Rankine and Hugoniot; d'Alembert; Sod (1978), J. Comput. Phys. 27, 1; Noh (1987), J. Comput. Phys. 72, 78; "
    "patch test: Irons and Razzaque (1972)",
)
def _run(recipe: Recipe) -> Iterator[Row]:
    for problem in (plate_impact, elastic_waves, sod, noh, patch):
        yield from problem.of_elements()


CASE = _run
