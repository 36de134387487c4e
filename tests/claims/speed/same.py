"""That the fast step gives the answers of the one before it, and that nothing else decides its bits.

The former step is that of its own tree (``tests.benchmarks.baseline``), whose return to yield goes on to round-off:
its tolerance, 1e-5 of the trial stress, is larger than what is compared here.
"""

import collections
import itertools
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tests.benchmarks.baseline import COMMIT, ROOT, NoHistory, former_tree, measured
from tests.benchmarks.measure import COARSE, PERTURBATION, STATE_STEPS
from tests.claims import Row, at_most, claim
from tests.claims.computed import rows_of_tests

CASES = list(itertools.product(COARSE, ("linear", "gimp", "quadratic-bspline"), ("musl", "usf", "usl")))
STATE = 1e-10  # of a field's largest value
PERTURBED = 10  # former runs with other round-off
LEAST = 1e-6  # of a diameter: spreads below it are not asked for

FIELDS = ("position", "velocity", "density", "energy", "pressure", "deviator", "plastic_strain", "temperature")


@claim(
    "former-state",
    says=f"after {STATE_STEPS} steps the state is the former one to 1e-10, for every shape, scheme and geometry",
)
def former_state() -> Iterator[Row]:
    try:
        with former_tree(tight=True) as tree, tempfile.TemporaryDirectory() as folder:
            places = Path(folder) / "ours", Path(folder) / "theirs"
            for where, place in zip((ROOT, tree), places, strict=True):
                place.mkdir()
                measured(where, "states", CASES, str(place))
            for case in CASES:
                file = f"{'-'.join(case)}.npz"
                name, worst = _largest_difference(*(np.load(place / file) for place in places))
                yield at_most(f"{', '.join(case)}: most in {name}", limit=STATE, got=worst)
    except NoHistory as error:
        yield Row(f"the tree of {COMMIT}", "in the history", str(error), None)


def _largest_difference(ours: Mapping[str, Any], theirs: Mapping[str, Any]) -> tuple[str, float]:
    """The field that differs most, and by how much of its largest value; one that holds a NaN before all others."""
    differences = {}
    for name in FIELDS:
        scale = np.abs(theirs[name]).max()
        differences[name] = float(np.abs(ours[name] - theirs[name]).max() / scale) if scale else 0.0
    name = max(differences, key=lambda each: np.nan_to_num(differences[each], nan=np.inf))
    return name, differences[name]


@claim(
    "former-runs",
    says="whole runs take the former number of steps and end with the former hole, within the spread of former runs "
    f"whose positions were changed by {PERTURBATION:g}, or 1e-6; where round-off decides the former steps and how a "
    "run ends, it is one of the former ends",
)
def former_runs() -> Iterator[Row]:
    try:
        with former_tree(tight=True) as tree:
            runs = measured(ROOT, "wholes", CASES, 0), measured(tree, "wholes", CASES, PERTURBED)
            for case, [ours], [theirs, *others] in zip(CASES, *runs, strict=True):
                where = ", ".join(case)
                counts = [each["steps"] for each in (theirs, *others)]
                within = min(counts) <= ours["steps"] <= max(counts)
                text = f"{where}: steps (former runs: {min(counts)} to {max(counts)})"
                yield Row(text, theirs["steps"], ours["steps"], within)
                yield _hole(where, ours["hole"], [each["hole"] for each in (theirs, *others)])
    except NoHistory as error:
        yield Row(f"the tree of {COMMIT}", "in the history", str(error), None)


def _hole(where: str, ours: float | str, theirs: list[float | str]) -> Row:
    """The former run is the first of theirs; a run that ended as unphysical has the quantity that was."""
    former = theirs[0]
    sizes = [each for each in theirs if isinstance(each, float)]
    if len(sizes) < len(theirs) or isinstance(ours, str) or isinstance(former, str):
        ends = collections.Counter("hole" if isinstance(each, float) else each for each in theirs)
        end = "hole" if isinstance(ours, float) else ours
        return Row(f"{where}: end (former runs: {dict(ends)})", former, ours, end in ends)
    spread = max(max(sizes) - min(sizes), LEAST * former)
    text = f"{where}: hole against {1e3 * former:.6f} mm (m)"
    return at_most(text, limit=spread, got=abs(ours - former))


@claim("same-bits", says="two threads and a restart change no bit, plain Python only round-off")
def same_bits() -> Iterator[Row]:
    for test in (
        "solver/test_threads.py::test_step__gives_the_same_bits_with_any_number_of_threads",
        "solver/test_step.py::test_scheme__gives_the_same_bits_with_any_number_of_threads",
        "solver/test_checkpoint.py::test_restart__ends_with_the_bits_of_a_run_that_never_stopped",
        "solver/test_jit.py::test_step__gives_the_same_numbers_without_the_compiler",
    ):
        yield from rows_of_tests(f"tests/{test}")


@claim("nan-seen", says="a NaN in any field ends the run, and no lane of eight hides it")
def nan_seen() -> Iterator[Row]:
    for test in (
        "solver/test_simulation.py::test_nan__in_any_field_ends_the_run_within_three_steps",
        "solver/test_vectors.py::test_reductions__pass_over_a_nan_or_show_it",
    ):
        yield from rows_of_tests(f"tests/{test}")
