"""Sweeps and shots as people have them in Python: arrays and pint in place of texts with a unit."""

from typing import Any

import numpy as np
import pint
import pytest
import xarray as xr

from studies.quantities.arrays import plain
from studies.quantities.parameters import Plain

UNITS: Any = pint.UnitRegistry()
SPEEDS = ["2.0 km/s", "4.5 km/s", "7.0 km/s"]


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
