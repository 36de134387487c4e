"""A cube of a service, opened remotely: the parts of the file that are accessed are loaded."""

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING

from studies.quantities.findings import MissingExtra

if TYPE_CHECKING:
    from studies.cubes.opening import DataTree

BLOCK = 1 << 18  # bytes per request


def open_remote(url: str, headers: Mapping[str, str]) -> "DataTree":
    """The dataset at an address; closing it closes the connection. Raises MissingExtra and InvalidInput."""
    try:
        import fsspec

        # fsspec and xarray would import these later.
        for name in ("aiohttp", "h5netcdf"):
            import_module(name)
    except ImportError as error:
        raise MissingExtra(
            f"opening a cube remotely needs more libraries ({error}): pip install 'whipple[remote]'; or fetch the cube"
        ) from None
    from studies.cubes.opening import open_file

    file = fsspec.open(url, cache_type="blockcache", block_size=BLOCK, headers=dict(headers))
    return open_file(file.open(), url)
