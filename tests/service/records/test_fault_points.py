"""Points where a process can be made to die: each is somewhere, and does nothing unless asked."""

import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from service.records.fault_points import POINTS, VARIABLE, point

ROOT = Path(__file__).parents[3]
CALL = re.compile(r'\bpoint\("([a-z-]+)"\)')


def test_points__each_is_passed_somewhere_and_no_other() -> None:
    texts = [file.read_text() for file in (ROOT / "service").rglob("*.py")]
    called = [name for text in texts for name in CALL.findall(text)]
    assert set(called) == set(POINTS)


def test_point__does_nothing_unless_it_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, POINTS[1])
    point(POINTS[0])
    monkeypatch.delenv(VARIABLE)
    point(POINTS[1])


def test_point__kills_the_process_that_passes_it() -> None:
    program = (
        f"from service.records.fault_points import point; point({POINTS[0]!r}); print('went on')"
    )
    answer = subprocess.run(
        [sys.executable, "-c", program],
        cwd=ROOT,
        env={VARIABLE: POINTS[0]},
        capture_output=True,
        check=False,
    )
    assert (answer.returncode, answer.stdout) == (-signal.SIGKILL, b"")


def test_point__must_be_known() -> None:
    with pytest.raises(AssertionError):
        point("somewhere-else")
