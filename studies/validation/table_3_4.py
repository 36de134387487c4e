"""Craters in a copper block at 4 to 7 km/s: Ma (2005), section 3.2.2, Table 3.4.

The published numbers are computed ones, on cells of 1 mm, and are the table of shots ``craters-thesis``. How the
thesis reads a diameter is not said. Ours, at the original surface, misses the tolerance at 5 km/s in the half model, by
0.2 mm of 3 mm: the mouth widens to the end. At 30 us version 5 of the diameter, from which the present one differs by
up to 0.2 mm, had the published ones within 1 mm (24.0, 25.9, 28.7 and 30.1 mm); from there to 45 us it grew by 0.6,
2.4, 2.0 and 2.9 mm, the depth by 0.9 mm at most. The figures of the thesis are of 45 us.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from studies.fits.fit import fit, forms_of
from studies.fits.measured import MeasuredShots, of_table
from studies.validation import Cubes, Level, Picture, PublishedNumber, Validation, of_observations
from studies.validation._block import CELL, MESH, craters
from studies.validation._compare import ComparedReading, against, compared
from studies.verification import Row

DIAMETER = 5e-3  # m
CELLS = DIAMETER / CELL
THESIS = "MPM3D (Ma 2005)"

# Two cells in depth, and a cell and a half on either side: what a reading on such a grid can differ by.
WITHIN = {"crater_depth": 2.0, "crater_diameter": 3.0}  # mm
FORMS = ("linear", "power")


def _sweeps(level: Level) -> Mapping[str, Mapping[str, Any]]:
    shape = {"projectile_shape": "cylinder", "projectile_length": "4 mm"}
    crater = craters(level, DIAMETER, "45 us", **shape)
    speeds = [f"{speed} km/s" for speed in (4, 5, 6, 7)]
    title = "Craters in a copper block: Ma (2005), Table 3.4"
    return {"craters": {"title": title, "axes": {"speed": speeds}, **crater}}


def _numbers() -> list[PublishedNumber]:
    return of_observations("craters-thesis", "thick_plate", THESIS)


def _rows(level: Level, cubes: Cubes) -> Iterator[Row]:
    cube, numbers = cubes["craters"], _numbers()
    for name, within in WITHIN.items():
        for speed in cube.speed.values:
            quantity = ComparedReading(cube, name, {"speed": float(speed)})
            there = [each for each in numbers if each.shot.parameters["speed"] == speed]
            where = f"{speed / 1e3:g} km/s"
            yield from compared(where, quantity, there, THESIS, mesh=(CELLS, MESH), within=within)
    yield from _fits(cubes)


def _fits(cubes: Cubes) -> Iterator[Row]:
    """Line and power through the published points and through ours, with the root of the mean square; mm, km/s."""
    for published in of_table("craters-thesis", list(WITHIN)):
        for form in forms_of(published.quantity):
            if form.name in FORMS:
                texts = [_fitted(each, form) for each in (published, _ours(cubes, published))]
                words = published.quantity.replace("_", " ")
                claim = f"{words}, {form.equation.replace('y/d', 'y')}; y in mm (rms in mm)"
                yield Row(claim, texts[0], texts[1], None)


def _ours(cubes: Cubes, published: MeasuredShots) -> MeasuredShots:
    """The published points with our sizes, whatever their flags."""
    values = [
        ComparedReading(cubes["craters"], published.quantity, {"speed": shot.speed}).best[0] / 1e3
        for shot in published.shots
    ]
    return replace(published, values=np.array(values), errors=None)


def _fitted(measured: MeasuredShots, form: Any) -> str:
    if not np.isfinite(measured.values).all():
        return "a point has no value"
    fitted = fit(measured, form)
    if fitted.solution is None:
        return fitted.reason
    constants = ", ".join(f"{name} = {value:.3g}" for name, value in (fitted.in_millimetres() or {}).items())
    return f"{constants} ({1e3 * fitted.rms:.2f})"


def _pictures(cubes: Cubes) -> Iterator[Picture]:
    for name in WITHIN:
        words = name.replace("_", " ").capitalize()
        title = f"{words}, copper cylinder on copper"
        yield against(f"table-3-4-{name}", title, cubes["craters"], name, "speed", _numbers())


CASE = Validation(
    name="table-3-4",
    says="craters of the thesis' copper cylinder at 4 to 7 km/s: on its cells of 1 mm within 2 mm in depth and 3 mm in "
    "diameter (its half model misses the diameter of 5 km/s by 0.2 mm); the value without a mesh beside it, deeper "
    "and wider",
    source="Ma (2005), section 3.2.2, Table 3.4: computed with MPM3D",
    sweeps=_sweeps,
    rows=_rows,
    pictures=_pictures,
)
