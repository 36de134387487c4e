"""The film of a run as a dataset over time and particle; its frames are loaded when they are looked at."""

from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
import xarray as xr
from xarray import Dataset
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing

from studies.values.errors import Finding, InvalidInput
from studies.values.files import FILM

__all__ = ["Dataset", "open_film"]

FRAMES = {  # of each particle: its unit and meaning
    "position": ("m", "position: x, y, z, or in axisymmetry r, z, theta"),
    "speed": ("m s-1", "speed"),
    "pressure": ("Pa", "pressure"),
    "temperature": ("K", "temperature"),
}


def open_film(path: str | Path) -> Dataset:
    """Open a film, or the one in a folder; raises InvalidInput for anything else.

    ``position`` (time, particle, component), ``speed``, ``pressure`` and ``temperature`` (time, particle) are in SI and
    NaN where a particle has left the grid. ``particle`` is its permanent number, ``body`` the name of what it is of,
    empty for one that no frame has seen on the grid.
    """
    file = Path(path)
    file = file / FILM if file.is_dir() else file
    try:
        return xr.open_dataset(file, engine=_Films)
    except (OSError, EOFError, KeyError, ValueError, BadZipFile) as error:
        cure = "give the film.npz that a run with keep: film leaves, or its folder"
        raise InvalidInput([Finding("film", str(file), f"a film ({error})", cure)]) from None


class _Films(BackendEntrypoint):
    """Reads ``film.npz`` for xarray."""

    def open_dataset(self, filename_or_obj: Any, *, drop_variables: Any = None) -> Dataset:
        with np.load(filename_or_obj) as saved:
            time, number, body = saved["time"], saved["number"], saved["body"]
            names = np.append(saved["bodies"], "")  # -1, the last: a particle that was never seen
            attributes = {"stride": int(saved["stride"]), "whole": int(saved["whole"])}
        dims = ("time", "particle", "component")
        sizes = (time.size, number.size, 3)
        frames = {}
        for name, (unit, meaning) in FRAMES.items():
            rank = 3 if name == "position" else 2
            values = indexing.LazilyIndexedArray(_Frames(filename_or_obj, name, sizes[:rank]))
            attrs = {"units": unit, "long_name": meaning}
            frames[name] = xr.Variable(dims[:rank], values, attrs)
        coordinates = {
            "time": ("time", time, {"units": "s", "long_name": "time since the begin of the run"}),
            "particle": ("particle", number, {"long_name": "number of the particle"}),
            "body": ("particle", names[body], {"long_name": "body that the particle is of"}),
        }
        return Dataset(frames, coordinates, attributes)


class _Frames(BackendArray):
    """One quantity in the file of a film, as xarray indexes it."""

    dtype = np.dtype(np.float32)

    def __init__(self, path: str, name: str, shape: tuple[int, ...]):
        self._path, self._name, self.shape = path, name, shape

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        support = indexing.IndexingSupport.BASIC
        return indexing.explicit_indexing_adapter(key, self.shape, support, self._read)

    def _read(self, key: tuple[int | slice, ...]) -> np.ndarray:
        with np.load(self._path) as saved:
            values: np.ndarray = saved[self._name][key]
        return values
