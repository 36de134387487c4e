"""The log of a run: its parameters, a line for each observation, and how it ended."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from solver.problem import Problem
from studies import measurements
from studies.quantities.display import with_bar
from studies.quantities.measured import flags_in_words
from studies.quantities.units import readable
from studies.runs.results import Progress, RunResult
from studies.runs.run import Run

DIGITS = 5  # significant digits of a logged value; the result has them all


@dataclass(frozen=True)
class RunLog:
    """Writes the lines of a run's log."""

    write: Callable[[str], object]  # takes one line

    def begin(self, run: Run, problem: Problem, provenance: Mapping[str, object]) -> None:
        """Parameters in SI, the grid, and the versions that compute."""
        versions = ", ".join(f"{name} {value}" for name, value in provenance.items())
        self.write(f"run {run.id}: {run.scenario}; {versions}")
        for name, value in run.parameters.items():
            self.write(f"  {name} = {value}")
        cells = " x ".join(str(count) for count in problem.geometry.cells)
        particles = ", ".join(f"{body.name}: {body.mass.size} particles" for body in problem.bodies)
        self.write(f"{cells} cells of {_short(problem.geometry.spacing, 'm')}; {particles}")
        self.write(f"until {_short(problem.end_time, 's')} at most")

    def stage(self, problem: Problem, number: int) -> None:
        """The grid of a later stage, and what comes to it."""
        cells = " x ".join(str(count) for count in problem.geometry.cells)
        here, coming = sum(body.mass.size for body in problem.bodies), problem.particle_count
        self.write(
            f"stage {number}: {cells} cells of {_short(problem.geometry.spacing, 'm')}; {here} particles, and "
            f"{coming - here} that arrive; until {_short(problem.end_time, 's')} at most"
        )

    def progress(self, now: Progress) -> None:
        """Time, step and the present values of the measurements."""
        values = (f"{name} {_value(name, value)}" for name, value in now.measured.items())
        self.write("  ".join((f"t = {_short(now.time, 's'):>11}", f"step {now.step:>7}", *values)))

    def end(self, result: RunResult) -> None:
        """The state, the measurements and all numbers of the result, as a run alone tells them: on a single grid."""
        if result.state != "succeeded":
            self.write(f"{result.state}: {result.failure}: {result.reason}")
            return
        self.write(f"{result.state}: {result.stop}")
        for name, measured in result.measurements.items():
            flags = f" [{', '.join(flags_in_words(measured.flags))}]" if measured.flags else ""
            value = "nothing to measure" if measured.value is None else with_bar(_value(name, measured.value), None)
            self.write(f"  {name} = {value}{flags}")
        for name, number in result.numbers.items():
            self.write(f"  {name} = {number:.6g}")
        of_values = dict.fromkeys(flag for measured in result.measurements.values() for flag in measured.flags)
        self.write(f"flags of the run: {', '.join(flags_in_words(result.flags)) or 'none'}")
        self.write(f"flags of what it measured: {', '.join(flags_in_words(of_values)) or 'none'}")


def _value(name: str, value: float) -> str:
    return _short(value, measurements.load(name).unit)


def _short(value: float, unit: str) -> str:
    return readable(float(f"{value:.{DIGITS}g}"), unit)
