"""Stands in for ``studies.runs.execution`` and ``studies.reports.publish``: runs that behave as their parameters say.

A run is ``fine`` by default. It can also return a ``verdict``, ``abort`` the interpreter (the first ``crashes`` times),
``raise`` (also because its disk is ``stale``), ``hang``, be ``busy`` (for a second, without reading messages),
``deaf`` (hang with the interpreter blocked), ``silent`` (return without a result),
``greedy`` (take memory without end, or so many ``mebibytes``) or ``starved`` (the same, in a library that aborts),
``litter`` (start a process of its own, then hang), ``orphan`` (fork, then crash), print ``noise``, ``roar`` (print so
many ``mebibytes``), or ``soil`` the process that computes it. Each leaves its process id in ``pid`` in its folder.

A run has steps of which each needs the one before: whoever resumes wrongly gets another hole. With ``seconds``, or
``WHIPPLE_TEST_SECONDS``, it takes as long: it tells progress, keeps a checkpoint after each step, goes on from there,
and leaves when asked to. Those whose speed ``FAILING`` names in the environment behave as it says. Runs and sweeps do
not end before the files are there that ``RUN_GATE`` and ``SWEEP_GATE`` name.
"""

import ctypes
import errno
import json
import os
import subprocess
import time
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from solver.errors import Interrupted
from studies.quantities.files import SWEEP_FILES, write_text
from studies.quantities.measured import Measured
from studies.runs import run as real
from studies.runs.results import NO_CONTROL, Progress, RunControl, RunResult

RUN_GATE, SWEEP_GATE = "WHIPPLE_TEST_RUN_GATE", "WHIPPLE_TEST_SWEEP_GATE"
FAILING = "WHIPPLE_TEST_FAILING"  # environment: behaviours by speed in m/s, as JSON
PAUSE = 0.02  # s, between two looks at a gate
STEPS = 10
GROWTH = 3.9  # of the logistic map: chaotic, so that every bit of every step counts
FOREVER = 600  # s; longer than any test waits
MEBIBYTE = 1 << 20
PERFORATES = 155.0  # m/s: the least speed at which a plate is perforated
MOST = 4096  # MiB that a greedy run takes at most: a machine without limits should survive it

FAKE = "fake"  # in place of the materials of a fake run: its id


@dataclass(frozen=True)
class FakeRun:
    """A question that costs nothing."""

    id: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    scenario: str = "thin_plate"

    def as_json(self) -> real.RunSpec:
        return {"scenario": self.scenario, "parameters": dict(self.parameters), "materials": {FAKE: {"id": self.id}}}

    @staticmethod
    def from_json(plain: real.RunSpec) -> "FakeRun":
        """The run that ``as_json``, here or of a real run, wrote."""
        id = str(plain["materials"][FAKE]["id"]) if FAKE in plain["materials"] else real.Run.from_json(plain).id
        return FakeRun(id, plain["parameters"], plain["scenario"])


Run = FakeRun  # the name under which a warm process asks for it


def execute(
    run: FakeRun,
    directory: Path,
    control: RunControl = NO_CONTROL,
    *,
    threads: int = 1,
    checkpoint: Path | None = None,
    film: bool = False,
) -> RunResult:
    """Behave as the parameters say, and leave the result that a real run would leave."""
    (directory / "pid").write_text(str(os.getpid()))
    failing = json.loads(os.environ.get(FAILING, "{}"))
    behaviour = str(run.parameters.get("behaviour", failing.get(f"{run.parameters.get('speed', 0):.0f}", "fine")))
    chain = _Chain(run, checkpoint, control)
    control.log(f"begins at step {chain.step}")
    begun = f"on from step {chain.step}" if chain.step else ""
    behave(behaviour, run, directory)
    chain.go_on()
    while _is_closed(RUN_GATE):
        time.sleep(PAUSE)
        chain.mind()
    result = _result(run, behaviour, chain.value, threads=threads, checkpoint=begun)
    if behaviour != "silent":
        for name in ("state.npz", "film.npz")[: 1 + film]:
            write_text(directory / name, f"{run.id} {chain.value!r}")
        write_text(directory / "result.json", json.dumps(result.as_json()))
    return result


def behave(behaviour: str, run: FakeRun, directory: Path) -> None:
    """Do what a behaviour does beside computing; nothing, if the run is fine."""
    action = globals().get(f"_{behaviour}")
    if action is not None:
        action(run, directory)


def publish(
    document: Mapping[str, Any],
    outcomes: Mapping[str, Mapping[str, Any]],
    directory: Path,
    sections: Mapping[str, Path] | None = None,
    places: Any = None,
) -> dict[str, str]:
    if document.get("name") == "unpublishable":
        raise RuntimeError("this sweep cannot be published")
    while _is_closed(SWEEP_GATE):
        time.sleep(PAUSE)
    outcomes_as_json = {id: {"state": one["state"], "reason": one["reason"]} for id, one in outcomes.items()}
    for name in SWEEP_FILES:
        write_text(directory / name, json.dumps(outcomes_as_json, sort_keys=True))
    return {}


def _is_closed(gate: str) -> bool:
    """Whether the environment names a file that is not there."""
    name = os.environ.get(gate)
    return name is not None and not Path(name).exists()


class _Chain:
    """Steps that take their time, with a checkpoint after each."""

    def __init__(self, run: FakeRun, checkpoint: Path | None, control: RunControl):
        """Go on from the checkpoint, if there is one."""
        self._id, self._checkpoint, self._control = run.id, checkpoint, control
        self._pause = float(run.parameters.get("seconds", os.environ.get("WHIPPLE_TEST_SECONDS", 0))) / STEPS
        self.step, self.value = 0, (int(run.id[:12], 16) + 1) / 2.0**49
        if checkpoint is not None and checkpoint.is_file():
            whose, self.step, self.value = json.loads(checkpoint.read_text())
            assert whose == run.id
            control.checkpointed(self.step)

    def go_on(self) -> None:
        """All steps that are left."""
        while self.step < STEPS:
            self.step, self.value = self.step + 1, GROWTH * self.value * (1 - self.value)
            if self._pause:
                time.sleep(self._pause)
                self._tell(self.step / STEPS)

    def _tell(self, done: float) -> None:
        if self._checkpoint is not None:
            write_text(self._checkpoint, json.dumps([self._id, self.step, self.value]))
            self._control.checkpointed(self.step)
        self._control.progress(Progress(done, 1.0, self.step, done, None, {"hole_diameter": done}))
        self.mind()

    def mind(self) -> None:
        if self._control.must_stop():
            raise Interrupted(time=self.step / STEPS, step=self.step)


def _result(run: FakeRun, behaviour: str, value: float, **provenance: Any) -> RunResult:
    if behaviour == "verdict":
        reason = "density = 3e4 at particle 17"
        return RunResult(run.id, "failed", reason=reason, failure="UnphysicalState")
    hole = Measured(0.01 * value, 1e-4, {}, (), {"time": [0.0], "value": [0.01 * value]}, 1)
    measurements = {"hole_diameter": hole}
    if run.scenario == "plugging":
        through = float(run.parameters["speed"]) >= PERFORATES
        measurements["perforated"] = Measured(float(through), None, {}, (), hole.history, 1)
    if "behaviour" in run.parameters:  # no run of a cube: what another could have left in its process
        provenance |= {
            "process": str(os.getpid()),
            "folder": os.getcwd(),
            "filters": str(sum(one[2] is SoilWarning for one in warnings.filters)),
            "numba_threads": os.environ.get("NUMBA_NUM_THREADS", ""),
        }
    return RunResult(
        run.id,
        "succeeded",
        measurements=measurements,
        flags=(),
        numbers={},
        stop="settled",
        provenance={"seconds": 0.5, **provenance},
    )


class SoilWarning(UserWarning):
    """Nobody has heard of it."""


def _abort(run: FakeRun, directory: Path) -> None:
    attempts = len(list(directory.parent.glob("a*")))
    if attempts <= int(run.parameters.get("crashes", FOREVER)):
        os.abort()


def _raise(run: FakeRun, directory: Path) -> None:
    raise RuntimeError("something that nobody foresaw")


def _stale(run: FakeRun, directory: Path) -> None:
    raise OSError(errno.ESTALE, os.strerror(errno.ESTALE))


def _hang(run: FakeRun, directory: Path) -> None:
    time.sleep(FOREVER)


def _deaf(run: FakeRun, directory: Path) -> None:
    ctypes.PyDLL(None).sleep(FOREVER)


def _busy(run: FakeRun, directory: Path) -> None:
    time.sleep(1)


def _greedy(run: FakeRun, directory: Path) -> None:
    try:
        hoard = [bytearray(MEBIBYTE) for _ in range(int(run.parameters.get("mebibytes", MOST)))]
    except MemoryError as error:
        raise RuntimeError("a library that says it in its own words") from error
    del hoard


def _starved(run: FakeRun, directory: Path) -> None:
    reserve = ctypes.CDLL(None).malloc
    reserve.restype = ctypes.c_void_p
    for _ in range(MOST):
        if reserve(ctypes.c_size_t(MEBIBYTE)) is None:
            os.write(2, b"terminate called after throwing an instance of 'std::bad_alloc'\n")
            os.abort()


def _litter(run: FakeRun, directory: Path) -> None:
    other = subprocess.Popen(["sleep", str(FOREVER)])
    write_text(directory / "litter", str(other.pid))
    if "seconds" not in run.parameters:
        time.sleep(FOREVER)


def _orphan(run: FakeRun, directory: Path) -> None:
    if pid := os.fork():
        write_text(directory / "litter", str(pid))
        os.abort()
    time.sleep(FOREVER)


def _roar(run: FakeRun, directory: Path) -> None:
    print("first words", flush=True)
    for _ in range(int(run.parameters["mebibytes"])):
        os.write(1, b"x" * (MEBIBYTE - 1) + b"\n")
    print("last words", flush=True)


def _noise(run: FakeRun, directory: Path) -> None:
    print("not a JSON line", flush=True)
    os.write(1, b"nor is this\n")
    ctypes.CDLL(None).puts(b"nor this, which a library holds back")


def _soil(run: FakeRun, directory: Path) -> None:
    os.chdir("/tmp")
    warnings.simplefilter("error", SoilWarning)
