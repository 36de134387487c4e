"""README.md does what it says: the claim ``readme`` in short, and its block over REST when something fails."""

from pathlib import Path

import pytest

from tests.acceptance.checks.readme import row_of_curl, rows_in_short, rows_of_failures
from tests.rows import check


@pytest.mark.slow
def test_readme__does_in_a_fresh_clone_what_it_says(tmp_path: Path) -> None:
    check(rows_in_short(tmp_path))


def test_readme__block_over_rest_ends_with_an_error_where_something_fails(tmp_path: Path) -> None:
    check(rows_of_failures(tmp_path))


def test_readme__needs_no_recent_curl() -> None:
    check([row_of_curl()])
