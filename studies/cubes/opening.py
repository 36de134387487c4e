"""Cubes opened: the tree of a file, as it is looked at, or all of it in one dataset."""

import hashlib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import BinaryIO

import xarray as xr
from xarray import DataTree

from studies.cubes.groups import joined
from studies.cubes.variables import SCHEMA_VERSION
from studies.quantities.files import CUBE
from studies.quantities.findings import refusal


def whole_cube(path: Path) -> xr.Dataset:
    """All variables of the cube of a file in one dataset, in memory; raises InvalidInput where it is none."""
    with open_tree(path) as tree:
        loaded = joined(tree).load()
    file = path / CUBE if path.is_dir() else path
    return loaded.assign_attrs(digest=hashlib.sha256(file.read_bytes()).hexdigest())


def open_tree(path: Path) -> xr.DataTree:
    """The cube of a file, read as it is looked at; raises InvalidInput where it is none."""
    from studies.sweeps.document import no_such_cube

    file = path / CUBE if path.is_dir() else path
    if not file.exists():
        raise no_such_cube(file)
    with _refusing(file):
        return _checked(xr.open_datatree(file, engine="netcdf4"))


def open_file(file: BinaryIO, place: str) -> DataTree:
    """The cube in an open file, read as it is looked at; closing it closes the file.

    ``place`` is where it is, for errors. Raises InvalidInput where it is no cube.
    """
    with ExitStack() as ends, _refusing(place):
        ends.callback(file.close)
        inner = xr.open_datatree(file, engine="h5netcdf")
        ends.callback(inner.close)
        tree = _checked(inner).copy()
        tree.set_close(ends.pop_all().close)
        return tree


@contextmanager
def _refusing(place: Path | str) -> Iterator[None]:
    """Refuse what is no cube, or one of another layout."""
    try:
        yield
    except (OSError, ValueError) as error:
        cure = f"give cube.nc of a sweep, or its folder: {error}"
        raise refusal("CUBE", str(place), "the cube of a sweep", cure) from None


def _checked(tree: xr.DataTree) -> xr.DataTree:
    """A tree that is a cube of the present layout; raises ValueError for any other."""
    if "quantities" not in tree.attrs or "sweep" not in tree.attrs:
        raise ValueError("no sweep is in it")
    if (version := int(tree.attrs.get("schema_version", 0))) != SCHEMA_VERSION:
        raise ValueError(f"this one has layout {version}, and {SCHEMA_VERSION} is read: compute its sweep again")
    if "runs" not in tree.children:
        raise ValueError("this one has all variables in one group, as before 0.1.0: compute its sweep again")
    for group in tree.subtree:
        for axis in group.coords.values():
            axis.encoding["_FillValue"] = None  # else xarray gives it one where a group is written again
    return tree
