"""Holes in a copper plate of a quarter of the sphere's diameter at 2 to 7 km/s: Ma (2005), section 3.1.1.

The thesis' figure 3.2 is lost; it says that its holes lie between its laws A, B and C (Eqs. 1-3 to 1-5), near A and B
at high speed. Its mesh has two cells through the plate.
"""

import math
from collections.abc import Iterator, Mapping

import xarray as xr

from studies.cases.compared import ComparedReading, Picture, against
from studies.cases.validation import Cubes, Document, ValidationCase, ValidationLevel, numbers_of
from studies.quantities.comparison import Comparison

DIAMETER = 8.0  # mm
THESIS = 8  # cells per diameter
FINE = [8, 16, 32, 64]
A, B, C = "maiden_al", "zhang_tan", "strength_ln"


def _sweeps(level: ValidationLevel) -> Mapping[str, Document]:
    return {
        "holes": {
            "title": "Holes in a copper plate: Ma (2005), section 3.1.1",
            "scenario": "thin_plate",
            "fixed": {
                "projectile": "copper-thesis-jc",
                "target": "copper-thesis-jc",
                "projectile_diameter": f"{DIAMETER:g} mm",
                "plate_thickness": "2 mm",
                "plate_radius": "25 mm",
                "geometry": "quarter" if level == "thesis" else "axisymmetric",
                "recipe": "thesis",
                "edges": "fixed",
                "eos_form": "cubic",
                "thermal_softening": False,
                "tension": "unlimited",
                "end_time": "30 us",
                "stop": "end_time",
            },
            "axes": {"speed": [f"{speed} km/s" for speed in range(2, 8)]},
            "resolution": FINE if level == "fine" else THESIS,
        }
    }


def _rows(level: ValidationLevel, cubes: Cubes) -> Iterator[Comparison]:
    cube, numbers = cubes["holes"], numbers_of("thesis_holes", "thin_plate")
    for speed in cube.speed.values:
        hole = ComparedReading(cube, "hole_diameter", {"speed": float(speed)})
        beside = {each.by: hole.factor * each.value for each in numbers if each.shot.parameters["speed"] == speed}
        answers = {law: hole.factor * _answer(cube, law, speed) for law in (A, B, C)}
        known = [answer for answer in answers.values() if math.isfinite(answer)]
        low, high = min(known), max(known)
        where = f"{speed / 1e3:g} km/s"
        got = hole.on(THESIS if hole.is_refined else None)
        expected = f"between {low:.3g} and {high:.3g}, laws A, B and C"
        claim = f"{where}, cells of 1 mm: {hole.label}"
        passed = bool(low <= got <= high)
        yield Comparison(claim, expected, got, passed, others=answers | beside)
        if hole.is_refined:
            got, bar, _ = hole.converged
            claim = f"{where}, {hole.convergence}: {hole.label}"
            yield Comparison(claim, expected, got, None, bar=bar, others=answers | beside)


def _answer(cube: xr.Dataset, law: str, speed: float) -> float:
    """The hole of a law at a speed, m, whatever its range; the smallest of its variants."""
    labels = [str(label) for label in cube.hole_diameter_law.values]
    places = [place for place, label in enumerate(labels) if label.startswith(law)]
    return float(cube.hole_diameter_by_law.sel(speed=speed).values[places].min())


def _pictures(cubes: Cubes) -> Iterator[Picture]:
    numbers = numbers_of("thesis_holes", "thin_plate")
    title = "Holes in copper, t/d = 0.25"
    yield against("holes", title, cubes["holes"], "hole_diameter", "speed", numbers)


CASE = ValidationCase(
    name="thesis-holes",
    says="holes of the thesis' copper sphere in a plate of a quarter of its size lie between its laws A, B and C at "
    "2 to 7 km/s on its cells of 1 mm; the converged ones beside",
    source="Ma (2005), section 3.1.1 and Fig. 3.2; MPM3D-F90 on the same deck",
    sweeps=_sweeps,
    rows=_rows,
    pictures=_pictures,
)
