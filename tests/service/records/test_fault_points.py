"""Fault points: each is passed somewhere, and kills the process only on request."""

import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from service.records.fault_points import POINTS, VARIABLE, fault_point

ROOT = Path(__file__).parents[3]
CALL = re.compile(r'\bfault_point\("([a-z-]+)"\)')


def test_points__are_those_that_the_service_passes() -> None:
    texts = [file.read_text() for file in (ROOT / "service").rglob("*.py")]
    called = {name for text in texts for name in CALL.findall(text)}
    assert called - {"..."} == set(POINTS)
    with pytest.raises(AssertionError):
        fault_point("somewhere-else")


@pytest.mark.parametrize(("name", "status"), [(POINTS[0], -signal.SIGKILL), (POINTS[1], 0)])
def test_named_point__kills_the_process_that_passes_it(name: str, status: int) -> None:
    program = f"from service.records.fault_points import fault_point; fault_point({POINTS[0]!r})"
    command = [sys.executable, "-c", program]
    assert subprocess.run(command, cwd=ROOT, env={VARIABLE: name}, check=False).returncode == status
