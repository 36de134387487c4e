"""Computes the sections of the set-up and of the runs."""

import json
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import suppress

import numpy as np
import xarray as xr

from studies.cubes import audit, reading
from studies.cubes import variables as cubes
from studies.cubes.points import axes_of, by_run, main_quantities, places_of, plain
from studies.cubes.reading import finite
from studies.cubes.variable import variable_name
from studies.cubes.variables import STATES
from studies.quantities.findings import InvalidInput
from studies.quantities.measured import flags_in_words
from studies.quantities.parameters import Plain
from studies.reports.figures import of_runs
from studies.reports.section import Part, Source
from studies.reports.sections.runs import Audited, ListedRun, Runs
from studies.reports.sections.setup import Constant, Fixed, MaterialUsed, SetUp, StateCount
from studies.reports.wording import words
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
            doubts=_doubts(document),
            materials=tuple(_materials(dataset)),
        )
    )


def _doubts(document: Mapping[str, Plain]) -> tuple[str, ...]:
    """Doubts about the constants of a sweep; none of a sweep that is no longer read, as where its feature is gone."""
    with suppress(InvalidInput):
        return tuple(doubtful_constants(Sweep.parse(document, ACCEPTED)))
    return ()


def doubted_runs(dataset: xr.Dataset) -> np.ndarray:
    """Whether a run carries a flag on itself or on a main quantity, (runs,): its value is drawn as an open mark."""
    doubts = [cubes.FLAGS_OF_RUN.of(dataset).values.ravel() != 0]
    doubts += [reading.doubts(cubes.FLAGS.of(dataset, name)).values.ravel() != 0 for name in main_quantities(dataset)]
    return np.logical_or.reduce(doubts)


def flags_of_runs(dataset: xr.Dataset) -> list[list[str]]:
    """All flags of each run, those of a quantity with its name."""
    columns = {"": reading.flag_words(cubes.FLAGS_OF_RUN.of(dataset))}
    for name in reading.quantities_of(dataset):
        columns[f"{words(name)}: "] = reading.flag_words(cubes.FLAGS.of(dataset, name))
    return [
        [f"{quantity}{flag}" for quantity, column in columns.items() for flag in flags_in_words(column[number])]
        for number in range(dataset.run_state.size)
    ]


def _cells(dataset: xr.Dataset) -> tuple[float, float] | None:
    """The fewest and the most cells; None where a run has none."""
    cells = by_run(dataset, RESOLUTION) if RESOLUTION in dataset else np.empty(0)
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


def _materials(dataset: xr.Dataset) -> Iterator[MaterialUsed]:
    for name, material in json.loads(dataset.attrs["materials"]).items():
        numbers = (
            Constant(path, *(number[key] for key in ("value", "unit", "source", "confidence")))
            for path, number in material["numbers"].items()
        )
        yield MaterialUsed(name, material["title"], tuple(numbers))


# ---- runs ----------------------------------------------------------------------------------------


def runs_of(source: Source) -> Part:
    """The section, with growth and convergence as figures of the appendix."""
    record = Runs(tuple(_runs(source.dataset)), tuple(_audit(source.dataset)))
    return Part(record, of_runs(source.dataset, source.comparison))


def _runs(dataset: xr.Dataset) -> Iterator[ListedRun]:
    columns = {name: by_run(dataset, name) for name in _run_variables(dataset)}
    ids, reasons, failures, stops, states = (
        variable.of(dataset).values.ravel()
        for variable in (cubes.RUN_ID, cubes.RUN_REASON, cubes.RUN_FAILURE, cubes.STOP_REASON, cubes.RUN_STATE)
    )
    flags, doubted = flags_of_runs(dataset), doubted_runs(dataset)
    for number, place in enumerate(places_of(dataset)):
        yield ListedRun(
            number=number,
            at=place,
            state=STATES[states[number]],
            id=str(ids[number]),
            reason=str(reasons[number]),
            failure=str(failures[number]),
            stop=str(stops[number]),
            flags=tuple(flags[number]),
            doubted=bool(doubted[number]),
            values={name: finite(float(column[number])) for name, column in columns.items()},
        )


def _run_variables(dataset: xr.Dataset) -> list[str]:
    """Numbers that a run has one of: quantities, uncertainties, audit, time, diameter."""
    axes = set(axes_of(dataset))
    return [
        str(name)
        for name, array in dataset.variables.items()
        if array.dtype.kind == "f"
        and name not in axes
        and (array.dims == dataset.run_state.dims or name == cubes.EQUIVALENT_DIAMETER.name)
    ]


def _audit(dataset: xr.Dataset) -> Iterator[Audited]:
    places = places_of(dataset)
    for number in audit.audit_numbers():
        name, limit = number.variable.name, number.limit
        if number.shown and name in dataset and np.isfinite(dataset[name]).any():
            values = dataset[name].values.ravel()
            yield Audited(
                variable=name,
                label=words(number.name),
                meaning=number.meaning,
                unit=number.unit,
                is_share=number.share,
                smallest=float(np.nanmin(values)),
                median=float(np.nanmedian(values)),
                largest=float(np.nanmax(values)),
                farthest_at=places[int(np.nanargmax(np.abs(values)))],
                limit=limit,
                over_limit=None if limit is None else int((np.abs(values) > limit).sum()),
            )
