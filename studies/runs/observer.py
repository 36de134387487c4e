"""Observes a run: reads its measurements at each observation, and ends it when they have settled."""

import json
import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from solver.problem import Problem
from solver.simulation import Recorder
from solver.state import Snapshot
from studies import measurements
from studies.measurements import History, Measurement, Reading
from studies.quantities.measured import CLOSED_ON_AXIS, STILL_COMING, Measured
from studies.quantities.parameters import flat
from studies.runs.results import Progress, as_measured
from studies.scenarios import Scenario, Setting, SetUp
from studies.sections.section import SectionRecorder, Watched

# Share of a run that this process must have computed before it estimates the time left: an observation or two.
LEAST_SHARE = 0.02
# Windows after which a run usually settles: from 3.4 to 5.8 in 29 impacts of 2 to 7 km/s (2026-11).
USUAL_WINDOWS = 4.0
RECENT = 0.1  # share of a run whose pace says how long the rest takes: steps grow longer, and matter leaves the grid
# A particle moves its edge by a third to half of a cell when it comes loose: what varies by less has settled whatever
# the share of the value.
SETTLED_IN_CELLS = 0.25


class FilmRecorder(Recorder, Protocol):
    """Keeps frames, by an interval (s); a feature offers one by the entry points ``whipple.studies.runs.films``."""

    times: list[float]  # of the frames so far, s

    def __init__(self, problem: Problem, *, interval: float | None = None): ...

    def save(self, path: Path, *, compressed: bool = False) -> None:
        """Write the film: whole, or not at all."""

    def resume(self, path: Path, frames: int) -> None:
        """Continue after the first ``frames`` of a saved film, or begin here where they are lost."""


@dataclass
class RunObserver:
    """Reads the scenario's measurements at each observation and decides when they have settled."""

    scenario: Scenario
    parameters: SetUp
    setting: Setting
    report: Callable[[Progress], object] | None
    film: FilmRecorder | None = None
    sections: SectionRecorder | None = None
    watched: Watched | None = None
    times: list[float] = field(default_factory=list)
    readings: list[dict[str, Reading]] = field(default_factory=list)
    # Of each stage so far: its setting, and the place of its first reading.
    stages: list[tuple[Setting, int]] = field(default_factory=list)
    steps_before: int = 0  # of the stages that have ended
    last_view: Any = None
    # Clock (s) and share of the run at the last observations of this process.
    recent: deque[tuple[float, float]] = field(default_factory=deque)

    def __post_init__(self) -> None:
        self.begin(self.setting)
        self.names = self.scenario.measured_in(flat(self.parameters))
        measured = [measurements.load(name) for name in self.names]
        self.of_a_state = [measurement for measurement in measured if not measurement.follows]
        self.of_a_history = [measurement for measurement in measured if measurement.follows]

    def begin(self, setting: Setting, film: FilmRecorder | None = None) -> None:
        """Observe the next stage from here on."""
        self.setting, self.film = setting, film or self.film
        self.rate = self.parameters.rate(setting)
        self.stages.append((setting, len(self.readings)))

    def __call__(self, snapshot: Snapshot) -> str | None:
        """Observe a state; returns "settled" or "decided" when the run may end."""
        view = self.last_view = self.parameters.view(self.setting, snapshot)
        self.times.append(snapshot.time)
        self.readings.append({m.name: m.read(view) for m in self.of_a_state})
        self.readings[-1].update({m.name: self._follow(m) for m in self.of_a_history})
        if self.sections:
            self.sections.add(snapshot)
            if self.watched:
                self.watched.see(self.sections, snapshot)
        if self.report:
            self.report(self._progress(snapshot))
        stop = self.stop_reason()
        if self.film and (stop or snapshot.time >= self.setting.problem.end_time):
            self.film.add(snapshot)
        return stop

    def stop_reason(self) -> str | None:
        """Why the run may end after its last reading; None where it goes on."""
        names = self._of_stage(self.setting)
        if self.rate.decided and any(map(self._is_decided, names)):
            return "decided"
        return "settled" if self.rate.early and all(map(self._settled, names)) else None

    def _is_decided(self, name: str) -> bool:
        """Whether an outcome has been 1 for a window: matter that moves may close a hole of one column again."""
        return measurements.load(name).is_outcome and self.readings[-1][name].value == 1.0 and self.growth(name) == 0.0

    def as_text(self) -> str:
        """All readings so far; ``restore`` gives them back, bit for bit."""
        readings = [
            {name: (r.value, dict(r.parts), r.flags) for name, r in observed.items()} for observed in self.readings
        ]
        return json.dumps({"times": self.times, "readings": readings})

    def restore(self, text: str) -> None:
        """Go on from the readings that ``as_text`` wrote."""
        plain = json.loads(text)
        self.times = list(plain["times"])
        self.readings = [
            {name: Reading(value, parts, tuple(flags)) for name, (value, parts, flags) in r.items()}
            for r in plain["readings"]
        ]

    def definitions(self) -> str:
        """Scenario and versions of its measurements: another set could not go on from ``as_text``."""
        versions = {m.name: m.version for m in (*self.of_a_state, *self.of_a_history)}
        return json.dumps([self.scenario.name, versions], sort_keys=True)

    def measured(self) -> dict[str, Measured]:
        """The last readings with their uncertainty and history."""
        return {name: self.measured_as(name) for name in self.names}

    def growth(self, name: str) -> float:
        """Range of a measurement within the last window (s) of its stage.

        NaN before one has passed, and without a present value. A length that was not there yet, as a hole, has grown
        from zero.
        """
        setting, mine = self._stage_of(name)
        times, rate = self.times[mine], self.parameters.rate(setting)
        # Observations are up to a step late; half of an interval leaves as many of them in every window.
        begin = times[-1] - rate.window + 0.5 * rate.interval
        earlier = [index for index, at in enumerate(times) if at <= begin]
        if not earlier:
            return math.nan
        inside = np.array([reading[name].value for reading in self.readings[mine][earlier[-1] :]])
        if self._is_judged(name):
            inside[:-1] = np.nan_to_num(inside[:-1])
        return float(np.ptp(inside))

    def _stage_of(self, name: str) -> tuple[Setting, slice]:
        """The last stage that waits for a measurement, by default the last of all, and the places of its readings."""
        ends = [first for _, first in self.stages[1:]] + [len(self.readings)]
        mine = [
            (setting, slice(first, end))
            for (setting, first), end in zip(self.stages, ends, strict=True)
            if name in (setting.settles or ())
        ]
        return mine[-1] if mine else (self.stages[-1][0], slice(self.stages[-1][1], None))

    def _follow(self, measurement: Measurement) -> Reading:
        values = {name: np.array([reading[name].value for reading in self.readings]) for name in measurement.follows}
        return measurement.read(History(np.array(self.times), values))

    def _of_stage(self, setting: Setting) -> tuple[str, ...]:
        """The measurements that a stage waits for."""
        return self.scenario.settles if setting.settles is None else setting.settles

    def _awaited(self, measurement: Measurement, value: float) -> tuple[str, ...]:
        """The measurements that have to settle before a value is final: of a 0 that may become 1 all of its stage."""
        if measurement.is_outcome:
            return self._of_stage(self._stage_of(measurement.name)[0]) if value == 0.0 else ()
        return (measurement.name,) if self._is_judged(measurement.name) else ()

    def _is_judged(self, name: str) -> bool:
        """Whether a measurement can be flagged as growing: lengths, and those that end a run when they settle."""
        is_length = measurements.load(name).unit == "m" and math.isfinite(self.rate.window)
        return name in self.scenario.settles or is_length

    def _settled(self, name: str) -> bool:
        """Whether a measurement grew by less than a share of its value or a quarter of a cell, after two windows."""
        setting, mine = self._stage_of(name)
        rate, last = self.parameters.rate(setting), self.readings[mine][-1][name]
        passed = self.times[mine][-1] - setting.problem.start_time
        # A hole leaps when the film that still closes it has flown away, and debris may still come.
        if passed < 2.0 * rate.window or {CLOSED_ON_AXIS, STILL_COMING} & {*last.flags}:
            return False
        return self.growth(name) < max(
            rate.growth * abs(last.value), SETTLED_IN_CELLS * setting.problem.geometry.spacing
        )

    def measured_as(self, name: str) -> Measured:
        """The last reading of a measurement with its uncertainty, flags and history."""
        measurement, reading = measurements.load(name), self.readings[-1][name]
        history: dict[str, list[float | None]] = {
            "time": list(self.times),
            "value": [value if math.isfinite(value := read[name].value) else None for read in self.readings],
        }
        settled = not math.isfinite(reading.value) or all(map(self._settled, self._awaited(measurement, reading.value)))
        growth = self.growth(name)
        return as_measured(
            self.scenario, self.parameters, measurement, reading, history, growth=growth, settled=settled
        )

    def _progress(self, snapshot: Snapshot) -> Progress:
        begin, end = self.setting.problem.start_time, self.setting.problem.end_time
        of_stage = min((snapshot.time - begin) / (end - begin), 1.0)
        if self.rate.early:
            window = self.rate.window / (end - begin)
            of_stage /= min(1.0, max(USUAL_WINDOWS * window, of_stage + window))
        fraction = (len(self.stages) - 1 + of_stage) / self.parameters.stages
        measured = {name: reading.value for name, reading in self.readings[-1].items()}
        return Progress(
            time=snapshot.time,
            end_time=end,
            step=self.steps_before + snapshot.step,
            fraction=fraction,
            eta_seconds=self._time_left(fraction),
            measured={name: value for name, value in measured.items() if math.isfinite(value)},
        )

    def _time_left(self, fraction: float) -> float | None:
        """Seconds at the present pace; None until it has one."""
        now = time.monotonic()
        self.recent.append((now, fraction))
        while len(self.recent) > 2 and fraction - self.recent[1][1] >= RECENT:
            self.recent.popleft()
        clock, begun = self.recent[0]
        done = fraction - begun
        return (now - clock) * (1.0 - fraction) / done if done > LEAST_SHARE else None
