"""Sod's tube: a rarefaction, a contact and a shock in an ideal gas, by each method."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from solver.errors import UnphysicalState
from solver.problem import Problem
from solver.simulation import simulate
from studies.quantities.numerical_defaults import Recipe
from tests.cases.verification import case
from tests.cases.verification.setups.column import (
    INTERFACE_CELLS,
    OUTER_SHARE,
    ColumnProfile,
    Stretch,
    column,
    front,
    plateau,
    profile,
)
from tests.cases.verification.setups.matter import gas
from tests.cases.verification.setups.methods import LINE, PLAIN, kept, meshed, smoothed
from tests.cases.verification.solutions.gas import SOD, SOD_GAMMA, riemann
from tests.claims.rows import Row, at_least, at_most, observed_order, refinement, relatives, reported, trend

SOURCE = "Sod (1978), J. Comput. Phys. 27, 1; exact solution: Toro (2009), section 4.2"

CELLS = (100, 200, 400)  # or elements, in a tube of length 1, coarse to fine
PARTICLES = (200, 400, 800)  # the same
END_TIME = 0.2
EXACT = riemann(*SOD, SOD_GAMMA)

# Gas of the left chamber thins by a factor of 2.3, and two particles per cell become less than one. Splines still
# bridge the gaps; particles of a fixed width do not, and linear cells never did: they are reported,
# which was decided when GIMP had missed the gates by 4 %.
GATED: str = "quadratic-bspline"

# Set before any run, at the finest grid: what the plate impact is held to, and twice that for densities next to the
# contact, where the particles of both sides share cells.
PRESSURE, VELOCITY, DENSITY, SHOCK_SPEED = 0.01, 0.01, 0.02, 0.01
# Of smoothed particles: at a shock and a contact the error is one of places, and so of the order 1; a little less is
# usual.
ORDER = 0.7
# Of finite elements: p*, u* and the shock's speed, about as the grid is asked, fixed before any run.
ELEMENTS, ROUND_OFF = 0.02, 1e-11

Gases = tuple[ColumnProfile, ColumnProfile]  # left and right, at the end


@case("sod", says="Sod's tube: states between the waves and speed of the shock", source=SOURCE)
def _on_grid(recipe: Recipe) -> Iterator[Row]:
    for chosen in (recipe, replace(recipe, shape=GATED)):
        gases = {cells: _gases(_tube(cells, chosen)) for cells in CELLS}
        errors = [_density_error(gases[cells], cells**-2.0) for cells in CELLS]
        for row in _rows(gases[CELLS[-1]], CELLS[-1]):
            named = replace(row, claim=f"{chosen.shape}: {row.claim}")
            yield named if chosen.shape == GATED else named.ungated()
        yield from refinement(f"{chosen.shape}: L1 error of the density, {{}} cells", CELLS, errors)
        if recipe.shape == GATED:
            break


@case("sph-sod", says="smoothed particles hold the gates of Sod's tube, and converge with an order of 1", source=SOURCE)
def _smoothed(recipe: Recipe) -> Iterator[Row]:
    errors = []
    for particles in PARTICLES:
        gases = _gases(smoothed(_tube(particles, LINE)))
        errors.append(_density_error(gases, 1.0))
        yield reported(f"Sod, {particles} cells: L1 error of the density", errors[-1])
    yield from _rows(gases, particles)
    yield at_least("Sod: observed order of the L1 error", limit=ORDER, got=observed_order(errors))
    # With plain gradients particles beside one of an eighth of their mass do not see it enough, and run away.
    claim = "Sod, plain gradients: the run ends with"
    try:
        _gases(smoothed(_tube(PARTICLES[0], LINE), PLAIN))
    except UnphysicalState as error:
        yield Row(claim, "", str(error), None)
    else:
        yield Row(claim, "", "the end of its time", None)


def of_elements() -> Iterator[Row]:
    """The tube by finite elements."""
    errors: dict[str, list[float]] = {"p*": [], "u*": [], "speed of the shock": []}
    for cells in CELLS:
        outcome = simulate(meshed(_tube(cells, LINE)))
        line = profile(outcome.snapshot, 1)
        place = front(line, 1.0 / cells, 0.5 * (EXACT.pressure + EXACT.right.pressure))
        behind = plateau(line, 1.0 / cells, EXACT.contact * END_TIME, place)
        got = (behind.stress, behind.velocity, place / END_TIME)
        exact = (EXACT.pressure, EXACT.velocity, EXACT.shock)
        for series, value, answer in zip(errors.values(), got, exact, strict=True):
            series.append(abs(value / answer - 1.0))
    for name, series in errors.items():
        yield at_most(f"Sod, {CELLS[-1]} elements: error of {name}", limit=ELEMENTS, got=series[-1])
    for name, series in errors.items():
        yield trend(f"Sod: error of the {name}, finest of {len(CELLS)}", series)
    yield from kept("Sod", outcome.audit, ROUND_OFF)


def _gases(problem: Problem) -> Gases:
    snapshot = simulate(problem).snapshot
    return profile(snapshot, 0), profile(snapshot, 1)


def _tube(cells: int, recipe: Recipe) -> Problem:
    left, right = SOD
    matter = gas(SOD_GAMMA, densest=left.density, sound_speed=left.sound_speed(SOD_GAMMA))
    return column(
        [
            Stretch(name, matter, state.density, begin, begin + 0.5, energy=state.energy(SOD_GAMMA))
            for name, state, begin in (("left", left, -0.5), ("right", right, 0.0))
        ],
        recipe,
        lower=-0.5,
        cells=cells,
        spacing=1.0 / cells,
        end_time=END_TIME,
        ends=("SYMMETRIC", "SYMMETRIC"),
    )


def _rows(gases: Gases, cells: int) -> Iterator[Row]:
    """The states beside the contact and the shock, against their gates."""
    spacing = 1.0 / cells
    regions = {
        "left of the contact": (gases[0], EXACT.tail * END_TIME, EXACT.left_density),
        "right of the contact": (gases[1], EXACT.shock * END_TIME, EXACT.right_density),
    }
    for name, (line, end, density) in regions.items():
        region = _between(line, EXACT.contact * END_TIME, end, spacing)
        yield from relatives(
            f"Sod, {cells} cells, {name}",
            ("p*", EXACT.pressure, region.mean(region.stress), PRESSURE),
            ("u*", EXACT.velocity, region.mean(region.velocity), VELOCITY),
            ("density", density, float(region.mass.sum() / region.volume.sum()), DENSITY),
        )
    shock = front(gases[1], spacing, 0.5 * (EXACT.pressure + EXACT.right.pressure)) / END_TIME
    yield from relatives(f"Sod, {cells} cells", ("mean speed of the shock", EXACT.shock, shock, SHOCK_SPEED))


def _between(line: ColumnProfile, begin: float, end: float, spacing: float) -> ColumnProfile:
    """A uniform region: three cells at the contact and the outer fifth left out, both by the exact places."""
    inner = INTERFACE_CELLS * spacing * (1.0 if end > begin else -1.0)
    low, high = sorted((begin + inner, end - OUTER_SHARE * (end - begin)))
    return line.part((line.place > low) & (line.place < high))


def _density_error(gases: Gases, section: float) -> float:
    """Mean over the tube of |density - exact|, with the volumes of the particles; ``section`` is that of the tube."""
    gaps = [line.volume * np.abs(line.density - EXACT.density(line.place, END_TIME)) for line in gases]
    return sum(float(gap.sum()) for gap in gaps) / section


CASE = (_on_grid, _smoothed)
