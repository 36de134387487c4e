"""Laws asked about a shield, over HTTP and on the command line: they answer at once."""

import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from studies.answers import examples
from tests.claims.marked import Compared
from tests.claims.rows import at_most
from tests.contracts.features import ROOT
from tests.service.support.api import Api
from tests.studies.shields.samples import QUESTION

ANSWER = 0.05  # s
PRINTED, SHEET = 1.0, 3.0  # s of processor time


@pytest.mark.claim("door", "answer-time", minutes=0.2)
def test_laws__answer_within_fifty_milliseconds(shared_api: Api, compared: Compared) -> None:
    """A running service answers a question about one shield within 50 ms, the median of twenty."""

    def seconds(speed: int) -> float:
        begin = time.perf_counter()
        assert shared_api.http.post("/v1/laws/evaluate", json={**QUESTION, "speed": f"{speed} m/s"}).status_code == 200
        return time.perf_counter() - begin

    seconds(3000)
    compared(at_most("median time of an answer (s)", limit=ANSWER, got=sorted(map(seconds, range(3001, 3021)))[10]))


@pytest.mark.claim("house", "starts", minutes=0.2)
def test_answer__about_a_shield_is_quick(tmp_path: Path, compared: Callable[..., None]) -> None:
    """What equations and shots say of a shield takes a second of processor time, and its sheet of one page three."""

    def spent() -> float:
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    for options, limit in (((), PRINTED), (("--out", str(tmp_path / "shield.html")), SHEET)):
        before = spent()
        command = [sys.executable, "-m", "service", "laws", "--at", str(examples()[0]), *options]
        subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
        compared(at_most(f"whipple laws --at shield.yaml {' '.join(options[:1])}", limit=limit, got=spent() - before))
