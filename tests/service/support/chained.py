"""Runs in which each step needs the one before: whoever resumes wrongly gets another number.

Stands in for ``studies.runs.execution`` and ``studies.reports.publish``. Cube and report are the real ones, without
figures; a run takes ``WHIPPLE_TEST_SECONDS``, keeps a checkpoint after each of its steps and leaves its process id in
``pid``. Those whose speed ``FAILING`` names in the environment behave as runs of ``targets`` with that behaviour.
"""

import json
import os
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from solver.errors import Interrupted
from studies.quantities.files import write_text
from studies.quantities.measured import Measured
from studies.runs.results import NO_CONTROL, Progress, RunControl, RunResult
from tests.service.support.targets import Run, behave

__all__ = ["Run", "execute", "publish"]

FAILING = "WHIPPLE_TEST_FAILING"  # environment: behaviours by speed in m/s, as JSON
STEPS = 10
GROWTH = 3.9  # of the logistic map: chaotic, so that every bit of every step counts


def execute(
    run: Run,
    directory: Path,
    control: RunControl = NO_CONTROL,
    *,
    threads: int = 1,
    checkpoint: Path | None = None,
    film: bool = False,
) -> RunResult:
    """A chain of numbers from the run's id to its hole."""
    (directory / "pid").write_text(str(os.getpid()))
    failing = json.loads(os.environ.get(FAILING, "{}"))
    behave(failing.get(f"{run.parameters['speed']:.0f}", "fine"), run, directory)
    begun, value = _begin(run, checkpoint)
    step = begun
    control.log(f"begins at step {step}")
    pause = float(os.environ.get("WHIPPLE_TEST_SECONDS", 0)) / STEPS
    while step < STEPS:
        time.sleep(pause)
        step, value = step + 1, GROWTH * value * (1 - value)
        if checkpoint is not None:
            write_text(checkpoint, json.dumps([run.id, step, value]))
        control.checkpointed(step)
        control.progress(Progress(step / STEPS, 1.0, step, step / STEPS, None, {}))
        if control.must_stop():
            raise Interrupted(time=step / STEPS, step=step)
    went_on = f"on from step {begun}" if begun else ""
    result = _result(run, value, threads=threads, checkpoint=went_on)
    for name in ("state.npz", "film.npz")[: 1 + film]:
        write_text(directory / name, f"{run.id} {value!r}")
    write_text(directory / "result.json", json.dumps(result.as_json()))
    return result


def publish(
    document: Mapping[str, Any],
    outcomes: Mapping[str, Mapping[str, Any]],
    directory: Path,
    sections: Mapping[str, Path] | None = None,
) -> dict[str, str]:
    (directory / "pid").write_text(str(os.getpid()))
    # Most processes of a crash test compute runs alone, and need not load these.
    from studies.reports import publish as real
    from tests.studies.support.printed import undrawn

    with undrawn():
        return real.publish(document, outcomes, directory, sections)


def _begin(run: Run, checkpoint: Path | None) -> tuple[int, float]:
    """Where the last attempt was."""
    if checkpoint is None or not checkpoint.is_file():
        return 0, (int(run.id[:12], 16) + 1) / 2.0**49
    whose, step, value = json.loads(checkpoint.read_text())
    assert whose == run.id
    return step, value


def _result(run: Run, value: float, **provenance: Any) -> RunResult:
    hole = Measured(0.01 * value, 1e-4, {}, (), {"time": [0.0], "value": [0.01 * value]}, 1)
    return RunResult(
        run.id,
        "succeeded",
        measurements={"hole_diameter": hole},
        numbers={},
        stop="settled",
        provenance={"seconds": 0.5, **provenance},
    )
