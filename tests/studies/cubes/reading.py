"""What a person meets who opens a cube: results first, short labels, fixed parameters, times, a table of runs."""

import csv
import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr

from studies.cubes import cube
from studies.cubes.runs_table import runs_csv
from studies.cubes.variable import GROUPS, LONGEST_LABEL
from tests.rows import Row, at_most, equal
from tests.studies.support import compliance, fakes

SHOWN = 6  # variables before the dots where xarray prints a dataset


def checks(folder: Path) -> Iterator[Row]:
    """Facts about the file of a refined sweep with laws, shots and histories."""
    sweep = fakes.refined_holes()
    results = fakes.with_trouble(sweep)
    built = cube.build(sweep, results, fakes.catalogue(observations=fakes.SHOTS))
    file = cube.write(built, folder / "cube.nc")
    with xr.open_dataset(file) as dataset:
        yield from _order(dataset)
        yield from _labels(dataset)
        yield from _coordinates(dataset)
        yield from _table(dataset, len(sweep.runs()))
    yield equal("complaints of the CF checker", expected=0, got=len(compliance.complaints(file)))


def _order(dataset: xr.Dataset) -> Iterator[Row]:
    shown = [str(name) for name in dataset.data_vars][:SHOWN]
    not_results = [name for name in shown if dataset[name].attrs["group"] != "result"]
    yield equal("variables printed first that are no results", expected=0, got=len(not_results))
    expected = ["hole_diameter", "hole_diameter_reading_uncertainty", "hole_diameter_converged"]
    yield equal("the first three are the laws' quantity", expected=1, got=int(shown[:3] == expected))
    groups = [GROUPS.index(array.attrs["group"]) for array in dataset.data_vars.values()]
    yield equal("variables behind a later group", expected=0, got=int((np.diff(groups) < 0).sum()))


def _labels(dataset: xr.Dataset) -> Iterator[Row]:
    names = [str(array.attrs["long_name"]) for array in dataset.variables.values()]
    yield at_most("longest long_name (characters)", limit=LONGEST_LABEL, got=max(map(len, names)))
    parameters = json.loads(dataset.attrs["vocabulary"])["parameters"]
    kept = {str(each.attrs.get("comment") or each.attrs["long_name"]) for each in dataset.values()}
    meanings = [meaning for _, meaning in json.loads(dataset.attrs["vocabulary"])["quantities"].values()]
    yield equal("definitions of quantities that are lost", expected=0, got=len(set(meanings) - kept))
    lost = [
        name
        for name, (_, _, meaning) in parameters.items()
        if name in dataset and meaning not in dataset[name].attrs.values()
    ]
    yield equal("definitions of parameters that are lost", expected=0, got=len(lost))


def _coordinates(dataset: xr.Dataset) -> Iterator[Row]:
    fixed = json.loads(dataset.attrs["sweep"])["fixed"]
    scalars = [name for name in fixed if name in dataset.coords and not dataset[name].dims]
    yield equal("fixed parameters that are scalar coordinates", expected=len(fixed), got=len(scalars))
    history = dataset.hole_diameter_history
    yield equal("histories have the coordinate of time", expected=1, got=int("history_time" in history.coords))
    gaps = history.notnull() & dataset.history_time.isnull()
    yield equal("values of a history without a time", expected=0, got=int(gaps.sum()))


def _table(dataset: xr.Dataset, runs: int) -> Iterator[Row]:
    rows = list(csv.DictReader(runs_csv(dataset).splitlines()))
    yield equal("rows of runs.csv", expected=runs, got=len(rows))
    wrong = 0
    for row in rows:
        axes = ("speed [m s-1]", "cells_per_diameter", "offset")
        place = {heading.partition(" ")[0]: float(row[heading]) for heading in axes}
        cell = dataset.sel(place)
        value = float(row["hole_diameter [m]"] or "nan")
        same = np.array_equal(value, cell.hole_diameter.item(), equal_nan=True)
        wrong += not (same and row["run_id"] == cell.run_id.item())
    yield equal("rows that differ from their cells", expected=0, got=wrong)
