"""Computes the section of runs and their audit."""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from studies.cubes import audit
from studies.cubes import variables as cubes
from studies.cubes.points import axes_of, by_run, places_of
from studies.cubes.reading import finite
from studies.cubes.variables import STATES
from studies.reports.figures import of_runs
from studies.reports.section import Part, Source
from studies.reports.sections._setup import doubted_runs, flags_of_runs
from studies.reports.sections.runs import Audited, ListedRun, Runs


def runs_of(source: Source) -> Part:
    """The section, with growth and convergence as figures of the appendix."""
    record = Runs(tuple(_runs(source.dataset)), tuple(_audit(source.dataset)))
    return Part(record, of_runs(source.dataset, source.comparison))


def _runs(dataset: xr.Dataset) -> Iterator[ListedRun]:
    columns = {name: by_run(dataset, name) for name in _run_variables(dataset)}
    texts = {
        key: variable.of(dataset).values.ravel()
        for key, variable in (
            ("id", cubes.RUN_ID),
            ("reason", cubes.RUN_REASON),
            ("failure", cubes.RUN_FAILURE),
            ("stop", cubes.STOP_REASON),
        )
    }
    flags, doubted = flags_of_runs(dataset), doubted_runs(dataset)
    states = cubes.RUN_STATE.of(dataset).values.ravel()
    for number, place in enumerate(places_of(dataset)):
        values = {name: finite(float(column[number])) for name, column in columns.items()}
        yield ListedRun(
            number=number,
            at=place,
            state=STATES[states[number]],
            **{key: str(column[number]) for key, column in texts.items()},
            flags=tuple(flags[number]),
            doubted=bool(doubted[number]),
            values=values,
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
                label=number.name.replace("_", " "),
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
