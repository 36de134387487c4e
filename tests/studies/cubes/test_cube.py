"""The cube: every run in its cell, every variable as declared, the file whole, CF content."""

import csv
import json
import math
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
import xarray as xr

from studies import laws
from studies.cubes import cube
from studies.cubes.exports import runs_csv
from studies.cubes.groups import as_tree
from studies.cubes.opening import open_tree, whole_cube
from studies.cubes.reading import still_growing
from studies.cubes.variable import GROUPS, LONGEST_LABEL
from studies.cubes.variables import STATES
from studies.quantities.measured import MESH_DETERMINED, STILL_GROWING
from studies.runs.results import RunResult
from studies.sweeps import sweep as sweep_module
from studies.sweeps.axes import Axis
from studies.sweeps.reading import END
from studies.sweeps.sweep import Sweep
from tests.claims.marked import claimed
from tests.samples import needs
from tests.studies.support import compliance, fakes
from tests.studies.support.fakes import sweep_of

ZIP = sweep_of(Axis("speed", "m s-1", (5e3, 2e3, 3e3)), Axis("plate_thickness", "m", (2e-3, 3e-3, 2e-3)), combine="zip")
WORDS = sweep_of(
    Axis("projectile", None, ("al-1100-o", "copper-ofhc")),
    Axis("speed", "m s-1", (5e3, 3e3)),
    fixed={"plate_thickness": 2e-3},
)


def holes() -> xr.Dataset:
    sweep = fakes.holes()
    return fakes.cube_of(sweep, fakes.with_trouble(sweep))


def test_grid__axes_are_dimensions_and_every_value_is_in_its_cell() -> None:
    sweep = fakes.holes()
    results = fakes.results(sweep)
    dataset = fakes.cube_of(sweep, results)
    assert dataset.hole_diameter.dims == ("speed", "plate_thickness")
    for point in sweep.runs():
        cell = dataset.sel(point.coordinates)
        measured = results[point.run.id].measurements["hole_diameter"]
        assert float(cell.hole_diameter) == measured.value
        assert float(cell.hole_diameter_reading_uncertainty) == measured.uncertainty
        assert float(cell.hole_diameter_uncertainty_growth) == measured.parts["growth"]
        assert float(cell.hole_diameter_definition_part) == measured.parts["definition"]
        assert cell.run_id.item() == point.run.id
    assert "hole_diameter_uncertainty_definition" not in dataset
    assert "hole_diameter_areal_definition_part" not in dataset


def test_unfinished_runs__are_not_resolved_where_all_ids_are_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """The results so far have the values of runs that have ended, and of the others place, id and state alone."""
    sweep, pending = fakes.holes(), RunResult("", "pending", None)
    points = sweep.runs()
    ids = [point.run.id for point in points]
    ended = {id: result for id, result in fakes.results(sweep).items() if id in ids[1::5]}
    results = {id: ended.get(id, pending) for id in ids}
    catalogue = fakes.catalogue()
    whole = cube.build(sweep, results, catalogue)
    resolve = Mock(wraps=sweep_module.resolve)
    monkeypatch.setattr(sweep_module, "resolve", resolve)
    partial = cube.build(sweep, results, catalogue, ids)
    assert resolve.call_count == len(ended)
    assert partial.sizes == whole.sizes
    for name in ("run_id", "run_state", "speed", "plate_thickness", "projectile", "projectile_diameter"):
        xr.testing.assert_identical(partial[name].variable, whole[name].variable)
    for point in points:
        mine, other = (each.sel(point.coordinates) for each in (partial, whole))
        if point.run.id in ended:
            xr.testing.assert_equal(mine, other)
        else:
            assert np.isnan(mine.hole_diameter)
            assert np.isnan(mine.hole_diameter_by_law).all()
    # Of ids that are those of other runs, as of an older version, nothing is taken.
    xr.testing.assert_identical(cube.build(sweep, results, catalogue, ids[1:] + ids[:1]), whole)


@needs("plugging")
def test_parameter__that_some_runs_have_is_in_the_cube_and_one_that_none_has_is_not() -> None:
    document = {"scenario": "plugging", "axes": {"nose": ["blunt", "conical"]}, "fixed": {"speed": "300 m/s"}}
    sweep = Sweep.parse(document)
    dataset = cube.build(sweep, {point.run.id: RunResult("", "failed", "late") for point in sweep.runs()})
    np.testing.assert_array_equal(dataset.nose_length, [math.nan, 20e-3])
    assert not {"failure_time", "fixed_dt"} & {*dataset.variables}


@pytest.mark.claim("cube", "failed-run-is-a-result")
def test_failed_run__is_nan_with_state_and_reason_and_its_neighbours_are_untouched() -> None:
    """A run that fails is NaN with state and reason in the cube; its neighbours are untouched."""
    sweep = fakes.holes()
    whole, hurt = fakes.cube_of(sweep), fakes.cube_of(sweep, fakes.with_trouble(sweep))
    failed, cancelled = (hurt.sel(speed=2e3, plate_thickness=thick) for thick in (2e-3, 3e-3))
    assert np.isnan(failed.hole_diameter)
    assert STATES[int(failed.run_state)] == "failed"
    assert "density = 3e4 at particle 17" in failed.run_reason.item()
    assert failed.run_failure.item() == "UnphysicalState"
    assert STATES[int(cancelled.run_state)] == "cancelled"
    assert cancelled.run_reason.item() == "cancelled by its user"
    xr.testing.assert_identical(
        hurt.hole_diameter.sel(speed=slice(4e3, None)), whole.hole_diameter.sel(speed=slice(4e3, None))
    )


def test_laws__answer_as_themselves_with_range_and_reason() -> None:
    dataset = holes()
    for point in fakes.holes().runs():
        shot = laws.shot_from(point.run.parameters, point.run.materials)
        for law in fakes.HOLE_LAWS:
            for variant in law.variants(shot):
                label = f"{law.name}/{variant}" if variant else law.name
                cell = dataset.sel(point.coordinates).sel(hole_diameter_law=label)
                answer = law.evaluate(shot, variant)
                np.testing.assert_equal(float(cell.hole_diameter_by_law), answer.value)
                assert bool(cell.hole_diameter_by_law_in_range) == answer.in_range
                assert tuple(laws.RangeStatus)[int(cell.hole_diameter_by_law_range_status)] is answer.status
                assert bool(cell.hole_diameter_law_has_range) == law.range.is_published
                speeds = [float(cell[f"hole_diameter_law_speed_{bound}"]) for bound in ("lower", "upper")]
                np.testing.assert_equal(speeds, law.range.bounds(laws.SPEED))
                assert cell.hole_diameter_by_law_reason.item() == laws.in_words(answer.reasons)


def test_still_growing__are_runs_at_their_latest_end_of_which_one_quantity_had_not_settled() -> None:
    outcomes = fakes.results(fakes.holes())
    early, late, settled = list(outcomes)[:3]
    growing = fakes.measured(0.02, STILL_GROWING)
    for id, stop in ((early, "converged"), (late, END), (settled, END)):
        measurements = {**outcomes[id].measurements, **({} if id == settled else {"hole_diameter_areal": growing})}
        outcomes[id] = replace(outcomes[id], measurements=measurements, stop=stop)
    assert still_growing(fakes.cube_of(fakes.holes(), outcomes)) == {late}


def test_histories__are_thinned_padded_and_keep_both_ends() -> None:
    sweep = fakes.holes()
    outcomes = fakes.results(sweep)
    run = sweep.runs()[0].run.id
    hole = outcomes[run].measurements["hole_diameter"]
    values = [0.01 + 1e-5 * time for time in range(400)]
    long = replace(hole, history={"time": list(range(400)), "value": values})
    measurements = {"hole_diameter": long}
    outcomes[run] = replace(outcomes[run], measurements=measurements)
    dataset = fakes.cube_of(sweep, outcomes)
    first = dataset.hole_diameter_history.isel(speed=0, plate_thickness=0)
    assert dataset.sizes["sample"] == cube.HISTORY_SAMPLES < 400
    assert (float(first[0]), float(first[-1])) == (values[0], values[-1])
    assert int(dataset.hole_diameter_history[1, 0].count()) == 21


def test_histories__of_bodies_lie_over_body_and_time() -> None:
    sweep = fakes.holes()
    outcomes = fakes.results(sweep)
    run = sweep.runs()[0].run.id
    times = outcomes[run].measurements["hole_diameter"].history["time"]
    energy = [[2.0 * place for place in range(len(times))], [1.0] * len(times)]
    histories = {"time": times, "bodies": ["projectile", "target"], "kinetic_energy": energy}
    outcomes[run] = replace(outcomes[run], histories=histories)
    kinetic = fakes.cube_of(sweep, outcomes).body_kinetic_energy_history
    first = kinetic.isel(speed=0, plate_thickness=0)
    assert first.dims == ("body", "sample")
    assert first.sel(body="projectile").values.tolist() == energy[0]
    assert first.sel(body="target").values.tolist() == energy[1]
    assert first.history_time.values.tolist() == times
    assert kinetic.isel(speed=1).isnull().all()


@pytest.mark.claim("contract", "groups-are-cf")
@pytest.mark.parametrize(
    "case", claimed(("grid", "zip", "words", "refined", "nothing"), ("grid",), "cube", "cube-is-cf")
)
def test_file__opens_as_it_was_built_and_passes_the_cf_checker(tmp_path: Path, case: str) -> None:
    """compliance-checker finds no error against CF-1.11 in each group of a cube as a file of its own.

    The file has what was built.
    """
    sweeps = {"zip": ZIP, "words": WORDS, "refined": fakes.refined_holes()}
    sweep = sweeps.get(case, fakes.holes())
    outcomes = {} if case == "nothing" else fakes.results(sweep)
    shots = fakes.SHOTS if case in ("grid", "refined") else ()
    dataset = fakes.cube_of(sweep, outcomes, observations=shots)
    file = cube.write(dataset, tmp_path / "cube.nc")
    xr.testing.assert_equal(whole_cube(file), dataset)
    with open_tree(file) as tree:
        for group in tree.subtree:
            own = tmp_path / f"{group.name or 'root'}.nc"
            group.to_dataset().to_netcdf(own)
            assert compliance.complaints(own) == [], group.path


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    """The cube of a refined sweep with laws, shots and histories, as its file has it."""
    sweep = fakes.refined_holes()
    built = fakes.cube_of(sweep, fakes.with_trouble(sweep), observations=fakes.SHOTS)
    return whole_cube(cube.write(built, tmp_path_factory.mktemp("cube") / "cube.nc"))


@pytest.mark.claim("cube", "cube-reads")
def test_cube__is_printed_from_its_main_results_on(written: xr.Dataset) -> None:
    """A cube is printed with its main results first, one of each point, and its groups in their order."""
    tree = as_tree(written)
    assert list(tree.data_vars)[:2] == ["hole_diameter", "hole_diameter_uncertainty"]
    assert tree.hole_diameter.dims == ("speed",)
    assert tree["refinement"].hole_diameter.dims == ("speed", "cells_per_diameter", "offset")
    np.testing.assert_array_equal(tree.hole_diameter, written.hole_diameter_converged)
    assert [*tree.children] == list(GROUPS[1:])


@pytest.mark.claim("cube", "cube-reads")
def test_cube__has_short_labels_every_definition_and_its_coordinates(written: xr.Dataset) -> None:
    """Labels have at most 40 characters, no definition is lost, and fixed parameters and times are coordinates."""
    assert max(len(array.attrs["long_name"]) for array in written.variables.values()) <= LONGEST_LABEL == 40
    vocabulary = json.loads(written.attrs["vocabulary"])
    kept = {str(each.attrs.get("comment") or each.attrs["long_name"]) for each in written.values()}
    assert {meaning for _, meaning in vocabulary["quantities"].values()} <= kept
    for name, (_, _, meaning) in vocabulary["parameters"].items():
        assert name not in written or meaning in written[name].attrs.values(), name
    for name in json.loads(written.attrs["sweep"])["fixed"]:
        assert name in written.coords
        assert not written[name].dims
    assert "history_time" in written.hole_diameter_history.coords
    assert not (written.hole_diameter_history.notnull() & written.history_time.isnull()).any()


@pytest.mark.claim("cube", "cube-reads")
def test_table_of_runs__has_every_run_as_its_cell(written: xr.Dataset) -> None:
    """runs.csv has every run with the value of its cell."""
    rows = list(csv.DictReader(runs_csv(written).splitlines()))
    assert len(rows) == written.run_state.size
    for row in rows:
        axes = ("speed [m s-1]", "cells_per_diameter", "offset")
        cell = written.sel({heading.partition(" ")[0]: float(row[heading]) for heading in axes})
        np.testing.assert_equal(float(row["hole_diameter [m]"] or "nan"), cell.hole_diameter.item())
        assert row["run_id"] == cell.run_id.item()


@pytest.mark.parametrize(("grids", "flagged"), [((16.0,), True), ((16.0, 32.0), True), (fakes.CELLS, False)])
def test_value_of_the_mesh__keeps_its_flag_below_three_grids(grids: tuple[float, ...], flagged: bool) -> None:
    sweep = fakes.refined_holes(grids)
    outcomes = {
        run: replace(
            result,
            measurements={
                name: replace(measured, flags=(MESH_DETERMINED,)) for name, measured in result.measurements.items()
            },
        )
        for run, result in fakes.results(sweep).items()
        if getattr(result, "measurements", None)
    }
    dataset = fakes.cube_of(sweep, outcomes)
    # At the last speed every run succeeded.
    flags = dataset.hole_diameter_flags.isel(speed=-1)
    assert bool((flags > 0).all()) == bool((flags > 0).any()) == flagged
