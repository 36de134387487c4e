"""Screening runs: another strength, failure and equation of state, beside the points of a sweep."""

import math
from dataclasses import replace
from functools import partial
from statistics import mean, stdev

import pytest

from studies import materials
from studies.materials.schema import SpallStrength
from studies.runs.run import Run
from studies.sweeps.cost import cost_of
from studies.sweeps.screening import (
    DRAWN,
    STRENGTH,
    STRENGTH_DEVIATION,
    STRONGER,
    WEAKER,
    contributions_of,
    failures_of,
    screens_of,
)
from studies.sweeps.sweep import Sweep
from tests.contracts.test_scenarios import asked

DOCUMENT = {
    "scenario": "thin_plate",
    "fixed": {
        **dict.fromkeys(("projectile", "target"), "copper-ofhc"),
        **{"projectile_diameter": "8 mm", "plate_thickness": "2 mm"},
    },
    "axes": {"speed": ["4 km/s", "5 km/s", "6 km/s"]},
    "resolution": [8, 12],
    "model_part": "screen",
}


def run_of(material: str) -> Run:
    return asked("thin_plate", projectile=material, target=material)


def test_strength_deviation__is_that_of_published_strengths() -> None:
    # Yield stress of Al 6061-T6, and flow stress of copper at a plastic strain of 1 and 1e5/s, both in MPa: the sources
    # are at the constant.
    rates = [1.0 + rate * math.log(1e5) for rate in (0.025, 0.013)]
    johnson_cook = [(90.0 + 292.0) * rates[0], (65.0 + 356.0) * rates[1]]
    copper = [*johnson_cook, 157.0 + 425.0, 118.0 + 484.0, 120.0 * 37.0**0.45]
    aluminium = [276.0, 290.0, 324.0]
    deviations = [stdev(each) / mean(each) for each in (copper, aluminium)]
    assert deviations == pytest.approx([0.11, 0.08], abs=0.005)
    assert min(deviations) < STRENGTH_DEVIATION < max(deviations)


@pytest.mark.parametrize("name", materials.names())
def test_strength__of_any_material_is_scaled_in_its_stresses_alone(name: str) -> None:
    run = run_of(name)
    stronger, weaker, *_ = screens_of(run)
    for screen, factor in ((stronger, 1.0 + STRENGTH_DEVIATION), (weaker, 1.0 - STRENGTH_DEVIATION)):
        assert screen.run is not None
        before, after = (each.materials["target"] for each in (run, screen.run))
        for path, unit in before.paths().items():
            value = before.value_at(path)
            scale = factor if unit == "Pa" and path.startswith("strength.") else 1.0
            assert after.value_at(path) == (value if value is None else pytest.approx(scale * value))


def test_screens__are_every_other_source_of_strength_failure_and_equation_of_state() -> None:
    screens = {each.name: each.run for each in screens_of(run_of("copper-ofhc"))}
    assert list(screens) == [
        STRONGER,
        WEAKER,
        "strength of copper-ofhc-steinberg",
        "failure none",
        "failure spall-rate",
        "failure johnson-cook",
        "failure johnson-cook-spall",
        "equation of state of copper-ofhc-tillotson",
    ]
    assert all(screens.values())
    on = screens["failure spall-rate"]
    assert on is not None
    back = {each.name: each.run for each in screens_of(on)}["failure void-growth"]
    assert back is not None
    assert back.id == run_of("copper-ofhc").id

    (screen,) = [each for each in screens_of(run_of("al-1100-o")) if each.name == "failure johnson-cook"]
    assert screen.run is None
    assert "fracture strain D1" in screen.reason


def test_contributions__are_the_largest_difference_that_an_alternative_makes_and_the_mean_square_of_draws() -> None:
    answers = {STRONGER: 19.0, WEAKER: 21.0, "strength of another": 17.0, "failure spall-rate": 20.5}
    assert contributions_of(20.0, answers) == pytest.approx({STRENGTH: 0.15})
    drawn = {STRONGER: 19.8, f"{DRAWN} of one": 18.0, f"{DRAWN} of two": 22.0, f"{DRAWN} of three": 20.0}
    assert contributions_of(20.0, drawn) == pytest.approx({STRENGTH: 0.1 * math.sqrt(2.0 / 3.0)})


def test_failures__are_signed_differences_from_the_failure_that_is_asked_for() -> None:
    answers = {STRONGER: 19.0, "failure none": 19.0, "failure johnson-cook": 25.0}
    of = partial(failures_of, 20.0, answers, own="void-growth")
    assert of(of="void-growth") == pytest.approx({"none": -0.05, "johnson-cook": 0.25})
    assert of(of="johnson-cook") == pytest.approx({"none": -0.24, "void-growth": -0.2})
    assert of(of="spall") == {}
    assert failures_of(20.0, {STRONGER: 19.0}, own=None, of=None) == {}


def test_screens__are_the_materials_of_a_sweep_that_have_the_alloy_too() -> None:
    own = {f"draw-{a}": {"base": "copper-ofhc", "strength": {"A": f"{a} MPa"}} for a in (60, 120)}
    own["another"] = {"base": "al-6061-t6", "strength": {"A": "300 MPa"}}
    _, screens = Sweep.parse({**DOCUMENT, "materials": own}).screening()
    drawn = {each.name: each.run for each in screens if each.name.startswith(DRAWN)}
    assert list(drawn) == [f"{DRAWN} of draw-60", f"{DRAWN} of draw-120"]
    run = drawn[f"{DRAWN} of draw-60"]
    assert run is not None
    assert [run.materials[role].value_at("strength.A") for role in ("projectile", "target")] == [60e6, 60e6]


def test_sweep__screens_its_middle_on_the_finest_grid_beside_its_points() -> None:
    sweep = Sweep.parse(DOCUMENT)
    middle, screens = sweep.screening()
    assert (middle.parameters["speed"], middle.parameters["cells_per_diameter"]) == (5e3, 12.0)
    assert middle.id in {point.run.id for point in sweep.runs()}
    beside = [*sweep.every_run()][len(sweep.runs()) :]
    assert [point.coordinates["screening"] for point in beside] == [each.name for each in screens]
    assert [point.run.id for point in beside] == [each.run.id for each in screens if each.run]
    assert cost_of(sweep).runs == sweep.size + len(screens)


def test_strength__of_a_material_without_constants_of_failure_breaks_as_the_one_that_it_replaces() -> None:
    copper = materials.load("copper-ofhc")
    other = replace(copper.with_value("strength.A", 100e6), name="other", spall=SpallStrength())
    *_, screen = [each for each in screens_of(run_of("copper-ofhc"), [other]) if each.name.startswith(DRAWN)]
    assert screen.run is not None
    assert screen.run.materials["target"].spall == copper.spall
