"""README.md as a user meets it: its blocks run in order, as they stand, in a fresh clone."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

from tests.acceptance.checks import readme as checks
from tests.claims import Row, claim


@claim("readme", says="the blocks of README.md do what it says: run in order, verbatim, in a fresh clone")
def readme() -> Iterator[Row]:
    yield checks.row_of_curl()
    with tempfile.TemporaryDirectory(prefix="whipple-readme-") as name:
        yield from checks.rows_of_failures(Path(name))
    with tempfile.TemporaryDirectory(prefix="whipple-readme-") as name:
        yield from checks.rows_in_full(Path(name))
