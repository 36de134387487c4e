"""A search is one row of the queue, whose state is the results of its runs."""

from typing import Any

import pytest

from service.queue.searching import next_points
from service.records.jobs import Cause, Kind, State, Submission, SweepState
from service.workers.attempt import Attempt
from studies import scenarios
from studies.sweeps.sweep import Point, Sweep
from tests.service.support.attempts import computed, published
from tests.service.support.harness import Harness
from tests.service.support.targets import PERFORATES

if "plugging" not in scenarios.names():
    pytest.skip("no scenario whose limit is searched", allow_module_level=True)

DOCUMENT: dict[str, Any] = {
    "scenario": "plugging",
    "axes": {"speed": {"limit_of": "perforated", "between": ["100 m/s", "200 m/s"], "tolerance": "5 m/s"}},
    "resolution": 8,
}
SWEEP = Sweep.parse(DOCUMENT)
BISECTION = [100.0, 150.0, 200.0, 175.0, 162.5, 156.25, 153.125]  # m/s, up to a gap below 5 m/s


def submit(harness: Harness) -> str:
    return harness.store.sweeps.create(Submission(SWEEP)).id


def speed(attempt: Attempt) -> float:
    return float(str(computed(attempt)["parameters"]["speed"]))


def searched(harness: Harness, begun: list[Attempt], speeds: list[float]) -> Attempt:
    """Compute all runs that begin, noting their speeds, until the publication begins, and return it."""
    for _ in range(60):
        for attempt in begun:
            if attempt.kind is Kind.PUBLISH:
                return attempt
            speeds.append(speed(attempt))
            harness.end_well(attempt)
        begun = harness.tick()
    raise AssertionError("the search does not end")


def test_search__submits_ordinary_runs_until_it_has_its_interval(harness: Harness) -> None:
    id, speeds = submit(harness), list[float]()
    publication = searched(harness, [], speeds)
    assert speeds == BISECTION[: len(speeds)]
    assert len(speeds) == 7
    above, below = (min(v for v in speeds if v >= PERFORATES), max(v for v in speeds if v < PERFORATES))
    assert above - below <= 5.0
    status = harness.store.sweeps.get(id)
    assert (status.planned, status.new, status.counts["succeeded"]) == (7, 7, 7)
    assert len(published(publication)["outcomes"]) == 7
    harness.end_well(publication)
    harness.tick()
    assert harness.store.sweeps.get(id).state is SweepState.SUCCEEDED


def test_search__publishes_what_there_is_once_cancelled_and_goes_on_when_retried(harness: Harness) -> None:
    id, speeds = submit(harness), list[float]()
    begun = harness.tick()
    for attempt in begun:
        harness.end_well(attempt)
    [third] = harness.tick()
    harness.store.sweeps.cancel(id)
    harness.end_badly(third, Cause.LOST)
    [publication] = harness.tick()
    assert publication.kind is Kind.PUBLISH
    assert {each["state"] for each in published(publication)["outcomes"]} == {State.SUCCEEDED, State.CANCELLED}
    harness.end_well(publication)
    harness.tick()
    assert harness.store.sweeps.get(id).state is SweepState.CANCELLED
    harness.store.sweeps.retry(id)
    harness.end_well(searched(harness, [], speeds))
    harness.tick()
    assert speeds == BISECTION[2:]
    assert harness.store.sweeps.get(id).state is SweepState.SUCCEEDED


@pytest.mark.parametrize("is_thinking", [False, True])
def test_search__that_is_cancelled_between_two_steps_begins_no_further_run(
    harness: Harness, is_thinking: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    harness.engine.free = 3
    id = submit(harness)
    for attempt in harness.tick():
        harness.end_well(attempt)

    def cancelled(*arguments: Any) -> list[Point]:
        assert harness.store.sweeps.cancel(id).state is SweepState.CANCELLING
        return next_points(*arguments)

    if is_thinking:
        monkeypatch.setattr("service.queue.searching.next_points", cancelled)
    else:
        harness.engine.free = 0
        harness.tick()
        assert harness.store.sweeps.cancel(id).state is SweepState.CANCELLING
        harness.engine.free = 3
    assert len(published(harness.publish())["outcomes"]) == 3
    status = harness.store.sweeps.get(id)
    assert (status.state, status.planned) == (SweepState.CANCELLED, 3)
