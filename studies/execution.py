"""Computes a run: problem, simulation, measurements on the way, balances, files. Imported by processes that solve."""

import json
import math
import platform
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from solver import PHYSICS_VERSION
from solver.errors import WhippleError
from solver.jit import software
from solver.simulation import Outcome, simulate
from solver.state import Snapshot
from studies import measurements, scenarios
from studies.atomic import write_atomically
from studies.measurements import Reading
from studies.measurements._view import View, view
from studies.results import Measured, Progress, RunResult
from studies.run import Run, materials_of
from studies.scenarios import Scenario, Setting
from studies.scenarios._impact import settled_window

OBSERVATIONS_PER_WINDOW = 5  # of the time over which growth is judged
UNDER_RESOLVED = {"cells_per_diameter": 16.0, "cells_per_thickness": 4.0}

# A cross-check of connectivity, which alone decides what is plate: MPM3D-F90's holes were read from particles slower
# than this, m/s.
FAST = 300.0

# Flagged, not failed: what a run with sound balances stays below. The hottest 0.1 % of mass of resolved impacts holds a
# tenth of the internal energy and more, so half of it means that single particles have run away.
ENERGY_DRIFT_FLAG = 0.01
HOTTEST_SHARE_FLAG = 0.5


@dataclass
class Observer:
    """Reads the scenario's measurements at each observation and decides when they have settled."""

    scenario: Scenario
    given: Any  # parameters
    setting: Setting
    progress: Callable[[Progress], None] | None
    times: list[float] = field(default_factory=list)
    readings: list[dict[str, Reading]] = field(default_factory=list)
    last_view: View | None = None
    started: float = field(default_factory=time.monotonic)

    def __call__(self, snapshot: Snapshot) -> str | None:
        """Observe a state; returns "settled" when the run may end."""
        seen = view(self.setting, snapshot)
        self.times.append(snapshot.time)
        self.readings.append(
            {name: measurements.load(name).read(seen) for name in self.scenario.measurements}
        )
        self.last_view = seen
        if self.progress:
            self.progress(self._progress(snapshot))
        settled = self.given.stop == "settled" and all(
            self._settled(name) for name in self.scenario.settles
        )
        return "settled" if settled else None

    def measured(self) -> dict[str, Measured]:
        """The last readings with their uncertainty and history."""
        return {name: self._measured(name) for name in self.scenario.measurements}

    def growth(self, name: str) -> float:
        """Change of a measurement within the last window; NaN where it has no value on both ends."""
        begin = self.times[-1] - settled_window(self.given) * (1.0 - 1e-9)
        earlier = [index for index, at in enumerate(self.times) if at <= begin]
        if not earlier:
            return math.nan
        return self.readings[-1][name].value - self.readings[earlier[-1]][name].value

    def _settled(self, name: str) -> bool:
        """Two windows at least, and less growth within the last one than allowed."""
        if self.times[-1] < 2.0 * settled_window(self.given):
            return False
        growth, value = self.growth(name), self.readings[-1][name].value
        return abs(growth) < self.given.settled_growth * abs(value)

    def _measured(self, name: str) -> Measured:
        reading = self.readings[-1][name]
        growth = self.growth(name)
        parts = dict(reading.parts)
        if math.isfinite(growth):
            parts["growth"] = abs(growth)
        known = math.isfinite(reading.value)
        flags = reading.flags
        if known and name in self.scenario.settles and not self._settled(name):
            flags = (*flags, "still_growing")
        return Measured(
            value=reading.value if known else None,
            uncertainty=math.hypot(*parts.values()) if known else None,
            parts=parts if known else {},
            flags=flags,
            history={
                "time": list(self.times),
                "value": [_finite(reading[name].value) for reading in self.readings],
            },
            version=measurements.load(name).version,
        )

    def _progress(self, snapshot: Snapshot) -> Progress:
        end = self.setting.problem.end_time
        fraction = min(snapshot.time / end, 1.0)
        elapsed = time.monotonic() - self.started
        measured = {name: reading.value for name, reading in self.readings[-1].items()}
        return Progress(
            time=snapshot.time,
            end_time=end,
            step=snapshot.step,
            fraction=fraction,
            eta_seconds=elapsed * (1.0 - fraction) / fraction if fraction > 0.02 else None,
            measured={name: value for name, value in measured.items() if math.isfinite(value)},
        )


def compute(
    run: Run,
    directory: Path,
    progress: Callable[[Progress], None] | None = None,
    *,
    threads: int | None = None,
) -> RunResult:
    """The result of a run, also written to the directory."""
    directory.mkdir(parents=True, exist_ok=True)
    started = datetime.now(UTC).isoformat(timespec="seconds")
    clock = time.perf_counter()
    try:
        result = _succeed(run, directory, progress, threads)
    except WhippleError as error:
        result = RunResult(run.id, "failed", reason=str(error), failure=type(error).__name__)
    seconds = time.perf_counter() - clock
    result = RunResult(
        **{**vars(result), "provenance": provenance() | {"started": started, "seconds": seconds}}
    )
    text = json.dumps(result.as_json(), allow_nan=False, indent=1)
    write_atomically(directory / "result.json", lambda file: Path(file).write_text(text))
    return result


def setting_of(run: Run) -> Setting:
    """The problem of a run, and what an observer needs to know of it."""
    scenario = scenarios.load(run.scenario)
    return scenario.build(scenario.parameters(**run.parameters), materials_of(run))


def compile_kernels() -> None:
    """A few steps of each scenario's kernels, so that the cache holds them."""
    from studies.sweep import Sweep

    for document in _WARM_UP:
        for point in Sweep.parse(document).runs():
            _simulate(point.run, None, None)


def provenance() -> dict[str, str | float]:
    """What computed: versions and processor."""
    try:
        release = version("whipple")
    except PackageNotFoundError:
        release = "unknown"
    return {
        "whipple": release,
        "physics_version": str(PHYSICS_VERSION),
        "python": platform.python_version(),
        "numpy": np.__version__,
        **software(),
    }


def _succeed(
    run: Run,
    directory: Path,
    progress: Callable[[Progress], None] | None,
    threads: int | None,
) -> RunResult:
    observer, outcome = _simulate(run, progress, threads)
    numbers = _numbers(observer, outcome)
    _save_state(directory, outcome)
    return RunResult(
        run.id,
        "succeeded",
        measurements=observer.measured(),
        flags=_flags(numbers),
        numbers=numbers,
        stop=outcome.stop,
    )


def _simulate(
    run: Run, progress: Callable[[Progress], None] | None, threads: int | None
) -> tuple[Observer, Outcome]:
    scenario = scenarios.load(run.scenario)
    given = scenario.parameters(**run.parameters)
    setting = setting_of(run)
    observer = Observer(scenario, given, setting, progress)
    interval = settled_window(given) / OBSERVATIONS_PER_WINDOW
    outcome = simulate(setting.problem, observer, interval=interval, threads=threads)
    return observer, outcome


def _numbers(observer: Observer, outcome: Outcome) -> dict[str, float]:
    audit, counters = outcome.audit, outcome.counters
    last = observer.last_view
    assert last is not None
    loose = last.target & ~last.attached_target
    return {
        **observer.scenario.cells(observer.given),
        "particles": float(sum(body.mass.size for body in observer.setting.problem.bodies)),
        "particle_steps": float(outcome.particle_steps),
        "steps": float(outcome.snapshot.step),
        "end_time": outcome.snapshot.time,
        "smallest_step": outcome.smallest_step,
        "energy_drift": audit.energy_drift,
        "largest_energy_drift": max((a.energy_drift for a in outcome.history), key=abs),
        "momentum_error": audit.momentum_error,
        "mass_error": audit.mass_error,
        "outflow_mass_fraction": audit.outflow_mass,
        "outflow_energy_fraction": audit.outflow_energy,
        "hottest_energy_share": audit.hottest_energy_share,
        "largest_speed": audit.largest_speed,
        "separated_mass_fraction": _share(last, loose),
        "fast_mass_fraction": _share(last, last.attached_target & (last.speed > FAST)),
        "tension_floors": float(counters.tension_floors),
        "beyond_hugoniot": float(counters.beyond_hugoniot),
        "below_zero_kelvin": float(counters.below_zero_kelvin),
        "reflected": float(counters.reflected),
    }


def _share(seen: View, keep: np.ndarray) -> float:
    """Mass of some particles over the target's mass still on the grid."""
    whole = float(seen.mass[seen.target].sum())
    return float(seen.mass[keep].sum()) / whole if whole else 0.0


def _flags(numbers: Mapping[str, float]) -> tuple[str, ...]:
    flags = []
    if any(numbers[name] < least for name, least in UNDER_RESOLVED.items()):
        flags.append("under_resolved")
    if abs(numbers["largest_energy_drift"]) > ENERGY_DRIFT_FLAG:
        flags.append("energy_drift")
    if numbers["hottest_energy_share"] > HOTTEST_SHARE_FLAG:
        flags.append("runaway_particles")
    flags += [name for name in ("below_zero_kelvin", "beyond_hugoniot") if numbers[name] > 0.0]
    return tuple(flags)


def _save_state(directory: Path, outcome: Outcome) -> None:
    """The living particles of the final state, so that measurements can be read again without solving."""
    particles, living = outcome.snapshot.particles, outcome.snapshot.particles.alive == 1
    fields = {
        name: getattr(particles, name)[living] for name in particles._fields if name != "alive"
    }

    def save(path: Path) -> None:
        with open(path, "wb") as file:
            np.savez_compressed(
                file, body=outcome.snapshot.body[living], time=outcome.snapshot.time, **fields
            )

    write_atomically(directory / "state.npz", save)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


# Small problems that touch each kernel: both geometries, the strengths and equations of state of the shipped examples.
_WARM_UP: tuple[Mapping[str, Any], ...] = tuple(
    {
        "name": "warm-up",
        "scenario": scenario,
        "fixed": {
            "projectile": material,
            "target": material,
            "projectile_diameter": "8 mm",
            "speed": "3 km/s",
            "end_time": "0.2 us",
            **(
                {"plate_thickness": "2 mm"}
                if scenario == "thin_plate"
                else {"target_depth": "10 mm"}
            ),
        },
        "axes": {"geometry": ["axisymmetric", "quarter"]},
        "resolution": 4,
    }
    for scenario, material in (
        ("thin_plate", "copper-ofhc"),
        ("thick_plate", "copper-thesis-plastic"),
    )
)
