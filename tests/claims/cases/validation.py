"""The validation cases: each is a claim by its own sentence, on three grids; all together on coarse ones are quick.

Their pages are opened in a browser. With all of these the set takes a core more than an hour; each case has a name of
its own, so that ``make claims NAME`` recomputes it alone.
"""

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import xarray as xr

from service.cli.validation import STORE, selected, validated
from service.records.settings import Settings
from studies import validation
from studies.cubes import cube
from studies.runs.execution import execute
from studies.sweeps.sweep import Sweep
from studies.validation import Level
from tests.acceptance.support.browser import SCHEMES, WIDTHS, chromium, look, rows_of
from tests.claims import Claim, Row, claim

BY_COMMAND = "taylor-bar"  # a single run


@contextmanager
def _unwatched(name: str) -> Iterator:
    yield lambda status: None


def _rows(names: Sequence[str], level: Level) -> Iterator[Row]:
    with tempfile.TemporaryDirectory(prefix="whipple-claims-") as folder:
        settings = Settings(data=Path(folder) / STORE)
        cases = selected(names, level)
        for each in validated(cases, level, Path(folder), settings, _unwatched):
            yield each.row


def _quick_rows() -> Iterator[Row]:
    """The rows of all cases: of one by the command, of the others without its service and reports, which cost most."""
    yield from _rows([BY_COMMAND], "quick")
    for case in map(validation.load, validation.names()):
        if case.name != BY_COMMAND:
            cubes = {name: _cube(document) for name, document in case.documents("quick").items()}
            yield from case.rows("quick", cubes)


def _cube(document: Mapping[str, Any]) -> xr.Dataset:
    """The cube of a sweep that is computed in this process."""
    sweep = Sweep.parse(document)
    with tempfile.TemporaryDirectory(prefix="whipple-claims-") as folder:
        results = {point.run.id: execute(point.run, Path(folder), threads=1) for point in sweep.runs()}
    return cube.build(sweep, results)


@claim(
    "validation-pages",
    says="index and pages of `whipple validate`, in Chromium at 400 and 1400 px, light and dark: no message, no "
    "request, nothing cut off and no serious violation of accessibility",
)
def validation_pages() -> Iterator[Row]:
    names = ["elastic-bar", "hole-laws", "taylor-bar"]
    with tempfile.TemporaryDirectory(prefix="whipple-claims-") as folder, chromium() as browser:
        out = Path(folder)
        settings = Settings(data=out / STORE)
        for _ in validated(selected(names, "quick"), "quick", out, settings, _unwatched):
            pass
        for name in ("index", *names):
            for width in WIDTHS:
                for scheme in SCHEMES:
                    seen = look(browser, out / f"{name}.html", width, scheme)
                    yield from rows_of(seen, f"{name}, {width} px, {scheme}")


# Of a core: by particle-steps and 0.1 us each, measured 2026-11-23.
MINUTES = {"hole-laws": 50.0, "table-3-3-half-model": 9.0, "table-3-4-half-model": 16.0}
CLAIMS = [
    Claim(name, validation.load(name).says, partial(_rows, [name], "fine"), minutes=MINUTES.get(name, 0.0))
    for name in validation.names()
]
CLAIMS += [
    Claim(
        f"{name}-half-model",
        f"{name} in three dimensions, the thesis' half model on cells of 1 mm",
        partial(_rows, [name], "thesis"),
        minutes=MINUTES[f"{name}-half-model"],
    )
    for name in ("table-3-3", "table-3-4")
]
CLAIMS.append(Claim("validation-quick", "every validation case holds on coarse grids", _quick_rows, quick=True))
