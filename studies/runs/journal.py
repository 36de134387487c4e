"""The log of a run: its question, a line for each observation, and how it ended."""

from collections.abc import Callable, Mapping

from solver.problem import Problem
from studies import measurements
from studies.results import Measured, Progress, RunResult
from studies.runs.run import Run
from studies.values.quantities import readable

DIGITS = 5  # significant ones; the result has them all

Say = Callable[[str], object]  # takes one line


class Journal:
    """Says line after line, if there is somebody to hear it."""

    def __init__(self, say: Say | None):
        self.say: Say = say or _nobody

    def question(self, run: Run, problem: Problem, made: Mapping[str, object]) -> None:
        """What is computed, on which grid, and by what; parameters in SI."""
        by = ", ".join(f"{name} {word}" for name, word in made.items())
        self.say(f"run {run.id}: {run.scenario}; {by}")
        for name, value in run.parameters.items():
            self.say(f"  {name} = {value}")
        cells = " x ".join(str(count) for count in problem.geometry.cells)
        particles = ", ".join(f"{body.name}: {body.mass.size} particles" for body in problem.bodies)
        self.say(f"{cells} cells of {_short(problem.geometry.spacing, 'm')}; {particles}")
        self.say(f"until {_short(problem.end_time, 's')} at most")

    def progress(self, now: Progress) -> None:
        """Time, step, and what can be measured now."""
        values = (f"{name} {_value(name, value)}" for name, value in now.measured.items())
        self.say("  ".join((f"t = {_short(now.time, 's'):>11}", f"step {now.step:>7}", *values)))

    def end(self, result: RunResult) -> None:
        """The verdict, the measurements, and every number that tells how the run went."""
        if result.state != "succeeded":
            self.say(f"{result.state}: {result.failure}: {result.reason}")
            return
        self.say(f"{result.state}: {result.stop}")
        for name, measured in result.measurements.items():
            flags = f" [{', '.join(measured.flags)}]" if measured.flags else ""
            self.say(f"  {name} = {_with_error(name, measured)}{flags}")
        for name, number in result.numbers.items():
            self.say(f"  {name} = {number:.6g}")
        self.say(f"flags: {', '.join(result.flags) or 'none'}")


def _nobody(_: str) -> None:
    """A listener that does not listen."""


def _with_error(name: str, measured: Measured) -> str:
    if measured.value is None:
        return "nothing to measure"
    if measured.uncertainty is None:
        return _value(name, measured.value)
    return f"{_value(name, measured.value)} +- {_value(name, measured.uncertainty)}"


def _value(name: str, value: float) -> str:
    return _short(value, measurements.load(name).unit)


def _short(value: float, unit: str) -> str:
    return readable(float(f"{value:.{DIGITS}g}"), unit)
