"""The checks of the claims disk-identity and frozen-leader, as tests."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.acceptance.checks.shared_disk import directory_moved, frozen_leader
from tests.rows import Row, check
from tests.service.support.databases import postgresql_server


@pytest.mark.slow
@pytest.mark.parametrize("rows", [directory_moved, frozen_leader])
def test_shared_disk__loses_no_result(rows: Callable[[Path, str], Iterator[Row]], tmp_path: Path) -> None:
    with postgresql_server() as server, server.database() as url:
        check(rows(tmp_path, url))
