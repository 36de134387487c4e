"""Reads the stored final state of a run again when the definition of a measurement has changed; nothing is solved.

What a run measured carries the version of the definition that it was read with. Where that is no longer today's, the
measurement is read off the final state once more. How a measurement grew belongs to its old definition, and a final
state cannot tell it: the history of one that was read again is its last value alone, its uncertainty has no part for
growth, whether it had settled is not said, and it gets the flag ``needs_solving``. A measurement that looks at the
history of others can be read again only while theirs is of today's definition; else it keeps its value and gets the
same flag.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from studies import measurements, scenarios
from studies.measurements import Measurement, Reading
from studies.results import TOO_COARSE, Measured, RunResult
from studies.runs.run import Run

NEEDS_SOLVING = "needs_solving"  # flag of a value whose history no stored state can renew
NEVER = Measured(None, None, {}, (NEEDS_SOLVING,), {"time": [], "value": []}, 0)


def definitions(scenario: str) -> Mapping[str, int]:
    """Version of each measurement of a scenario, as it is defined today."""
    return {name: measurements.load(name).version for name in scenarios.load(scenario).measurements}


def outdated(scenario: str, stored: Mapping[str, Mapping[str, Any]]) -> tuple[str, ...]:
    """Measurements of a run that a look at its final state could renew.

    ``stored`` has, by name, ``version`` and ``flags`` of what the run measured, as its JSON has them.
    """
    return tuple(
        name
        for name, version in definitions(scenario).items()
        if stored.get(name, {}).get("version") != version
        and not (
            measurements.load(name).follows
            and NEEDS_SOLVING in stored.get(name, {}).get("flags", ())
        )
    )


def remeasure(run: Run, result: RunResult, state: Path, *, by: str) -> RunResult:
    """The result of a run with all that is outdated read off its final state; ``by`` is who did it, for provenance.

    Raises whatever numpy does (OSError, ValueError, KeyError, BadZipFile) where the file is no state.
    """
    known = result.as_json()["measurements"]
    names = outdated(run.scenario, known)
    if not names:
        return result
    chosen = [measurements.load(name) for name in names]
    renewed = dict(result.measurements)
    seen = _view_of(run, result, state) if any(not one.follows for one in chosen) else None
    for one in chosen:
        if one.follows:
            renewed[one.name] = _renewed(one, _follow(one, result), result)
        else:
            renewed[one.name] = _without_history(run, one, one.read(seen), result)
    return replace(
        result,
        measurements={name: renewed[name] for name in _in_order(run.scenario, renewed)},
        provenance={**result.provenance, "remeasured": _told(result, chosen, by)},
    )


def load_state(file: Path, *, step: int = 0) -> Any:
    """The final state in a ``state.npz``, as a ``solver.state.Snapshot`` of the particles that were on the grid."""
    import numpy as np

    from solver.state import Particles, Snapshot

    with np.load(file, allow_pickle=False) as saved:
        body = saved["body"]
        alive = np.ones(body.size, np.uint8)
        fields = {name: saved[name] for name in Particles._fields if name != "alive"}
        return Snapshot(float(saved["time"]), step, Particles(**fields, alive=alive), body)


def _view_of(run: Run, result: RunResult, state: Path) -> Any:
    """What measurements of one state look at."""
    from studies.runs.execution import setting_of

    step = int(result.numbers.get("steps", 0))
    return scenarios.load(run.scenario).watch.view(setting_of(run), load_state(state, step=step))


def _follow(measurement: Measurement, result: RunResult) -> Reading | None:
    """A reading off stored histories; None where one of them is not whole, or of another definition."""
    import numpy as np

    from studies.measurements import History

    whole = max((_observations(one) for one in result.measurements.values()), default=0)
    followed = {name: result.measurements.get(name, NEVER) for name in measurement.follows}
    for name, one in followed.items():
        if one.version != measurements.load(name).version or not 0 < _observations(one) == whole:
            return None
    times = next(_floats(one.history["time"]) for one in followed.values())
    values = {name: _floats(one.history["value"]) for name, one in followed.items()}
    return measurement.read(History(np.asarray(times), values))


def _observations(measured: Measured) -> int:
    return len(measured.history["time"])


def _renewed(measurement: Measurement, reading: Reading | None, result: RunResult) -> Measured:
    """What a run measured, after another reading; with None there could be none."""
    before = result.measurements.get(measurement.name)
    if reading is None:
        kept = before or replace(NEVER, version=measurement.version)
        return replace(kept, flags=tuple(dict.fromkeys((*kept.flags, NEEDS_SOLVING))))
    return _measured(measurement, reading, result)


def _without_history(
    run: Run, measurement: Measurement, reading: Reading, result: RunResult
) -> Measured:
    """What a run measured, read off its final state alone."""
    measured = _measured(measurement, reading, result)
    flags: tuple[str, ...] = (*measured.flags, NEEDS_SOLVING)
    if measured.value is not None and scenarios.load(run.scenario).watch.too_coarse(result.numbers):
        return replace(measured, uncertainty=None, flags=(*flags, TOO_COARSE))
    return replace(measured, flags=flags)


def _measured(measurement: Measurement, reading: Reading, result: RunResult) -> Measured:
    known = math.isfinite(reading.value)
    value = reading.value if known else None
    return Measured(
        value=value,
        uncertainty=math.hypot(*reading.parts.values()) if known and reading.parts else None,
        parts=dict(reading.parts) if known else {},
        flags=reading.flags,
        history={"time": [result.numbers["end_time"]], "value": [value]},
        version=measurement.version,
    )


def _told(result: RunResult, chosen: Iterable[Measurement], by: str) -> str:
    """What was read again, from which definition to which; behind what was told before."""
    news = []
    for one in chosen:
        before = result.measurements.get(one.name)
        was = before.version if before else "nothing"
        news.append(f"{one.name} {was} to {one.version}")
    told = f"{', '.join(news)} by {by}"
    earlier = result.provenance.get("remeasured")
    return f"{earlier}; {told}" if earlier else told


def _in_order(scenario: str, found: Iterable[str]) -> Iterable[str]:
    """Names as the scenario has them, then those that it no longer has."""
    return dict.fromkeys([*(name for name in definitions(scenario) if name in found), *found])


def _floats(values: Iterable[float | None]) -> Any:
    import numpy as np

    return np.array([math.nan if value is None else value for value in values], float)
