"""The cost of a sweep in Python: a document as people have it there, and errors that say what is meant."""

from typing import Any

import numpy as np
import pint
import pytest

import whipple

UNITS: Any = pint.UnitRegistry()
SWEEP: dict[str, Any] = {
    "scenario": "thin_plate",
    "fixed": {"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": 8 * UNITS.mm},
    "axes": [("speed", np.linspace(2, 7, 11), "km/s"), ("plate_thickness", [2, 4], "mm")],
    "resolution": 8,
}


@pytest.mark.claim(
    "contract", "python", says="A sweep in Python has arrays and pint as axes, and errors say what is meant."
)
def test_estimate__takes_arrays_and_pint_and_is_words_in_a_notebook() -> None:
    estimated = whipple.estimate(SWEEP)
    assert estimated.cost.runs == 22
    assert repr(estimated).startswith("thin_plate: 22 runs, about ")
    coarser = whipple.estimate(SWEEP, accuracy="draft")
    assert coarser.cost.core_seconds > estimated.cost.core_seconds


@pytest.mark.claim("contract", "python")
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
    """What is wrong raises whipple.InvalidInput, which says what is meant: at most five names."""
    with pytest.raises(whipple.InvalidInput, match="is refused") as refused:
        whipple.estimate({**SWEEP, **change})
    assert any(finding.cure.startswith(cure) for finding in refused.value.findings)
    assert all(finding.cure.count("'") <= 2 * 5 for finding in refused.value.findings)
