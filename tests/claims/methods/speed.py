"""Cost of a step of a smoothed particle and of an element, with one thread and two, by the code of ``make bench``."""

from collections.abc import Iterator

from tests.benchmarks import figures
from tests.benchmarks.measure import BARS
from tests.claims import Row, claim
from tests.claims.computed import rows_of_tests

SIZE = "12k"


@claim(
    "methods-speed",
    says="a step of smoothed particles, hexahedra and quadrilaterals costs what is shown, by one thread and by two, "
    "which change no bit of any of them",
    minutes=6.0,
)
def methods_speed() -> Iterator[Row]:
    for test in (
        "solver/test_sph.py::test_impact__has_the_same_bits_with_two_threads",
        "solver/test_fem.py::test_two_threads_give_the_same_bits",
        "solver/test_coupling.py::test_threads_and_a_checkpoint_give_the_same_bits",
    ):
        yield from rows_of_tests(f"tests/{test}")
    for name, got in figures.steps(f"{family}_{SIZE}" for family in ("3d_sph", *BARS)):
        yield Row(name, "", got, None)
