"""Parts of a cube, and cubes that are not complete."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from studies import cube, slices
from studies.errors import InvalidInput
from studies.slices import as_json, excerpt
from tests.studies import fakes
from tests.studies.fakes import Axis, Sweep

ZIP = Sweep(
    (Axis("speed", "m s-1", (5e3, 2e3, 3e3)), Axis("plate_thickness", "m", (2e-3, 3e-3, 2e-3))),
    combine="zip",
)
WORDS = Sweep(
    (Axis("projectile", None, ("tin", "lead")), Axis("speed", "m s-1", (5e3, 3e3))),
    fixed={"projectile_diameter": fakes.DIAMETER, "plate_thickness": 2e-3},
)


def cube_of(sweep: Sweep) -> xr.Dataset:
    return cube.build(sweep, fakes.results(sweep), fakes.catalogue())


@pytest.fixture(scope="module")
def holes() -> xr.Dataset:
    sweep = fakes.holes()
    return cube.build(sweep, fakes.with_trouble(sweep), fakes.catalogue())


def refused(dataset: xr.Dataset, variables: list[str], **at: str) -> InvalidInput:
    with pytest.raises(InvalidInput) as error:
        excerpt(dataset, variables, {name: [text] for name, text in at.items()})
    return error.value


def test_excerpt__of_nothing_named_is_what_was_measured(holes: xr.Dataset) -> None:
    part = excerpt(holes, [], {})
    assert "hole_diameter" in part
    assert part.hole_diameter.identical(holes.hole_diameter)


def test_excerpt__brings_uncertainty_flags_and_state_along(holes: xr.Dataset) -> None:
    part = excerpt(holes, ["hole_diameter"], {})
    companions = {"hole_diameter_uncertainty", "hole_diameter_flags", "run_state"}
    assert set(part.data_vars) == {"hole_diameter", *companions}


@pytest.mark.parametrize("text", ["3 km/s", "3000", "3e3", "3000 m/s", " 3 km/s "])
def test_excerpt__at_one_value_drops_the_dimension(holes: xr.Dataset, text: str) -> None:
    part = excerpt(holes, ["hole_diameter"], {"speed": [text]})
    assert part.hole_diameter.dims == ("plate_thickness",)
    np.testing.assert_array_equal(part.hole_diameter, holes.hole_diameter.sel(speed=3e3))
    assert part.speed.item() == 3e3


def test_excerpt__at_several_values_keeps_the_dimension(holes: xr.Dataset) -> None:
    part = excerpt(holes, ["hole_diameter"], {"speed": ["5 km/s", "3000", "5000"]})
    assert list(part.speed.values) == [3e3, 5e3]


@pytest.mark.parametrize(
    ("text", "speeds"),
    [
        ("3 km/s..5 km/s", [3e3, 4e3, 5e3]),
        ("3000..5000", [3e3, 4e3, 5e3]),
        ("..3 km/s", [2e3, 3e3]),
        ("6500..", [7e3]),
        ("..", list(fakes.SPEEDS)),
    ],
)
def test_excerpt__of_a_range_has_both_ends(
    holes: xr.Dataset, text: str, speeds: list[float]
) -> None:
    part = excerpt(holes, ["hole_diameter"], {"speed": [text]})
    assert list(part.speed.values) == speeds


def test_excerpt__of_a_zip_takes_the_runs_that_have_the_values() -> None:
    dataset = cube_of(ZIP)
    part = excerpt(dataset, ["hole_diameter"], {"plate_thickness": ["2 mm"]})
    assert part.hole_diameter.dims == ("run",)
    assert list(part.speed.values) == [5e3, 3e3]
    one = excerpt(dataset, ["hole_diameter"], {"plate_thickness": ["2 mm"], "speed": ["3 km/s"]})
    assert list(one.speed.values) == [3e3]
    error = refused(dataset, [], plate_thickness="3 mm", speed="5 km/s")
    assert "together" in str(error)


def test_excerpt__of_words_takes_them_as_they_are() -> None:
    part = excerpt(cube_of(WORDS), ["hole_diameter"], {"projectile": ["tin"]})
    assert part.hole_diameter.dims == ("speed",)
    assert "lead" in str(refused(cube_of(WORDS), [], projectile="Tin"))


def test_excerpt__takes_resolution_and_offset_as_axes() -> None:
    refined = cube_of(fakes.refined_holes())
    part = excerpt(refined, ["hole_diameter"], {"cells_per_diameter": ["32"], "offset": ["0"]})
    assert part.hole_diameter.dims == ("speed",)
    expected = refined.hole_diameter.sel(cells_per_diameter=32.0, offset=0.0)
    np.testing.assert_array_equal(part.hole_diameter, expected)


def test_excerpt__names_everything_that_is_wrong_with_a_cure(holes: xr.Dataset) -> None:
    error = refused(holes, ["hole_diametr"], sped="1", speed="3.1 km/s", plate_thickness="2 kg")
    fields = {finding.field: finding for finding in error.findings}
    assert set(fields) == {"variable", "sped", "speed", "plate_thickness"}
    assert "hole_diameter" in fields["variable"].cure
    assert "speed" in fields["sped"].cure
    assert "3 km/s" in fields["speed"].limit
    assert ".." in fields["speed"].cure
    assert "length" in fields["plate_thickness"].limit


@pytest.mark.parametrize(
    "text", ["nan", "inf", "", "x", "1e999", "9000..8000", "9 km/s..", "1..2..3"]
)
def test_excerpt__at_what_is_no_value_is_refused(holes: xr.Dataset, text: str) -> None:
    [finding] = refused(holes, [], speed=text).findings
    assert finding.field == "speed"


def test_excerpt__of_too_many_values_is_refused_with_the_number(
    holes: xr.Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(slices, "MOST_VALUES", 10)
    assert "at most 10" in str(refused(holes, ["hole_diameter"]))
    excerpt(holes, ["hole_diameter"], {"speed": ["3 km/s"], "plate_thickness": ["2 mm"]})


def test_json__has_units_words_and_null_for_what_is_no_number(holes: xr.Dataset) -> None:
    plain = json.loads(json.dumps(as_json(excerpt(holes, ["hole_diameter"], {})), allow_nan=False))
    hole = plain["variables"]["hole_diameter"]
    assert (hole["dims"], hole["unit"]) == (["speed", "plate_thickness"], "m")
    assert plain["coords"]["speed"]["values"] == list(fakes.SPEEDS)
    assert "failed" in plain["variables"]["run_state"]["words"]
    expected = holes.hole_diameter.values
    assert np.isnan(expected).any()
    np.testing.assert_array_equal(np.array(hole["values"], float), expected)


@pytest.mark.parametrize("ending", ["json", "nc"])
def test_part__is_written_in_both_forms(holes: xr.Dataset, tmp_path: Path, ending: str) -> None:
    source = cube.write(holes, tmp_path / "cube.nc")
    file = slices.write_part(source, [], {"speed": ["3 km/s"]}, tmp_path / f"part.{ending}")
    if ending == "nc":
        with xr.open_dataset(file) as part:
            np.testing.assert_array_equal(part.hole_diameter, holes.hole_diameter.sel(speed=3e3))
            assert part.attrs["Conventions"] == "CF-1.11"
    else:
        assert json.loads(file.read_text())["dims"]["plate_thickness"] == 3


def test_partial_cube__says_of_itself_that_it_is_not_complete(holes: xr.Dataset) -> None:
    partial = slices.marked_as_partial(holes, "running, 3 of 18 runs have a result")
    assert partial.attrs["sweep_state"].startswith("running")
    assert partial.attrs["comment"].startswith("Not complete")
    assert "sweep_state" not in holes.attrs


def test_partial_cube__of_a_sweep_has_its_runs_and_its_gaps(tmp_path: Path) -> None:
    from studies.sweep import Sweep as Real
    from tests.service.api import SWEEP

    ids = [point.run.id for point in Real.parse(SWEEP).runs()]
    outcomes: dict[str, dict[str, Any]] = {
        ids[0]: {"state": "pending", "reason": None},
        ids[1]: {"state": "failed", "reason": "density"},
    }
    file = slices.write_partial(SWEEP, outcomes, tmp_path / "cube.nc", state="running")
    with xr.open_dataset(file) as partial:
        words = partial.run_state.attrs["flag_meanings"].split()
        assert [words[int(state)] for state in partial.run_state] == ["pending", "failed"]
        assert partial.attrs["sweep_state"] == "running"
