"""Holes in aluminium 2024-T3 where Maiden's law was fitted: Maiden, Gehring and McMillan (1963), by Ma (2005), Eq. 1-3.

The shots themselves are in no open source, so that their fit stands for them.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

from studies.cases.compared import ComparedReading, Line, Picture
from studies.cases.validation import Cubes, Document, ValidationCase, ValidationLevel
from studies.laws.maiden_al import hole_ratio
from studies.quantities.comparison import Comparison, relative

DIAMETER = 10.0  # mm
THICKNESSES = (2.0, 4.0)  # mm
SPEEDS = (4.0, 5.5, 7.0)  # km/s
FINE = [20, 30, 45]
QUICK = 16  # the least that a projectile is resolved with

# Of craters and holes against experiments, as the project's reference asks; above 5 km/s, where published laws for
# aluminium agree with each other to 12 %. Below they differ by up to 30 %, and rows are reported.
SHARE, FROM = 0.15, 5e3


def _sweeps(level: ValidationLevel) -> Mapping[str, Document]:
    quick = level == "quick"
    thicknesses, speeds = (THICKNESSES[1:], SPEEDS[1:]) if quick else (THICKNESSES, SPEEDS)
    return {
        "holes": {
            "title": "Holes in aluminium 2024-T3, in the range of Maiden's law",
            "scenario": "thin_plate",
            "fixed": {"projectile": "al-2024-t3", "target": "al-2024-t3", "projectile_diameter": f"{DIAMETER:g} mm"},
            "axes": {
                "speed": [f"{speed:g} km/s" for speed in speeds],
                "plate_thickness": [f"{thickness:g} mm" for thickness in thicknesses],
            },
            "resolution": FINE if level == "fine" else QUICK if quick else FINE[0],
        }
    }


def _rows(level: ValidationLevel, cubes: Cubes) -> Iterator[Comparison]:
    cube = cubes["holes"]
    for thickness in cube.plate_thickness.values:
        for speed in cube.speed.values:
            at = {"speed": float(speed), "plate_thickness": float(thickness)}
            hole = ComparedReading(cube, "hole_diameter", at)
            value, bar = hole.best
            ratio = float(hole_ratio(speed, 1e3 * thickness / DIAMETER))
            made = relative(
                f"{speed / 1e3:g} km/s, t/d = {1e3 * thickness / DIAMETER:g}: {hole.label}",
                expected=DIAMETER * ratio,
                got=value,
                within=SHARE if speed >= FROM else None,
            )
            others = {
                str(label): hole.factor * float(answer)
                for label, answer, inside in zip(
                    cube.hole_diameter_law.values,
                    cube.hole_diameter_by_law.sel(at).values,
                    cube.hole_diameter_by_law_in_range.sel(at).values,
                    strict=True,
                )
                if inside and not str(label).startswith("maiden_al")
            }
            yield replace(made, bar=bar, others=others)


def _pictures(cubes: Cubes) -> Iterator[Picture]:
    cube, lines = cubes["holes"], []
    for thickness in cube.plate_thickness.values:
        ratio = 1e3 * float(thickness) / DIAMETER
        speeds = [float(speed) for speed in cube.speed.values]
        law = [(v / 1e3, DIAMETER * float(hole_ratio(v, ratio)), 0.0) for v in speeds]
        ours = [
            ComparedReading(cube, "hole_diameter", {"speed": speed, "plate_thickness": float(thickness)}).point
            for speed in speeds
        ]
        points = tuple((v / 1e3, *hole) for v, hole in zip(speeds, ours, strict=True))
        lines.append(Line(f"whipple, t/d = {ratio:g}", points))
        lines.append(Line(f"Maiden, t/d = {ratio:g}", tuple(law), joined=True))
    title = "Holes in aluminium 2024-T3"
    yield Picture("aluminium-holes", title, "speed (km/s)", "hole diameter (mm)", tuple(lines))


CASE = ValidationCase(
    name="aluminium-holes",
    says="holes in aluminium 2024-T3 are within 15 % of Maiden's law, which was fitted there, at 5 km/s and above; "
    "4 km/s beside",
    source="Maiden, Gehring and McMillan (1963), GM-DRL TR-63-225, by Ma (2005), Eq. 1-3",
    sweeps=_sweeps,
    rows=_rows,
    pictures=_pictures,
)
