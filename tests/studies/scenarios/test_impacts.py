"""Impacts as they are built: their masses."""

import math

import pytest

from tests.contracts.test_scenarios import CORNERS, DIAMETER, ROUND_OFF, Changes, asked, built

each_corner = pytest.mark.parametrize(
    ("name", "changes"), CORNERS, ids=lambda part: part if isinstance(part, str) else "-".join(map(str, part.values()))
)


@each_corner
def test_impact__weighs_what_its_bodies_weigh(name: str, changes: Changes) -> None:
    """Per radian, or the part that the model covers."""
    run = asked(name, **changes)
    setting = built(run)
    projectile, target = setting.problem.bodies
    part = 1.0 if setting.sector == 1.0 else setting.sector / (2.0 * math.pi)
    whole = 2.0 * math.pi if setting.sector == 1.0 else 1.0
    length = run.parameters["projectile_length"]
    ball = math.pi / 6.0 * DIAMETER**3
    rod = math.pi / 4.0 * DIAMETER**2 * float(length or 0.0)
    volume = (rod if length else ball) * part / whole
    assert math.isclose(projectile.mass.sum(), projectile.density * volume, rel_tol=ROUND_OFF)
    # A round target in axisymmetry, a square one otherwise.
    face = math.pi * setting.radius**2 / whole if whole > 1.0 else 4.0 * setting.radius**2 * part
    assert math.isclose(target.mass.sum(), target.density * face * setting.thickness, rel_tol=ROUND_OFF)
