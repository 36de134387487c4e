"""Validation and verification cases computed on this machine, with their pages."""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from service.cli.local import STORE_OF_FOLDER, ShowProgress, run_sweeps
from service.settings import Settings
from solver.errors import WhippleError
from studies.cases import validation, verification
from studies.cases.pages import write_case, write_index
from studies.cases.rows import Verified, timed
from studies.cases.validation import Cubes, ValidationCase, ValidationLevel
from studies.cases.verification import VerificationCase, verify
from studies.cubes.reading import open_cube
from studies.quantities.findings import nearest_cure, refusal

STORE = STORE_OF_FOLDER
KINDS = ("validation", "verification")


def selected(names: Sequence[str], level: ValidationLevel) -> list[VerificationCase | ValidationCase]:
    """Cases of the names, or of all; of whole kinds, at ``quick``, those of seconds. Raises InvalidInput."""
    quick = level == "quick"
    of_kinds: Mapping[str, list[VerificationCase | ValidationCase]] = {
        "validation": [validation.load(name) for name in validation.names()],
        "verification": [verification.load(name) for name in verification.names(quick=quick)],
    }
    by_name: dict[str, VerificationCase | ValidationCase] = {
        name: package.load(name) for package in (verification, validation) for name in package.names()
    }
    chosen: dict[str, VerificationCase | ValidationCase] = {}
    for name in names or KINDS:
        if name in of_kinds:
            chosen |= {case.name: case for case in of_kinds[name]}
        elif name in by_name:
            chosen[name] = by_name[name]
        else:
            cure = nearest_cure(name, [*KINDS, *by_name])
            raise refusal("case", name, "a case, validation or verification", cure)
    return list(chosen.values())


def validated(
    cases: Sequence[VerificationCase | ValidationCase],
    level: ValidationLevel,
    out: Path,
    settings: Settings,
    showing: ShowProgress,
) -> Iterator[Verified]:
    """Compute cases, and yield each row as it is known; writes a page for each case, and an index.

    The sweeps of all cases are computed together, each into ``out/CASE/SWEEP``. An error of the solver is a row that
    failed.
    """
    done: list[tuple[VerificationCase | ValidationCase, list[Verified]]] = []
    for case in cases:
        if isinstance(case, VerificationCase):
            rows: list[Verified] = []
            for row in verify([case.name]):
                rows.append(row)
                yield row
            write_case(case, rows, {}, out)
            done.append((case, rows))
    published = [case for case in cases if isinstance(case, ValidationCase)]
    for case, cubes in _computed(published, level, out, settings, showing):
        rows = []
        for row in timed(case.name, case.says, partial(case.rows, level, cubes), WhippleError):
            rows.append(row)
            yield row
        write_case(case, rows, cubes, out)
        done.append((case, rows))
    write_index(done, level, out)


def _computed(
    cases: Sequence[ValidationCase], level: ValidationLevel, out: Path, settings: Settings, showing: ShowProgress
) -> Iterator[tuple[ValidationCase, Cubes]]:
    """Each case with its cubes by name, as the last of its sweeps ends."""
    documents = {f"{case.name}/{name}": document for case in cases for name, document in case.documents(level).items()}
    if not documents:
        return
    waiting: dict[str, tuple[ValidationCase, dict[str, Any]]] = {case.name: (case, {}) for case in cases}
    for place, finished in run_sweeps(documents, out, showing=showing, settings=settings):
        case_name, name = place.split("/")
        case, cubes = waiting[case_name]
        cubes[name] = open_cube(finished.folder)
        if len(cubes) == len(case.sweeps(level)):
            yield case, cubes
