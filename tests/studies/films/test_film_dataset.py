"""A film that is opened: as a dataset, and as VTU files."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

import whipple
from solver.state import Snapshot
from studies.films.film import SCALARS, Film
from studies.quantities.findings import InvalidInput
from tests.service.support.command import run
from tests.studies.films.test_exports import read
from tests.studies.films.test_film import small_problem, states

LEFT, ABSENT = 3, 5  # particles: gone between the two frames, and before both
FIELDS = SCALARS


def without(state: Snapshot, *numbers: int) -> Snapshot:
    gone = np.isin(state.particles.number, numbers)
    alive = np.where(gone, 0, state.particles.alive)
    return state._replace(particles=state.particles._replace(alive=alive))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A film of two frames and two bodies; in a third frame everything has left."""
    film = Film(small_problem())
    film.bodies = ["plate", "ball"]
    first, second, third = states(3)
    number = first.particles.number
    body = (number >= number.size // 2).astype(first.body.dtype)
    film.add(without(first, ABSENT)._replace(body=body))
    film.add(without(second, ABSENT, LEFT)._replace(body=body))
    film.add(without(third, *number)._replace(body=body))
    film.save(tmp_path / "film.npz", compressed=True)
    return tmp_path


def test_open_film__has_time_particle_and_body_with_their_units(folder: Path) -> None:
    film = whipple.open_film(folder)
    assert film.position.dims == ("time", "particle", "component")
    assert film.time.values.tolist() == [0.0, 1.0, 2.0]
    assert film.body.sel(particle=[ABSENT, 0, film.sizes["particle"] - 1]).values.tolist() == ["", "plate", "ball"]
    assert np.isnan(film.speed.sel(particle=LEFT)).values.tolist() == [False, True, True]
    units = [film[name].attrs["units"] for name in ("time", "position", *FIELDS)]
    assert units == ["s", "m", "m s-1", "Pa", "K", "1", "1"]
    with np.load(folder / "film.npz") as saved:
        np.testing.assert_array_equal(film.temperature, saved["temperature"])
        np.testing.assert_array_equal(film.position[0, 7:9], saved["position"][0, 7:9])


@pytest.mark.parametrize("content", [None, b"", b"PK no zip", b"text"])
def test_open_film__of_something_else_is_refused(tmp_path: Path, content: bytes | None) -> None:
    file = tmp_path / "film.npz"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(InvalidInput, match=r"film\.npz"):
        whipple.open_film(tmp_path)
    assert run("export", file, "--vtk", tmp_path / "out") == 2


@pytest.mark.claim("pages", "vtk-reads-exports", minutes=0.1)
def test_export__has_a_file_for_each_frame_also_where_everything_has_left(folder: Path) -> None:
    assert run("export", folder, "--vtk", folder / "out") == 0
    listed = list(ET.parse(folder / "out" / "film.pvd").iter("DataSet"))
    assert [float(entry.attrib["timestep"]) for entry in listed] == [0.0, 1.0, 2.0]
    counts = [read(folder / "out" / entry.attrib["file"]).GetNumberOfPoints() for entry in listed]
    assert counts == np.isfinite(whipple.open_film(folder).speed).sum("particle").values.tolist()
    assert counts[-1] == 0
