"""Plate impacts as they are built: masses, shocks, and when they end."""

import math

import pytest

from studies import materials
from studies.plate_impacts.scenario import CROSSED, shocks
from tests.contracts.test_scenarios import ROUND_OFF, asked, built


@pytest.mark.parametrize("geometry", ["axisymmetric", "quarter"])
def test_plates__weigh_what_their_column_weighs(geometry: str) -> None:
    run = asked("plate_impact", geometry=geometry, target_thickness=6e-3, cells_across=2)
    width = 2 * 4e-3 / 20.0
    section = 0.5 * width**2 if geometry == "axisymmetric" else width**2
    for plate, thickness in zip(built(run).problem.bodies, (4e-3, 6e-3), strict=True):
        mass = plate.density * section * thickness
        assert math.isclose(plate.mass.sum(), mass, rel_tol=ROUND_OFF)


# Shock states of reference copper (8930 kg/m3, 3940 m/s, 1.489) at half the impact speed, from the jump conditions.
SYMMETRIC_COPPER = ((2000.0, 5429.0, 48.48e9), (4000.0, 6918.0, 123.56e9), (7000.0, 9151.5, 286.03e9))


@pytest.mark.parametrize(("speed", "shock", "pressure"), SYMMETRIC_COPPER)
def test_shocks__of_copper_on_copper_are_those_of_the_jump_conditions(
    speed: float, shock: float, pressure: float
) -> None:
    copper = materials.load("copper-ofhc")
    result = shocks(copper, copper, speed)
    assert math.isclose(result.pressure, pressure, rel_tol=1e-4)
    assert result.speeds == pytest.approx((shock, shock), rel=1e-4)


def test_plates__end_before_any_shock_has_crossed_its_plate() -> None:
    run = asked("plate_impact", flyer="al-2024-t3", target_thickness=3e-3)
    problem = built(run).problem
    used = run.materials
    result = shocks(used["flyer"], used["target"], 2000.0)
    crossed = [us * problem.end_time / l for us, l in zip(result.speeds, (4e-3, 3e-3), strict=True)]
    assert math.isclose(max(crossed), CROSSED, rel_tol=1e-9)


def test_plates__break_as_their_failure_says() -> None:
    """The target has the failure, a flyer without its constants none, and its free faces have room until the end."""
    setting = built(asked("plate_impact", flyer="armco-iron", failure="spall-rate"))
    flyer, target = setting.problem.bodies
    assert type(flyer.matter.failure).__name__ == "NoFailure"
    assert target.matter.failure.strength == materials.load("copper-ofhc").value_at("spall.strength")
    # The shock has crossed the target, and two pulses of the flyer have passed.
    pulse = 2.0 * 4e-3 / materials.load("armco-iron").sound_speed
    crossed = 4e-3 / shocks(materials.load("armco-iron"), materials.load("copper-ofhc"), 2000.0).speeds[1]
    assert math.isclose(setting.problem.end_time, crossed + 2.0 * pulse, rel_tol=1e-9)
    # Until then the rear of the target, no faster than twice the impact speed, stays on the grid.
    geometry = setting.problem.geometry
    end = geometry.lower[2] + geometry.cells[2] * geometry.spacing
    assert end - 4e-3 > 2.0 * 2000.0 * (setting.problem.end_time - setting.crossing)
