"""The store under any order of events: invariants that hold at every moment.

Sweeps share runs out of a small pool; attempts end in every way, some of them late; dispatchers take
over from each other. Whatever happens, an attempt counts once, nobody waits in vain, nothing is
computed for nobody, and in the end every sweep that was accepted has ended.
"""

import shutil
import tempfile
from pathlib import Path

import pytest
import sqlalchemy as sa
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, MultipleResults, RuleBasedStateMachine, invariant, multiple, rule

from service.files.lost_results import Loss
from service.queue.retry import MOST_LOST_RESULTS, decide
from service.records.jobs import (
    ACTIVE,
    SWEEP_TERMINAL,
    Cause,
    Conflict,
    Keep,
    KeyReused,
    Kind,
    Lease,
    State,
    Submission,
)
from service.store.fair_queueing import LAST
from service.store.tables import JOBS, POINTS, SHARES, SWEEPS, now
from studies.quantities.files import STATE
from tests.claims.marked import in_full
from tests.service.store.test_owned_bytes import owned
from tests.service.support.fakes import open_store, run_id, settings_in, stored, sweep_of
from tests.service.support.rows import finish_all, result
from tests.service.support.targets import FakeRun

POOL = 5  # runs that sweeps can ask for
PRIORITY = st.integers(-2, 2)
STEP = st.sampled_from([None, 100, 200])


class Rules(RuleBasedStateMachine):
    """A store, people and dispatchers, in any order."""

    sweeps: "Bundle[str]" = Bundle("sweeps")
    leases: "Bundle[Lease]" = Bundle("leases")  # also those that count no longer

    def __init__(self) -> None:
        super().__init__()
        self.folder = Path(tempfile.mkdtemp(prefix="whipple-rules-"))
        self.store = open_store(settings_in(self.folder))
        self.deleted: set[str] = set()
        self.sent: dict[str, tuple[str, str]] = {}  # idempotency key: body, sweep
        self.held: dict[str, Lease] = {}  # attempts that count, by key
        self.known: set[str] = set()  # runs that have had a result
        self.term = self.store.terms.begin("first")
        self.paused = False

    def teardown(self) -> None:
        self.everything_ends()
        self.store.close()
        shutil.rmtree(self.folder)

    # --- people

    @rule(
        target=sweeps,
        wanted=st.lists(st.integers(0, POOL - 1), min_size=1, max_size=POOL),
        priority=PRIORITY,
        keep=st.sampled_from(Keep),
        owner=st.sampled_from(["", "other"]),
    )
    def submit(self, wanted: list[int], priority: int, keep: Keep, owner: str) -> str:
        asked = sweep_of([FakeRun(run_id(number)) for number in wanted])
        return self.store.sweeps.create(Submission(asked, priority=priority, keep=keep, owner=owner)).id

    @rule(target=sweeps, key=st.sampled_from(["a", "b"]), wanted=st.sampled_from([[0], [1, 2]]))
    def submit_with_key(self, key: str, wanted: list[int]) -> MultipleResults[str]:
        asked, body = sweep_of([FakeRun(run_id(number)) for number in wanted]), str(wanted)
        known, id = self.sent.get(key, (body, None))
        try:
            row = self.store.sweeps.create(Submission(asked, idempotency=(key, body)))
        except KeyReused:
            assert known != body
            return multiple()
        assert known == body
        assert id in (None, row.id)
        self.sent[key] = (body, row.id)
        return multiple(row.id) if id is None else multiple()

    @rule(sweep=sweeps)
    def cancel(self, sweep: str) -> None:
        if sweep not in self.deleted:
            self.store.sweeps.cancel(sweep)

    @rule(sweep=sweeps, verdicts=st.booleans())
    def retry(self, sweep: str, verdicts: bool) -> None:
        if sweep in self.deleted:
            return
        try:
            self.store.sweeps.retry(sweep, verdicts=verdicts)
        except Conflict:
            assert self.publication(sweep) is State.RUNNING

    @rule(sweep=sweeps)
    def delete(self, sweep: str) -> None:
        if sweep in self.deleted or self.store.sweeps.get(sweep).state not in SWEEP_TERMINAL:
            return
        self.store.sweeps.delete(sweep)
        self.deleted.add(sweep)
        self.sent = {key: known for key, known in self.sent.items() if known[1] != sweep}

    @rule(sweep=sweeps, priority=PRIORITY)
    def prioritise(self, sweep: str, priority: int) -> None:
        if sweep in self.deleted:
            return
        try:
            assert self.store.sweeps.set_priority(sweep, priority).priority == priority
        except Conflict:
            assert self.store.sweeps.get(sweep).is_terminal

    @rule(paused=st.booleans())
    def pause(self, paused: bool) -> None:
        self.paused = paused
        row = self.store.queue.pause() if paused else self.store.queue.resume()
        assert (row.paused is not None) == paused

    # --- dispatchers

    @rule(target=leases, limit=st.integers(1, 3))
    def lease(self, limit: int) -> MultipleResults[Lease]:
        leases = self.store.leases.take(limit, self.term)
        assert not self.paused or {lease.kind for lease in leases} <= {Kind.PUBLISH}
        for lease in leases:
            assert lease.id not in {held.id for held in self.held.values()}
            self.held[lease.key] = lease
        return multiple(*leases)

    @rule(target=leases, adopts=st.booleans())
    def take_over(self, adopts: bool) -> MultipleResults[Lease]:
        """Another term: it adopts what is under way, or leaves it as it is."""
        earlier, self.term = self.term, self.store.terms.begin("next")
        assert self.store.leases.take(9, earlier) == ()
        if not adopts:
            return multiple()
        for lease in self.store.leases.held():
            assert self.store.leases.adopt(lease, earlier) is None
            adopted = self.store.leases.adopt(lease, self.term)
            assert adopted is not None
            assert adopted.key in self.held
            self.held[adopted.key] = adopted
        return multiple(*self.held.values())

    def counts(self, lease: Lease) -> bool:
        """Whether the next word about this lease is heard; no later one is."""
        held = self.held.get(lease.key)
        if held is None or held.term != lease.term:
            return False
        del self.held[lease.key]
        return True

    def drop_outdated(self) -> None:
        """Publications of results that changed meanwhile count no longer."""
        self.held = {
            key: held
            for key, held in self.held.items()
            if held.sweep_id is None or self.publication(held.sweep_id) is State.RUNNING
        }

    @rule(lease=leases, succeeded=st.booleans())
    def finish(self, lease: Lease, succeeded: bool) -> None:
        counts = self.counts(lease)
        if lease.kind is Kind.PUBLISH:
            assert self.store.leases.publish(lease, [stored("cube.nc")], seconds=1.0) == counts
            return
        files = [stored(STATE, STATE)] if lease.keep is not Keep.NUMBERS else []
        assert self.store.leases.finish(lease, result(*files, succeeded=succeeded)) == counts
        if counts:
            self.known.add(lease.id)
            self.drop_outdated()

    @rule(lease=leases, cause=st.sampled_from([Cause.CRASH, Cause.MEMORY_LIMIT]), step=STEP)
    def fail(self, lease: Lease, cause: Cause, step: int | None) -> None:
        counts = self.counts(lease)
        crashes = decide(lease, cause, step).crashes
        assert self.store.leases.fail(lease, cause, failure="", reason="", crashes=crashes) == counts

    @rule(lease=leases, cause=st.sampled_from([Cause.CRASH, Cause.LOST]), step=STEP)
    def requeue(self, lease: Lease, cause: Cause, step: int | None) -> None:
        counts = self.counts(lease)
        state = self.store.leases.requeue(lease, cause, reason="", crashes=decide(lease, cause, step).crashes)
        assert (state is not None) == counts

    @rule(lease=leases, number=st.integers(1, POOL))
    def lose_results(self, lease: Lease, number: int) -> None:
        """A publication finds some of the results lost that it was made for."""
        if lease.kind is not Kind.PUBLISH or lease.sweep_id in self.deleted:
            return
        assert lease.sweep_id is not None
        _, outcomes = self.store.publications.inputs(lease.sweep_id, self.folder)
        found = {each["run_id"]: each["sha256"] for each in outcomes if each["sha256"] is not None}
        losses = [Loss(id, "", sha256) for id, sha256 in found.items()][:number]
        if not losses:
            return
        counts = self.counts(lease)
        self.store.queue.allow_forgetting(len(losses))
        assert self.store.publications.lose_results(lease, losses, most=MOST_LOST_RESULTS) == counts
        if counts:
            _, outcomes = self.store.publications.inputs(lease.sweep_id, self.folder)
            self.known -= {each["run_id"] for each in outcomes if each["sha256"] is None}
            self.drop_outdated()

    @rule(lease=leases, step=st.integers(1, 300))
    def checkpoint(self, lease: Lease, step: int) -> None:
        held = self.held.get(lease.key)
        counts = held is not None and held.term == lease.term
        before = self.checkpoint_of(lease.id)
        self.store.leases.record_progress([(lease, {"seconds": 1.0, "checkpoint": step})])
        assert self.checkpoint_of(lease.id) == (step if counts else before)

    @rule(shard=st.sampled_from(["0", ""]))
    def collect_garbage(self, shard: str) -> None:
        """Files that no sweep keeps go, and runs that no sweep has."""
        self.store.retention.drop(self.store.retention.discardable(3, shard))
        self.store.retention.forget_runs(now(), 1)
        with self.store.database.reading() as reading:
            self.known &= set(reading.scalars(sa.select(JOBS.c.id)))

    # --- what must hold

    @invariant()
    def sums_of_bytes_are_those_of_the_files(self) -> None:
        """The bytes kept for each owner are those of the files of the owner's jobs."""
        owned(self.store)

    @invariant()
    def runs_belong_to_an_owner_who_has_them(self) -> None:
        """A run belongs to the owner of a sweep that has it, and is abandoned once none has it."""
        owners: dict[str, set[str]] = {}
        having = sa.select(POINTS.c.run_id, SWEEPS.c.owner).join_from(POINTS, SWEEPS, SWEEPS.c.id == POINTS.c.sweep_id)
        runs = sa.select(JOBS.c.id, JOBS.c.owner, JOBS.c.abandoned).where(JOBS.c.kind == Kind.RUN)
        for row in self.store.database.rows(having):
            owners.setdefault(row.run_id, set()).add(row.owner)
        for run in self.store.database.rows(runs):
            assert (run.abandoned is None) == (run.id in owners)
            assert run.abandoned is not None or run.owner in owners[run.id]

    @invariant()
    def publications_wait_for_unfinished_runs(self) -> None:
        """A waiting publication waits for a run that is under way."""
        for sweep in self.living():
            if self.publication(sweep) is State.WAITING:
                assert any(state in ACTIVE for state in self.attached(sweep))

    @invariant()
    def counts_are_complete(self) -> None:
        """Every point of a sweep is in one state."""
        for row in self.store.sweeps.page(limit=1000).items:
            assert sum(row.counts.values()) == row.planned

    @invariant()
    def only_what_is_held_is_under_way(self) -> None:
        """The rows that are running are the attempts that count."""
        assert {lease.key for lease in self.store.leases.held()} == set(self.held)

    @invariant()
    def nothing_is_computed_for_nobody_and_urgent_runs_come_first(self) -> None:
        """An unfinished run is in the queue of a most urgent sweep that waits; for a queued one there is one."""
        publications = JOBS.alias("publications")
        demand = (
            sa.select(POINTS.c.run_id, SWEEPS.c.priority, SWEEPS.c.owner)
            .join_from(POINTS, SWEEPS, SWEEPS.c.id == POINTS.c.sweep_id)
            .join(publications, publications.c.sweep_id == SWEEPS.c.id)
            .where(POINTS.c.detached.is_(False), publications.c.state == State.WAITING)
        )
        unfinished = sa.select(JOBS).where(JOBS.c.kind == Kind.RUN, JOBS.c.state.in_(ACTIVE))
        wanted: dict[str, set[tuple[int, str]]] = {}
        with self.store.database.reading() as reading:
            for row in reading.execute(demand):
                wanted.setdefault(row.run_id, set()).add((row.priority, row.owner))
            queues = {(row.priority, row.owner) for row in reading.execute(sa.select(SHARES))}
            for run in reading.execute(unfinished):
                assert run.state is not State.QUEUED or run.id in wanted
                if run.id in wanted:
                    assert run.priority == min(wanted[run.id])[0]
                    assert (run.priority, run.owner) in wanted[run.id] & queues
                assert run.virtual_time < LAST

    @invariant()
    def results_are_kept(self) -> None:
        """A run that had a result has it until it is lost, whatever its state; no other has a file."""
        query = sa.select(JOBS.c.id, JOBS.c.state, JOBS.c.cause, JOBS.c.path).where(JOBS.c.kind == Kind.RUN)
        for id, state, cause, path in self.store.database.rows(query):
            assert (path is not None) == (id in self.known)
            if state not in ACTIVE:
                assert (state is State.SUCCEEDED or cause is Cause.VERDICT) == (id in self.known)

    def everything_ends(self) -> None:
        """Once the queue is worked through, every sweep has ended, and every point has its result."""
        self.store.queue.resume()
        term = self.store.terms.begin("last")
        for lease in self.store.leases.held():
            assert self.store.leases.requeue(lease, Cause.LOST, reason="the service ended during the attempt")
        finish_all(self.store, term=term)
        for row in self.store.sweeps.page(limit=1000).items:
            assert row.is_terminal
            assert sum(row.counts.values()) == row.planned

    # --- questions

    def living(self) -> list[str]:
        return [row.id for row in self.store.sweeps.page(limit=1000).items]

    def checkpoint_of(self, job: str) -> int | None:
        rows = self.store.database.rows(sa.select(JOBS.c.checkpoint).where(JOBS.c.id == job))
        return rows[0].checkpoint if rows else None

    def publication(self, sweep: str) -> State:
        return self.store.database.value(sa.select(JOBS.c.state).where(JOBS.c.sweep_id == sweep))

    def attached(self, sweep: str) -> list[State]:
        query = (
            sa.select(JOBS.c.state)
            .join_from(POINTS, JOBS, JOBS.c.id == POINTS.c.run_id)
            .where(POINTS.c.sweep_id == sweep, POINTS.c.detached.is_(False))
        )
        return [row.state for row in self.store.database.rows(query)]


Rules.TestCase.settings = settings(max_examples=100 if in_full() else 5, stateful_step_count=30)
TestRules = pytest.mark.claim(
    "queue", "any-order", minutes=1.0, short=True, says="the store keeps its rules under any order of events"
)(Rules.TestCase)
