"""Reads the stored final state of a run again when the definition of a measurement has changed; nothing is solved.

A final state cannot tell how a measurement grew: the history of one that was read again is its last value alone, its
uncertainty has no part for growth, whether it had settled is not said, and it gets the flag ``needs_solving``. A
measurement that looks at the history of others keeps its value and gets the same flag.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

from studies import measurements, scenarios
from studies.measurements import Measurement, Reading
from studies.quantities.measured import STILL_GROWING, Measured
from studies.runs.results import RunResult, as_measured, with_mesh_errors
from studies.runs.run import Run

if TYPE_CHECKING:
    from solver.state import Snapshot
    from studies.scenarios import Setting

NEEDS_SOLVING = "needs_solving"  # flag of a value whose history no stored state can renew
NEVER = Measured(None, None, {}, (NEEDS_SOLVING,), {"time": [], "value": []}, 0)


def definitions(scenario: str) -> Mapping[str, int]:
    """Version of each measurement of a scenario, as it is defined today."""
    return {name: measurements.load(name).version for name in scenarios.load(scenario).measurements}


class StoredVersion(TypedDict, total=False):
    """What the JSON of a measurement says of its definition."""

    version: int
    flags: Sequence[str]


def outdated(scenario: str, stored: Mapping[str, StoredVersion]) -> tuple[str, ...]:
    """Measurements that a look at the final state of a run could renew, but for those that the run may lack."""

    known = scenarios.load(scenario)
    may_lack = {*known.of_role, *known.asked_by}

    def is_outdated(name: str, version: int) -> bool:
        if name not in stored:
            return name not in may_lack
        is_settled = measurements.load(name).follows and NEEDS_SOLVING in stored[name]["flags"]
        return stored[name]["version"] != version and not is_settled

    return tuple(name for name, version in definitions(scenario).items() if is_outdated(name, version))


def versions_of(result: RunResult) -> dict[str, StoredVersion]:
    """What the JSON of a result says of the definitions of its measurements."""
    return {name: StoredVersion(version=m.version, flags=m.flags) for name, m in result.measurements.items()}


def remeasure(run: Run, result: RunResult, state: Path, *, by: str) -> RunResult:
    """The result of a run with all that is outdated read off its final state; ``by`` is the author, for provenance.

    Raises numpy's errors (OSError, ValueError, KeyError, BadZipFile) where the file is no state.
    """
    chosen = [measurements.load(name) for name in outdated(run.scenario, versions_of(result))]
    if not chosen:
        return result
    read = [measurement for measurement in chosen if not measurement.follows]
    renewed = {**result.measurements, **{m.name: _kept(m, result) for m in chosen if m.follows}}
    if read:
        view = _view_of(run, result, state)
        renewed |= {m.name: _from_state(run, m, m.read(view), result) for m in read}
    # Names as the scenario has them, then those that it no longer has.
    order = dict.fromkeys([*(n for n in definitions(run.scenario) if n in renewed), *renewed])
    renewed_result = replace(
        result,
        measurements={name: renewed[name] for name in order},
        provenance={**result.provenance, **({"remeasured": _provenance(result, read, by)} if read else {})},
    )
    return with_mesh_errors(run, renewed_result)


def load_state(file: Path) -> "Snapshot":
    """The final state in a ``state.npz``; only particles on the grid are in its arrays."""
    import numpy as np

    from solver.simulation import DEPARTED
    from solver.state import Departed, Particles, Snapshot

    with np.load(file, allow_pickle=False) as saved:
        body = saved["body"]
        alive = np.ones(body.size, np.uint8)
        fields = {name: saved[name] for name in Particles._fields if name != "alive"}
        departed = Departed(*(saved[DEPARTED + name] for name in Departed._fields))
        return Snapshot(float(saved["time"]), 0, Particles(**fields, alive=alive), body, departed)


def end_of(run: Run, file: Path) -> "tuple[Setting, Snapshot]":
    """The problem of the last stage of a run, and its stored final state."""
    import numpy as np

    from studies.runs.stages import earlier_stages, setting_of

    with np.load(file, allow_pickle=False) as saved:
        setting = setting_of(run, earlier_stages(saved))
    return setting, load_state(file)


def _view_of(run: Run, result: RunResult, state: Path) -> Any:
    """The view of the stored final state that the scenario's measurements read."""
    from solver.state import MASS

    setting, snapshot = end_of(run, state)
    snapshot, arrivals = snapshot._replace(step=int(result.numbers.get("steps", 0))), setting.problem.arrivals
    if arrivals is not None:
        snapshot = snapshot._replace(waiting=float(arrivals.table[MASS][arrivals.time > snapshot.time].sum()))
    return scenarios.load(run.scenario).parameters.view(setting, snapshot)


def _kept(measurement: Measurement, result: RunResult) -> Measured:
    """A measurement of the course of a run, with the flag that it has to be solved again."""
    before = result.measurements.get(measurement.name) or replace(NEVER, version=measurement.version)
    return replace(before, flags=tuple(dict.fromkeys((*before.flags, NEEDS_SOLVING))))


def _from_state(run: Run, measurement: Measurement, reading: Reading, result: RunResult) -> Measured:
    """A measurement read off the final state alone; an outcome that had not settled stays open."""
    before, flags = result.measurements.get(measurement.name), (*reading.flags, NEEDS_SOLVING)
    if before and STILL_GROWING in before.flags and measurement.is_outcome and reading.value == 0.0:
        flags = (*flags, STILL_GROWING)
    value = reading.value if math.isfinite(reading.value) else None
    history: dict[str, list[float | None]] = {"time": [result.numbers["end_time"]], "value": [value]}
    flagged = replace(reading, flags=flags)
    return as_measured(scenarios.load(run.scenario), run.set_up, measurement, flagged, history)


def _provenance(result: RunResult, chosen: Iterable[Measurement], by: str) -> str:
    """The measurements that were read again, with old and new version; appended to earlier entries."""
    changes = []
    for measurement in chosen:
        before = result.measurements.get(measurement.name)
        changes.append(f"{measurement.name} {before.version if before else 'nothing'} to {measurement.version}")
    entry = f"{', '.join(changes)} by {by}"
    earlier = result.provenance.get("remeasured")
    return f"{earlier}; {entry}" if earlier else entry
