"""After an upgrade of the physics accepted sweeps are expanded anew, and what they have is set aside."""

from pathlib import Path
from unittest.mock import Mock

import pytest

from service.files.artifacts import describe
from service.queue.renewal import MOST_TRIES, Expand
from service.records.expansion import ExpandedSweep
from service.records.jobs import Kind, State, SweepState
from service.store.tables import SWEEPS
from service.workers.attempt import Attempt, Ending
from solver import PHYSICS_VERSION
from studies.quantities.files import RESULT
from studies.quantities.findings import Finding, InvalidInput
from studies.runs.execution import refuse
from tests.service.support.fakes import RecordingEngine, run_id, runs_of, sweep_of, wait_until
from tests.service.support.harness import Harness

OLDER, NEWER = 0, 100  # first numbers of the runs of each version


def age(harness: Harness, physics: int = PHYSICS_VERSION - 1) -> None:
    """Let all sweeps be those of an older physics."""
    with harness.store.database.writing() as connection:
        connection.execute(SWEEPS.update().values(physics=physics))


def upgraded(harness: Harness, expand: Expand) -> None:
    """Put a leader of the newer version in the place of the dispatcher, with an engine of its own."""
    harness.engine = RecordingEngine()
    harness.dispatcher = harness.successor(harness.engine, expand=expand)


def settle(harness: Harness) -> list[Attempt]:
    """Take ticks until nothing is expanded any more; the attempts that began."""
    begun: list[Attempt] = []

    def is_done() -> bool:
        begun.extend(harness.tick())
        return harness.dispatcher._leader.renewer.reason is None

    wait_until(is_done)
    return begun


def half_computed(harness: Harness) -> str:
    """A sweep of four runs of an older physics: one has a result, one was under way when its service was killed."""
    id = harness.submit(runs_of(*["fine"] * 4, first=OLDER))
    [first, *_] = harness.tick()
    harness.end_well(first)
    harness.tick()
    age(harness)
    return id


def newer(count: int = 4) -> ExpandedSweep:
    return sweep_of(runs_of(*["fine"] * count, first=NEWER))


def refused(harness: Harness, attempt: Attempt) -> Ending:
    """The end of an attempt whose run another version alone can compute."""
    directory = Path(attempt.directory)
    refuse(attempt.run or "", directory)
    return Ending(None, "", "", (describe(directory / RESULT),), 0.1)


def runs_of_sweep(harness: Harness, id: str) -> dict[str, State]:
    return {point.run.id: point.state for point in harness.store.sweeps.points(id).items}


def test_renewal__computes_every_point_by_the_present_physics_and_sets_older_results_aside(harness: Harness) -> None:
    id = half_computed(harness)
    upgraded(harness, Mock(return_value=newer()))
    begun = settle(harness)
    while begun:
        for attempt in begun:
            harness.end_well(attempt)
        begun = harness.tick()
    status = harness.store.sweeps.get(id)
    assert runs_of_sweep(harness, id) == {run_id(NEWER + each): State.SUCCEEDED for each in range(4)}
    assert (status.state, status.physics, status.planned, status.new) == (SweepState.SUCCEEDED, PHYSICS_VERSION, 4, 4)
    assert status.renewed is not None
    assert status.older is not None
    aside = harness.store.sweeps.get(status.older)
    assert runs_of_sweep(harness, aside.id) == {
        run_id(OLDER): State.SUCCEEDED,
        **{run_id(OLDER + each): State.CANCELLED for each in (1, 2, 3)},
    }
    assert (aside.state, aside.physics) == (SweepState.CANCELLED, PHYSICS_VERSION - 1)
    assert aside.title.endswith(f"(results of physics {PHYSICS_VERSION - 1})")
    assert harness.store.publications.files(aside.id)
    assert f"physics {PHYSICS_VERSION} computes all its points" in status.renewal
    assert aside.id in status.renewal


def test_renewal__without_results_leaves_no_sweep_behind(harness: Harness) -> None:
    id = harness.submit(runs_of("fine", "fine", first=OLDER))
    age(harness)
    upgraded(harness, Mock(return_value=newer(2)))
    settle(harness)
    assert set(runs_of_sweep(harness, id)) == {run_id(NEWER), run_id(NEWER + 1)}
    assert [each.id for each in harness.store.sweeps.page().items] == [id]
    assert {harness.run(number).state for number in (OLDER, OLDER + 1)} == {State.CANCELLED}


def test_renewal__happens_once_and_begins_nothing_before(harness: Harness) -> None:
    expand = Mock(return_value=newer())
    id = half_computed(harness)
    upgraded(harness, expand)
    begun = settle(harness)
    assert {attempt.run for attempt in begun if attempt.kind is Kind.RUN} <= {run_id(NEWER + each) for each in range(4)}
    points = runs_of_sweep(harness, id)
    upgraded(harness, expand)
    settle(harness)
    assert expand.call_count == 1
    assert runs_of_sweep(harness, id).keys() == points.keys()
    assert len(harness.store.sweeps.page().items) == 2


def test_renewal__of_the_same_runs_changes_nothing(harness: Harness) -> None:
    id = half_computed(harness)
    age(harness)
    before = runs_of_sweep(harness, id)
    upgraded(harness, Mock(return_value=sweep_of(runs_of(*["fine"] * 4, first=OLDER))))
    settle(harness)
    status = harness.store.sweeps.get(id)
    assert (runs_of_sweep(harness, id).keys(), status.renewed, status.physics) == (before.keys(), None, PHYSICS_VERSION)


def test_sweeps__that_have_ended_were_cancelled_or_are_of_a_newer_physics_stay(harness: Harness) -> None:
    ended = harness.submit(runs_of("fine", first=OLDER))
    harness.compute_all()
    cancelled = harness.submit(runs_of("fine", first=OLDER + 1))
    harness.store.sweeps.cancel(cancelled)
    age(harness)
    harness.submit(runs_of("fine", first=OLDER + 2))
    assert harness.store.renewals.outdated(PHYSICS_VERSION) == ()
    assert harness.store.renewals.outdated(PHYSICS_VERSION - 1) == ()
    assert not harness.store.renewals.renew(ended, newer(1), PHYSICS_VERSION)


@pytest.mark.parametrize(
    ("error", "times"),
    [(InvalidInput([Finding("fixed.speeed", "3", "a parameter", "it was renamed")]), 1), (OSError("lost"), MOST_TRIES)],
)
def test_document__that_this_version_refuses_ends_with_the_reason(
    harness: Harness, error: Exception, times: int
) -> None:
    expand = Mock(side_effect=error)
    id = half_computed(harness)
    upgraded(harness, expand)
    begun = settle(harness)
    status = harness.store.sweeps.get(id)
    assert (status.state, expand.call_count, begun) == (SweepState.FAILED, times, [])
    assert f"physics {PHYSICS_VERSION} cannot compute it" in (status.reason or "")
    assert str(error) in (status.reason or "")
    assert status.counts["succeeded"] == 1


def test_retry__of_a_sweep_that_ended_with_refused_runs_expands_it_anew(harness: Harness) -> None:
    id = harness.submit(runs_of("fine", "fine", first=OLDER))
    same = sweep_of(runs_of("fine", "fine", first=OLDER))  # which helps nothing
    upgraded(harness, Mock(return_value=same))
    for attempt in harness.tick():
        if attempt.run == run_id(OLDER):
            harness.end_well(attempt)
        else:
            harness.end(attempt, refused(harness, attempt))
    for publication in settle(harness):
        harness.end_well(publication)
    harness.tick()
    age(harness)
    upgraded(harness, Mock(return_value=newer(2)))
    assert harness.store.sweeps.get(id).state is SweepState.SUCCEEDED
    harness.store.sweeps.retry(id)
    for attempt in settle(harness):
        harness.end(attempt, refused(harness, attempt))
    settle(harness)
    status = harness.store.sweeps.get(id)
    assert set(runs_of_sweep(harness, id)) == {run_id(NEWER), run_id(NEWER + 1)}
    assert status.older is not None
    assert runs_of_sweep(harness, status.older) == {run_id(OLDER): State.SUCCEEDED, run_id(OLDER + 1): State.CANCELLED}
