"""A PostgreSQL for tests: where there is none, tests are skipped; not claims, and not the checks of a clean clone."""

import os
import subprocess
from pathlib import Path

import pytest

from tests.service.support import databases

ROOT = Path(__file__).parents[3]


def nothing_starts(folder: Path) -> None:
    raise OSError(f"no server in {folder}")


def why_not() -> BaseException:
    """What becomes of a block that wants a server where none starts."""
    with pytest.raises(BaseException, match="no server in") as raised, databases.postgresql_server():
        pass  # never reached
    return raised.value


@pytest.fixture(autouse=True)
def _without(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CI", raising=False)
    monkeypatch.setattr(databases, "_start", nothing_starts)


def test_missing_server__skips_a_test_and_is_an_error_of_checks_and_claims(monkeypatch: pytest.MonkeyPatch) -> None:
    assert isinstance(why_not(), pytest.skip.Exception)
    with monkeypatch.context() as patch:
        patch.setenv("CI", "1")
        assert isinstance(why_not(), OSError)
    monkeypatch.delenv("PYTEST_CURRENT_TEST")
    assert isinstance(why_not(), OSError)


def test_checks__say_that_nothing_is_to_be_skipped(tmp_path: Path) -> None:
    for name, body in {"make": 'echo "CI=$CI"', "chromium": "true"}.items():
        (tmp_path / name).write_text(f"#!/bin/sh\n{body}\n")
        (tmp_path / name).chmod(0o755)
    path = os.pathsep.join([str(tmp_path), os.environ["PATH"]])
    output = subprocess.check_output([ROOT / ".ci" / "run"], env={**os.environ, "PATH": path}, text=True)
    assert output == "CI=1\n"
