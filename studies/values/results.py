"""The result of a run: measurements with uncertainty and history, balances, flags, provenance; JSON both ways."""

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

# Flags of a value with an unknown error: no law is compared with it.
TOO_COARSE = "too_coarse"  # read on a grid with fewer than two cells through the plate
CLOSED_ON_AXIS = "closed_on_axis"  # a film of the plate still closes the hole
MESH_DETERMINED = "mesh_determined"  # read off one grid, which decides such a value
ENOUGH_GRIDS = 3  # of one point, that take the flags of one grid from its values: they show the mesh
NOT_COMPARED = (TOO_COARSE, CLOSED_ON_AXIS)
# Nothing that is stated of a value says how far off it is. It doubts no value, and stands where there is no error bar.
ERROR_UNKNOWN = "error_unknown"
BY_ONE_GRID = (MESH_DETERMINED, ERROR_UNKNOWN)  # flags that enough grids take away
# The body has lost the particles that a measurement reads, so that the run has no answer; a flag of the run, too.
LOST_PARTICLES = "lost_particles"

# Part of an uncertainty that no mesh makes: half of the difference between two definitions of a quantity, where it has
# a second. It stands beside the numerical uncertainty, which is what converges and what tests of coverage are about.
DEFINITION = "definition"

# Share of the initial energy that a run may lose track of before it is marked, a verification case fails or a recipe is
# out: the first rule of docs/recipe.md. The sum is kept by construction, so that a drift is an error of bookkeeping.
ENERGY_DRIFT_LIMIT = 0.01


@dataclass(frozen=True)
class Measured:
    """A number read off the state of a run."""

    value: float | None  # None where the flags say why
    # Of the reading, standard: root of the sum of squares of the numerical parts; None: too coarse, or not known.
    uncertainty: float | None
    parts: Mapping[str, float]  # resolution, azimuth, growth; definition: same unit as the value
    flags: tuple[str, ...]
    history: Mapping[str, list[float | None]]  # time (s) and value
    version: int  # of the definition


def numerical_parts(parts: Mapping[str, float]) -> dict[str, float]:
    """The parts of an uncertainty that the numerics make: all but that of the definition."""
    return {name: size for name, size in parts.items() if name != DEFINITION}


@dataclass(frozen=True)
class Progress:
    """The progress of a run."""

    time: float  # simulated, s
    end_time: float  # cap, s
    step: int
    fraction: float  # 0..1 of the cap; a run may end earlier
    eta_seconds: float | None
    measured: Mapping[str, float]


def _ignore(_: object) -> None:
    """Take a report and do nothing."""


def _never() -> bool:
    return False


@dataclass(frozen=True, kw_only=True)
class RunControl:
    """The reports that a run makes to its caller while it computes, and the caller's wish that it leaves."""

    progress: Callable[[Progress], object] = _ignore  # after each observation
    log: Callable[[str], object] = _ignore  # each line of the run log
    checkpointed: Callable[[int], object] = _ignore  # step of a checkpoint, written or resumed from
    must_stop: Callable[[], bool] = _never  # asked after each step


NO_CONTROL = RunControl()


@dataclass(frozen=True)
class RunResult:
    """The outcome of a run: succeeded, or failed with an unphysical state."""

    run_id: str
    state: str  # "succeeded" or "failed"
    reason: str | None = None  # of a failure, or of an answer that was lost, in words
    failure: str | None = None  # of a failure, its kind
    measurements: Mapping[str, Measured] = field(default_factory=dict)
    flags: tuple[str, ...] = ()
    numbers: Mapping[str, float] = field(default_factory=dict)
    stop: str = ""  # "settled", "end_time"
    # Of the whole bodies, not of a sector: "time" (s), names of the "bodies", and lists over time, by body or alone.
    histories: Mapping[str, Any] = field(default_factory=dict)
    # By name (studies.measurements._distributions): "version", and "values" in nested lists.
    distributions: Mapping[str, Any] = field(default_factory=dict)
    provenance: Mapping[str, str | float] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """As plain objects that JSON can hold: no NaN."""
        plain: dict[str, Any] = _plain(dataclasses.asdict(self))
        return plain

    @staticmethod
    def from_json(plain: Mapping[str, Any]) -> "RunResult":
        """The result that ``as_json`` wrote."""
        measured = {
            name: Measured(**{**value, "flags": tuple(value["flags"])}) for name, value in plain["measurements"].items()
        }
        return RunResult(**{**plain, "measurements": measured, "flags": tuple(plain["flags"])})


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
