"""A bar of elements above particles."""

import pytest

from solver.simulation import start
from studies import measurements, scenarios
from tests.contracts.test_scenarios import ROUND_OFF, asked, built
from tests.studies.bars.test_bars import PRESSED


def test_coupled_bar__has_the_mass_of_the_bar_and_is_one_in_its_measurements() -> None:
    setting = built(asked("elastic_bar", method="sph-fem", **PRESSED))
    elements, particles = setting.problem.bodies
    whole = 8900.0 * 2e-3**2 * 20e-3
    assert elements.mass.sum() + particles.mass.sum() == pytest.approx(whole, rel=ROUND_OFF)
    view = scenarios.load("elastic_bar").parameters.view(setting, start(setting.problem, threads=1).snapshot())
    assert measurements.load("rear_face_place").read(view).value == pytest.approx(20e-3)
    assert measurements.load("middle_stress").read(view).value == 0.0
