"""Debris clouds behind a copper plate of 2 mm at 2 to 8 km/s, and of 3 mm at 6.6 km/s: Ma (2005), section 3.1.2."""

import math
from collections.abc import Iterator, Mapping

import xarray as xr

from studies.cases.compared import ComparedReading, Picture, against, grids_of
from studies.cases.validation import Cubes, Document, ValidationCase, ValidationLevel
from studies.quantities.comparison import Comparison, at_most

DIAMETER = 8e-3  # m
DENSITY = 8930.0  # kg/m3
FINE = [16, 32, 64]
QUICK = 8
CLOSED = 1e-6  # of the momentum
# Of 2 u_p, the impact speed of like metals: gated for the thesis' 3 mm and 6.6 km/s, where it was stated before a run,
# from 16 cells across the sphere on; on 8 cells jets are faster, which was known when this was written.
FASTEST = 1.1
PHOTOGRAPH = "photograph"
SHAPES = ("cloud_length_over_diameter", "cloud_radius", "rear_velocity", "melted_share_behind")


def _sweeps(level: ValidationLevel) -> Mapping[str, Document]:
    copper = {"projectile": "copper-ofhc", "target": "copper-ofhc"}
    speeds = (2, 6) if level == "quick" else (2, 4, 6, 8)
    plates = {"speeds": ("2 mm", [f"{speed} km/s" for speed in speeds]), PHOTOGRAPH: ("3 mm", ["6.6 km/s"])}
    # The photograph has its gate from 16 cells on.
    cells = {name: QUICK if level == "quick" and name == "speeds" else FINE[0] for name in plates}
    return {
        name: {
            "title": "Debris clouds: Ma (2005), section 3.1.2",
            "scenario": "debris_cloud",
            "fixed": {**copper, "projectile_diameter": "8 mm", "plate_thickness": thickness},
            "axes": {"speed": speeds},
            "resolution": FINE if level == "fine" else cells[name],
        }
        for name, (thickness, speeds) in plates.items()
    }


def _rows(level: ValidationLevel, cubes: Cubes) -> Iterator[Comparison]:
    for name, cube in cubes.items():
        plate = f"plate of {1e3 * float(cube.plate_thickness):g} mm"
        for speed in cube.speed.values:
            at = {"speed": float(speed)}
            where = f"{plate}, {speed / 1e3:g} km/s"
            yield from _balances(where, cube, at)
            tip = ComparedReading(cube, "tip_velocity_permille", at)
            got = tip.best[0] / tip.factor / speed
            made = at_most(f"{where}: velocity that 0.1 % of the mass exceeds, over 2 u_p", limit=FASTEST, got=got)
            yield made if name == PHOTOGRAPH else made.ungated(FASTEST)
            for quantity in SHAPES:
                reading = ComparedReading(cube, quantity, at)
                value, bar = reading.best
                place = f"{where}, {reading.convergence}" if reading.is_refined else where
                yield Comparison(f"{place}: {reading.label}", "", value, None, bar=bar)


def _balances(where: str, cube: xr.Dataset, at: Mapping[str, float]) -> Iterator[Comparison]:
    """Axial momentum of all matter, on each grid: that of the projectile."""
    momentum = math.pi / 6.0 * DIAMETER**3 * DENSITY * at["speed"]
    for cells, run in grids_of(cube.sel(at)):
        yield at_most(
            f"{where}, {cells:g} cells: error of the momentum (of {momentum:.4g} N s)",
            limit=CLOSED,
            got=abs(float(run.audit_momentum_error)),
        )


def _pictures(cubes: Cubes) -> Iterator[Picture]:
    for name in ("tip_velocity_permille", "cloud_length_over_diameter"):
        title = name.replace("_", " ").capitalize()
        yield against(f"cloud-{name}", title, cubes["speeds"], name, "speed", [])


CASE = ValidationCase(
    name="debris-clouds",
    says="debris behind a copper plate at 2 to 8 km/s: the momentum is closed to 1e-6; behind 3 mm at 6.6 km/s no more "
    "than 0.1 % of the mass flies faster than 1.1 x 2 u_p; shape and melt of each cloud, on three grids",
    source="Ma (2005), section 3.1.2 and Figs. 3.3 to 3.5, which are pictures",
    sweeps=_sweeps,
    rows=_rows,
    pictures=_pictures,
)
