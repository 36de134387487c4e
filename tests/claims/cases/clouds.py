"""The debris cloud of Ma (2005), section 3.1.2: 3 mm of copper, 6.6 km/s, 9 us."""

import math
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from solver.simulation import start
from studies import materials, measurements
from studies.convergence.richardson import Sample, converge
from studies.runs.execution import execute, setting_of
from studies.runs.remeasure import load_state
from studies.runs.run import resolve
from studies.values.results import DEFINITION, Measured, RunResult, numerical_parts
from tests.claims import Row, absolute, at_most, claim, equal

GRIDS = (16.0, 32.0, 64.0)  # cells across the projectile: 6, 12 and 24 through the plate
SPEED, DIAMETER, THICKNESS, END = 6600.0, 8e-3, 3e-3, 9e-6
COPPER = "copper-ofhc"

CASE = {
    "speed": SPEED,
    "projectile_diameter": DIAMETER,
    "plate_thickness": THICKNESS,
    "end_time": END,
    "projectile": COPPER,
    "target": COPPER,
}

MOMENTUM = 15.80  # N s, of the whole projectile
PRINTED = 0.005  # N s: half of its last digit
CLOSED = 1e-6  # of the momentum
FASTEST = 1.1  # of the free surface's velocity 2 u_p; of like metals u_p is half of the impact speed


@dataclass(frozen=True)
class Cloud:
    """A run of the case on one grid."""

    cells: float
    result: RunResult
    departed_downrange: float  # mass that departed behind the plate, kg

    def measured(self, name: str) -> Measured:
        return self.result.measurements[name]


def cloud(cells: float) -> Cloud:
    """Compute the case on a grid."""
    parameters = {**CASE, "cells_per_diameter": cells}
    roles = {role: materials.load(COPPER) for role in ("projectile", "target")}
    with tempfile.TemporaryDirectory() as folder:
        result = execute(resolve("debris_cloud", parameters, roles), Path(folder), threads=1)
        departed = load_state(Path(folder) / "state.npz").departed
    behind = departed.position[:, 1] > THICKNESS
    return Cloud(cells, result, float(2.0 * math.pi * departed.mass[behind].sum()))


@claim(
    "debris-cloud",
    says="3 mm of copper hit at 6.6 km/s by 8 mm: by 9 us nothing behind the plate has left the grid, the axial "
    "momentum of 15.80 N s is closed to 1e-6 with what left elsewhere, and the tip flies at 1.1 x 2 u_p at most",
)
def debris_cloud() -> Iterator[Row]:
    clouds = [cloud(cells) for cells in GRIDS]
    for each in clouds:
        yield from _balances(each)
        tip = each.measured("tip_velocity_permille")
        yield at_most(
            f"{each.cells:g} cells: velocity that 0.1 % of the mass exceeds, over 2 u_p",
            limit=FASTEST,
            got=(tip.value or math.nan) / SPEED,
        )
    for name in clouds[0].result.measurements:
        yield _on_grids(name, clouds)


def _balances(each: Cloud) -> Iterator[Row]:
    where, histories = f"{each.cells:g} cells:", each.result.histories
    yield equal(f"{where} mass that left downrange", expected=0.0, got=each.departed_downrange)
    momentum = np.sum(histories["axial_momentum"], axis=0) - histories["axial_impulse"]
    momentum += np.sum(histories["departed_axial_momentum"], axis=0)
    yield absolute(
        f"{where} axial momentum at the touch (N s)", expected=MOMENTUM, got=float(momentum[0]), within=PRINTED
    )
    error = float(np.abs(momentum / momentum[0] - 1.0).max())
    yield at_most(f"{where} axial momentum at any time, relative error", limit=CLOSED, got=error)


def _on_grids(name: str, clouds: list[Cloud]) -> Row:
    """A measurement on the grids, converged with its error bar; reported."""
    kind = measurements.load(name)
    samples = [_sample(each, name) for each in clouds]
    point = converge(samples)
    values = ", ".join(f"{sample.value:.4g}" for sample in samples)
    error = "" if math.isnan(point.uncertainty) else f" +- {point.uncertainty:.2g}"
    part = clouds[-1].measured(name).parts.get(DEFINITION)
    definition = "" if part is None else f", definition {part:.2g}"
    got = f"{values}; {point.value:.4g}{error} ({point.verdict}){definition}"
    grids = ", ".join(f"{cells:g}" for cells in GRIDS)
    return Row(f"{kind.title} ({kind.unit}) on {grids} cells; converged", "", got, None)


def _sample(each: Cloud, name: str) -> Sample:
    measured = each.measured(name)
    parts = numerical_parts(measured.parts)
    rest = math.hypot(*(size for part, size in parts.items() if part != "resolution"))
    value = math.nan if measured.value is None else measured.value
    return Sample(1.0 / each.cells, value, measured.parts.get("resolution", 0.0), rest)


ROOM = (4.0, 50.0)  # grid before and behind the plate, projectile diameters
STEPS, ROUNDS = 150, 3
DEARER = 1.25  # at most, for sixty times as many nodes; process times differ by a tenth on a busy machine


def cost(room: float) -> tuple[int, float]:
    """Nodes of the grid of the case with some room around the plate, and the time of a particle-step (s)."""
    roles = {role: materials.load(COPPER) for role in ("projectile", "target")}
    sizes = {"uprange": room, "downrange": room, "beyond_edge": 0.5 * room}
    run = resolve("debris_cloud", {**CASE, **sizes, "cells_per_diameter": 24.0}, roles)
    problem = setting_of(run).problem
    simulation = start(problem, threads=1)
    for _ in range(STEPS):
        simulation.advance()
    begin = time.process_time()
    for _ in range(STEPS):
        simulation.advance()
    passed = time.process_time() - begin
    return int(problem.geometry.nodes.prod()), passed / STEPS / simulation.particles.mass.size


@claim(
    "empty-grid",
    says="only the occupied part of a grid costs time: a step of the debris cloud's case on a grid with sixty times as "
    "many nodes takes no more than a quarter longer",
)
def empty_grid() -> Iterator[Row]:
    timed = [[cost(room) for room in ROOM] for _ in range(ROUNDS)]
    (few, small), (many, large) = (min(each) for each in zip(*timed, strict=True))
    yield Row("nodes, and nanoseconds of a particle-step", "", f"{few}, {1e9 * small:.1f}", None)
    yield Row("the same on the larger grid", "", f"{many}, {1e9 * large:.1f}", None)
    yield at_most("ratio of the times", limit=DEARER, got=large / small)
