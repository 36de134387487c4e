"""Whatever is sent to the interface: it answers as it is described, and never fails."""

import os
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping

from tests.acceptance.serving import ROOT
from tests.claims import Row, claim

BODIES = 10_000
COUNTS = re.compile(r"(\d+) (passed|failed|error|errors|skipped)")
FULL = {"WHIPPLE_EXAMPLES": "60", "WHIPPLE_SEQUENCES": "60"}  # of test_openapi.py


@claim(
    "openapi",
    says="schemathesis (fixed seed, operations alone and in sequence) finds nothing against the description",
)
def openapi() -> Iterator[Row]:
    yield from _passes("tests/service/test_openapi.py", FULL)


@claim(
    "bodies",
    says="10 000 bodies that Hypothesis invents are accepted or refused with a reason: none fails",
)
def bodies() -> Iterator[Row]:
    yield from _passes("tests/service/test_bodies.py", {"WHIPPLE_BODIES": str(BODIES)})


def _passes(file: str, environment: Mapping[str, str]) -> Iterator[Row]:
    """The tests of a file, run now with more examples than usual."""
    command = [sys.executable, "-m", "pytest", "-q", file]
    answer = subprocess.run(
        command,
        cwd=ROOT,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    counts = {word: int(number) for number, word in COUNTS.findall(answer.stdout)}
    given = ", ".join(f"{name}={value}" for name, value in environment.items())
    bad = sum(count for word, count in counts.items() if word != "passed")
    is_fine = answer.returncode == 0 and bad == 0 and counts.get("passed", 0) > 0
    yield Row(f"{file} with {given}: findings", "none", _findings(answer.stdout, bad), is_fine)
    yield Row("tests that passed", "", counts.get("passed", 0), None)


def _findings(said: str, bad: int) -> str:
    return "none" if not bad else f"{bad}: {said[-1000:]}"
