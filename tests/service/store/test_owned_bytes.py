"""The bytes that are kept for each owner, whatever happens to files, runs and sweeps, on both databases."""

from collections import Counter
from dataclasses import replace

import sqlalchemy as sa

from service.records.jobs import Keep, Submission
from service.store import Store
from service.store.tables import ARTIFACTS, JOBS, now
from studies.quantities.files import STATE
from tests.service.support.fakes import run_id, stored, sweep_of
from tests.service.support.rows import finish_all

SIZE = stored().size
RUN, PUBLICATION = 2 * SIZE, SIZE  # bytes: the result and the final state, and a cube


def submit(store: Store, owner: str, runs: int, keep: Keep = Keep.FINAL) -> str:
    return store.sweeps.create(Submission(sweep_of(runs), owner=owner, keep=keep)).id


def compute(store: Store) -> None:
    """Compute everything that is queued, runs with their final states."""
    finish_all(store, stored(STATE, STATE))


def owned(store: Store) -> dict[str, int]:
    """The kept sums, which must be those of the files."""
    sizes = sa.select(ARTIFACTS.c.job_id, sa.func.sum(ARTIFACTS.c.size)).group_by(ARTIFACTS.c.job_id)
    by_owner = Counter[str]()
    with store.database.reading() as reading:
        right = {job: int(size) for job, size in reading.execute(sizes)}
        for job in reading.execute(sa.select(JOBS.c.id, JOBS.c.owner, JOBS.c.abandoned, JOBS.c.bytes)):
            assert job.bytes == right.get(job.id, 0)
            by_owner[job.owner] += 0 if job.abandoned else job.bytes
    return {owner: size for owner, size in by_owner.items() if size}


def test_files__of_a_run_belong_to_the_owner_of_a_sweep_that_has_it(store: Store) -> None:
    first = submit(store, "anna", 3)
    compute(store)
    assert owned(store) == {"anna": 3 * RUN + PUBLICATION}
    second = submit(store, "ben", 2)
    compute(store)
    assert owned(store) == {"anna": 3 * RUN + PUBLICATION, "ben": PUBLICATION}
    store.sweeps.delete(first)
    assert owned(store) == {"ben": 2 * RUN + PUBLICATION}  # the third is nobody's
    store.sweeps.delete(second)
    assert owned(store) == {}
    submit(store, "carla", 3)
    compute(store)
    assert owned(store) == {"carla": 3 * RUN + PUBLICATION}


def test_files__that_are_replaced_dropped_or_forgotten_change_the_sum(store: Store) -> None:
    sweep = submit(store, "anna", 3)
    compute(store)
    before = owned(store)["anna"]
    answer = stored()
    store.runs.replace_result(run_id(0), answer.sha256, replace(answer, size=SIZE + 7), {})
    assert owned(store) == {"anna": before + 7}
    store.runs.replace_result(run_id(0), answer.sha256, answer, {})
    store.retention.forget_files(run_id(0), [STATE])
    assert owned(store) == {"anna": before - SIZE}
    other = submit(store, "ben", 3, Keep.NUMBERS)
    compute(store)
    store.sweeps.delete(sweep)
    assert owned(store) == {"ben": before - SIZE}
    store.retention.drop(store.retention.discardable(9, "0"))
    assert owned(store) == {"ben": before - 3 * SIZE}
    store.sweeps.delete(other)
    assert store.retention.forget_runs(now(), 9) == 3
    assert owned(store) == {}
