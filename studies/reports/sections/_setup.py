"""Computes the section of the set-up."""

import json
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress

import numpy as np
import xarray as xr

from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.points import by_run, main_quantities, plain
from studies.cubes.reading import finite
from studies.cubes.variable import variable_name
from studies.cubes.variables import STATES
from studies.quantities.findings import InvalidInput
from studies.quantities.measured import flags_in_words
from studies.reports.section import Part, Source
from studies.reports.sections.setup import Constant, Fixed, MaterialUsed, SetUp, StateCount
from studies.sweeps.reading import ACCEPTED, RESOLUTION
from studies.sweeps.sweep import Sweep
from studies.sweeps.warnings import doubtful_constants


def setup_of(source: Source) -> Part:
    """The section."""
    dataset = source.dataset
    states = cubes.RUN_STATE.of(dataset).values.ravel()
    counts = Counter(STATES[state] for state in states)
    doubted, flagged = doubted_runs(dataset), np.array([bool(flags) for flags in flags_of_runs(dataset)])
    valued = np.isfinite([by_run(dataset, name) for name in main_quantities(dataset)]).any(axis=0)
    document = json.loads(dataset.attrs["sweep"])
    return Part(
        SetUp(
            runs=len(states),
            states=tuple(StateCount(state, counts[state]) for state in STATES if counts[state]),
            flagged=int(doubted.sum()),
            flagged_elsewhere=int((flagged & ~doubted).sum()),
            without_value=int(((states == STATES.index("succeeded")) & ~valued).sum()),
            cells=_cells(dataset),
            accuracy=str(document.get("accuracy") or ""),
            asked=document.get("fixed", {}),
            fixed=tuple(_fixed(dataset)),
            doubts=_doubts(dataset),
            materials=tuple(_materials(dataset)),
        )
    )


def doubted_runs(dataset: xr.Dataset) -> np.ndarray:
    """Whether a run carries a flag on itself or on a main quantity, (runs,): its value is drawn as an open mark."""
    doubts = [cubes.FLAGS_OF_RUN.of(dataset).values.ravel() != 0]
    doubts += [reading.doubts(cubes.FLAGS.of(dataset, name)).values.ravel() != 0 for name in main_quantities(dataset)]
    return np.logical_or.reduce(doubts)


def flags_of_runs(dataset: xr.Dataset) -> list[list[str]]:
    """All flags of each run, those of a quantity with its name."""
    columns = {"": reading.flag_words(cubes.FLAGS_OF_RUN.of(dataset))}
    for name in reading.quantities_of(dataset):
        columns[f"{name.replace('_', ' ')}: "] = reading.flag_words(cubes.FLAGS.of(dataset, name))
    return [
        [f"{quantity}{flag}" for quantity, column in columns.items() for flag in flags_in_words(column[number])]
        for number in range(dataset.run_state.size)
    ]


def _cells(dataset: xr.Dataset) -> tuple[float, float] | None:
    if RESOLUTION not in dataset:
        return None
    cells = by_run(dataset, RESOLUTION)
    cells = cells[np.isfinite(cells)]
    return (float(cells.min()), float(cells.max())) if cells.size else None


def _fixed(dataset: xr.Dataset) -> Iterator[Fixed]:
    """Parameters that all runs share."""
    parameters = json.loads(dataset.attrs["vocabulary"])["parameters"]
    for parameter, (_, unit, meaning) in parameters.items():
        name = variable_name(parameter)
        if name in dataset and not dataset[name].dims:
            value = finite(plain(dataset[name].item()))
            if value not in (None, ""):
                yield Fixed(parameter, value, unit, meaning)


def _doubts(dataset: xr.Dataset) -> tuple[str, ...]:
    """Doubts about the constants of a sweep; none of a sweep of another version."""
    with suppress(InvalidInput):
        return tuple(doubtful_constants(Sweep.parse(json.loads(dataset.attrs["sweep"]), ACCEPTED)))
    return ()


def _materials(dataset: xr.Dataset) -> Iterator[MaterialUsed]:
    for name, material in json.loads(dataset.attrs["materials"]).items():
        numbers = (
            Constant(path, *(number[key] for key in ("value", "unit", "source", "confidence")))
            for path, number in material["numbers"].items()
        )
        yield MaterialUsed(name, material["title"], tuple(numbers))
