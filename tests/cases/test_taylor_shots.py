"""Calibrated constants against shots that they never had, on all published Taylor bars at room temperature."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import whipple
from studies import materials
from studies.cases.rows import absolute, at_least, at_most, reported
from studies.cubes.reading import open_cube
from studies.fits.calibration.design import box_of, sweep_of
from studies.fits.calibration.emulator import emulators_of
from studies.fits.calibration.posterior import Calibration, posterior_of
from studies.fits.calibration.prediction import LEVEL, leave_series_out
from studies.fits.calibration.shots import read_shots
from studies.sweeps.reading import published_shots

HOUSE, JOHNSON_COOK = "House (1989)", "Johnson and Cook (1983); Zerilli and Armstrong (1987)"
WITHIN = 0.05  # of the share of the shots that intervals at 90 % are to hold
TABLES = {
    "taylor-bars-copper-ofhc": "copper-ofhc",
    "taylor-bars-al-6061-t6": "al-6061-t6",
    "taylor-bars-steel-4340": "steel-4340",
}


@pytest.fixture(scope="module")
def calibration_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Calibration]:
    """The calibration of a table, with its bars computed once."""

    @cache
    def calibration(table: str) -> Calibration:
        material = materials.load(TABLES[table])
        shots = read_shots(table, material)
        folder = whipple.run_sweep(sweep_of(material, shots), tmp_path_factory.mktemp(table), keep="numbers")
        emulators = emulators_of(open_cube(folder), shots.diameter, shots.names)
        return Calibration(shots, emulators, box_of(material))

    return calibration


@pytest.mark.parametrize(
    "table",
    [pytest.param(each, marks=pytest.mark.claim("breaking", f"{each}-left-out", minutes=4.0)) for each in TABLES],
)
def test_intervals__hold_shots_of_series_that_were_left_out(
    table: str, calibration_of: Callable[[str], Calibration], compared: Callable[..., None]
) -> None:
    """90 % intervals from the other series hold 85 to 95 % of the sizes of Taylor bars, each series left out once.

    It does not hold: 46 of 56 of copper, of which House's lot is harder than all others; 26 of 27 of steel; 64 of 64 of
    aluminium, where two lots that are left do not bound how lots differ, and the prior does (docs/calibrate.md).
    """
    calibration = calibration_of(table)
    for name, emulator in calibration.emulators.items():
        compared(reported(f"{name}: error of the emulator, of the strain", emulator.error))
    inside = []
    for lot, predicted in leave_series_out(calibration):
        inside += predicted.inside.tolist()
        for name in predicted.shots.names:
            part = predicted.of(name)
            compared(reported(f"{lot}: {name}, share of {len(part.inside)} in their intervals", part.coverage))
            compared(reported(f"{lot}: {name}, measured over predicted, less 1", part.offset))
            width = float(np.median((part.high - part.low) / part.median))
            compared(reported(f"{lot}: {name}, width of the intervals over the size", width))
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
