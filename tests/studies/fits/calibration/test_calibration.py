"""Calibration: known constants are recovered at the nominal rate, and what is no table of bars is refused in words."""

import math
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from studies import materials
from studies.cubes import cube
from studies.fits.calibration.design import prior_of, sweep_of
from studies.fits.calibration.emulator import emulator_of
from studies.fits.calibration.picture import draw
from studies.fits.calibration.posterior import Calibration, Posterior, posterior_of
from studies.fits.calibration.prediction import LEVEL, chances, predict
from studies.fits.calibration.results import calibrated, write
from studies.fits.calibration.shots import SIZES, BarStrains, read_shots
from studies.materials import read_own
from studies.quantities.findings import InvalidInput
from studies.runs.results import RunResult
from studies.sweeps.document import read_yaml
from studies.sweeps.sweep import Sweep
from tests.claims.rows import Row, absolute, at_least, at_most
from tests.studies.support import fakes

COPPER = materials.load("copper-ofhc")
PRIOR = prior_of(COPPER)


class TaylorStrain:
    """The strain of a bar that flattens at its mean flow stress: ln(L / L_f) = rho v^2 / (2 Y), in closed form.

    Y is that of Johnson and Cook at half the strain of a middling shot and 1e4/s, heated by its own work.
    """

    error = 0.0

    def __init__(self, share: float) -> None:
        self.share = share  # of the strain: length 1, mushroom more

    def strains(self, places: np.ndarray) -> np.ndarray:
        a, b, n, c, m, speed, ratio = places.T
        stress = (np.exp(a) + np.exp(b) * (0.2 * self.share) ** n) * (1.0 + c * math.log(1e4)) * (1.0 - 0.08**m)
        return np.asarray(self.share * 8930.0 * np.exp(2.0 * speed) / (2.0 * stress) * np.exp(-0.05 * ratio))


EMULATORS: Mapping[str, Any] = {"final_length": TaylorStrain(1.0), "mushroom_diameter": TaylorStrain(1.7)}


def synthetic(seed: int) -> tuple[BarStrains, np.ndarray]:
    """Shots of four lots with known constants, drawn from the prior, and these constants."""
    rng, (low, high) = np.random.default_rng(seed), PRIOR.T
    truth = low + (high - low) * rng.uniform(size=5)
    lots, each = [f"lot {number}" for number in range(4)], 8
    yields = np.clip(truth[0] + 0.15 * rng.standard_normal(len(lots)), low[0], high[0])
    series = np.repeat(lots, each)
    quantities = np.tile(list(SIZES), len(series) // 2)
    speeds, ratios = rng.uniform(110.0, 220.0, len(series)), rng.uniform(2.0, 6.0, len(series))
    places = np.column_stack([np.tile(truth, (len(series), 1)), np.log(speeds), np.log(ratios)])
    places[:, 0] = np.repeat(yields, each)
    computed = np.select([quantities == name for name in SIZES], [EMULATORS[name].strains(places) for name in SIZES])
    errors = np.full(len(series), 0.004)
    bias = np.select([quantities == name for name in SIZES], np.exp(0.1 * rng.standard_normal(2)).tolist())
    noise = np.sqrt(errors**2 + (0.04 * computed) ** 2) * rng.standard_t(4.0, len(series))
    initial = np.where(quantities == "final_length", 7.6e-3 * ratios, 7.6e-3)
    strains = bias * computed + noise
    return BarStrains(quantities, series, speeds, ratios, initial, strains, errors, 7.6e-3), truth


def flow_stress(constants: np.ndarray) -> np.ndarray:
    """The stress, Pa, that decides how long a bar becomes: what the shots know of five constants, up to the bias."""
    a, b, n, c, m = constants.T
    return np.asarray((np.exp(a) + np.exp(b) * 0.2**n) * (1.0 + c * math.log(1e4)) * (1.0 - 0.08**m))


def inside(truth: np.ndarray, drawn: np.ndarray) -> np.ndarray:
    low, high = np.quantile(drawn, (0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL), axis=0)
    return np.asarray((truth >= low) & (truth <= high))


def short(shots: BarStrains, seed: int = 1) -> Posterior:
    return posterior_of(Calibration(shots, EMULATORS, PRIOR), steps=200, burn_in=150, seed=seed)


@pytest.mark.claim("fits", "known-constants", minutes=0.1)
def test_posterior__holds_known_constants_at_the_nominal_rate(compared: Callable[[Row], None]) -> None:
    """Constants that synthetic shots are made with lie in the intervals of their calibration."""
    held, narrow, scatters = [], [], []
    for seed in range(4):
        shots, truth = synthetic(seed)
        posterior = short(shots, seed)
        drawn = posterior.constants
        scatters.append(float(np.median(posterior.scatters)))
        stress = np.log(flow_stress(drawn))
        held += [*inside(truth, drawn), inside(np.log(flow_stress(truth[None])[0]), stress)]
        beforehand = np.random.default_rng(seed).uniform(PRIOR[:, 0], PRIOR[:, 1], (2000, 5))
        narrow.append(float(stress.std() / np.log(flow_stress(beforehand)).std()))
    # Of 24 intervals at 90 %, 18 or more hold the truth in 98 of 100 repetitions.
    compared(at_least("constants and flow stresses in their intervals, of 24", limit=18, got=float(sum(held))))
    # A posterior that had not seen the shots would hold as many, and be as wide as the prior.
    compared(absolute("scatter of the shots, mean", expected=0.04, got=float(np.mean(scatters)), within=0.02))
    compared(at_most("width of the flow stress over that of the prior", limit=0.5, got=max(narrow)))


@pytest.fixture(scope="module")
def posterior() -> Posterior:
    return short(synthetic(0)[0])


def test_further_lots__are_wider_than_lots_that_were_shot(posterior: Posterior) -> None:
    low, high = PRIOR[0]
    further = posterior.further_lots()[:, 0]
    away = further - posterior.constants[:, 0]
    assert np.median(np.abs(away) / posterior.lots_deviation) == pytest.approx(0.67, abs=0.15)  # of a normal one
    assert ((further >= low) & (further <= high)).all()


def test_prediction__of_a_lot_that_was_not_shot_is_wider(posterior: Posterior) -> None:
    shots = posterior.calibration.shots
    own = predict(posterior, shots)
    other = predict(posterior, replace(shots, series=np.full(len(shots.series), "another lot")))
    assert (other.high - other.low).mean() > (own.high - own.low).mean()
    assert own.coverage > 0.75  # of 32 at 90 %: fewer than 25 in one of 100 repetitions


def test_chances__know_that_the_shots_of_a_series_share_a_lot(posterior: Posterior) -> None:
    shots = posterior.calibration.shots
    other = predict(posterior, replace(shots, series=np.full(len(shots.series), "another lot")))
    counts = other.repeated.sum(axis=1)
    assert counts.mean() == pytest.approx(LEVEL * len(shots.series), rel=0.01)  # ends of intervals are between draws
    independent = math.sqrt(len(shots.series) * LEVEL * (1.0 - LEVEL))
    assert counts.std() > 2.0 * independent
    inside = int(other.inside.sum())
    assert chances([other]) == (np.mean(counts <= inside), np.mean(counts >= inside))


def test_emulator__is_that_of_the_bars_that_were_computed() -> None:
    shots, exact = synthetic(0)[0], TaylorStrain(1.0)
    sweep = Sweep.parse(sweep_of(COPPER, shots, runs=30))
    results = {}
    for point in sweep.runs():
        parameters = point.run.parameters
        strength: Mapping[str, Any] = point.run.materials["bar"].strength.constants
        length = parameters["bar_length"]
        assert isinstance(length, float)
        place = [math.log(strength["A"]), math.log(strength["B"]), *(strength[name] for name in "nCm")]
        place += [math.log(parameters["speed"]), math.log(length / shots.diameter)]  # type: ignore[arg-type]
        size = length * math.exp(-exact.strains(np.array([place]))[0])
        measured = {"final_length": fakes.measured(size), "mushroom_diameter": fakes.measured(shots.diameter)}
        results[point.run.id] = RunResult(point.run.id, "succeeded", measurements=measured)
    emulator = emulator_of(cube.build(sweep, results), shots.diameter, "final_length")
    assert emulator.error < 0.1
    rng, bounds = np.random.default_rng(2), PRIOR
    places = np.column_stack(
        [rng.uniform(bounds[:, 0], bounds[:, 1], (50, 5)), np.full(50, math.log(160.0)), np.full(50, math.log(4.0))]
    )
    away = emulator.strains(places) / exact.strains(places) - 1.0
    assert np.sqrt(np.mean(away**2)) < 2.0 * emulator.error
    assert len(emulator.strains(places[:0])) == 0  # of a series that measured another size


HOLE: Mapping[str, Any] = {
    "name": "hole",
    "scenario": "thin_plate",
    "fixed": {
        "projectile": "al-6061-t6",
        "projectile_diameter": "5 mm",
        "target": "copper-ofhc",
        "plate_thickness": "2 mm",
        "speed": "4 km/s",
    },
    "axes": {},
    "resolution": 8,
}

# ---- files ---------------------------------------------------------------------------------------


def test_files__read_as_what_was_calibrated(posterior: Posterior, tmp_path: Path) -> None:
    predicted = predict(posterior, posterior.calibration.shots)
    files = {file.name: file for file in write(tmp_path, COPPER, posterior, predicted, "lots")}
    middle = calibrated(COPPER, posterior, "copper-ofhc-calibrated", "mean")
    assert read_own(tomllib.loads(files["material.toml"].read_text())) == middle
    document = {**HOLE, "materials": read_yaml(files["materials.yaml"].read_text(), "materials.yaml")["materials"]}
    document["fixed"] = {name: value for name, value in HOLE["fixed"].items() if name != "target"}
    document["axes"] = {"target": list(document["materials"])}
    yields = [point.run.materials["target"].value_at("strength.A") for point in Sweep.parse(document).runs()]
    assert len(yields) == 16
    assert yields[0] == pytest.approx(math.exp(posterior.further_lots()[0, 0]), rel=1e-3)
    assert draw(posterior, predicted, tmp_path / "calibration.png").stat().st_size > 10_000


# ---- refusals ------------------------------------------------------------------------------------

HEADER = "bar,speed [m/s],bar_length [mm],bar_diameter [mm],final_length [mm],final_length_uncertainty [mm],source\n"
SHOT = "copper-ofhc,190,25.4,7.62,16.2,0.1,us\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (HEADER + 3 * SHOT, "3 final lengths of copper-ofhc"),
        (HEADER + 6 * SHOT.replace("copper-ofhc", "steel-4340"), "6 of steel-4340"),
        (HEADER + 5 * SHOT + SHOT.replace("0.1", ""), "no uncertainty"),
        (HEADER + 5 * SHOT + SHOT.replace("16.2", "26.2"), "a bar flattens"),
        (HEADER + 5 * SHOT + SHOT.replace("190", ""), "no speed"),
        ("projectile,hole_diameter [mm],source\nal-6061-t6,9,us\n", "a table of Taylor bars"),
    ],
)
def test_shots__that_do_not_do_are_refused(text: str, said: str, tmp_path: Path) -> None:
    file = tmp_path / "shots.csv"
    file.write_text(text)
    with pytest.raises(InvalidInput, match=said):
        read_shots(str(file), COPPER)
