"""Outdated results measured again from stored final states, after the definition of a measurement has changed.

No service runs meanwhile, and nothing is solved. A child process measures one state and writes a result beside
the earlier one; one transaction then points the run to it and marks the sweeps that use the run, which the next
start of the service publishes again. After an interruption the same command continues: current results are
skipped.
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
from typing import TYPE_CHECKING

from service import version
from service.files.artifacts import Artifacts, describe, digest
from service.queue.verification import Damaged, summary_of
from service.records.jobs import State, Stored, Summary, SweepStatus
from service.settings import Settings
from service.workers.warm_process import die_with_parent
from solver.errors import WhippleError
from studies.quantities.files import RESULT, STATE, write_text
from studies.runs.remeasure import outdated, remeasure
from studies.runs.results import RunResult
from studies.runs.run import Run, RunSpec

if TYPE_CHECKING:
    from service.store import Store

BATCH = 1000  # runs whose parameters are in memory, about 2 kB each

NewResult = tuple[Stored, Summary]  # its file, and the summary for the run's row


@dataclass(frozen=True)
class RemeasurePlan:
    """The outdated results of a store, by run."""

    measurable: tuple[str, ...]  # runs with a stored final state
    without_state: tuple[str, ...]  # their results stay unchanged
    sweeps: Mapping[str, str]  # names by id of the sweeps that use measurable runs


@dataclass(frozen=True)
class Remeasured:
    """The outcome for one outdated result."""

    run_id: str
    marked: tuple[str, ...] = ()  # sweeps that the next start of the service publishes again
    reason: str | None = None  # why the result is unchanged


@dataclass(frozen=True)
class _Task:
    """One result to measure again, for a child process; paths are absolute."""

    run_id: str
    spec: RunSpec
    answer: Stored
    state: Stored


def plan_of(store: "Store") -> RemeasurePlan:
    """The outdated results of a store, found with a few statements for each sweep."""
    measurable: set[str] = set()
    without_state: set[str] = set()
    sweeps: dict[str, str] = {}
    for sweep in _sweeps(store):
        for run in store.runs.measured(sweep.id):
            measured = run.summary.get("measurements", {}) if run.summary else {}
            if run.state is not State.SUCCEEDED or not outdated(run.scenario, measured):
                continue
            if run.kept is None:
                without_state.add(run.id)
            else:
                measurable.add(run.id)
                sweeps[sweep.id] = sweep.name
    return RemeasurePlan(tuple(sorted(measurable)), tuple(sorted(without_state)), sweeps)


def _sweeps(store: "Store") -> Iterator[SweepStatus]:
    page = store.sweeps.page()
    yield from page.items
    while page.next_cursor is not None:
        page = store.sweeps.page(cursor=page.next_cursor)
        yield from page.items


def remeasure_runs(settings: Settings, store: "Store", run_ids: Sequence[str]) -> Iterator[Remeasured]:
    """Measure states again in child processes, and register the results one by one.

    The caller keeps services away. Raises WhippleError if a child process dies, and StoreUnavailable.
    """
    artifacts = Artifacts.of(settings)
    pool = ProcessPoolExecutor(
        min(settings.workers, len(run_ids)),
        # A forked child would inherit the lock of the data directory.
        multiprocessing.get_context("spawn"),
        _begin_child,
        (settings.targets_module,),
    )
    try:
        with pool:
            for begin in range(0, len(run_ids), BATCH):
                tasks = [_task(store, artifacts, id) for id in run_ids[begin : begin + BATCH]]
                for task, outcome in zip(tasks, pool.map(_measure, tasks), strict=True):
                    yield _register(store, artifacts, task, outcome)
    except BrokenProcessPool:
        raise WhippleError(
            "a process that measures states died; finished results are registered; repeat the command, "
            "with WHIPPLE_WORKERS=1 if the memory was exhausted"
        ) from None


def _task(store: "Store", artifacts: Artifacts, id: str) -> _Task:
    answer, state = (
        replace(file, path=str(artifacts.local(file)))
        for file in (store.runs.file(id, name) for name in (RESULT, STATE))
    )
    return _Task(id, store.runs.spec(id), answer, state)


def _register(store: "Store", artifacts: Artifacts, task: _Task, outcome: NewResult | str) -> Remeasured:
    """Point the run to its new result, unless the outcome is the reason why there is none."""
    if isinstance(outcome, str):
        return Remeasured(task.run_id, reason=outcome)
    file, summary = outcome
    answer = replace(file, name=RESULT, path=artifacts.relative(Path(file.path)))
    artifacts.keep([answer])
    marked = store.runs.replace_result(task.run_id, task.answer.sha256, answer, summary)
    return Remeasured(task.run_id, marked)


# --- in a child process ---------------------------------------------------------------------------


def _begin_child(targets: str | None) -> None:
    """Leave Ctrl-C to the parent, end with it, and load the measurements that the workers use."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    die_with_parent()
    if targets is not None:
        import_module(targets)


def _measure(task: _Task) -> NewResult | str:
    """The new result; or the reason why the earlier one stays."""
    try:
        return _measure_state(task)
    # Any error concerns this run only.
    except Exception as error:
        return f"{type(error).__name__}: {error}"


def _measure_state(task: _Task) -> NewResult:
    run = Run.from_json(task.spec)
    if run.id != task.run_id:
        raise WhippleError("it was computed with another version of the physics")
    earlier, state = Path(task.answer.path), Path(task.state.path)
    for file, sha256 in ((earlier, task.answer.sha256), (state, task.state.sha256)):
        if digest(file) != sha256:
            raise Damaged(f"{file.name} does not match its checksum")
    before = RunResult.from_json(json.loads(earlier.read_bytes()))
    answer = remeasure(run, before, state, by=f"whipple {version()}").as_json()
    # Named after the earlier result, so that no registered file is overwritten.
    file = earlier.with_name(f"result-{task.answer.sha256[:16]}.json")
    write_text(file, json.dumps(answer, allow_nan=False, indent=1))
    return describe(file), summary_of(RunResult.from_json(answer))
