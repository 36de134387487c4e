"""The surrogate of a cube: exact where it must be, honest about the runs that it has not seen."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.special import ndtr

from studies.fits.indices import indices_of, indices_of_surrogate
from studies.fits.surrogate import NUGGET, Surrogate, _process, runs_of, sampled_slices, surrogate_of
from studies.laws import Shot
from studies.values.errors import InvalidInput, MissingExtra
from tests.service.support.command import run
from tests.studies.support.sized import CRATERS, HOLES, sized_cube

ROUND_OFF = 1e-6  # relative: of a covariance with a condition of 1e6 and more


def bent(shot: Shot) -> float:
    """A size that no straight line has, m."""
    return 1e-3 * (shot.speed / 1e3) ** 0.6 + 3e-4 * np.sin(shot.speed / 1e3)


@pytest.fixture(scope="module")
def cube() -> xr.Dataset:
    return sized_cube(CRATERS, bent, "crater_depth")


@pytest.fixture(scope="module")
def surrogate(cube: xr.Dataset) -> Surrogate:
    return surrogate_of(cube, "crater_depth")


def test_surrogate__meets_the_runs_within_their_intervals(surrogate: Surrogate) -> None:
    predicted = surrogate.predict(surrogate.runs.places)
    assert (np.abs(predicted.values - surrogate.runs.values) <= predicted.intervals).all()
    at_runs, between = predicted.intervals.max(), surrogate.predict(np.array([[5500.0]])).intervals
    assert at_runs < between[0]


def test_slices__sample_a_density_between_bounds() -> None:
    samples = np.array(sampled_slices(lambda at: -0.5 * float(at @ at), np.zeros(2), np.array([[-9.0, 9.0]] * 2)))
    assert samples.mean() == pytest.approx(0.0, abs=0.2)
    assert (samples < 1.0).mean() == pytest.approx(ndtr(1.0), abs=0.08)


def test_indices__of_the_only_axis_are_one(surrogate: Surrogate) -> None:
    (index,) = indices_of_surrogate(surrogate)
    assert (index.name, index.first.value, index.total.value) == ("speed", 1.0, 1.0)


def test_indices__of_a_sum_are_the_shares_of_the_variances() -> None:
    # Variances of uniform distributions, width^2 / 12: 4 and 1.
    bounds = [(0.0, 4.0), (5.0, 6.0)]
    first, second = indices_of(lambda x: x[:, 0] + 2.0 * x[:, 1], ["a", "b"], bounds, samples=512)
    for index, share in ((first, 0.8), (second, 0.2)):
        assert index.first.low <= share <= index.first.high
        assert index.total.low <= share <= index.total.high


def test_process__has_the_likelihood_and_the_predictions_of_scikit_learn() -> None:
    from sklearn.gaussian_process import GaussianProcessRegressor

    rng = np.random.default_rng(2)
    x, y, there = rng.random((9, 2)), rng.standard_normal(9), rng.random((4, 2))
    for parameters in (np.log([0.5, 0.3, 2.0, 1e-3]), np.log([2.0, 1.0, 0.2, 0.1])):
        process = _process(parameters, x, y)
        library = GaussianProcessRegressor(process.kernel, optimizer=None, alpha=NUGGET).fit(x, y)
        constant = 0.5 * len(y) * np.log(2.0 * np.pi)
        likelihood = library.log_marginal_likelihood_value_ + constant
        assert process.likelihood(y) == pytest.approx(likelihood, rel=ROUND_OFF)
        values, deviations = library.predict(there, return_std=True)
        assert process.means(there) == pytest.approx(values, rel=ROUND_OFF)
        assert process.deviations(there) == pytest.approx(deviations, rel=ROUND_OFF)


def test_surrogate__without_numbers_or_runs_is_refused(cube: xr.Dataset) -> None:
    metals = {**CRATERS["axes"], "target": ["copper-ofhc", "al-2024-t3"]}
    words = {**CRATERS, "fixed": {**CRATERS["fixed"]}, "axes": metals}
    del words["fixed"]["target"]
    with pytest.raises(InvalidInput, match="axes of numbers"):
        runs_of(sized_cube(words, bent, "crater_depth"), "crater_depth")
    with pytest.raises(InvalidInput, match="4 runs or more for 1"):
        runs_of(cube.isel(speed=[0, 1, 2]), "crater_depth")


def test_surrogate__uses_runs_of_coarse_grids_and_says_which_it_leaves_out() -> None:
    def flag(shot: Shot) -> str:
        if shot.speed < 3.5e3:
            return "closed_on_axis"
        return "too_coarse" if shot.plate_thickness != 3e-3 else ""

    runs = runs_of(sized_cube({**HOLES, "offsets": 2}, bent, "hole_diameter", flag), "hole_diameter")
    assert [each.name for each in runs.inputs] == ["speed", "plate_thickness"]
    assert (len(runs.values), runs.not_used, runs.too_coarse) == (30, {"closed on axis": 6}, 20)
    assert list(runs.axes_not_used) == ["offset"]
    for text in ("30 of 36 runs", "6 left out: closed on axis", "axis offset left out", "20 of"):
        assert text in runs.scope


def test_surrogate__of_runs_that_have_lost_an_axis_is_refused() -> None:
    cube = sized_cube(
        HOLES, bent, "hole_diameter", lambda shot: "closed_on_axis" if shot.plate_thickness != 3e-3 else ""
    )
    with pytest.raises(InvalidInput, match="6 of 18 runs that count") as refused:
        runs_of(cube, "hole_diameter")
    assert "12 closed on axis" in str(refused.value)


def test_place__is_read_with_units_and_inside_the_runs() -> None:
    runs = runs_of(sized_cube({**HOLES, "resolution": [16, 32]}, bent, "hole_diameter"), "hole_diameter")
    texts = ["speed=5 km/s", "plate_thickness = 2 mm"]
    assert runs.read_place(texts).tolist() == [5000.0, 2e-3, 32.0]
    for wrong in (texts[:1], [*texts, "x=1"], ["speed=9 km/s", texts[1]], ["speed=5", texts[1]]):
        with pytest.raises(InvalidInput):
            runs.read_place(wrong)


def test_command__prints_errors_indices_and_a_prediction(
    cube: xr.Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cube.isel(speed=slice(1, 6)).to_netcdf(tmp_path / "cube.nc")
    picture = tmp_path / "a.svg"
    assert run("surrogate", str(tmp_path), "--at", "speed=5.5 km/s", "--json", "--plot", str(picture)) == 0
    plain = json.loads(capsys.readouterr().out)
    assert len(plain["left_out"]["runs"]) == plain["runs"] == plain["runs_of_the_cube"] == 5
    assert plain["runs_not_used"] == plain["axes_not_used"] == []
    prediction = plain["prediction"]
    truth = 1e-3 * 5.5**0.6 + 3e-4 * np.sin(5.5)
    assert abs(prediction["value"] - truth) <= prediction["interval"]
    assert picture.stat().st_size > 1000
    assert run("surrogate", str(tmp_path), "--quantity", "hole") == 2


def test_surrogate__without_its_extra_names_it(monkeypatch: pytest.MonkeyPatch, cube: xr.Dataset) -> None:
    monkeypatch.setitem(sys.modules, "sklearn.gaussian_process", None)
    with pytest.raises(MissingExtra, match=r"whipple\[surrogate\]"):
        surrogate_of(cube, "crater_depth")
