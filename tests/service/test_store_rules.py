"""The store under any order of events: what must hold at every moment.

Sweeps share runs out of a small pool; attempts end in every way, some of them late. Whatever
happens, an attempt counts once, nobody waits in vain, and nothing is computed for nobody.
"""

import atexit
import shutil
import tempfile
from functools import cache
from pathlib import Path

import sqlalchemy as sa
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    Bundle,
    MultipleResults,
    RuleBasedStateMachine,
    consumes,
    invariant,
    multiple,
    rule,
)

from service.jobs import ACTIVE, SWEEP_TERMINAL, Cause, Claim, Conflict, Kind, Result, State
from service.store.tables import JOBS, POINTS
from tests.service.doubles import open_store, run_id, settings_in, stored, sweep_of
from tests.service.targets import Run

POOL = 5  # runs that sweeps can ask for


@cache
def empty_store() -> Path:
    """An empty store, made once, then copied."""
    folder = Path(tempfile.mkdtemp(prefix="whipple-rules-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    open_store(settings_in(folder)).close()
    return folder


class Rules(RuleBasedStateMachine):
    """A store, people and a dispatcher, in any order."""

    sweeps: "Bundle[str]" = Bundle("sweeps")
    claims: "Bundle[Claim]" = Bundle("claims")
    spent: "Bundle[Claim]" = Bundle("spent")

    def __init__(self) -> None:
        super().__init__()
        self.folder = Path(tempfile.mkdtemp(prefix="whipple-rules-"))
        shutil.copytree(empty_store(), self.folder, dirs_exist_ok=True)
        self.store = open_store(settings_in(self.folder))
        self.deleted: set[str] = set()

    def teardown(self) -> None:
        self.store.close()
        shutil.rmtree(self.folder)

    # --- people

    @rule(target=sweeps, wanted=st.lists(st.integers(0, POOL - 1), min_size=1, max_size=POOL))
    def submit(self, wanted: list[int]) -> str:
        return self.store.create_sweep(sweep_of([Run(run_id(number)) for number in wanted])).id

    @rule(sweep=sweeps)
    def cancel(self, sweep: str) -> None:
        if sweep not in self.deleted:
            self.store.cancel_sweep(sweep)

    @rule(sweep=sweeps, verdicts=st.booleans())
    def retry(self, sweep: str, verdicts: bool) -> None:
        if sweep in self.deleted:
            return
        try:
            self.store.retry_sweep(sweep, verdicts=verdicts)
        except Conflict:
            assert self.publication(sweep) is State.RUNNING

    @rule(sweep=sweeps)
    def delete(self, sweep: str) -> None:
        if sweep in self.deleted or self.store.sweep(sweep).state not in SWEEP_TERMINAL:
            return
        self.store.delete_sweep(sweep)
        self.deleted.add(sweep)

    # --- the dispatcher

    @rule(target=claims, limit=st.integers(1, 3))
    def claim(self, limit: int) -> MultipleResults[Claim]:
        return multiple(*self.store.claim(limit, 1))

    @rule(target=spent, claim=consumes(claims), succeeded=st.booleans())
    def finish(self, claim: Claim, succeeded: bool) -> Claim:
        if claim.kind is Kind.PUBLISH:
            assert self.store.publish(claim, [stored("cube.nc")], seconds=1.0)
        else:
            assert self.store.finish(claim, Result(stored(), succeeded, None, None, {}, 1.0))
        return claim

    @rule(target=spent, claim=consumes(claims), cause=st.sampled_from([Cause.CRASH, Cause.ERROR]))
    def fail(self, claim: Claim, cause: Cause) -> Claim:
        assert self.store.fail(claim, cause, failure="", reason="")
        return claim

    @rule(target=spent, claim=consumes(claims), cause=st.sampled_from([Cause.CRASH, Cause.LOST]))
    def requeue(self, claim: Claim, cause: Cause) -> Claim:
        assert self.store.requeue(claim, cause, reason="")
        return claim

    @rule(claim=spent)
    def end_again(self, claim: Claim) -> None:
        assert not self.store.finish(claim, Result(stored(), True, None, None, {}, 1.0))
        assert not self.store.fail(claim, Cause.CRASH, failure="", reason="")
        assert not self.store.requeue(claim, Cause.LOST, reason="")
        assert not self.store.publish(claim, [stored("late.nc")], seconds=1.0)

    # --- what must hold

    @invariant()
    def nobody_waits_in_vain(self) -> None:
        """A waiting publication waits for a run that is under way."""
        for sweep in self.living():
            if self.publication(sweep) is State.WAITING:
                assert any(state in ACTIVE for state in self.attached(sweep))

    @invariant()
    def counts_are_complete(self) -> None:
        """Every point of a sweep is in one state."""
        for row in self.store.sweeps(limit=1000).items:
            assert sum(row.counts.values()) == row.planned

    @invariant()
    def nothing_is_computed_for_nobody(self) -> None:
        """A run in the queue has a sweep that waits for it."""
        waiting = [s for s in self.living() if self.publication(s) is State.WAITING]
        with self.store._database.reading() as reading:
            queued = reading.execute(
                sa.select(JOBS.c.id).where(JOBS.c.kind == Kind.RUN, JOBS.c.state == State.QUEUED)
            ).scalars()
            wanted = reading.execute(
                sa.select(POINTS.c.run_id).where(
                    POINTS.c.sweep_id.in_(waiting), POINTS.c.detached.is_(False)
                )
            ).scalars()
            assert set(queued) <= set(wanted)

    @invariant()
    def results_are_kept(self) -> None:
        """A run that succeeded has a file, one without a result has none."""
        with self.store._database.reading() as reading:
            query = sa.select(JOBS.c.state, JOBS.c.cause, JOBS.c.path)
            for state, cause, path in reading.execute(query.where(JOBS.c.kind == Kind.RUN)):
                assert (path is not None) == (state is State.SUCCEEDED or cause is Cause.VERDICT)

    # --- questions

    def living(self) -> list[str]:
        return [row.id for row in self.store.sweeps(limit=1000).items]

    def publication(self, sweep: str) -> State:
        query = sa.select(JOBS.c.state).where(JOBS.c.sweep_id == sweep)
        with self.store._database.reading() as reading:
            return reading.execute(query).scalar_one()

    def attached(self, sweep: str) -> list[State]:
        query = (
            sa.select(JOBS.c.state)
            .join_from(POINTS, JOBS, JOBS.c.id == POINTS.c.run_id)
            .where(POINTS.c.sweep_id == sweep, POINTS.c.detached.is_(False))
        )
        with self.store._database.reading() as reading:
            return list(reading.execute(query).scalars())


Rules.TestCase.settings = settings(max_examples=25, stateful_step_count=30)
TestRules = Rules.TestCase
