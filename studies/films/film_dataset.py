"""The film of a run as a dataset over time and particle."""

from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from xarray import Dataset

from studies.quantities.files import FILM
from studies.quantities.findings import Finding, InvalidInput

FRAMES = {  # unit and meaning of each array over particles
    "position": ("m", "position: x, y, z, or in axisymmetry r, z, theta"),
    "speed": ("m s-1", "speed"),
    "pressure": ("Pa", "pressure"),
    "temperature": ("K", "temperature"),
    "plastic_strain": ("1", "plastic strain"),
    "damage": ("1", "damage: 0 whole, 1 failed"),
}


def open_film(path: str | Path) -> Dataset:
    """Open a film, or the one in a folder; raises InvalidInput for anything else.

    ``position`` (time, particle, component), ``speed``, ``pressure``, ``temperature``, ``plastic_strain`` and
    ``damage`` (time, particle) are in SI and NaN where a particle has left the grid. ``particle`` is its permanent
    number, ``body`` the name of its body, empty for one that no frame shows on the grid.
    """
    file = Path(path)
    file = file / FILM if file.is_dir() else file
    try:
        with np.load(file) as saved:
            return _dataset(saved)
    except (OSError, EOFError, KeyError, ValueError, BadZipFile) as error:
        cure = "give the film.npz of a run that was computed with keep: film, or its folder"
        raise InvalidInput([Finding("film", str(file), f"a film ({error})", cure)]) from None


def _dataset(saved: "np.lib.npyio.NpzFile") -> Dataset:
    """The arrays of a film (studies.films.film) with their names, dimensions and units."""
    names = np.append(saved["bodies"], "")  # -1, the last: a particle that no frame shows
    dims = ("time", "particle", "component")
    frames = {}
    for name, (unit, meaning) in FRAMES.items():
        values = saved[name]
        frames[name] = (dims[: values.ndim], values, {"units": unit, "long_name": meaning})
    coordinates = {
        "time": ("time", saved["time"], {"units": "s", "long_name": "time since the run began"}),
        "particle": ("particle", saved["number"], {"long_name": "number of the particle"}),
        "body": ("particle", names[saved["body"]], {"long_name": "body of the particle"}),
    }
    attributes = {name: int(saved[name]) for name in ("stride", "whole")}
    return Dataset(frames, coordinates, attributes)
