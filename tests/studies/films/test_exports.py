"""Results in the formats of other programs, read back by their own readers."""

import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
import zarr

import whipple
from solver.state import Departed, Particles
from studies.cubes import cube
from studies.films.vtk import UNITS, export_vtk, files_of
from studies.runs.execution import execute
from studies.runs.remeasure import load_state
from tests.claims.rows import equal
from tests.service.support.command import run
from tests.studies.runs.solved import asked
from tests.studies.support import fakes

NAMES = {"number": "particle", "time": "departure_time"}  # of fields whose name says more in a file


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run")
    execute(asked("thin_plate"), folder, threads=1, film=True)
    return folder


@pytest.fixture
def cube_file(tmp_path: Path) -> Path:
    return cube.write(fakes.cube_of(fakes.holes()), tmp_path / "cube.nc")


def read(file: Path) -> Any:
    """What the reader of VTK makes of a file; it reports nothing."""
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader  # half a gigabyte, for this claim alone

    reader, reports = vtkXMLUnstructuredGridReader(), []
    for kind in ("ErrorEvent", "WarningEvent"):
        reader.AddObserver(kind, lambda *event: reports.append(event))
    reader.SetFileName(str(file))
    reader.Update()
    assert not reports
    return reader.GetOutput()


def arrays(grid: Any) -> dict[str, tuple[np.ndarray, str | None]]:
    """Each array of a grid with its unit, its points as "position"."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkDataArray

    data = grid.GetPointData()
    listed = {data.GetArrayName(k): data.GetArray(k) for k in range(data.GetNumberOfArrays())}
    listed["position"] = grid.GetPoints().GetData()
    return {
        name: (vtk_to_numpy(each), each.GetInformation().Get(vtkDataArray.UNITS_LABEL()))
        for name, each in listed.items()
    }


def about(grid: Any) -> tuple[float, list[str]]:
    """Time of a grid, and the names of its bodies."""
    data = grid.GetFieldData()
    bodies = data.GetAbstractArray("bodies")
    names = [bodies.GetValue(k) for k in range(bodies.GetNumberOfValues())]
    return data.GetArray("TimeValue").GetValue(0), names


def same(name: str, read: np.ndarray, expected: np.ndarray) -> Any:
    """Whether the numbers are the same, bit for bit."""
    return equal(name, expected=True, got=read.dtype == expected.dtype and np.array_equal(read, expected))


@pytest.mark.claim("pages", "vtk-reads-exports", minutes=0.1)
def test_export__is_read_by_vtk_with_every_field_unit_and_time(
    folder: Path, tmp_path: Path, compared: Callable[..., None]
) -> None:
    """The reader of VTK finds every field, unit and time of an exported film and final state, bit for bit."""
    export_vtk(files_of(folder), tmp_path)
    state = load_state(folder / "state.npz")
    kept = {name: value for name, value in state.particles._asdict().items() if name != "alive"}
    for file, fields in {
        "state.vtu": {**kept, "body": state.body},
        "departed.vtu": {name: value for name, value in state.departed._asdict().items() if name != "remembered"},
    }.items():
        grid = read(tmp_path / file)
        found = arrays(grid)
        assert set(found) == {NAMES.get(name, name) for name in fields}
        compared(equal(f"time and bodies of {file}", expected=(state.time, ["projectile", "target"]), got=about(grid)))
        for name, values in fields.items():
            array, unit = found[NAMES.get(name, name)]
            compared(same(f"{name} of {file}", array, np.asarray(values)))
            assert unit == UNITS.get(name)
    assert set(UNITS) == {*Particles._fields, *Departed._fields} - {"alive", "number", "body", "remembered"}
    film = whipple.open_film(folder)
    listed = list(ET.parse(tmp_path / "film.pvd").iter("DataSet"))
    compared(
        equal("times", expected=film.time.values.tolist(), got=[float(each.attrib["timestep"]) for each in listed])
    )
    for index, entry in enumerate(listed):
        frame = film.isel(time=index).dropna("particle")
        grid = read(tmp_path / entry.attrib["file"])
        found = arrays(grid)
        assert set(found) == {*map(str, film), "particle", "body"}
        assert about(grid)[0] == film.time.values[index]
        assert [about(grid)[1][number] for number in found["body"][0]] == frame.body.values.tolist()
        for name in map(str, film):
            array, unit = found[name]
            np.testing.assert_array_equal(array, frame[name])
            assert unit == film[name].attrs["units"]


@pytest.mark.parametrize("name", ["cube.zarr", "cube.zarr.zip"])
def test_cube__is_the_same_as_zarr_and_its_table_has_every_run(name: str, cube_file: Path, tmp_path: Path) -> None:
    assert run("export", cube_file, "--zarr", tmp_path / name, "--csv", tmp_path / "runs.csv") == 0
    store = zarr.storage.ZipStore(tmp_path / name, mode="r") if name.endswith("zip") else tmp_path / name
    with xr.open_datatree(cube_file) as written, xr.open_datatree(store, engine="zarr") as read:
        xr.testing.assert_identical(read.load(), written.load())
        table = pd.read_csv(tmp_path / "runs.csv")
        assert table["run_id"].tolist() == written["runs"].run_id.values.ravel().tolist()
