"""The bare formulas of the laws against printed tables, to the printed digits."""

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from studies.laws import maiden_al, maiden_c, strength_ln, zhang_tan
from tests.claims import Row, claim

DIAMETER = 8.0  # mm
COPPER_DENSITY = 8930.0  # kg/m3
COPPER_SOUND_SPEED = 3940.0  # m/s
SPEEDS = (2, 3, 4, 5, 6, 7)  # km/s

# D/d for copper, t/d = 2 mm / 8 mm.
THESIS_LAWS = {
    "1-3 (A)": "1.257 1.436 1.614 1.793 1.971 2.150",
    "general form of 1-3 (C = 3.94 km/s)": "1.383 1.625 1.867 2.109 2.350 2.592",
    "1-4 (B)": "0.830 1.174 1.438 1.660 1.856 2.033",
    "1-5 (C), Y = 240 MPa": "2.292 2.974 3.457 3.832 4.138 4.397",
    "1-5 (C), Y = 157 MPa": "2.649 3.330 3.813 4.188 4.495 4.754",
    "1-5 (C), Y = 120 MPa": "2.875 3.556 4.039 4.414 4.720 4.979",
    "1-5 (C), Y = 90 MPa": "3.116 3.797 4.281 4.656 4.962 5.221",
}
# The same in mm, for a projectile of 8 mm.
THESIS_LAWS_IN_MILLIMETRES = {
    "1-3 (A)": "10.06 11.49 12.91 14.34 15.77 17.20",
    "general form of 1-3 (C = 3.94 km/s)": "11.07 13.00 14.94 16.87 18.80 20.74",
    "1-4 (B)": "6.64 9.39 11.50 13.28 14.85 16.26",
    "1-5 (C), Y = 240 MPa": "18.34 23.79 27.65 30.65 33.10 35.18",
}
# D/d at t/d = 0.6; aluminium 2024-T3 with Y = 345 MPa and 2780 kg/m3.
CALIBRATION = {
    "1-3 (A)": "1.540 1.860 2.180 2.501 2.821 3.141",
    "1-4 (B)": "1.286 1.818 2.227 2.572 2.875 3.150",
    "1-5 (C), Al 2024-T3": "1.007 1.688 2.172 2.547 2.853 3.112",
    "1-5 (C), Cu with Y = 240 MPa": "2.292 2.974 3.457 3.832 4.138 4.397",
}

Formula = Callable[[np.ndarray], np.ndarray]  # D/d of speeds in m/s


def strength(yield_stress: float, density: float) -> Formula:
    return lambda speed: strength_ln.hole_ratio(speed, yield_stress, density)


def formulas(thickness_ratio: float) -> dict[str, Formula]:
    """The bare formulas by the names that the tables use."""
    return {
        "1-3 (A)": lambda speed: maiden_al.hole_ratio(speed, thickness_ratio),
        "general form of 1-3 (C = 3.94 km/s)": lambda speed: maiden_c.hole_ratio(
            speed, thickness_ratio, COPPER_SOUND_SPEED
        ),
        "1-4 (B)": lambda speed: zhang_tan.hole_ratio(speed, thickness_ratio),
        "1-5 (C), Al 2024-T3": strength(345e6, 2780.0),
        "1-5 (C), Cu with Y = 240 MPa": strength(240e6, COPPER_DENSITY),
        **{
            f"1-5 (C), Y = {megapascal} MPa": strength(megapascal * 1e6, COPPER_DENSITY)
            for megapascal in (240, 157, 120, 90)
        },
    }


def compare(table: Mapping[str, str], computed: Mapping[str, Formula], factor: float, digits: int) -> Iterator[Row]:
    """One row a law: all its printed numbers beside the computed ones, in the printed digits."""
    speeds = np.array(SPEEDS) * 1e3
    unit = "D/d" if factor == 1.0 else "mm"
    for law, printed in table.items():
        got = " ".join(f"{value:.{digits}f}" for value in factor * computed[law](speeds))
        yield Row(f"{law}, {SPEEDS[0]} to {SPEEDS[-1]} km/s ({unit})", printed, got, got == printed)


@claim(
    "thesis-laws-copper",
    says="the laws of Ma (2005) for copper, d = 8 mm, t = 2 mm, have their printed values",
    quick=True,
)
def thesis_laws_copper() -> Iterator[Row]:
    yield from compare(THESIS_LAWS, formulas(0.25), 1.0, 3)
    yield from compare(THESIS_LAWS_IN_MILLIMETRES, formulas(0.25), DIAMETER, 2)


@claim(
    "law-c-calibration",
    says="law 1-5 with aluminium 2024-T3 meets laws 1-3 and 1-4 at its calibration t/d = 0.6",
    quick=True,
)
def law_c_calibration() -> Iterator[Row]:
    yield from compare(CALIBRATION, formulas(0.6), 1.0, 3)
    speeds = np.array([4e3, 5e3, 6e3, 7e3])
    computed = formulas(0.6)
    aluminium = computed["1-5 (C), Al 2024-T3"](speeds)
    for law in ("1-3 (A)", "1-4 (B)"):
        apart = float(np.max(np.abs(aluminium / computed[law](speeds) - 1.0)))
        yield Row(f"1-5 apart from {law}, 4 to 7 km/s (%)", "at most 3", 100 * apart, apart <= 0.03)
