"""Opens a cube where it lies: a path, or a file that somebody else holds open."""

from contextlib import ExitStack
from typing import BinaryIO

import xarray as xr
from xarray import Dataset

__all__ = ["Dataset", "open_file"]


def open_file(file: BinaryIO) -> Dataset:
    """The dataset in an open file, read as it is looked at; closing it closes the file."""
    with ExitStack() as ends:
        ends.callback(file.close)
        inner = xr.open_dataset(file, engine="h5netcdf")
        ends.callback(inner.close)
        dataset = inner.copy()
        dataset.set_close(ends.pop_all().close)
    return dataset
