"""Laws over HTTP, asked about a shield: they answer at once."""

import time

import pytest

from tests.claims.marked import Compared
from tests.claims.rows import at_most
from tests.service.support.api import Api
from tests.studies.shields.samples import QUESTION

ANSWER = 0.05  # s


@pytest.mark.claim("door", "answer-time", minutes=0.2)
def test_laws__answer_within_fifty_milliseconds(shared_api: Api, compared: Compared) -> None:
    """A running service answers a question about one shield within 50 ms, the median of twenty."""

    def seconds(speed: int) -> float:
        begin = time.perf_counter()
        assert shared_api.http.post("/v1/laws/evaluate", json={**QUESTION, "speed": f"{speed} m/s"}).status_code == 200
        return time.perf_counter() - begin

    seconds(3000)
    compared(at_most("median time of an answer (s)", limit=ANSWER, got=sorted(map(seconds, range(3001, 3021)))[10]))
