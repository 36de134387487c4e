"""Published problems computed on this machine, with their page."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from service.cli.local import STORE_OF_FOLDER, ShowProgress, run_sweeps
from service.settings import Settings
from studies.cases import validation
from studies.cases.pages import ComputedCase, write_page
from studies.cases.validation import Cubes, ValidationCase, ValidationLevel
from studies.cubes.opening import whole_cube
from studies.quantities.comparison import Comparison

STORE = STORE_OF_FOLDER


def selected(names: Sequence[str]) -> list[ValidationCase]:
    """Cases of the names, or all; raises InvalidInput."""
    return [validation.load(name) for name in dict.fromkeys(names or validation.names())]


def validated(
    cases: Sequence[ValidationCase], level: ValidationLevel, out: Path, settings: Settings, showing: ShowProgress
) -> Iterator[tuple[str, Comparison]]:
    """Compute cases, and yield each comparison with the name of its case as it is known; writes a page of all.

    The sweeps of all cases are computed together, each into ``out/CASE/SWEEP``. An error of the solver is a comparison
    that failed.
    """
    done = []
    for case, cubes in _computed(cases, level, out, settings, showing):
        comparisons = []
        for comparison in case.compared(level, cubes):
            comparisons.append(comparison)
            yield case.name, comparison
        done.append(ComputedCase(case, comparisons, cubes))
        write_page(done, level, out)


def _computed(
    cases: Sequence[ValidationCase], level: ValidationLevel, out: Path, settings: Settings, showing: ShowProgress
) -> Iterator[tuple[ValidationCase, Cubes]]:
    """Each case with its cubes by name, as the last of its sweeps ends."""
    documents = {f"{case.name}/{name}": document for case in cases for name, document in case.documents(level).items()}
    named, waiting = {case.name: case for case in cases}, dict[str, Cubes]()
    for place, finished in run_sweeps(documents, out, showing=showing, settings=settings):
        case_name, name = place.split("/")
        case, cubes = named[case_name], {**waiting.get(case_name, {}), name: whole_cube(finished.folder)}
        waiting[case_name] = cubes
        if len(cubes) == len(case.sweeps(level)):
            yield case, cubes
