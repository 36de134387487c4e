"""What is wrong or hardly useful in a sweep: what is refused at the door, what is warned of, and in which words."""

from collections.abc import Callable, Mapping
from typing import Any

import pytest

from studies.quantities.findings import InvalidInput
from studies.sweeps.sweep import Sweep
from studies.sweeps.warnings import warnings_of
from tests.claims.rows import Row, equal
from tests.samples import needs

METAL = "al-2024-t3"
JOHNSON_COOK = {"failure": "johnson-cook"}


def said(*, own: Mapping[str, Any] | None = None, axes: Mapping[str, Any] | None = None, **fixed: Any) -> list[str]:
    """What a sweep with these constants is refused for, or warned of; ``own`` changes a material of the user's."""
    document = {
        "scenario": "thin_plate",
        "fixed": {
            "projectile": METAL,
            "target": METAL if own is None else "mine",
            "projectile_diameter": "8 mm",
            "plate_thickness": "2 mm",
            **fixed,
        },
        "axes": {"speed": ["5 km/s"], **(axes or {})},
        "resolution": 16,
        **({} if own is None else {"materials": {"mine": {"base": METAL, **own}}}),
    }
    try:
        sweep = Sweep.parse(document)
        sweep.runs()
    except InvalidInput as error:
        return [f"refused: {finding}" for finding in error.findings]
    return warnings_of(sweep)


def fracture(**constants: float) -> dict[str, Any]:
    return {**JOHNSON_COOK, **{f"target.fracture.{name}": value for name, value in constants.items()}}


# What is wrong, the sweep, and a part of what is said.
WRONG: Mapping[str, tuple[Mapping[str, Any], str]] = {
    "D1 below -D2": (fracture(D1=-0.5), "refused: failure: johnson-cook"),
    "sign of D2": (fracture(D2=-0.13), "fails at its first slip"),
    "sign of D4": (fracture(D4=-0.2), "at its first slip under a triaxiality of -0.33, 100000 /s"),
    "sign of D5": (fracture(D5=-3.0), "T* = 0.5; correct target.fracture.D1"),
    "sign of D3": (fracture(D3=1.5), "programs that write exp(-D3 sigma*) have -1.5 here as 1.5"),
    "sign of D3 at a point": (
        {**JOHNSON_COOK, "axes": {"target.fracture.D3": [-1.5, 1.5]}},
        "D3 = 1.5 of al-2024-t3, at",
    ),
    "D3 of a user's material": ({**JOHNSON_COOK, "own": {"fracture": {"D3": 1.5}}}, "target.fracture.D3 = 1.5 of mine"),
    "failure at 0.2 %": ({"failure": "plastic-strain", "failure_strain": 0.002}, "failure_strain = 0.002: 0.01 to 10"),
    "failure in 1 ps": ({"failure": "spall", "failure_time": "1 ps"}, "failure_time"),
    "density / 10": ({"own": {"density": "0.2785 g/cm3"}}, "target.density = 278.5 kg m-3 of mine: aluminium is"),
    "density x 10": ({"target.density": "27.85 g/cm3"}, "target.density = 27850 kg m-3"),
    "bulk modulus / 10": ({"own": {"elastic": {"bulk_modulus": "7.9 GPa"}}}, "rho0 c0^2 = 79.06 GPa, which acts alone"),
    "sound speed / 10": ({"target.eos.c0": "532.8 m/s"}, "target.elastic.bulk_modulus = 79.06 GPa"),
    "shear modulus x 10": ({"target.elastic.shear_modulus": "286 GPa"}, "Poisson's ratio is negative"),
    "yield stress x 1000": ({"target.strength.A": "369 GPa"}, "more than a tenth of the shear modulus"),
    "yield stress / 1000": ({"target.strength.A": "0.369 MPa"}, "1 MPa to 5 GPa is usual (initial yield stress)"),
    "rate sensitivity x 100": ({"target.strength.C": 0.83}, "target.strength.C = 0.83"),
    "spall strength x 100": ({"target.tension.spall_strength": "120 GPa"}, "above a fifth of its bulk modulus"),
    "heat capacity / 1000": ({"target.thermal.heat_capacity": "0.875 J/(kg K)"}, "refused: fixed.target.thermal"),
    "heat capacity / 100": ({"target.thermal.heat_capacity": "8.75 J/(kg K)"}, "100 J kg-1 K-1 to 2500 J kg-1 K-1"),
}


@pytest.mark.claim("mend", "constants")
def test_wrong_constants__are_refused_or_doubted(compared: Callable[[Row], None]) -> None:
    """Constants of another sign, in another unit or at odds with others are refused, or warned of with a reason."""
    for what, (sweep, words) in WRONG.items():
        sentences = said(**sweep)
        first = next((sentence for sentence in sentences if words in sentence), "")
        compared(equal(f"{what}: {first or sentences}", expected=True, got=bool(first)))


@pytest.mark.parametrize(
    "sweep",
    [{}, JOHNSON_COOK, {"target.tension.spall_strength": "0 Pa"}, {"own": {"density": "2.6 g/cm3"}}],
    ids=["shipped", "johnson-cook", "no tension", "another density"],
)
def test_constants__that_may_be_are_left_in_peace(sweep: Mapping[str, Any]) -> None:
    assert said(**sweep) == []


@pytest.mark.parametrize(
    ("speeds", "thicknesses", "words"),
    [
        # 8930 kg/m3 (100 m/s)^2 / 90 MPa
        (["0.1 km/s", "6 km/s"], ["2 mm"], ["speed 100 m/s", "= 0.99 ", "1 of 2"]),
        # 2.28 (6/3.94)^(2/3) = 3.018 diameters deep: 62.5 / 3.018
        (["6 km/s"], ["500 mm", "4 mm"], ["t/d = 62.5", " 21 times", "1 of 2"]),
        (["2 km/s", "7 km/s"], ["2 mm", "8 mm"], []),
    ],
)
def test_impacts__that_are_slow_or_on_thick_plates_are_warned_of(
    speeds: list[str], thicknesses: list[str], words: list[str]
) -> None:
    copper = {"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": "8 mm"}
    axes = {"speed": speeds, "plate_thickness": thicknesses}
    sweep = Sweep.parse({"scenario": "thin_plate", "fixed": copper, "axes": axes, "resolution": 16})
    warnings = warnings_of(sweep)
    assert len(warnings) == bool(words)
    assert all(word in warnings[0] for word in words)


@needs("taylor_bar")
def test_sweep__without_shots_has_nothing_to_be_warned_of() -> None:
    assert warnings_of(Sweep.parse({"scenario": "taylor_bar", "axes": {"speed": ["100 m/s"]}})) == []
