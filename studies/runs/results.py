"""The result of a run, with JSON both ways; and what a run reports while it is computed."""

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypedDict

from studies import scenarios
from studies.quantities.measured import MESH_DETERMINED, STILL_GROWING, TOO_COARSE, UNDER_RESOLVED, WIDE_BAR, Measured
from studies.quantities.parameters import Plain

if TYPE_CHECKING:
    from studies.measurements import Measurement, Reading
    from studies.runs.run import Run
    from studies.scenarios import Scenario, SetUp


OTHER_PHYSICS = "OtherPhysics"  # kind of the failure of a run that another version alone can compute


@dataclass(frozen=True)
class Progress:
    """The progress of a run."""

    time: float  # simulated, s
    end_time: float  # cap, s
    step: int
    fraction: float  # 0..1 of the time that is expected; a run that settles has some left at its end
    eta_seconds: float | None
    measured: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class RunControl:
    """The reports that a run makes to its caller while it computes, and the caller's wish that it leaves."""

    progress: Callable[[Progress], object] = lambda progress: None  # after each observation
    log: Callable[[str], object] = lambda line: None  # each line of the run log
    checkpointed: Callable[[int], object] = lambda step: None  # step of a checkpoint, written or resumed from
    must_stop: Callable[[], bool] = lambda: False  # asked after each step


NO_CONTROL = RunControl()


class ReadDistribution(TypedDict):
    """A distribution as it was read off a run."""

    version: int
    values: list[float | list[float]]  # over its bins


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
    stop: str = ""  # "settled", "decided", "end_time"
    # Of the whole bodies, not of a sector: "time" (s), names of the "bodies", and lists over time, by body or alone.
    histories: Mapping[str, Any] = field(default_factory=dict)
    # By name (studies.measurements.distributions).
    distributions: Mapping[str, ReadDistribution] = field(default_factory=dict)
    provenance: Mapping[str, str | float] = field(default_factory=dict)

    def as_json(self) -> dict[str, Plain]:
        """As plain objects that JSON can hold: no NaN."""
        return {name: _plain(value) for name, value in dataclasses.asdict(self).items()}

    @staticmethod
    def from_json(plain: Mapping[str, Any]) -> "RunResult":
        """The result that ``as_json`` wrote."""
        measured = {
            name: Measured(**{**value, "flags": tuple(value["flags"])}) for name, value in plain["measurements"].items()
        }
        return RunResult(**{**plain, "measurements": measured, "flags": tuple(plain["flags"])})


def with_mesh_errors(run: "Run", result: RunResult) -> RunResult:
    """A result whose measurements have their mesh errors beside them, where experience tells them.

    Where it tells those of all that settles, the run is not under-resolved: its grid is in their bars.
    """
    errors, settles = run.mesh_errors, scenarios.load(run.scenario).settles
    is_known = bool(settles) and errors.keys() >= {*settles}
    flags = tuple(flag for flag in result.flags if not (is_known and flag == UNDER_RESOLVED))
    measured = {
        name: replace(one, mesh_error=dataclasses.asdict(errors[name])) if name in errors else one
        for name, one in result.measurements.items()
    }
    return replace(result, measurements=measured, flags=flags)


def _plain(value: Plain) -> Plain:
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def as_measured(
    scenario: "Scenario",
    parameters: "SetUp",
    measurement: "Measurement",
    reading: "Reading",
    history: Mapping[str, list[float | None]],
    *,
    growth: float = math.nan,
    settled: bool = True,
) -> Measured:
    """A reading with its uncertainty and flags; ``growth`` is a part of it, ``settled`` says whether the value has."""
    value, parts, flags = (reading.value if math.isfinite(reading.value) else None), dict[str, float](), reading.flags
    if value is not None:
        shares = parameters.uncertainty_parts(measurement.name)
        parts = {**reading.parts, **{part: share * abs(value) for part, share in shares.items()}}
        flags = (*flags, *[MESH_DETERMINED] * measurement.mesh_determined)
        flags = (*flags, *[STILL_GROWING] * (not settled))
        if math.isfinite(growth):
            parts["growth"] = growth
    uncertainty, unknown = measurement.uncertainty_by(parts)
    if measurement.is_wide(value, uncertainty):
        flags = (*flags, WIDE_BAR)
    if value is not None and scenario.too_coarse(parameters.cells()):
        uncertainty, unknown = None, (TOO_COARSE,)
    flags = flags if value is None else (*flags, *unknown)
    return Measured(value, uncertainty, parts, flags, history, measurement.version)
