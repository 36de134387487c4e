"""A search for the limit of a shield begins where its equations and shots leave it open."""

import math
from dataclasses import replace
from typing import Any

import pytest

from studies.quantities.findings import InvalidInput
from studies.shields.shield import ShotAtShield
from studies.shields.shots.chance import mean_of_curves
from studies.sweeps.cost import cost_of
from studies.sweeps.sweep import Sweep
from studies.sweeps.warnings import warnings_of


def test_until__starts_on_a_shield_where_its_equations_and_shots_leave_it_open() -> None:
    document: dict[str, Any] = {
        "scenario": "whipple_shield",
        "fixed": {
            **{"projectile": "al-2017-t4", "bumper": "al-6061-t6", "wall": "al-6061-t6"},
            **{"bumper_thickness": "1 mm", "stand_off": "10 cm", "wall_thickness": "3 mm"},
        },
        "axes": {
            "speed": ["3 km/s", "7 km/s"],
            "projectile_diameter": {"limit_of": "wall_perforated", "between": ["1 mm", "10 mm"], "until": "10 %"},
        },
        "resolution": 16,
    }
    sweep = Sweep.parse(document)
    assert Sweep.parse(sweep.document()) == sweep
    assert warnings_of(sweep)[0].startswith("limit_of wall_perforated is experimental")
    shots = list(sweep.shots())
    assert [shot.speed for shot in shots] == [3000.0, 7000.0]
    for shot in shots:
        assert isinstance(shot, ShotAtShield)
        answers = [mean_of_curves(replace(shot, projectile_diameter=d)) for d in (1e-3, shot.projectile_diameter, 1e-2)]
        low, there, high = (answer.value for answer in answers if answer is not None)
        even = math.log10(shot.projectile_diameter / 1e-3)
        assert 0.5 * even + 0.5 * (there - low) / (high - low) == pytest.approx(0.5, abs=1e-6)
    assert shots[0].projectile_diameter != shots[1].projectile_diameter
    limits = sweep.limits(lambda run: float(run.parameters["projectile_diameter"] or 0.0) > 4.2e-3)
    assert all(limit.lower <= 4.2e-3 < limit.upper <= 1.11 * limit.lower for _, limit in limits)
    runs = {point.run.id for point in sweep.tried(limits).runs()}
    assert runs >= {point.run.id for point in sweep.runs()}
    assert cost_of(sweep).runs == sweep.most_runs
    short = {**document, "fixed": {**document["fixed"], "stand_off": "25 mm"}}  # refused for 10 mm alone
    with pytest.raises(InvalidInput, match="projectile_diameter = 10 mm"):
        Sweep.parse(short).runs()
