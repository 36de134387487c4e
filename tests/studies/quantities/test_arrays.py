"""Sweeps and shots as people have them in Python: arrays and pint in place of texts with a unit."""

from typing import Any

import numpy as np
import pint
import pytest
import xarray as xr

import whipple
from studies.quantities.arrays import plain
from studies.quantities.parameters import Plain

UNITS: Any = pint.UnitRegistry()
SPEEDS = ["2.0 km/s", "4.5 km/s", "7.0 km/s"]
SWEEP: dict[str, Any] = {
    "scenario": "thin_plate",
    "fixed": {"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": 8 * UNITS.mm},
    "axes": [("speed", np.linspace(2, 7, 11), "km/s"), ("plate_thickness", [2, 4], "mm")],
    "resolution": 8,
}


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ((np.linspace(2, 7, 3), "km/s"), SPEEDS),
        ([("speed", np.linspace(2, 7, 3), "km/s")], {"speed": SPEEDS}),
        (np.linspace(2, 7, 3) * UNITS.km / UNITS.s, SPEEDS),
        (30 * UNITS.deg, "30 deg"),
        (xr.DataArray([2.0, 4.5, 7.0], attrs={"units": "km/s"}), SPEEDS),
        ((np.float64(8), "mm"), "8.0 mm"),
        (np.array([8, 16]), [8, 16]),
        ((np.array([0.1, 0.2]), "1"), [0.1, 0.2]),
        (("2 km/s", "3 km/s"), ["2 km/s", "3 km/s"]),
        ([0.2, 0.3], [0.2, 0.3]),
        ("a text", "a text"),
    ],
    ids=str,
)
def test_plain__is_what_a_document_writes(value: Any, text: Plain) -> None:
    assert plain(value) == text


@pytest.mark.claim("contract", "python")
def test_whipple__is_asked_as_people_try_it() -> None:
    """Estimate, laws, shots and materials take arrays and pint, and errors say what is meant."""
    assert whipple.__version__.count(".") == 2
    estimated = whipple.estimate(SWEEP)
    assert estimated.cost.runs == 22
    assert repr(estimated).startswith("thin_plate: 22 runs, about ")
    shot = {"projectile": "al-2017-t4", "projectile_diameter": 5 * UNITS.mm, "target": "al-6061-t6"}
    assert whipple.laws(speed=(np.linspace(2, 7, 11), "km/s"), **shot).speed.values[1] == 2500.0
    shots = whipple.shots(wall="AA2219", speed="6 km/s to 7 km/s")
    assert shots.attrs["units"]["speed"] == "m s-1"
    assert shots.wall.str.startswith("AA2219").all()
    assert {"al-6061-t6", "lead"} <= {*whipple.materials().index}
    assert whipple.materials("lead").source.str.len().min() > 0


@pytest.mark.parametrize(
    ("change", "cure"),
    [
        ({"resolution": "fine"}, "write accuracy: fine"),
        ({"resolution": "high"}, "write accuracy: fine"),
        ({"fixed": {**SWEEP["fixed"], "target": "aluminum"}}, "did you mean 'al-1100-o', 'al-2017-t4', "),
        ({"fixed": {**SWEEP["fixed"], "incidence": "30 deg"}}, "did you mean 'obliquity'?"),
        ({"axes": {"speed": np.linspace(2, 7, 3)}}, "write '2.0 km/s'"),
    ],
)
def test_invalid_input__says_what_is_meant(change: dict[str, Any], cure: str) -> None:
    with pytest.raises(whipple.InvalidInput, match="is refused") as refused:
        whipple.estimate({**SWEEP, **change})
    assert any(finding.cure.startswith(cure) for finding in refused.value.findings)
