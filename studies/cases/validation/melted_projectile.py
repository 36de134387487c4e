"""Melted share of an aluminium sphere behind an aluminium bumper, beside CALE: NASA/TM-2009-214785, Table 4-4.

CALE has another equation of state, with melt; ours is Mie and Grueneisen's, and melt is read off the energy that is
left once matter has expanded, against c_v (T_m - T_0) and the latent heat. The numbers are a comparison of codes and
have no gate; that more melts at a higher speed has.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import pairwise

from studies.cases.compared import ComparedReading, Picture, against, compared
from studies.cases.validation import Cubes, Document, ValidationCase, ValidationLevel, numbers_of
from studies.quantities.comparison import Comparison

QUANTITY = "melted_share_projectile"
SPEEDS, THICKNESSES = (6, 8, 10, 12), (1, 2, 5)  # km/s; mm, of a sphere of 10 mm
FINE, QUICK = [32 / 3, 16, 24], 10  # cells a diameter, each 1.5 times finer


def _sweeps(level: ValidationLevel) -> Mapping[str, Document]:
    thicknesses = THICKNESSES[1:2] if level == "quick" else THICKNESSES
    return {
        "melt": {
            "title": "Melted share of an aluminium sphere: NASA/TM-2009-214785, Table 4-4",
            "scenario": "debris_cloud",
            "fixed": {"projectile": "al-2024-t3", "target": "al-6061-t6", "projectile_diameter": "10 mm"},
            "axes": {
                "speed": [f"{speed} km/s" for speed in SPEEDS],
                "plate_thickness": [f"{thickness} mm" for thickness in thicknesses],
            },
            "resolution": FINE if level == "fine" else QUICK if level == "quick" else FINE[0],
        }
    }


def _rows(level: ValidationLevel, cubes: Cubes) -> Iterator[Comparison]:
    cube, numbers = cubes["melt"], numbers_of("melted_projectile", "debris_cloud")
    for thickness in cube.plate_thickness.values:
        shares = []
        for speed in cube.speed.values:
            at = {"speed": float(speed), "plate_thickness": float(thickness)}
            there = [each for each in numbers if all(abs(each.at(axis) - at[axis]) < 1e-9 for axis in at)]
            where = f"bumper of {100 * thickness:g} diameters, {speed / 1e3:g} km/s"
            reading = ComparedReading(cube, QUANTITY, at)
            if there:  # at 12 km/s the table has the thinner bumpers alone
                yield from compared(where, reading, there, "CALE", mesh=(FINE[0], "coarsest grid"))
            shares.append(reading.best[0])
        rises = all(slow < fast for slow, fast in pairwise(shares))
        got = ", ".join(f"{share:.3g}" for share in shares)
        claim = f"bumper of {100 * thickness:g} diameters: melted share by speed"
        yield Comparison(claim, "rises", got, rises)


def _pictures(cubes: Cubes) -> Iterator[Picture]:
    cube, numbers = cubes["melt"], numbers_of("melted_projectile", "debris_cloud")
    for thickness in cube.plate_thickness.values:
        there = [each for each in numbers if each.shot.parameters["plate_thickness"] == thickness]
        title = f"Melted share of the projectile, t/d = {100 * thickness:g}"
        name = f"melt-{1e3 * thickness:g}-mm"
        plate = cube.sel(plate_thickness=thickness)
        yield replace(against(name, title, plate, QUANTITY, "speed", there), ends=(0.0, 1.0))


CASE = ValidationCase(
    name="melted-projectile",
    says="of an aluminium sphere behind a bumper more is molten at a higher speed; the shares beside those of CALE",
    source="NASA/TM-2009-214785, Table 4-4",
    sweeps=_sweeps,
    rows=_rows,
    pictures=_pictures,
)
