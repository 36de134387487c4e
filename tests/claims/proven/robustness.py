"""Draws from the shipped ranges: a run gives a measured result or a named error, and every number is finite."""

import math
import multiprocessing
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from studies import materials
from studies.runs.execution import execute
from studies.runs.run import resolve
from studies.values.results import RunResult
from studies.verification.energy import CELLS_PER_DIAMETER
from tests.claims import Row, claim

SEED = 20050601
ORDINARY, FAST = 200, 40  # draws
ORDINARY_SPEEDS, FAST_SPEEDS = (2e3, 7e3), (7e3, 15e3)  # m/s
MEASURED_SHARE = 0.98
WORKERS = 2  # processes of one thread each

SCENARIOS = {"thin_plate": "hole_diameter", "thick_plate": "crater_depth"}  # and what is asked of it
ODDS = {"thin_plate": 0.8, "thick_plate": 0.2}
DIAMETERS = (1e-3, 20e-3)  # m
THICKNESSES = (0.15, 1.5)  # of the projectile's diameter
# Cells per diameter and their shares; the examples have 8 to 40. A block is ten times the work of a plate, and each
# doubling eight times the work: 16 cells of a block at 13 km/s take a quarter of an hour.
CELLS = {
    "thin_plate": {8.0: 0.3, 12.0: 0.25, 16.0: 0.25, 24.0: 0.12, 32.0: 0.08},
    "thick_plate": {6.0: 0.5, 8.0: 0.4, 12.0: 0.1},
}
COARSE = {"thin_plate": {8.0: 1.0}}
LEAST_CELLS = 2.0  # through a plate
# The plate that was not perforated, the block that was: an answer to the question, in words.
ANSWERS = ("not_perforated", "perforated")
NAMELESS = "no value and no reason"


@dataclass(frozen=True)
class Answer:
    """What came of a draw."""

    cause: str  # "measured", a flag, or the kind of the failure
    finite: bool  # whether every number of result and final state is one
    flags: tuple[str, ...] = ()  # of the run and of what was asked

    @property
    def measured(self) -> bool:
        """A value, or words that answer the question."""
        return self.cause in ("measured", *ANSWERS)


def draws(
    count: int, speeds: tuple[float, float], seed: int, shares: Mapping[str, Mapping[float, float]] = CELLS
) -> list[tuple[str, dict[str, Any]]]:
    """Scenarios with their parameters (SI); numbers and materials are drawn, models are those of the default."""
    random = np.random.default_rng(seed)
    names = materials.names()
    drawn = []
    odds = np.array([ODDS[name] for name in shares])
    odds /= odds.sum()
    for _ in range(count):
        scenario = str(random.choice(list(shares), p=odds))
        cells = float(random.choice(list(shares[scenario]), p=list(shares[scenario].values())))
        diameter = _log_uniform(random, *DIAMETERS)
        parameters = {
            "speed": float(random.uniform(*speeds)),
            "projectile_diameter": diameter,
            "cells_per_diameter": cells,
            "projectile": str(random.choice(names)),
            "target": str(random.choice(names)),
        }
        least, most = THICKNESSES
        thickness = _log_uniform(random, max(least, LEAST_CELLS / cells), most)
        if scenario == "thin_plate":
            parameters["plate_thickness"] = thickness * diameter
        drawn.append((scenario, parameters))
    return drawn


def _log_uniform(random: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(random.uniform(math.log(low), math.log(high))))


def answer(draw: tuple[str, dict[str, Any]]) -> Answer:
    """Compute one draw."""
    scenario, parameters = draw
    roles = {role: materials.load(parameters[role]) for role in ("projectile", "target")}
    run = resolve(scenario, parameters, roles)
    with tempfile.TemporaryDirectory() as folder:
        result = execute(run, Path(folder), threads=1)
        finite = _finite(Path(folder)) and _is_finite(_numbers(result))
    if result.state != "succeeded":
        return Answer(f"error: {result.failure}" if result.failure else NAMELESS, finite)
    measured = result.measurements[SCENARIOS[scenario]]
    flags = (*result.flags, *measured.flags)
    if measured.value is not None:
        return Answer("measured", finite, flags)
    return Answer(measured.flags[0] if measured.flags else NAMELESS, finite, flags)


def _numbers(result: RunResult) -> Iterator[float]:
    """All that a result states as a number."""
    yield from result.numbers.values()
    for measured in result.measurements.values():
        yield from measured.parts.values()
        yield from (each for each in (measured.value, measured.uncertainty) if each is not None)


def _finite(folder: Path) -> bool:
    """Whether the stored state holds numbers only; a failed run stores none."""
    file = folder / "state.npz"
    if not file.exists():
        return True
    with np.load(file) as state:
        arrays = [state[name] for name in state.files]
    return all(np.isfinite(each).all() for each in arrays if each.dtype.kind == "f")


def _is_finite(numbers: Iterable[float]) -> bool:
    return all(math.isfinite(number) for number in numbers)


def answers(drawn: list[tuple[str, dict[str, Any]]]) -> list[Answer]:
    """All draws, in processes of their own."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(WORKERS, mp_context=context) as pool:
        return list(pool.map(answer, drawn))


def _counts(answered: list[Answer]) -> str:
    counts = Counter(each.cause for each in answered)
    return ", ".join(f"{cause} {count}" for cause, count in counts.most_common())


def _flags(answered: list[Answer]) -> str:
    counts = Counter(flag for each in answered for flag in each.flags)
    return ", ".join(f"{flag} {count}" for flag, count in counts.most_common()) or "none"


@claim(
    "robustness",
    says="200 draws over materials, speeds of 2 to 7 km/s, sizes, thicknesses and resolutions: 98 % measured, the rest "
    "named errors, every number finite; none of at least 16 cells per diameter drifts by more than 1 % of its energy",
)
def robustness() -> Iterator[Row]:
    drawn = draws(ORDINARY, ORDINARY_SPEEDS, SEED)
    answered = answers(drawn)
    share = sum(each.measured for each in answered) / len(answered)
    yield Row(
        f"measured results of {ORDINARY} draws ({_counts(answered)})",
        f"at least {MEASURED_SHARE:.0%}",
        f"{share:.1%}",
        share >= MEASURED_SHARE,
    )
    yield Row(f"flags of them: {_flags(answered)}", "", "", None)
    yield _kept(drawn, answered)
    yield from _sound(answered)


@claim(
    "robustness-fast",
    says="7 to 15 km/s: a measured result or a named error, every number finite; none of at least 16 cells per "
    "diameter drifts by more than 1 % of its energy",
)
def robustness_fast() -> Iterator[Row]:
    drawn = draws(FAST, FAST_SPEEDS, SEED + 1)
    answered = answers(drawn)
    yield Row(f"{FAST} draws: {_counts(answered)}", "", f"{sum(each.measured for each in answered)}", None)
    yield Row(f"flags of them: {_flags(answered)}", "", "", None)
    yield _kept(drawn, answered)
    yield from _sound(answered)


def _kept(drawn: list[tuple[str, dict[str, Any]]], answered: list[Answer]) -> Row:
    """Whether the draws that are fine enough keep their energy within what the flag of a run allows."""
    fine = [
        each
        for (_, parameters), each in zip(drawn, answered, strict=True)
        if parameters["cells_per_diameter"] >= CELLS_PER_DIAMETER
    ]
    drifting = sum("energy_drift" in each.flags for each in fine)
    return Row(
        f"draws flagged energy_drift, of {len(fine)} with at least {CELLS_PER_DIAMETER:g} cells per diameter",
        0,
        drifting,
        drifting == 0 < len(fine),
    )


def _sound(answered: list[Answer]) -> Iterator[Row]:
    named = sum(each.measured or each.cause.startswith("error: ") for each in answered)
    unnamed = len(answered) - named
    yield Row("draws that end with neither a result nor a named error", 0, unnamed, unnamed == 0)
    odd = sum(not each.finite for each in answered)
    yield Row("draws with a number that is not finite", 0, odd, odd == 0)
