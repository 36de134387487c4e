"""What holds for every test: how properties are searched, and which folder makes which mark."""

import signal
from pathlib import Path

import pytest
from hypothesis import settings

# The same examples every time (red stays red), and no deadline: a first call compiles kernels.
settings.register_profile("whipple", derandomize=True, deadline=None, print_blob=True)
settings.load_profile("whipple")

pytest_plugins = ["tests.claims.marked"]

MARK_OF_FOLDER = {"crash": "crash", "cases": "cases"}
TESTS = Path(__file__).parent
# Helpers have no doctests, and would load browsers and clusters for every stage.
collect_ignore_glob = ["*/support", "benchmarks/[!t]*", "service/*/cluster.py", "service/*/object_store.py"]


def pytest_configure() -> None:
    """In the background of a shell Ctrl-C is ignored, and would be by every process that a test starts."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.is_relative_to(TESTS):
            folder = item.path.relative_to(TESTS).parts[0]
            if folder in MARK_OF_FOLDER:
                item.add_marker(MARK_OF_FOLDER[folder])
