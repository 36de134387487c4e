"""Results read again off stored final states, where the definition of a measurement has changed; nothing is solved.

No service works on the store meanwhile. A child process reads one result and writes it beside the earlier
one; then one transaction points the run to it and marks the sweeps that use the run, whose cubes and
reports the next start of the service makes again. After an interruption the same command goes on: what is
of today's definitions is left alone.
"""

import json
import multiprocessing
import signal
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from service.files.artifacts import Artifacts, describe, digest
from service.queue.verification import Damaged, summary_of
from service.records.jobs import State, Stored, SweepStatus
from service.records.settings import Settings
from service.records.version import version
from service.workers.warm_process import die_with_parent
from solver.errors import WhippleError
from studies.results import RunResult
from studies.runs.remeasure import outdated, remeasure
from studies.runs.run import Run
from studies.values.files import RESULT, STATE, write_text

if TYPE_CHECKING:
    from service.store import Store

AT_ONCE = 1000  # runs whose questions are in memory, about 2 kB each


@dataclass(frozen=True)
class Plan:
    """The outdated results of a store, by run."""

    read: tuple[str, ...]  # those with a stored final state
    not_kept: tuple[str, ...]  # the others stay as they are
    sweeps: Mapping[str, str]  # names of the sweeps that use what is read, by id


@dataclass(frozen=True)
class Renewal:
    """What became of one outdated result."""

    run_id: str
    marked: tuple[str, ...] = ()  # sweeps that the next start of the service publishes again
    reason: str | None = None  # why the result stays as it is


@dataclass(frozen=True)
class _Order:
    """One result to read again, for a child process; paths are absolute."""

    run_id: str
    spec: Mapping[str, Any]
    answer: Stored
    state: Stored


def plan_of(store: "Store") -> Plan:
    """What there is to read again; a few statements a sweep."""
    read: set[str] = set()
    not_kept: set[str] = set()
    sweeps: dict[str, str] = {}
    for sweep in _sweeps(store):
        for run in store.measured_runs(sweep.id):
            measured = (run.summary or {}).get("measurements", {})
            if run.state is not State.SUCCEEDED or not outdated(run.scenario, measured):
                continue
            if run.kept is None:
                not_kept.add(run.id)
            else:
                read.add(run.id)
                sweeps[sweep.id] = sweep.name
    return Plan(tuple(sorted(read)), tuple(sorted(not_kept)), sweeps)


def _sweeps(store: "Store") -> Iterator[SweepStatus]:
    page = store.sweeps()
    yield from page.items
    while page.next_cursor is not None:
        page = store.sweeps(cursor=page.next_cursor)
        yield from page.items


def renew(settings: Settings, store: "Store", run_ids: Sequence[str]) -> Iterator[Renewal]:
    """Read results again in child processes and register them one by one.

    The caller keeps services away. Raises WhippleError when a child process dies, and StoreUnavailable.
    """
    artifacts = Artifacts(settings.data)
    pool = ProcessPoolExecutor(
        min(settings.workers, len(run_ids)),
        multiprocessing.get_context("spawn"),  # a forked child would inherit the lock
        _begin_child,
        (settings.targets_module,),
    )
    try:
        with pool:
            for begin in range(0, len(run_ids), AT_ONCE):
                ids = run_ids[begin : begin + AT_ONCE]
                orders = [_order(store, artifacts, id) for id in ids]
                for order, read in zip(orders, pool.map(_read_again, orders), strict=True):
                    yield _registered(store, artifacts, order, read)
    except BrokenProcessPool:
        cure = "give it again, with WHIPPLE_WORKERS=1 if memory was short"
        raise WhippleError(
            f"a process that reads states died; what was read before counts; {cure}"
        ) from None


def _order(store: "Store", artifacts: Artifacts, id: str) -> _Order:
    answer, state = (
        replace(file, path=str(artifacts.path(file)))
        for file in (store.run_file(id, name) for name in (RESULT, STATE))
    )
    return _Order(id, store.run_spec(id), answer, state)


def _registered(
    store: "Store",
    artifacts: Artifacts,
    order: _Order,
    read: tuple[Stored, Mapping[str, Any]] | str,
) -> Renewal:
    """A result that was read again, in its row; or why there is none."""
    if isinstance(read, str):
        return Renewal(order.run_id, reason=read)
    file, summary = read
    answer = replace(file, name=RESULT, path=artifacts.relative(Path(file.path)))
    marked = store.replace_result(order.run_id, order.answer.sha256, answer, summary)
    return Renewal(order.run_id, marked)


# --- in a child process ---------------------------------------------------------------------------


def _begin_child(targets: str | None) -> None:
    """Leave Ctrl-C to the parent, end with it, and know the definitions that the workers know."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    die_with_parent()
    if targets is not None:
        import_module(targets)


def _read_again(order: _Order) -> tuple[Stored, Mapping[str, Any]] | str:
    """The new result's file with its summary for the row; or why the earlier one stays."""
    try:
        return _write_again(order)
    except Exception as error:  # whatever it is, it touches this run alone
        return f"{type(error).__name__}: {error}"


def _write_again(order: _Order) -> tuple[Stored, Mapping[str, Any]]:
    run = Run.from_json(order.spec)
    if run.id != order.run_id:
        raise WhippleError("it was computed with another version of the physics")
    earlier, state = Path(order.answer.path), Path(order.state.path)
    for file, sha256 in ((earlier, order.answer.sha256), (state, order.state.sha256)):
        if digest(file) != sha256:
            raise Damaged(f"{file.name} does not match its checksum")
    before = RunResult.from_json(json.loads(earlier.read_bytes()))
    answer = remeasure(run, before, state, by=f"whipple {version()}").as_json()
    # Named after the earlier result, so that no registered file is ever written to.
    place = earlier.with_name(f"result-{order.answer.sha256[:16]}.json")
    write_text(place, json.dumps(answer, allow_nan=False, indent=1))
    return describe(place), summary_of(answer)
