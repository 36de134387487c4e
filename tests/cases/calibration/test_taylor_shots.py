"""Calibrated constants against shots that they never had, on all published Taylor bars at room temperature."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.stats import binomtest

import whipple
from studies import materials
from studies.cubes.opening import whole_cube
from studies.fits.calibration.design import prior_of, sweep_of
from studies.fits.calibration.emulator import emulator_of
from studies.fits.calibration.posterior import Calibration, posterior_of
from studies.fits.calibration.prediction import LEVEL, chances, leave_series_out
from studies.fits.calibration.shots import read_shots
from studies.observations.compared import ratio, stored
from studies.sweeps.reading import published_shots
from tests.claims.rows import absolute, at_least, at_most, equal, reported

HOUSE, JOHNSON_COOK = "House (1989)", "Johnson and Cook (1983); Zerilli and Armstrong (1987)"
WITHIN = 0.05  # of the share of the shots that intervals at 90 % are to hold
TABLES = {
    "taylor-bars-copper-ofhc": "copper-ofhc",
    "taylor-bars-al-6061-t6": "al-6061-t6",
    "taylor-bars-steel-4340": "steel-4340",
}


LENGTH, MUSHROOM = "final_length", "mushroom_diameter"
# Bars that had no length before grids grew with what a bar spreads: their speeds, m/s.
SPREAD = {"taylor-bars-al-6061-t6": (591.0,), "taylor-bars-copper-etp": (311.0, 316.0, 332.0, 357.0, 367.0)}
# Of simulation / shot - 1 over the others, as it was then (physics 9): shots, mean and standard deviation.
FORMER = {
    ("taylor-bars-copper-ofhc", LENGTH): (34, -0.0495, 0.0762),
    ("taylor-bars-copper-ofhc", MUSHROOM): (22, 0.0433, 0.0339),
    ("taylor-bars-copper-etp", LENGTH): (5, 0.0119, 0.0421),
    ("taylor-bars-al-6061-t6", LENGTH): (40, -0.0239, 0.0185),
    ("taylor-bars-al-6061-t6", MUSHROOM): (23, 0.0920, 0.0428),
    ("taylor-bars-steel-4340", LENGTH): (15, -0.0063, 0.0207),
    ("taylor-bars-steel-4340", MUSHROOM): (12, 0.0499, 0.0446),
}
ROUNDED = 5e-5  # half of the last digit above


@pytest.mark.claim("breaking", "taylor-bias-and-scatter")
@pytest.mark.parametrize(("table", "quantity"), FORMER)
def test_bars__are_no_farther_from_their_shots_than_before(
    table: str, quantity: str, compared: Callable[..., None]
) -> None:
    """Over the bars of the former table bias and scatter are not worse than in it; bars that are new stand beside."""
    rows = [row for row in stored()["shots"] if (row["table"], row["quantity"]) == (table, quantity)]
    new = [row for row in rows if quantity == LENGTH and row["parameters"]["speed"] in SPREAD.get(table, ())]
    off = np.array([ratio(row) for row in rows if row not in new])
    shots, bias, scatter = FORMER[table, quantity]
    where = f"{table}: {quantity}"
    compared(equal(f"{where}: shots of the former table", expected=shots, got=len(off)))
    compared(at_most(f"{where}: size of the bias", limit=abs(bias) + ROUNDED, got=abs(float(off.mean()))))
    compared(at_most(f"{where}: scatter", limit=scatter + ROUNDED, got=float(off.std(ddof=1))))
    for row in new:
        compared(
            reported(f"{where}, new at {row['parameters']['speed']:g} m/s: computed over measured, less 1", ratio(row))
        )
    if new:
        every = np.array([ratio(row) for row in rows])
        compared(reported(f"{where}: bias of all {len(every)}", float(every.mean())))
        compared(reported(f"{where}: scatter of all {len(every)}", float(every.std(ddof=1))))


@pytest.fixture(scope="module")
def calibration_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Calibration]:
    """The calibration of a table, with its bars computed once."""

    @cache
    def calibration(table: str) -> Calibration:
        material = materials.load(TABLES[table])
        shots = read_shots(table, material)
        cube = whole_cube(whipple.run_sweep(sweep_of(material, shots), tmp_path_factory.mktemp(table), keep="numbers"))
        emulators = {name: emulator_of(cube, shots.diameter, name) for name in shots.names}
        return Calibration(shots, emulators, prior_of(material))

    return calibration


@pytest.mark.parametrize(
    "table",
    [pytest.param(each, marks=pytest.mark.claim("breaking", f"{each}-left-out", minutes=4.0)) for each in TABLES],
)
def test_intervals__hold_shots_of_series_that_were_left_out(
    table: str, calibration_of: Callable[[str], Calibration], compared: Callable[..., None]
) -> None:
    """90 % intervals from the other series hold 85 to 95 % of the sizes of Taylor bars, each series left out once.

    It does not hold: 45 of 56 of copper, of which House's lot is harder than all others; 26 of 27 of steel; 64 of 64
    of aluminium, where two lots that are left do not bound how lots differ, and the prior does. Beside it stands how
    likely such counts are: shots of a series share its lot (docs/calibrate.md).
    """
    calibration = calibration_of(table)
    for name, emulator in calibration.emulators.items():
        compared(reported(f"{name}: error of the emulator, of the strain", emulator.error))
    every = []
    for lot, predicted in leave_series_out(calibration):
        every.append(predicted)
        for name in predicted.shots.names:
            part = predicted.of(name)
            compared(reported(f"{lot}: {name}, share of {len(part.inside)} in their intervals", part.coverage))
            compared(reported(f"{lot}: {name}, measured over predicted, less 1", part.offset))
            width = float(np.median((part.high - part.low) / part.median))
            compared(reported(f"{lot}: {name}, width of the intervals over the size", width))
    inside = np.concatenate([each.inside for each in every])
    # Clopper and Pearson (1934), Biometrika 26, 404: of independent shots, which those of a series are not.
    exact = binomtest(int(inside.sum()), len(inside)).proportion_ci(0.95)
    compared(reported(f"{table}: lower end of the binomial interval of that share, 95 %", exact.low))
    compared(reported(f"{table}: upper end", exact.high))
    fewer, more = chances(every)
    compared(reported(f"{table}: chance of no more inside, of series as predicted", fewer))
    compared(reported(f"{table}: chance of no fewer", more))
    share = float(np.mean(inside))
    compared(absolute(f"{table}: share of {len(inside)} in their intervals", expected=LEVEL, got=share, within=WITHIN))


@pytest.mark.claim("breaking", "two-tempers", minutes=4.0)
def test_house__shot_copper_of_another_temper(
    calibration_of: Callable[[str], Calibration], compared: Callable[..., None]
) -> None:
    """The OFHC bars of House (1989) are of harder copper than those of Johnson and Cook, by lengths and stiff ends.

    Their mushrooms alone do not tell the two apart: that row is reported.
    """
    table = "taylor-bars-copper-ofhc"
    calibration = calibration_of(table)
    shots = calibration.shots
    house = shots.series == HOUSE
    for name in shots.names:
        without = replace(calibration, shots=shots.where(~house | (shots.quantities == name)))
        posterior, lots = posterior_of(without), without.shots.lots
        harder = posterior.lots[:, lots.index(HOUSE)] - posterior.lots[:, lots.index(JOHNSON_COOK)]
        compared(reported(f"A of House over that of Johnson and Cook, by {name}", float(np.exp(np.median(harder)))))
        row = at_least(f"probability that it is more, by {name}", limit=0.95, got=float(np.mean(harder > 0.0)))
        compared(row if name == "final_length" else row.ungated(0.95))
    # A length that was read wrong by a factor is wrong at every speed, also at none; a yield stress acts with v^2.
    lengths = shots.where(house & (shots.quantities == "final_length"))
    _, at_rest = np.polyfit(lengths.speeds**2, lengths.strains, 1)
    compared(at_most("strain of House's lengths at no speed, of 0.07 to 0.12", limit=0.035, got=abs(float(at_rest))))
    # Copper of low yield flows up to its rear end; the part that did not is measured apart from length and mushroom.
    stiff = {source: _stiff_shares(table, source) for source in (HOUSE, JOHNSON_COOK)}
    compared(at_least("least stiff share of House's bars", limit=max(stiff[JOHNSON_COOK]), got=min(stiff[HOUSE])))


def _stiff_shares(table: str, source: str) -> list[float]:
    """The shares of the lengths of bars that stayed undeformed, from the notes of a table."""
    shares = []
    for shot in published_shots(table, "taylor_bar"):
        note = re.search(r"undeformed length ([\d.]+) mm", shot.note)
        if shot.source == source and note:
            length = shot.parameters["bar_length"]
            assert isinstance(length, float)
            shares.append(1e-3 * float(note[1]) / length)
    return shares
