"""A sweep as the document that is read as itself."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from studies.observations import AllowedNames, written
from studies.sweeps.accuracy import in_percent
from studies.sweeps.axes import Axis
from studies.sweeps.reading import END

if TYPE_CHECKING:
    from studies.sweeps.sweep import Sweep


def document_of(sweep: "Sweep", terms: AllowedNames, cells: Iterable[float | None]) -> dict[str, Any]:
    """A sweep as plain values that ``Sweep.parse`` reads as itself; ``cells`` are what its accuracy chose."""
    document: dict[str, Any] = {
        "name": sweep.name,
        "title": sweep.title,
        "scenario": sweep.scenario,
        "fixed": {name: written(value, terms.parameters[name].unit) for name, value in sweep.fixed.items()},
        "axes": {axis.name: _written_axis(axis) for axis in sweep.axes},
        "combine": sweep.combine,
        "points": sweep.sampling.points if sweep.sampling else None,
        "seed": sweep.sampling.seed if sweep.sampling else None,
        "resolution": list(sweep.resolutions) if len(sweep.resolutions) > 1 else next(iter(sweep.resolutions), None),
        "offsets": sweep.offsets if sweep.offsets > 1 else None,
        "accuracy": None if sweep.accuracy is None else in_percent(sweep.accuracy),
        "cells": None if sweep.accuracy is None else [*cells],
        "materials": {name: each.document() for name, each in sweep.materials.items()},
        "observations": [each.document(terms) for each in sweep.observations],
        "laws": [each.document() for each in sweep.laws],
        "model_part": None if sweep.model_part == "stored" else sweep.model_part,
        "ends": [
            {name: written(value, terms.parameters[name].unit) for name, value in {**at, END: end}.items()}
            for at, end in sweep.ends
        ],
    }
    return {key: value for key, value in document.items() if value not in (None, {}, [])}


def _written_axis(axis: Axis) -> Any:
    """An axis as a document writes it: its values, and the ends of its range where it is sampled."""
    if axis.search:
        low, high, tolerance = (
            written(value, axis.unit) for value in (axis.search.low, axis.search.high, axis.search.tolerance)
        )
        until = axis.search.until
        width = {"tolerance": tolerance} if until is None else {"until": until}
        return {"limit_of": axis.search.quantity, "between": [low, high], **width}
    values = [written(value, axis.unit) for value in axis.values]
    if axis.bounds is None:
        return values
    low, high = (written(end, axis.unit) for end in axis.bounds)
    return {"low": low, "high": high, "values": values}
