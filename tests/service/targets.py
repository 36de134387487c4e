"""Stands in for ``studies.run`` and ``studies.publish``: runs that behave as their parameters say.

A run is ``fine`` unless told otherwise. It can also return a ``verdict``, ``abort`` the interpreter
(the first ``crashes`` times), ``raise``, ``hang``, be ``deaf`` (hang with the interpreter blocked),
be ``silent`` (return without a result), ``litter`` (start a process of its own, then hang) or print
``noise``. Each leaves its process id in ``pid`` in its folder.
"""

import ctypes
import json
import os
import subprocess
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from studies import run as real
from studies.atomic import write_text
from studies.results import Measured, Progress, RunResult

STEPS = 10
FOREVER = 600  # s; longer than any test waits


@dataclass(frozen=True)
class Run:
    """A question that costs nothing."""

    id: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    scenario: str = "thin_plate"

    def as_json(self) -> dict[str, Any]:
        """As plain objects."""
        return {"id": self.id, "scenario": self.scenario, "parameters": dict(self.parameters)}

    @staticmethod
    def from_json(plain: Mapping[str, Any]) -> "Run":
        """The run that ``as_json``, here or of a real run, wrote."""
        id = plain["id"] if "id" in plain else real.Run.from_json(plain).id
        return Run(id, plain["parameters"], plain["scenario"])


def execute(
    run: Run, directory: Path, progress: Callable[[Progress], None] | None = None
) -> RunResult:
    """Behave as the parameters say, and leave the result that a real run would leave."""
    (directory / "pid").write_text(str(os.getpid()))
    behaviour = str(run.parameters.get("behaviour", "fine"))
    _BEHAVIOURS.get(behaviour, _fine)(run, directory)
    seconds = float(run.parameters.get("seconds", os.environ.get("WHIPPLE_TEST_SECONDS", 0)))
    for step in range(STEPS if seconds else 0):
        time.sleep(seconds / STEPS)
        if progress is not None:
            done = (step + 1) / STEPS
            progress(Progress(done, 1.0, step, done, None, {"hole_diameter": 0.01 * done}))
    result = _result(run, behaviour)
    if behaviour != "silent":
        write_text(directory / "result.json", json.dumps(result.as_json()))
    return result


def publish(
    document: Mapping[str, Any], outcomes: Mapping[str, Mapping[str, Any]], directory: Path
) -> dict[str, str]:
    """Three files that say what was given."""
    if document.get("name") == "unpublishable":
        raise RuntimeError("this sweep cannot be published")
    said = {id: {"state": one["state"], "reason": one["reason"]} for id, one in outcomes.items()}
    for name in ("cube.nc", "report.html", "report.json"):
        write_text(directory / name, json.dumps(said, sort_keys=True))
    return {}


def _result(run: Run, behaviour: str) -> RunResult:
    if behaviour == "verdict":
        reason = "density = 3e4 at particle 17"
        return RunResult(run.id, "failed", reason=reason, failure="UnphysicalState")
    hole = Measured(0.0148, 1e-4, {}, (), {"time": [0.0], "value": [0.0148]}, 1)
    return RunResult(
        run.id,
        "succeeded",
        measurements={"hole_diameter": hole},
        flags=("under_resolved",),
        numbers={"threads": float(os.environ["NUMBA_NUM_THREADS"])},
        stop="settled",
        provenance={"seconds": 0.5},
    )


def _fine(run: Run, directory: Path) -> None:
    """Nothing special."""


def _abort(run: Run, directory: Path) -> None:
    attempts = len(list(directory.parent.iterdir()))
    if attempts <= int(run.parameters.get("crashes", FOREVER)):
        os.abort()


def _raise(run: Run, directory: Path) -> None:
    raise RuntimeError("something that nobody foresaw")


def _hang(run: Run, directory: Path) -> None:
    time.sleep(FOREVER)


def _deaf(run: Run, directory: Path) -> None:
    ctypes.PyDLL(None).sleep(FOREVER)


def _litter(run: Run, directory: Path) -> None:
    other = subprocess.Popen(["sleep", str(FOREVER)])
    write_text(directory / "litter", str(other.pid))
    time.sleep(FOREVER)


def _noise(run: Run, directory: Path) -> None:
    print("not a JSON line", flush=True)
    os.write(1, b"nor is this\n")


_BEHAVIOURS = {
    "abort": _abort,
    "raise": _raise,
    "hang": _hang,
    "deaf": _deaf,
    "litter": _litter,
    "noise": _noise,
}
