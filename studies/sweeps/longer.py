"""A sweep with more values on one of its axes."""

from collections.abc import Sequence
from dataclasses import replace

from studies.observations import written
from studies.quantities.findings import refusal
from studies.quantities.parameters import Plain, Value
from studies.sweeps.reading import ACCEPTED, RESOLUTION
from studies.sweeps.sweep import Sweep


def with_values(sweep: Sweep, name: str, added: Sequence[Plain]) -> Sweep:
    """The sweep with more values on an axis, or more resolutions; raises InvalidInput. What ascends still does."""
    document = sweep.document()
    document.pop("cells", None)  # of other points
    if name == RESOLUTION and sweep.resolutions:
        document["resolution"] = [*sweep.resolutions, *added]
        return Sweep.parse(document, ACCEPTED)
    axis = next((axis for axis in sweep.axes if axis.name == name), None)
    if axis is None or sweep.combine != "grid" or axis.search:
        limit = "an axis with values of its own, of a sweep with combine: grid"
        raise refusal("axis", name, limit, "submit another sweep")
    written_axes = {other.name: other.document() for other in sweep.axes}
    document["axes"] = {**written_axes, name: [*(written(value, axis.unit) for value in axis.values), *added]}
    longer = Sweep.parse(document, ACCEPTED)
    if list(axis.values) != sorted(axis.values, key=_by_size):
        return longer
    axes = (replace(a, values=tuple(sorted(a.values, key=_by_size))) if a.name == name else a for a in longer.axes)
    return replace(longer, axes=tuple(axes))


def _by_size(value: Value) -> tuple[bool, float, str]:
    """The order of numbers by size, and of words after them."""
    return (True, 0.0, str(value)) if isinstance(value, str) or value is None else (False, float(value), "")
