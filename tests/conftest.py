"""What holds for every test: how properties are searched, and which folder makes which mark."""

from pathlib import Path

import pytest
from hypothesis import settings

# The same examples every time (red stays red), and no deadline: a first call compiles kernels.
settings.register_profile("whipple", derandomize=True, deadline=None, print_blob=True)
settings.load_profile("whipple")

MARK_OF_FOLDER = {"acceptance": "acceptance", "verification": "verification"}
TESTS = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.is_relative_to(TESTS):
            folder = item.path.relative_to(TESTS).parts[0]
            if folder in MARK_OF_FOLDER:
                item.add_marker(MARK_OF_FOLDER[folder])
