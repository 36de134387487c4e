"""The validation cases: each is a claim by its own sentence, on three grids; all together on coarse ones are quick."""

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from service.cli.validation import STORE, selected, validated
from service.records.settings import Settings
from studies import validation
from studies.validation import Level
from tests.claims import Claim, Row


@contextmanager
def _unwatched(name: str) -> Iterator:
    yield lambda status: None


def _rows(names: Sequence[str], level: Level) -> Iterator[Row]:
    with tempfile.TemporaryDirectory(prefix="whipple-claims-") as folder:
        settings = Settings(data=Path(folder) / STORE)
        cases = selected(names, level)
        for each in validated(cases, level, Path(folder), settings, _unwatched):
            yield each.row


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
