"""Spall of copper and aluminium in plate impacts: the velocity of the free surface, and the spall strength it gives.

The constants of the failures are those of the materials' files, none of which comes from these shots: copper's are
computed from dislocations and voids (Wilkerson and Ramesh 2016), those of 6061 are other plate impacts.
"""

import math
from collections.abc import Iterator, Mapping
from itertools import product

import numpy as np
import xarray as xr

from studies import materials
from studies.cases.compared import ComparedReading, Line, Picture, PublishedNumber
from studies.cases.validation import Cubes, Document, ValidationCase, ValidationLevel, of_observations
from studies.quantities.comparison import Comparison, absolute, relative
from studies.quantities.display import decimals
from studies.quantities.parameters import Plain
from studies.scenarios.parts.matter import elastic_speed

TABLE = "plate-impacts"
COMPUTED = ("copper-ofhc", "al-6061-t6")  # the targets of the table with constants of spall
CELLS = "cells_per_thickness"
FAILURES = ("spall-rate", "void-growth")  # of which the first has no part in the names of its sweeps
GRIDS: dict[ValidationLevel, tuple[float, ...]] = {"quick": (20.0,), "thesis": (50.0,), "fine": (25.0, 50.0, 100.0)}
# Set before any run. The comparison is no gate of this page: the claim ``pull-back`` is.
STRENGTH = 0.1
PEAK = 0.05  # of the velocity of like fluids, which is that of the impact: strength and ripples are within it
ENERGY = 1e-10


def shots() -> dict[str, PublishedNumber]:
    """The published shots that are computed, by the name of their sweep."""
    numbers = [each for each in of_observations(TABLE, "plate_impact", "experiment") if each.shot.parameters]
    chosen = [each for each in numbers if each.shot.parameters["target"] in COMPUTED]
    return {f"{each.shot.parameters['target']}-{each.at('speed'):g}": each for each in chosen}


def document(
    number: PublishedNumber, cells: tuple[float, ...], failure: str = "spall-rate", **fixed: Plain
) -> Document:
    """The sweep of a shot on some grids."""
    shot = number.shot.parameters
    return {
        "title": f"Spall of {shot['target']}: {number.shot.source}",
        "scenario": "plate_impact",
        "fixed": {
            "flyer": str(shot["flyer"]),
            "target": str(shot["target"]),
            "speed": f"{number.at('speed'):g} m/s",
            **{name: f"{1e3 * number.at(name):.6g} mm" for name in ("flyer_thickness", "target_thickness")},
            "strength": "material",
            "failure": failure,
            **fixed,
        },
        "axes": {CELLS: list(cells)},
    }


def _sweeps(level: ValidationLevel) -> Mapping[str, Document]:
    chosen = list(shots().items())
    if level == "quick":  # a shock that comes and goes, of matter that never breaks
        name, number = chosen[0]
        return {name: document(number, GRIDS[level], "none", end_time="0.8 us")}
    return {
        _sweep_name(name, failure): document(number, GRIDS[level], failure)
        for failure in FAILURES
        for name, number in chosen
    }


def _sweep_name(shot: str, failure: str) -> str:
    return shot if failure == FAILURES[0] else f"{shot}-{failure}"


def _published(cubes: Cubes) -> Iterator[tuple[str, PublishedNumber, str, xr.Dataset]]:
    """Of each cube: its name, the published number, the failure and the cube."""
    for (name, number), failure in product(shots().items(), FAILURES):
        sweep = _sweep_name(name, failure)
        if sweep in cubes:
            yield sweep, number, failure, cubes[sweep]


def _rows(level: ValidationLevel, cubes: Cubes) -> Iterator[Comparison]:
    for _, number, failure, cube in _published(cubes):
        for cells in map(float, cube[CELLS].values):
            with_failure = "" if level == "quick" else f", {failure}"
            where = f"{_words(number)}{with_failure}, {cells:g} cells in the flyer"
            speed = number.at("speed")
            yield relative(
                f"{where}: peak of the free surface (m/s)",
                expected=speed,
                got=_read(cube, "free_surface_peak", cells),
                within=PEAK,
            )
            drift = float(cube.audit_largest_energy_drift.sel({CELLS: cells}))
            yield absolute(f"{where}: drift of the total energy", expected=0.0, got=drift, within=ENERGY)
            if level == "quick":
                pull = _read(cube, "pullback_velocity", cells)
                yield Comparison(f"{where}: pull-back without a failure", "none", pull, passed=math.isnan(pull))
            else:
                yield from _pulled(where, number, cube, cells)


def _read(cube: xr.Dataset, name: str, cells: float) -> float:
    """A measured quantity of a run, SI."""
    reading = ComparedReading(cube, name, {CELLS: cells})
    return reading.on() / reading.factor


def _words(number: PublishedNumber) -> str:
    return f"{number.shot.parameters['target']} at {number.at('speed'):g} m/s"


def _pulled(where: str, number: PublishedNumber, cube: xr.Dataset, cells: float) -> Iterator[Comparison]:
    """Pull-back beside the two that the published strength may mean, and the strength itself."""
    pull = _read(cube, "pullback_velocity", cells)
    others = {f"experiment, by {by}": decimals(value, 4) for by, value in pullbacks(number).items()}
    yield Comparison(f"{where}: pull-back (m/s)", "", pull, None, others=others)
    expected, got = number.value / 1e9, _read(cube, "spall_strength", cells) / 1e9
    made = relative(f"{where}: spall strength (GPa)", expected=expected, got=got, within=STRENGTH)
    yield made.ungated(STRENGTH)


def pullbacks(number: PublishedNumber) -> dict[str, float]:
    """The pull-back velocity (m/s) that a published strength means: 2 strength / (rho0 c), by either sound speed."""
    target = materials.load(str(number.shot.parameters["target"]))
    speeds = {"the bulk sound speed": target.sound_speed, "the longitudinal one": elastic_speed(target)}
    return {by: 2.0 * number.value / (target.density * speed) for by, speed in speeds.items()}


def _pictures(cubes: Cubes) -> Iterator[Picture]:
    """Free surfaces from 0.85 of the peak on; the published minimum stands at the time of that of the finest grid."""
    for name, number, failure, cube in _published(cubes):
        peak = float(cube.free_surface_peak.values[-1])
        lines = [_history(cube, cells, 0.85 * peak) for cells in map(float, cube[CELLS].values)]
        lowest = float(cube.free_surface_minimum.values[-1])
        times, velocities, _ = np.array(lines[-1].points).T
        after = int(np.abs(velocities - peak).argmin())
        time = float(times[after + int(np.abs(velocities[after:] - lowest).argmin())])
        lines += [
            Line(f"experiment: minimum by {by}", ((time, peak - pull, 0.0),)) for by, pull in pullbacks(number).items()
        ]
        title = f"Free surface of {_words(number)}, {failure}"
        yield Picture(f"plate-spall-{name}", title, "time (us)", "velocity of the free surface (m/s)", tuple(lines))


def _history(cube: xr.Dataset, cells: float, least: float) -> Line:
    """The velocity of the free surface (m/s) over time (us) on a grid, once it exceeds a least one."""
    run = cube.sel({CELLS: cells})
    time, velocity = run.history_time.values, run.free_surface_velocity_history.values
    shown = time >= time[velocity >= least].min()
    points = zip(time[shown], velocity[shown], strict=True)
    return Line(f"{cells:g} cells in the flyer", tuple((1e6 * float(x), float(y), 0.0) for x, y in points), joined=True)


CASE = ValidationCase(
    name="plate-spall",
    says="plate impacts that spall copper and aluminium 6061: the free surface peaks within 5 % of the impact speed "
    "and energy is closed to 1e-10; pull-back and spall strength stand beside the published ones",
    source="Fensin et al. (2015), J. Appl. Phys. 118 (23), and Chen et al. (2006), J. Appl. Phys. 99 (2), at second "
    "hand: studies/observations/plate-impacts.csv",
    sweeps=_sweeps,
    rows=_rows,
    pictures=_pictures,
)
