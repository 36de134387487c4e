"""A service without engine: a new one for a test, or one for all tests of a file."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.service.support.api import Api, open_api


@pytest.fixture
def api(tmp_path: Path) -> Iterator[Api]:
    with open_api(tmp_path) as opened:
        yield opened


@pytest.fixture(scope="module")
def shared_api(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Api]:
    """For tests that leave no sweep behind which others would meet."""
    with open_api(tmp_path_factory.mktemp("shared")) as opened:
        yield opened
