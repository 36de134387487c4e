"""The validation cases: each is a claim by its own sentence, on three grids; all together on coarse ones are quick.

Their pages are opened in a browser.
"""

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from service.cli.validation import STORE, selected, validated
from service.records.settings import Settings
from studies import validation
from studies.validation import Level
from tests.acceptance.support.browser import SCHEMES, WIDTHS, chromium, look, rows_of
from tests.claims import Claim, Row, claim


@contextmanager
def _unwatched(name: str) -> Iterator:
    yield lambda status: None


def _rows(names: Sequence[str], level: Level) -> Iterator[Row]:
    with tempfile.TemporaryDirectory(prefix="whipple-claims-") as folder:
        settings = Settings(data=Path(folder) / STORE)
        cases = selected(names, level)
        for each in validated(cases, level, Path(folder), settings, _unwatched):
            yield each.row


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


CLAIMS = [
    Claim(name, validation.load(name).says, partial(_rows, [name], "fine"))
    for name in validation.names()
]
CLAIMS.append(
    Claim(
        "validation-quick",
        "every validation case holds on coarse grids: `whipple validate validation`",
        partial(_rows, ["validation"], "quick"),
        quick=True,
    )
)
