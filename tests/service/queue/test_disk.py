"""The checks of the claims disk-identity and frozen-leader, as tests."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.claims import Row
from tests.claims.mend.disk import disk_that_goes_and_comes_back, leader_that_is_frozen


@pytest.mark.slow
@pytest.mark.parametrize("check", [disk_that_goes_and_comes_back, leader_that_is_frozen])
def test_claim__holds(
    check: Callable[[Path, str], Iterator[Row]], tmp_path: Path, postgresql_url: str
) -> None:
    rows = list(check(tmp_path, postgresql_url))
    assert [row for row in rows if row.passed is False] == []
