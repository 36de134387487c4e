"""Jobs that were lost again and again: how long they rest."""

import pytest

from service.queue import backoff as rests
from service.queue.backoff import FREE, Rests
from service.records.jobs import Claim, Keep, Kind, State
from tests.service.support.fakes import run_id

CLAIM = Claim(
    id=run_id(1),
    kind=Kind.RUN,
    attempt=1,
    epoch=1,
    token="0123abcd",
    crashes=0,
    crash_step=None,
    priority=0,
    keep=Keep.FINAL,
    state=State.RUNNING,
    spec={},
    sweep_id=None,
)


def test_rest__doubles_to_a_longest_one() -> None:
    asked = Rests()
    waits = [asked.lose(CLAIM, None) for _ in range(FREE + 100)]
    assert waits[:FREE] == [0.0] * FREE
    assert waits[FREE : FREE + 4] == [10.0, 20.0, 40.0, 80.0]
    assert set(waits[FREE + 6 :]) == {rests.LONGEST_SECONDS}
    assert asked.resting() == (CLAIM.id,)


def test_rest__is_over_after_its_seconds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rests, "FIRST_SECONDS", 0.0)
    asked = Rests()
    for _ in range(FREE + 1):
        asked.lose(CLAIM, None)
    assert asked.resting() == ()


def test_progress__starts_the_count_anew() -> None:
    asked = Rests()
    assert {asked.lose(CLAIM, step) for step in range(1, 100)} == {0.0}
    assert [asked.lose(CLAIM, 99) for _ in range(FREE)][-1] == rests.FIRST_SECONDS


def test_other_end__starts_the_count_anew() -> None:
    asked = Rests()
    for _ in range(FREE):
        asked.lose(CLAIM, None)
    asked.end(CLAIM)
    assert asked.lose(CLAIM, None) == 0.0
