"""Computes the section of the model part."""

from collections import Counter
from collections.abc import Iterator

import numpy as np
import xarray as xr

from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.points import by_run
from studies.cubes.reading import finite
from studies.cubes.variable import Variable
from studies.reports.section import Part, Source
from studies.reports.sections.models import ModelPart, Models, Side
from studies.sweeps.screening import CONTRIBUTIONS


def models_of(source: Source) -> Part | None:
    """The section; None where no run states any."""
    parts = tuple(_parts(source.dataset))
    return Part(Models(parts)) if parts else None


def _parts(dataset: xr.Dataset) -> Iterator[ModelPart]:
    """Each statement with the runs that it is about."""
    for quantity in reading.quantities_of(dataset):
        shares = {name: _by_run(dataset, cubes.model_contribution(name), quantity) for name in CONTRIBUTIONS}
        factors = _by_run(dataset, cubes.MODEL_DISTANCE, quantity)
        texts = by_run(dataset, cubes.MODEL_REASON.named(quantity)).astype(str)
        for text, count in Counter(filter(None, texts.tolist())).items():
            mine = texts == text
            distances = factors[mine & np.isfinite(factors)]
            yield ModelPart(
                quantity=quantity,
                statement=text,
                contributions={name: finite(float(share[mine][0])) for name, share in shares.items()},
                lower=_side(dataset, quantity, cubes.MODEL_SIDES[0], mine),
                upper=_side(dataset, quantity, cubes.MODEL_SIDES[1], mine),
                thrown_out=_thrown_out(dataset, quantity, mine),
                distance=float(distances.max()) if distances.size else None,
                runs=count,
            )


def _side(dataset: xr.Dataset, quantity: str, side: tuple[Variable, Variable], mine: np.ndarray) -> Side | None:
    sizes, values = _by_run(dataset, side[0], quantity)[mine], by_run(dataset, quantity)[mine]
    if not np.isfinite(sizes[0]):
        return None
    failure = by_run(dataset, side[1].named(quantity))[mine][0]
    return Side(abs(float(sizes[0] / values[0])) if values[0] else None, str(failure))


def _thrown_out(dataset: xr.Dataset, quantity: str, mine: np.ndarray) -> tuple[str, ...]:
    if not cubes.MODEL_THROWN_OUT.is_in(dataset, quantity):
        return ()
    names = by_run(dataset, cubes.MODEL_THROWN_OUT.named(quantity))[mine][0]
    return tuple(name for name in str(names).split(cubes.BETWEEN_FAILURES) if name)


def _by_run(dataset: xr.Dataset, variable: Variable, quantity: str) -> np.ndarray:
    """A number of a quantity for each run, (runs,); NaN where no run has it."""
    if not variable.is_in(dataset, quantity):
        return np.full(dataset.run_state.size, np.nan)
    return by_run(dataset, variable.named(quantity))
