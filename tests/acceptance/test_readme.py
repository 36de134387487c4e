"""README.md does what it says: the claim ``readme`` in short, and its block over REST when something fails."""

from pathlib import Path

import pytest

from tests.acceptance.rows import holds
from tests.claims.mend.readme import row_of_curl, rows_in_short, rows_of_failures


@pytest.mark.slow
def test_readme__does_in_a_fresh_clone_what_it_says(tmp_path: Path) -> None:
    holds(rows_in_short(tmp_path))


def test_readme__block_over_rest_ends_with_an_error_where_something_fails(tmp_path: Path) -> None:
    holds(rows_of_failures(tmp_path))


def test_readme__asks_for_nothing_that_an_older_curl_lacks() -> None:
    holds([row_of_curl()])
