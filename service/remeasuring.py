"""Which results of a sweep are of an older definition, and which of these can be read again.

Reading is part of publishing the sweep again: one job of the queue reads the states, makes cube and
report of what it read, and all of it is registered at once. So it is claimed, fenced, tried again and
lost like every publication; whatever dies, the rows tell the old results or the new ones. Other sweeps
that use the same runs are published again behind it.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from service.jobs import State, Stored
from service.store import Store
from studies.remeasure import outdated


@dataclass(frozen=True)
class Plan:
    """The runs of a sweep, each once, by what can be done about their measurements."""

    read: Mapping[str, Stored]  # outdated, with the final state that tells the new values
    not_kept: tuple[str, ...]  # outdated, and there is no state: they stay as they are
    up_to_date: int
    without_result: int  # failed, cancelled, or not there yet


def plan_of(store: Store, sweep_id: str) -> Plan:
    """What there is to read again of a sweep; raises NotFound. Two statements, whatever the size."""
    read: dict[str, Stored] = {}
    not_kept: list[str] = []
    up_to_date = without_result = 0
    for run in store.measured_runs(sweep_id):
        if run.state is not State.SUCCEEDED or run.summary is None:
            without_result += 1
        elif not outdated(run.scenario, run.summary.get("measurements", {})):
            up_to_date += 1
        elif run.kept is None:
            not_kept.append(run.id)
        else:
            read[run.id] = run.kept
    return Plan(read, tuple(not_kept), up_to_date, without_result)


def order(store: Store, sweep_id: str) -> Plan:
    """Have a sweep read again what can be, if there is anything; raises NotFound, Conflict."""
    plan = plan_of(store, sweep_id)
    if plan.read:
        store.remeasure_sweep(sweep_id, runs=len(plan.read))
    return plan
