"""A cube as Zarr and as a table; called by the command line, and by the service in a child process."""

from pathlib import Path
from typing import TYPE_CHECKING

from studies.quantities.files import write_text, zipped
from studies.quantities.findings import MissingExtra

if TYPE_CHECKING:
    from xarray import Dataset


def export_zarr(dataset: "Dataset", out: Path) -> Path:
    """Write a cube as a Zarr store: a folder, or one file where the name ends in ``.zip``. Raises MissingExtra.

    Zarr 2 with consolidated metadata, which every reader knows: strings are no part of the specification of Zarr 3 yet.
    """
    try:
        import zarr  # noqa: F401 # xarray would import it later
    except ImportError as error:
        raise MissingExtra(f"Zarr needs more libraries ({error}): pip install 'whipple[zarr]'") from None
    plain = dataset.load().drop_encoding()  # chunks and filters of NetCDF mean nothing here
    plain.attrs.pop("digest", None)  # of the file that it was read from
    if out.suffix == ".zip":
        return zipped(lambda folder: plain.to_zarr(folder, zarr_format=2, consolidated=True), out)
    plain.to_zarr(out, mode="w", zarr_format=2, consolidated=True)
    return out


def export_csv(dataset: "Dataset", out: Path) -> Path:
    """Write the runs of a cube as a table with every column."""
    from studies.cubes.runs_table import runs_csv

    return write_text(out, runs_csv(dataset, every_column=True))
