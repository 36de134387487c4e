"""Warnings: what is allowed and hardly useful is said once for a sweep, with the farthest point."""

from typing import Any

import pytest

from studies.sweeps.sweep import Sweep
from studies.sweeps.warnings import warnings_of
from tests.samples import needs

HOLES = {
    "scenario": "thin_plate",
    "fixed": {"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": "8 mm"},
    "resolution": 16,
}


def warned(axes: dict[str, Any], **more: Any) -> list[str]:
    return warnings_of(Sweep.parse({**HOLES, "axes": axes, **more}))


def test_sweep__of_hypervelocity_impacts_on_thin_plates_is_left_in_peace() -> None:
    assert warned({"speed": ["2 km/s", "7 km/s"], "plate_thickness": ["2 mm", "8 mm"]}) == []


@pytest.mark.parametrize(
    ("axes", "words"),
    [
        # 8930 kg/m3 (100 m/s)^2 / 90 MPa
        ({"speed": ["0.1 km/s", "6 km/s"], "plate_thickness": ["2 mm"]}, ["speed 100 m/s", "= 0.99 ", "1 of 2"]),
        # 2.28 (6/3.94)^(2/3) = 3.018 diameters deep: 62.5 / 3.018
        ({"speed": ["6 km/s"], "plate_thickness": ["500 mm", "4 mm"]}, ["t/d = 62.5", " 21 times", "1 of 2"]),
    ],
)
def test_sweep__is_warned_of_with_number_and_count(axes: dict[str, Any], words: list[str]) -> None:
    (warning,) = warned(axes)
    assert all(word in warning for word in words), warning


@needs("taylor_bar")
def test_sweep__without_shots_has_nothing_to_be_warned_of() -> None:
    bar = {"scenario": "taylor_bar", "axes": {"speed": ["100 m/s"]}}
    assert warnings_of(Sweep.parse(bar)) == []
