"""A cube of a service, opened where it is: parts of the file are loaded as they are looked at."""

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING

from studies.values.errors import MissingExtra

if TYPE_CHECKING:
    from studies.values.opening import Dataset

BLOCK = 1 << 18  # bytes asked for at once


def open_remote(url: str, headers: Mapping[str, str]) -> "Dataset":
    """The dataset at an address; closing it closes the connection. Raises MissingExtra."""
    try:
        import fsspec

        for name in ("aiohttp", "h5netcdf"):  # fsspec and xarray would ask for them later
            import_module(name)
    except ImportError as error:
        raise MissingExtra(
            f"opening a cube where it is needs more libraries ({error}): pip install 'whipple[remote]'; "
            "or fetch it"
        ) from None
    from studies.values.opening import open_file

    there = fsspec.open(url, cache_type="blockcache", block_size=BLOCK, headers=dict(headers))
    return open_file(there.open())
