"""The stored model part: each metal has the runs behind it, and holds what other sourced models make of a shot."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest
import xarray as xr

from docs.model_part import METALS, SHOTS, SPEEDS, class_of
from docs.pages import read_json
from solver import PHYSICS_VERSION
from studies import materials
from studies.cubes import cube
from studies.cubes.models import BASE, STORED, classes, stored_failures, stored_shares
from studies.quantities.measured import Measured
from studies.sweeps.axes import Axis
from studies.sweeps.screening import CONTRIBUTIONS, FAILURE, STRENGTH, THROWN_OUT
from tests.cases.cubes import result_of
from tests.claims.rows import Row, at_least, at_most, equal, relative
from tests.studies.support import fakes

SPEED = SPEEDS.index(5e3)
HOLE = "hole_diameter"
KEPT = 1e-4  # digits that are stored
DIGITS = 6  # of shares that are compared, in per cent
# The shot that was computed with each failure before the model part was: 2024-T3 on 2024-T3.
SHOT: dict[str, Any] = {
    **dict.fromkeys(("projectile", "target"), "al-2024-t3"),
    **{"projectile_diameter": 10e-3, "plate_thickness": 4e-3, "speed": 6.18e3, "cells_per_diameter": 24.0},
}
WIDEST = [
    *({"failure": "spall", "failure_time": time} for time in (10e-9, 20e-9, 50e-9, 100e-9, 1e-6)),
    *({"failure": "plastic-strain", "failure_strain": strain} for strain in (0.3, 1.0)),
]


@pytest.mark.parametrize("scenario", SHOTS)
def test_stored__is_there_for_every_metal_at_every_speed(scenario: str) -> None:
    mine = {each["material"]: each for each in classes() if each["scenario"] == scenario}
    assert set(mine) == set(METALS)
    families = {each["family"] for each in mine.values()}
    assert {load.family for load in map(materials.load, materials.names())} == families
    for each in mine.values():
        quantity = HOLE if scenario == "thin_plate" else "crater_depth"
        assert None not in each["quantities"][quantity][BASE]


@pytest.mark.claim("breaking", "model-part-runs", minutes=4.0)
@pytest.mark.parametrize("metal", METALS)
def test_model_part__is_what_its_runs_give(metal: str, compared: Callable[..., None]) -> None:
    """Each change of strength, failure and equation of state behind a metal's model part gives the stored hole."""
    (stored,) = [each for each in classes() if (each["scenario"], each["material"]) == ("thin_plate", metal)]
    answers = class_of("thin_plate", metal, SPEEDS[SPEED : SPEED + 1])["quantities"][HOLE]
    at_speed = {change: values[SPEED] for change, values in stored["quantities"][HOLE].items()}
    holes = {change: hole for change, hole in at_speed.items() if hole is not None}
    compared(equal(f"{metal}: changes", expected=list(holes), got=list(answers)))
    for change, (value,) in answers.items():
        compared(relative(f"{metal}, {change}: hole (m)", expected=holes[change], got=value, within=KEPT))
    shares = stored_shares(stored, HOLE, SPEEDS[SPEED])
    compared(at_least(f"{metal}: share of strength", limit=KEPT, got=shares[STRENGTH]))
    failures = stored_failures(stored, HOLE, SPEEDS[SPEED], stored["failure"])
    if materials.load(metal).value_at("spall.strength") is not None:
        compared(at_least(f"{metal}: difference by failure", limit=KEPT, got=max(map(abs, failures.values()))))
    for name in CONTRIBUTIONS:
        compared(Row(f"{metal}: {name}", "", shares.get(name, "not assessed"), passed=None))


@pytest.mark.claim("breaking", "model-part-widest", minutes=0.5)
def test_failures__hold_what_those_of_any_constant_make_of_a_shot(compared: Callable[..., None]) -> None:
    """The widest of seven failures with constants of a user moves a hole less than those that a report names."""

    def hole(**failure: object) -> float:
        return result_of("thin_plate", {**SHOT, **failure}).measurements[HOLE].value or math.nan

    base = hole()
    (stored,) = [each for each in classes() if (each["scenario"], each["material"]) == ("thin_plate", "al-2024-t3")]
    most = max(map(abs, stored_failures(stored, HOLE, SHOT["speed"], stored["failure"]).values()))
    for each in WIDEST:
        got = abs(hole(**each) / base - 1.0)
        compared(at_most(f"{each}: difference from the default", limit=most, got=got))


# ---- its shape -----------------------------------------------------------------------------------

STATED = (("thin_plate", (HOLE,)), ("thick_plate", ("crater_depth", "crater_diameter")))
SYMMETRIC = ("strength", "equation of state")
VALUE = 0.02  # m, of each invented run
Shape = dict[str, float]  # strength and equation of state: share; each failure: signed difference


@pytest.mark.claim("mesh-error", "model-part-shape")
@pytest.mark.parametrize("metal", ["copper-ofhc", "al-6061-t6"])
def test_model_part__has_the_shape_that_its_answers_give(metal: str, compared: Callable[..., None]) -> None:
    """What models leave open of holes and craters follows from stored answers: one part is symmetric, one has two sides
    by failures, and those that the rule of the default throws out are named alone.
    """
    rule = read_json(THROWN_OUT)
    out = {name for name, why in rule["reasons"].items() if why}
    for scenario, quantities in STATED:
        (stored,) = [each for each in read_json(STORED) if (each["scenario"], each["material"]) == (scenario, metal)]
        physics = {stored["physics"], rule["physics"]}
        compared(equal(f"{metal}, {scenario}: physics of what is stored", expected={PHYSICS_VERSION}, got=physics))
        speeds = stored["speeds"]
        speeds += [(low + high) / 2.0 for low, high in pairwise(speeds)]
        for own in (stored[FAILURE], "johnson-cook"):
            dataset = _cube_of(scenario, metal, quantities, own, speeds)
            for quantity in quantities:
                answers = stored["quantities"][quantity]
                shapes = [_shape(answers, place, stored[FAILURE], own) for place in range(len(answers[BASE]))]
                shapes += [_middle(*ends) for ends in pairwise(shapes)]
                named = {name for shape in shapes for name in shape if name in out and name != own}
                for speed, shape in zip(speeds, shapes, strict=True):
                    where = f"{quantity} of {metal} with {own} at {speed / 1e3:g} km/s"
                    point = dataset.sel(speed=speed).squeeze()
                    compared(*_rows(where, point, quantity, shape, out), *_names(where, point, quantity, named))


def _cube_of(scenario: str, metal: str, quantities: Sequence[str], own: str, speeds: Sequence[float]) -> xr.Dataset:
    """A cube of invented runs, all with the same value."""
    fixed = {**SHOTS[scenario], **dict.fromkeys(("projectile", "target"), metal), "failure": own}
    cells = fixed.pop("cells_per_diameter")
    axis = Axis("speed", "m s-1", tuple(sorted(speeds)))
    sweep = fakes.sweep_of(axis, scenario=scenario, fixed=fixed, resolutions=(cells,))
    measured = {name: Measured(VALUE, 1e-4, {"resolution": 1e-4}, (), {}, 1) for name in quantities}
    runs = [point.run for point in sweep.runs()]
    return cube.build(sweep, {run.id: replace(fakes.result(run), measurements=measured) for run in runs})


def _shape(answers: Mapping[str, Sequence[float | None]], place: int, default: str, own: str) -> Shape:
    """What the stored answers at a speed make of one with a failure."""
    told = {name: value for name, values in answers.items() if (value := values[place])}
    changed = {name: abs(value / told[BASE] - 1.0) for name, value in told.items()}
    shape = {kind: max(changed[name] for name in told if name.startswith(kind)) for kind in SYMMETRIC}
    by_failure = {default: told[BASE], **{name.split()[1]: told[name] for name in told if name.startswith(FAILURE)}}
    return shape | {name: value / by_failure[own] - 1.0 for name, value in by_failure.items()}


def _middle(low: Shape, high: Shape) -> Shape:
    """The shape half way between two speeds; what one of them does not tell is that of the other."""
    names = {**low, **high}
    return {name: (low.get(name, names[name]) + high.get(name, names[name])) / 2.0 for name in names}


def _rows(where: str, point: xr.Dataset, quantity: str, shape: Shape, out: set[str]) -> Iterator[Row]:
    """The parts of a point of the cube, in per cent, beside those of a shape."""
    symmetric = [shape[kind] for kind in SYMMETRIC]
    failures = {name: share for name, share in shape.items() if name not in SYMMETRIC}
    moved = [share for name, share in failures.items() if name not in out]
    parts = {
        "model_part": math.hypot(*symmetric),
        "model_part_lower": max(0.0, -min(moved)),
        "model_part_upper": max(0.0, *moved),
    }
    got = [round(100.0 * float(point[f"{quantity}_{part}"] / point[quantity]), DIGITS) for part in parts]
    expected = [round(100.0 * part, DIGITS) for part in parts.values()]
    yield equal(f"{where}: symmetric, lower, upper part (%)", expected=expected, got=got)
    before = 100.0 * math.hypot(*symmetric, max(map(abs, failures.values())))
    yield Row(f"{where}: one symmetric part with every failure (%)", "", round(before, 1), passed=None)


def _names(where: str, point: xr.Dataset, quantity: str, named: set[str]) -> Iterator[Row]:
    """Which failures a point of the cube names as thrown out, and whether each side has one that is not."""
    listed = str(point[f"{quantity}_model_part_thrown_out"].values).split(", ")
    yield equal(f"{where}: thrown out", expected=sorted(named), got=sorted(listed))
    for side in ("lower", "upper"):
        size, maker = (point[f"{quantity}_model_part_{name}"].values for name in (side, f"{side}_failure"))
        yield equal(
            f"{where}: {side} part has a failure", expected=bool(size), got=bool(maker) and str(maker) not in named
        )
