"""Reads the stored final state of a run again when the definition of a measurement has changed; nothing is solved.

What a run measured carries the version of the definition that it was read with. Where that is no longer today's, the
measurement is read off the final state once more. How a measurement grew belongs to its old definition, and a final
state cannot tell it: the history of one that was read again is its last value alone, its uncertainty has no part for
growth, whether it had settled is not said, and it gets the flag ``needs_solving``. A measurement that looks at the
history of others keeps its value and gets the same flag.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from studies import measurements, scenarios
from studies.measurements import Measurement, Reading
from studies.quantities.measured import STILL_GROWING, Measured
from studies.runs.results import RunResult, as_measured, with_mesh_errors
from studies.runs.run import Run

NEEDS_SOLVING = "needs_solving"  # flag of a value whose history no stored state can renew
NEVER = Measured(None, None, {}, (NEEDS_SOLVING,), {"time": [], "value": []}, 0)


def definitions(scenario: str) -> Mapping[str, int]:
    """Version of each measurement of a scenario, as it is defined today."""
    return {name: measurements.load(name).version for name in scenarios.load(scenario).measurements}


def outdated(scenario: str, stored: Mapping[str, Mapping[str, Any]]) -> tuple[str, ...]:
    """Measurements of a run that a look at its final state could renew.

    ``stored`` has, by name, ``version`` and ``flags`` of what the run measured, as its JSON has them. What it did not
    measure and a run may lack is none.
    """
    return tuple(
        name
        for name, version in definitions(scenario).items()
        if stored.get(name, {}).get("version") != version
        and (name in stored or not scenarios.load(scenario).may_lack(name))
        and not (measurements.load(name).follows and NEEDS_SOLVING in stored.get(name, {}).get("flags", ()))
    )


def remeasure(run: Run, result: RunResult, state: Path, *, by: str) -> RunResult:
    """The result of a run with all that is outdated read off its final state; ``by`` is the author, for provenance.

    Raises numpy's errors (OSError, ValueError, KeyError, BadZipFile) where the file is no state.
    """
    chosen = [measurements.load(name) for name in outdated(run.scenario, result.as_json()["measurements"])]
    if not chosen:
        return result
    renewed = dict(result.measurements)
    read = [measurement for measurement in chosen if not measurement.follows]
    renewed |= {m.name: _kept(m, result) for m in chosen if m.follows}
    if read:
        view = _view_of(run, result, state)
        renewed |= {
            measurement.name: _from_state(run, measurement, measurement.read(view), result) for measurement in read
        }
    # Names as the scenario has them, then those that it no longer has.
    order = dict.fromkeys([*(n for n in definitions(run.scenario) if n in renewed), *renewed])
    renewed_result = replace(
        result,
        measurements={name: renewed[name] for name in order},
        provenance={**result.provenance, **({"remeasured": _provenance(result, read, by)} if read else {})},
    )
    return with_mesh_errors(run, renewed_result)


def load_state(file: Path, *, step: int = 0) -> Any:
    """The final state in a ``state.npz``, a ``solver.state.Snapshot``; only particles on the grid are in its arrays."""
    import numpy as np

    from solver.simulation import DEPARTED
    from solver.state import Departed, Particles, Snapshot

    with np.load(file, allow_pickle=False) as saved:
        body = saved["body"]
        alive = np.ones(body.size, np.uint8)
        fields = {name: saved[name] for name in Particles._fields if name != "alive"}
        departed = Departed(*(saved[DEPARTED + name] for name in Departed._fields))
        return Snapshot(float(saved["time"]), step, Particles(**fields, alive=alive), body, departed)


def _view_of(run: Run, result: RunResult, state: Path) -> Any:
    """The view of the stored final state that the scenario's measurements read."""
    import numpy as np

    from solver.state import MASS
    from studies.runs.stages import earlier_stages, setting_of

    step = int(result.numbers.get("steps", 0))
    with np.load(state, allow_pickle=False) as saved:
        setting = setting_of(run, earlier_stages(saved))
    snapshot, arrivals = load_state(state, step=step), setting.problem.arrivals
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
    return _measured(run, measurement, replace(reading, flags=flags), result)


def _measured(run: Run, measurement: Measurement, reading: Reading, result: RunResult) -> Measured:
    scenario, value = scenarios.load(run.scenario), reading.value if math.isfinite(reading.value) else None
    history: dict[str, list[float | None]] = {"time": [result.numbers["end_time"]], "value": [value]}
    return as_measured(scenario, scenario.record(run.parameters), measurement, reading, history)


def _provenance(result: RunResult, chosen: Iterable[Measurement], by: str) -> str:
    """The measurements that were read again, with old and new version; appended to earlier entries."""
    changes = []
    for measurement in chosen:
        before = result.measurements.get(measurement.name)
        changes.append(f"{measurement.name} {before.version if before else 'nothing'} to {measurement.version}")
    entry = f"{', '.join(changes)} by {by}"
    earlier = result.provenance.get("remeasured")
    return f"{earlier}; {entry}" if earlier else entry
