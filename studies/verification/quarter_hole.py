"""The hole in a quarter model and in the whole plate, at the end of the run."""

from collections.abc import Iterator

import numpy as np

from solver.simulation import simulate
from solver.state import Snapshot
from studies import measurements
from studies.measurements._impact import view
from studies.values.recipes import Recipe
from studies.verification import Case, Row, absolute, reported
from studies.verification._impacts import SMALL, impact_setting, unfolded

END_TIME = 25e-6  # s
# Half a cell is what a user may count on. Faces of symmetry that turn no force round shift the hole by half of that: a
# twentieth of a cell sees them.
WITHIN = 0.05
QUANTITIES = ("hole_diameter", "hole_diameter_areal")


def _run(recipe: Recipe) -> Iterator[Row]:
    quarter = impact_setting(recipe, geometry="quarter", material="copper-ofhc", end_time=END_TIME, plate_radius=20e-3)
    whole = unfolded(unfolded(quarter.problem, 0), 1)
    cell = quarter.problem.geometry.spacing
    views = {
        "quarter": view(quarter, simulate(quarter.problem).snapshot),
        "whole": view(quarter, _folded(simulate(whole).snapshot)),
    }
    for quantity in QUANTITIES:
        read = {name: measurements.load(quantity).read(state).value for name, state in views.items()}
        yield absolute(
            f"{quantity}, {SMALL['speed'] / 1e3:g} km/s, {SMALL['cells_per_diameter']:g} cells per diameter: "
            "quarter against whole (cells)",
            expected=read["whole"] / cell,
            got=read["quarter"] / cell,
            within=WITHIN if quantity == QUANTITIES[0] else None,
        )
    yield reported("hole of the whole plate (mm)", 1e3 * measurements.load(QUANTITIES[0]).read(views["whole"]).value)


def _folded(snapshot: Snapshot) -> Snapshot:
    """The four quarters of a plate on top of one another, each with a quarter of its mass."""
    p = snapshot.particles
    position = p.position.copy()
    position[:, :2] = np.abs(position[:, :2])
    return snapshot._replace(particles=p._replace(position=position, mass=0.25 * p.mass))


CASE = Case(
    name="quarter-hole",
    says="the hole of a quarter model is that of the whole plate within a twentieth of a cell",
    source="symmetry; round-off grows in a flow that breaks up, a hole must not",
    run=_run,
    quick=False,
)
