"""Computes a run: problem, simulation, measurements on the way, balances, files. Imported by processes that solve."""

import json
import math
import platform
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from solver import PHYSICS_VERSION
from solver.checkpoint import Checkpointing
from solver.errors import WhippleError
from solver.jit import software
from solver.simulation import Outcome, simulate, threads_for
from solver.state import Snapshot
from studies import measurements, scenarios
from studies.atomic import write_atomically
from studies.checkpoints import Checkpoints
from studies.files import ANSWER, FILM, STATE
from studies.film import Film
from studies.journal import Journal, Say
from studies.measurements import History, Measurement, Reading
from studies.results import TOO_COARSE, Measured, Progress, RunResult
from studies.run import Run, materials_of
from studies.scenarios import Scenario, Setting

# Flagged, not failed: what a run with sound balances stays below. The hottest 0.1 % of mass of resolved perforations
# holds 3 to 9 % of the internal energy at the end; half of it means that single particles have run away.
ENERGY_DRIFT_FLAG = 0.01
HOTTEST_SHARE_FLAG = 0.5

# A particle moves its edge by a third to half of a cell when it comes loose: what varies by less has settled whatever
# the share of the value.
SETTLED_IN_CELLS = 0.25

LEAST_SHARE = (
    0.02  # of a run that has to be done here before the time left is told: an observation or two
)


@dataclass
class Observer:
    """Reads the scenario's measurements at each observation and decides when they have settled."""

    scenario: Scenario
    given: Any  # parameters
    setting: Setting
    progress: Callable[[Progress], None] | None
    film: Film | None = None
    times: list[float] = field(default_factory=list)
    readings: list[dict[str, Reading]] = field(default_factory=list)
    last_view: Any = None
    first: tuple[float, float] | None = (
        None  # clock (s) and share of the run at our first observation
    )

    def __post_init__(self) -> None:
        self.pace = self.scenario.watch.pace(self.given, self.setting)
        measured = [measurements.load(name) for name in self.scenario.measurements]
        self.of_a_state = [one for one in measured if not one.follows]
        self.of_a_history = [one for one in measured if one.follows]

    def __call__(self, snapshot: Snapshot) -> str | None:
        """Observe a state; returns "settled" when the run may end."""
        seen = self.scenario.watch.view(self.setting, snapshot)
        self.times.append(snapshot.time)
        self.readings.append({one.name: one.read(seen) for one in self.of_a_state})
        self.readings[-1].update({one.name: self._follow(one) for one in self.of_a_history})
        self.last_view = seen
        if self.progress:
            self.progress(self._progress(snapshot))
        settled = self.pace.early and all(self._settled(name) for name in self.scenario.settles)
        if self.film:
            self.film.see(snapshot, last=settled or snapshot.time >= self.setting.problem.end_time)
        return "settled" if settled else None

    def remember(self) -> str:
        """What was read so far, as text: ``recall`` gives it back, bit for bit."""
        readings = [
            {name: (one.value, dict(one.parts), one.flags) for name, one in reading.items()}
            for reading in self.readings
        ]
        return json.dumps({"times": self.times, "readings": readings})

    def recall(self, text: str) -> None:
        """Go on from what ``remember`` wrote."""
        plain = json.loads(text)
        self.times = list(plain["times"])
        self.readings = [
            {name: Reading(value, parts, tuple(flags)) for name, (value, parts, flags) in r.items()}
            for r in plain["readings"]
        ]

    def definitions(self) -> str:
        """Scenario and versions of what it measures: another set could not go on from ``remember``."""
        versions = {one.name: one.version for one in (*self.of_a_state, *self.of_a_history)}
        return json.dumps([self.scenario.name, versions], sort_keys=True)

    def measured(self) -> dict[str, Measured]:
        """The last readings with their uncertainty and history."""
        return {name: self.measured_as(name) for name in self.scenario.measurements}

    def growth(self, name: str) -> float:
        """Range of a measurement within the last window; NaN before one has passed, and without a present value.

        A length that was not there yet, as a hole, has grown from nothing.
        """
        # Observations are up to a step late; half of an interval leaves as many of them in every window.
        begin = self.times[-1] - self.pace.window + 0.5 * self.pace.interval
        earlier = [index for index, at in enumerate(self.times) if at <= begin]
        if not earlier:
            return math.nan
        values = np.array([reading[name].value for reading in self.readings[earlier[-1] :]])
        if self._is_judged(name):
            values[:-1] = np.nan_to_num(values[:-1])
        return float(np.ptp(values))

    def _follow(self, measurement: Measurement) -> Reading:
        values = {
            name: np.array([reading[name].value for reading in self.readings])
            for name in measurement.follows
        }
        return measurement.read(History(np.array(self.times), values))

    def _is_judged(self, name: str) -> bool:
        """Whether it is said of a measurement that it still grows: of lengths, and of what a run waits for."""
        waited = name in self.scenario.settles
        return waited or (measurements.load(name).unit == "m" and math.isfinite(self.pace.window))

    def _settled(self, name: str) -> bool:
        """Two windows at least, and a range within the last one below a share of the value or a quarter of a cell."""
        if self.times[-1] < 2.0 * self.pace.window:
            return False
        share = self.pace.growth * abs(self.readings[-1][name].value)
        cells = SETTLED_IN_CELLS * self.setting.problem.geometry.spacing
        return self.growth(name) < max(share, cells)

    def measured_as(self, name: str) -> Measured:
        """The last reading of a measurement with its uncertainty, flags and history."""
        reading = self.readings[-1][name]
        growth = self.growth(name)
        parts = dict(reading.parts)
        if math.isfinite(growth):
            parts["growth"] = growth
        known = math.isfinite(reading.value)
        flags = reading.flags
        if known and self._is_judged(name) and not self._settled(name):
            flags = (*flags, "still_growing")
        uncertainty = math.hypot(*parts.values()) if known and parts else None
        if uncertainty and uncertainty > measurements.load(name).widest * abs(reading.value):
            flags = (*flags, "wide_bar")
        if known and self.scenario.watch.too_coarse(self.scenario.cells(self.given)):
            uncertainty, flags = None, (*flags, TOO_COARSE)
        return Measured(
            value=reading.value if known else None,
            uncertainty=uncertainty,
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
        measured = {name: reading.value for name, reading in self.readings[-1].items()}
        return Progress(
            time=snapshot.time,
            end_time=end,
            step=snapshot.step,
            fraction=fraction,
            eta_seconds=self._time_left(fraction),
            measured={name: value for name, value in measured.items() if math.isfinite(value)},
        )

    def _time_left(self, fraction: float) -> float | None:
        """Seconds at the pace of this process, which may have gone on from a checkpoint; None until it has one."""
        now = time.monotonic()
        if self.first is None:
            self.first = (now, fraction)
        clock, begun = self.first
        done = fraction - begun
        return (now - clock) * (1.0 - fraction) / done if done > LEAST_SHARE else None


def compute(
    run: Run,
    directory: Path,
    progress: Callable[[Progress], None] | None = None,
    *,
    threads: int | None = None,
    checkpoint: Path | None = None,
    leave: Callable[[], bool] | None = None,
    saved: Callable[[int], object] | None = None,
    film: bool = False,
    say: Say | None = None,
) -> RunResult:
    """The result of a run, also written to the directory, with the final state and the ``film`` if it is wanted.

    ``threads`` (``solver.simulation.threads_for``) decide how long it takes, and no number. With ``checkpoint`` the run
    goes on from that file where it is this run's and this machine's, and writes it as it goes; the numbers are those of
    a run that never stopped. ``saved`` is told the step of each checkpoint that it writes or goes on from, and ``say``
    each line of the run's log. Raises Interrupted once ``leave`` says so.
    """
    directory.mkdir(parents=True, exist_ok=True)
    started = datetime.now(UTC).isoformat(timespec="seconds")
    clock = time.perf_counter()
    resumed: list[str] = []
    log = Journal(say)

    def explain(sentence: str) -> None:
        resumed.append(sentence)
        log.say(sentence)

    def listen(news: Progress) -> None:
        log.progress(news)
        if progress:
            progress(news)

    made = provenance()
    try:
        watched = observer_of(run, listen, film=film)
        problem = watched.setting.problem
        threads = threads_for(sum(body.mass.size for body in problem.bodies), threads)
        made["threads"] = threads
        log.question(run, problem, made)
        kept = None
        if checkpoint:
            kept = Checkpoints(checkpoint, watched).of_solver(
                leave=leave, saved=saved, tell=explain
            )
        result = _succeed(run, directory, watched, threads, kept)
    except WhippleError as error:
        result = RunResult(run.id, "failed", reason=str(error), failure=type(error).__name__)
    made |= {"started": started, "seconds": time.perf_counter() - clock}
    if resumed:
        made["checkpoint"] = "; ".join(resumed)
    result = replace(result, provenance=made)
    log.end(result)
    text = json.dumps(result.as_json(), allow_nan=False, indent=1)
    write_atomically(directory / ANSWER, lambda file: Path(file).write_text(text))
    return result


def observer_of(
    run: Run, progress: Callable[[Progress], None] | None = None, *, film: bool = False
) -> Observer:
    """The observer of a run, with the problem that it is to watch."""
    scenario, setting = scenarios.load(run.scenario), setting_of(run)
    shown = Film(setting.problem) if film else None
    return Observer(scenario, scenario.parameters(**run.parameters), setting, progress, shown)


def setting_of(run: Run) -> Setting:
    """The problem of a run, and what an observer needs to know of it."""
    scenario = scenarios.load(run.scenario)
    return scenario.build(scenario.parameters(**run.parameters), materials_of(run))


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
    watched: Observer,
    threads: int | None,
    kept: Checkpointing | None,
) -> RunResult:
    outcome = simulate(
        watched.setting.problem,
        watched,
        interval=watched.pace.interval,
        threads=threads,
        checkpoint=kept,
    )
    numbers = _numbers(watched, outcome)
    _save_state(directory, outcome)
    if watched.film:
        watched.film.save(directory / FILM, compressed=True)
    return RunResult(
        run.id,
        "succeeded",
        measurements=watched.measured(),
        flags=_flags(numbers, watched.scenario.watch.least_cells),
        numbers=numbers,
        stop=outcome.stop,
    )


def _numbers(watched: Observer, outcome: Outcome) -> dict[str, float]:
    audit = outcome.audit
    counted = {name: float(count) for name, count in asdict(outcome.counters).items()}
    return {
        **watched.scenario.cells(watched.given),
        "particles": float(sum(body.mass.size for body in watched.setting.problem.bodies)),
        "particle_steps": float(outcome.particle_steps),
        "steps": float(outcome.snapshot.step),
        "end_time": outcome.snapshot.time,
        "smallest_step": outcome.smallest_step,
        "energy_drift": audit.energy_drift,
        "largest_energy_drift": max((a.energy_drift for a in outcome.history), key=abs),
        "momentum_error": audit.momentum_error,
        "mass_error": audit.mass_error,
        "taken_energy_fraction": audit.taken_energy,
        "contact_energy_fraction": audit.contact_energy,
        "outflow_mass_fraction": audit.outflow_mass,
        "outflow_energy_fraction": audit.outflow_energy,
        "hottest_energy_share": audit.hottest_energy_share,
        "largest_speed": audit.largest_speed,
        **watched.scenario.watch.numbers(watched.last_view),
        **counted,
    }


def _flags(numbers: Mapping[str, float], least_cells: Mapping[str, float]) -> tuple[str, ...]:
    flags = []
    if any(numbers[name] < least for name, least in least_cells.items()):
        flags.append("under_resolved")
    if abs(numbers["largest_energy_drift"]) > ENERGY_DRIFT_FLAG:
        flags.append("energy_drift")
    if numbers["hottest_energy_share"] > HOTTEST_SHARE_FLAG:
        flags.append("runaway_particles")
    flags += [name for name in ("below_zero_kelvin", "beyond_hugoniot") if numbers[name] > 0.0]
    return tuple(flags)


def _save_state(directory: Path, outcome: Outcome) -> None:
    """The living particles of the final state, so that measurements can be read again, and records of the retired."""
    particles, living = outcome.snapshot.particles, outcome.snapshot.particles.alive == 1
    fields = {
        name: getattr(particles, name)[living] for name in particles._fields if name != "alive"
    }
    retired = outcome.snapshot.retired._asdict()
    fields.update({f"retired_{name}": array for name, array in retired.items()})

    def save(path: Path) -> None:
        with open(path, "wb") as file:
            np.savez_compressed(
                file, body=outcome.snapshot.body[living], time=outcome.snapshot.time, **fields
            )

    write_atomically(directory / STATE, save)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
