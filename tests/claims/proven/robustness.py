"""Draws from the shipped ranges: a run gives a measured result or a named error, and never a number that is none."""

import math
import multiprocessing
import tempfile
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from studies import materials
from studies.run import execute, resolve
from tests.claims import Row, claim

SEED = 20050601
ORDINARY, FAST = 200, 40  # draws
ORDINARY_SPEEDS, FAST_SPEEDS = (2e3, 7e3), (7e3, 15e3)  # m/s
MEASURED_SHARE = 0.98
WORKERS = 2  # processes of one thread each

SCENARIOS = {
    "thin_plate": "hole_diameter",
    "thick_plate": "crater_depth",
}  # and what is asked of it
DIAMETERS = (1e-3, 20e-3)  # m
THICKNESSES = (0.15, 1.5)  # of the projectile's diameter
# Cells per diameter. A block is ten times the work of a plate: 16 cells at 13 km/s take a quarter of an hour.
CELLS = {"thin_plate": (8.0, 12.0, 16.0), "thick_plate": (6.0, 8.0)}
LEAST_CELLS = 2.0  # through a plate
# The plate that was not perforated, the block that was: an answer to the question, in words.
ANSWERS = ("not_perforated", "perforated")


@dataclass(frozen=True)
class Answer:
    """What came of a draw."""

    cause: str  # "measured", a flag, or the kind of the failure
    finite: bool  # whether every number of result and final state is one

    @property
    def measured(self) -> bool:
        """A value, or words that answer the question."""
        return self.cause in ("measured", *ANSWERS)


def draws(count: int, speeds: tuple[float, float], seed: int) -> list[tuple[str, dict[str, Any]]]:
    """Scenarios with their parameters (SI); numbers and materials are drawn, models are those of the default."""
    random = np.random.default_rng(seed)
    names = materials.names()
    drawn = []
    for _ in range(count):
        scenario = str(random.choice(list(SCENARIOS), p=(0.8, 0.2)))
        cells = float(random.choice(CELLS[scenario]))
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
        finite = _finite(Path(folder)) and _is_finite(list(result.numbers.values()))
    if result.state != "succeeded":
        return Answer(f"error: {result.failure}", finite)
    measured = result.measurements[SCENARIOS[scenario]]
    if measured.value is not None:
        return Answer("measured", finite and _is_finite([measured.value]))
    return Answer(measured.flags[0] if measured.flags else "no value and no reason", finite)


def _finite(folder: Path) -> bool:
    """Whether the stored state holds numbers only; a failed run stores none."""
    file = folder / "state.npz"
    if not file.exists():
        return True
    with np.load(file) as state:
        arrays = [state[name] for name in state.files]
    return all(np.isfinite(one).all() for one in arrays if one.dtype.kind == "f")


def _is_finite(numbers: list[float]) -> bool:
    return all(math.isfinite(number) for number in numbers)


def answers(drawn: list[tuple[str, dict[str, Any]]]) -> list[Answer]:
    """All draws, in processes of their own."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(WORKERS, mp_context=context) as pool:
        return list(pool.map(answer, drawn))


def _counts(found: list[Answer]) -> str:
    counts = Counter(one.cause for one in found)
    return ", ".join(f"{cause} {count}" for cause, count in counts.most_common())


@claim(
    "robustness",
    says="200 draws over materials, speeds of 2 to 7 km/s, sizes, thicknesses and resolutions: 98 % measured, the rest "
    "named errors, no number that is none",
)
def robustness() -> Iterator[Row]:
    found = answers(draws(ORDINARY, ORDINARY_SPEEDS, SEED))
    share = sum(one.measured for one in found) / len(found)
    yield Row(
        f"measured results of {ORDINARY} draws ({_counts(found)})",
        f"at least {MEASURED_SHARE:.0%}",
        f"{share:.1%}",
        share >= MEASURED_SHARE,
    )
    yield from _sound(found)


@claim(
    "robustness-fast",
    says="7 to 15 km/s: a measured result or a named error, no number that is none",
)
def robustness_fast() -> Iterator[Row]:
    found = answers(draws(FAST, FAST_SPEEDS, SEED + 1))
    yield Row(f"{FAST} draws: {_counts(found)}", "", f"{sum(one.measured for one in found)}", None)
    yield from _sound(found)


def _sound(found: list[Answer]) -> Iterator[Row]:
    named = sum(one.measured or one.cause.startswith("error: ") for one in found)
    unnamed = len(found) - named
    yield Row("draws that end with neither a result nor a named error", 0, unnamed, unnamed == 0)
    odd = sum(not one.finite for one in found)
    yield Row("draws with a number that is none", 0, odd, odd == 0)
