"""Release at a free surface: a shock arrives at the back of the target, which then flies off without pressure."""

import math
from collections.abc import Iterator

import numpy as np

from solver.simulation import simulate
from solver.state import Snapshot
from studies.quantities.numerical_defaults import Recipe
from tests.cases.verification import case
from tests.cases.verification.setups.column import INTERFACE_CELLS, OUTER_SHARE, ColumnProfile, Stretch, column, profile
from tests.cases.verification.setups.matter import fluid
from tests.cases.verification.solutions.hugoniot import COPPER, Release, Shock, impedance_match, released
from tests.claims.rows import Row, relative, reported

SPEEDS = (2e3, 4e3, 6e3)  # m/s
FLYER_CELLS, TARGET_CELLS = 200, 100
SPACING = 1e-4  # m
# The release has run back through this part of the target at the end; the flyer is thick enough that nothing from its
# own free back arrives before.
RELEASED = 0.5
SPARE_CELLS = 10

# Set before any run: a quarter of the difference between u_fs and 2 up at 6 km/s would be seen.
SPEED, DENSITY = 0.01, 0.01


@case(
    "release",
    says="a free surface flies off with the speed of the isentrope",
    source="centred wave along the isentrope: Zel'dovich and Raizer (1966), chapter XI",
)
def _run(recipe: Recipe) -> Iterator[Row]:
    for speed in SPEEDS:
        yield from _rows(speed, recipe)


def _rows(speed: float, recipe: Recipe) -> Iterator[Row]:
    _, state = impedance_match(COPPER, COPPER, speed)
    end = released(COPPER, state)
    line = _free_end(speed, state, end, recipe)
    surface = float((line.mass * line.velocity).sum() / line.mass.sum())
    exact = state.particle_speed + end.velocity_gain
    where = f"Cu on Cu, {speed / 1e3:g} km/s"
    yield relative(f"{where}: free-surface speed (m/s)", expected=exact, got=surface, within=SPEED)
    yield reported(f"{where}: the exact one over 2 up", exact / (2.0 * state.particle_speed))
    yield relative(
        f"{where}: density after release (kg/m3)",
        expected=end.density,
        got=float(line.mass.sum() / line.volume.sum()),
        within=DENSITY,
    )
    yield reported(f"{where}: mean stress after release (of the shock's)", line.mean(line.stress) / state.pressure)


def _free_end(speed: float, state: Shock, end: Release, recipe: Recipe) -> ColumnProfile:
    """The released matter, by initial place: without the outer cells and the part next to the release wave.

    The tail of the release runs back into the matter with the impedance (rho c) of the released state.
    """
    arrival = TARGET_CELLS * SPACING / state.shock_speed
    tail = end.density * end.sound_speed / COPPER.density  # of initial places, m/s
    end_time = arrival + RELEASED * TARGET_CELLS * SPACING / tail
    reach = (state.particle_speed + end.velocity_gain) * (end_time - arrival)
    expansion = FLYER_CELLS * SPACING  # behind the flyer, whose back may move the other way
    problem = column(
        [
            Stretch("flyer", fluid(COPPER), COPPER.density, -FLYER_CELLS * SPACING, 0.0, speed),
            Stretch("target", fluid(COPPER), COPPER.density, 0.0, TARGET_CELLS * SPACING),
        ],
        recipe,
        lower=-FLYER_CELLS * SPACING - expansion,
        cells=2 * FLYER_CELLS + TARGET_CELLS + math.ceil(1.2 * reach / SPACING) + SPARE_CELLS,
        spacing=SPACING,
        end_time=end_time,
    )
    start: list[ColumnProfile] = []

    def watch(snapshot: Snapshot) -> None:
        if snapshot.time == 0.0:
            start.append(profile(snapshot, 1))

    outcome = simulate(problem, watch)
    final = profile(outcome.snapshot, 1)
    label = dict(zip(start[0].number.tolist(), start[0].place.tolist(), strict=True))
    place = np.array([label[number] for number in final.number.tolist()])
    depth = TARGET_CELLS * SPACING - place
    deepest = (1.0 - OUTER_SHARE) * tail * (outcome.snapshot.time - arrival)
    return final.part((depth > INTERFACE_CELLS * SPACING) & (depth < deepest))


CASE = _run
