"""The pages of docs/ as a user meets them: their blocks run in order, as they stand."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

from tests.acceptance.checks.pages import pages, rows_of_page
from tests.claims import Row, claim


@claim("docs-run", says="the blocks of every page of docs/ do what it says: run in order, verbatim, in a fresh clone")
def docs_run() -> Iterator[Row]:
    for page in pages():
        with tempfile.TemporaryDirectory(prefix="whipple-docs-") as name:
            yield from rows_of_page(page, Path(name))
