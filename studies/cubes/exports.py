"""A cube as tables and as Zarr; called by the command line, by publishing, and by the service in a child process.

``runs.csv`` has one row a run, in SI with the unit of each column in its heading; ``runs-all.csv`` is the same table
with every column.
"""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from studies.cubes import points, reading
from studies.cubes import variables as declared
from studies.cubes.groups import as_tree
from studies.cubes.long_texts import short_texts
from studies.quantities.files import zipped
from studies.quantities.findings import MissingExtra

RUN_COLUMNS = (declared.RUN_ID, declared.RUN_STATE, declared.RUN_REASON, declared.FLAGS_OF_RUN)


def runs_csv(dataset: xr.Dataset, *, every_column: bool = False) -> str:
    """The table as CSV: run, axes, and value, uncertainty and flags of each main quantity.

    With ``every_column`` also all other results, parts of uncertainties, other parameters and the audit. Numbers have
    every digit; an empty cell has no value. States and flags are words, several separated by spaces. Laws and converged
    values belong to points, not to runs: they are in the cube alone, and so is the full text of a deck.
    """
    columns = {
        _heading(dataset, name): _column(dataset, name)
        for name in (_every_name if every_column else _main_names)(dataset)
    }
    return pd.DataFrame(columns).to_csv(index=False, lineterminator="\n")


def _first_names(dataset: xr.Dataset) -> list[str]:
    """Identity, state, reason of a failure and flags of a run, and its place on the axes."""
    axes = (*str(dataset.attrs["axes"]).split(), *str(dataset.attrs["refinements"]).split())
    return [*(variable.named() for variable in RUN_COLUMNS), *axes]


def _main_names(dataset: xr.Dataset) -> list[str]:
    """The variables that a person reads, of each run."""
    of_quantity = (declared.VALUE, declared.UNCERTAINTY, declared.OVER_DIAMETER, declared.FLAGS)
    quantities = points.main_quantities(dataset)
    named = (v.named(name) for name in quantities for v in of_quantity if v.is_in(dataset, name))
    return [*_first_names(dataset), *named]


def _every_name(dataset: xr.Dataset) -> list[str]:
    """The variables with one value a run: identity, axes, what the root of the cube has, then group by group."""
    runs = dataset.run_state.dims
    of_runs = [
        str(name)
        for name, array in dataset.variables.items()
        if array.dims == runs or (array.attrs["group"] == "inputs" and {*array.dims} <= {*runs})
    ]
    return list(dict.fromkeys([*_first_names(dataset), *of_runs]))


def _column(dataset: xr.Dataset, name: str) -> np.ndarray:
    """The values of a variable for each run, (runs,); flags in words."""
    array = dataset[name]
    values = reading.by_run(dataset, array.variable).ravel()
    if array.dtype.kind in "OUT":
        short = short_texts(dataset[[name]])
        return np.array([short.get(text, text) for text in values], object)
    if "flag_masks" in array.attrs:
        return np.array([" ".join(words) for words in reading.flag_words(array)], object)
    if "flag_meanings" in array.attrs:
        return np.array(array.attrs["flag_meanings"].split(), object)[values]
    return values


def _heading(dataset: xr.Dataset, name: str) -> str:
    """A name with its unit, as a table of shots has it: "speed [m s-1]"."""
    unit = dataset[name].attrs.get("units", "1")
    return name if unit == "1" else f"{name} [{unit}]"


def export_zarr(dataset: xr.Dataset, out: Path) -> Path:
    """Write a cube as a Zarr store: a folder, or one file where the name ends in ``.zip``. Raises MissingExtra.

    Zarr 2 with consolidated metadata, which every reader knows: strings are no part of the specification of Zarr 3 yet.
    """
    try:
        import zarr  # noqa: F401 # xarray would import it later
    except ImportError as error:
        raise MissingExtra(f"Zarr needs more libraries ({error}): pip install 'whipple[zarr]'") from None
    tree = as_tree(dataset.load().drop_encoding())  # chunks and filters of NetCDF mean nothing here
    tree.attrs.pop("digest", None)  # of the file that it was read from
    if out.suffix == ".zip":
        return zipped(lambda folder: tree.to_zarr(folder, zarr_format=2, consolidated=True), out)
    tree.to_zarr(out, mode="w", zarr_format=2, consolidated=True)
    return out
