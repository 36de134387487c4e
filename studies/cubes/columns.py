"""What a sweep's runs say, as columns of the cube: names and values, one kind a function.

Names, dimensions and units are declared in :mod:`studies.cubes.variables`; here are the values alone.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from studies.convergence.richardson import VERDICTS, Convergence, Sample, converge
from studies.cubes.catalogue import Catalogue, Observed
from studies.cubes.layout import Cell, Layout, floats, labels, shared
from studies.cubes.variables import (
    NUMBERS,
    STATES,
    Quantity,
    SchemaError,
    Vocabulary,
    variable_name,
)
from studies.sweeps.sweep import RESOLUTION
from studies.values.parameters import Parameter

RUN_FLAGS = (
    "under_resolved",
    "energy_drift",
    "runaway_particles",
    "below_zero_kelvin",
    "beyond_hugoniot",
)
HISTORY_SAMPLES = 256  # of a run: a curve on paper shows no more
HISTORY_VALUES = 1_000_000  # of a quantity over all runs: 8 MB before compression
FLAG_BITS = 31  # of a signed 32-bit integer
SUB_CELL = "resolution"  # part of an uncertainty: what a single run cannot see, and offsets show

Column = tuple[str, Any]  # the name of a variable and its values


@dataclass(frozen=True)
class Mask:
    """Flags of each cell as bits, and what each bit means."""

    values: np.ndarray  # int32
    meanings: tuple[str, ...]


def all_columns(layout: Layout, words: Vocabulary, catalogue: Catalogue) -> Iterator[Column]:
    """Every column of a cube."""
    yield from of_parameters(layout, words)
    yield from of_runs(layout)
    yield from of_numbers(layout)
    for quantity in words.quantities.values():
        yield from of_quantity(layout, quantity, words)
        yield from of_history(layout, quantity.name)
        yield from of_convergence(layout, quantity.name)
        yield from of_laws(layout.points, quantity.name, catalogue)
    yield from of_observations(words, catalogue)


# ---- parameters and runs -------------------------------------------------------------------------


def of_parameters(layout: Layout, words: Vocabulary) -> Iterator[Column]:
    """Coordinates of the axes, and each other parameter: a scalar where all runs share it."""
    axes = {axis.name: axis for axis in (*layout.axes, *layout.refinements)}
    for name, parameter in words.parameters.items():
        if name in axes:
            yield variable_name(name), _column(parameter, _axis_values(axes[name], layout))
            continue
        values = [cell.run.parameters.get(name) for cell in layout.cells]
        if any(value is not None for value in values):
            yield variable_name(name), _compact(_column(parameter, values), layout)


def _axis_values(axis: Any, layout: Layout) -> Sequence[Any]:
    if layout.grid or axis in layout.refinements:
        return axis.values
    return [cell.coordinates[axis.name] for cell in layout.points.cells]


def _column(parameter: Parameter, values: Iterable[Any]) -> np.ndarray:
    return labels(values) if parameter.unit is None else floats(values)


def _compact(values: np.ndarray, layout: Layout) -> np.ndarray:
    """Values by cell: a scalar where all are equal, an array over points or runs otherwise."""
    if shared(list(values)):
        return np.array(values[0], values.dtype)
    filled = np.empty(layout.shape, values.dtype)
    for cell, value in zip(layout.cells, values, strict=True):
        filled[cell.index] = value
    by_point = filled.reshape(*layout.points.shape, -1)
    return by_point[..., 0] if (by_point == by_point[..., :1]).all() else filled


def of_runs(layout: Layout) -> Iterator[Column]:
    """Identity, state, reason, flags and cost of each run."""
    if not layout.grid:
        yield "run", np.arange(layout.shape[0], dtype=np.int32)
    yield "run_id", layout.texts(lambda cell: cell.run.id)
    yield "run_state", layout.integers(lambda cell: STATES.index(cell.state), np.int8)
    yield "run_reason", layout.texts(lambda cell: cell.reason)
    yield "run_failure", layout.texts(lambda cell: getattr(cell.result, "failure", None))
    yield "run_flags", _mask(layout, RUN_FLAGS, lambda cell: getattr(cell.result, "flags", ()))
    yield "stop_reason", layout.texts(lambda cell: getattr(cell.result, "stop", None))
    yield "solver_seconds", layout.numbers(lambda cell: cell.provenance.get("seconds"))
    yield "solver_threads", layout.numbers(lambda cell: cell.provenance.get("threads"))
    diameters = floats(getattr(cell.shot, "projectile_diameter", None) for cell in layout.cells)
    if np.isfinite(diameters).any():
        yield "equivalent_diameter", _compact(diameters, layout)


def _mask(layout: Layout, declared: Sequence[str], pick: Callable[[Cell], Iterable[str]]) -> Mask:
    """Bits in the order of the declared flags; CF wants at least one meaning."""
    found = {flag for cell in layout.cells for flag in pick(cell)}
    meanings = (*declared, *sorted(found - set(declared))) or ("flagged",)
    if len(meanings) > FLAG_BITS:
        raise SchemaError(
            f"{len(meanings)} different flags do not fit into {FLAG_BITS} bits: {meanings}"
        )
    bit = {flag: 1 << place for place, flag in enumerate(meanings)}
    return Mask(
        layout.integers(lambda cell: sum(bit[flag] for flag in set(pick(cell))), np.int32), meanings
    )


def of_numbers(layout: Layout) -> Iterator[Column]:
    """The audit; a number that is not declared stays out: see :func:`undeclared`."""
    for variable in NUMBERS:
        name = variable.name.removeprefix("audit_")
        if any(name in cell.numbers for cell in layout.cells):
            yield variable.name, layout.numbers(_picker(name))


def _picker(name: str) -> Callable[[Cell], float | None]:
    return lambda cell: cell.numbers.get(name)


def undeclared(layout: Layout) -> list[str]:
    """Names of numbers that runs carry and no one has declared."""
    declared = {variable.name.removeprefix("audit_") for variable in NUMBERS}
    return sorted({name for cell in layout.cells for name in cell.numbers} - declared)


# ---- measurements --------------------------------------------------------------------------------


def of_quantity(layout: Layout, quantity: Quantity, words: Vocabulary) -> Iterator[Column]:
    """Value, uncertainty and its parts, and flags of one quantity."""
    name = quantity.name
    measured = {cell.index: cell.measurements.get(name) for cell in layout.cells}

    def numbers(pick: Callable[[Any], float | None]) -> np.ndarray:
        found = {index: pick(one) for index, one in measured.items() if one is not None}
        return layout.numbers(lambda cell: found.get(cell.index))

    yield name, numbers(lambda one: one.value)
    yield f"{name}_uncertainty", numbers(lambda one: one.uncertainty)
    yield (
        f"{name}_flags",
        _mask(layout, (), lambda cell: getattr(measured[cell.index], "flags", ())),
    )
    for part in words.parts.get(name, ()):
        yield f"{name}_uncertainty_{part}", numbers(partial(_part, part))


def _part(name: str, measured: Any) -> float | None:
    return measured.parts.get(name)


def of_history(layout: Layout, quantity: str) -> Iterator[Column]:
    """Growth of a quantity, thinned evenly and padded with NaN to one length for all quantities."""
    samples = _samples(layout)
    if any(_history(cell, quantity, "time") for cell in layout.cells):
        yield f"{quantity}_history", _histories(layout, quantity, "value", samples)
        yield f"{quantity}_history_time", _histories(layout, quantity, "time", samples)


def _histories(layout: Layout, quantity: str, key: str, samples: int) -> np.ndarray:
    return layout.numbers(lambda cell: _padded(_history(cell, quantity, key), samples), samples)


def _history(cell: Cell, quantity: str, key: str) -> Sequence[float | None]:
    found = getattr(cell.measurements.get(quantity), "history", None) or {}
    return found.get(key, ())


def _samples(layout: Layout) -> int:
    lengths = (
        len(_history(cell, name, "time")) for cell in layout.cells for name in cell.measurements
    )
    allowed = max(8, HISTORY_VALUES // max(1, len(layout.cells)))
    return min(max(lengths, default=0), HISTORY_SAMPLES, allowed)


def _padded(values: Sequence[float | None], samples: int) -> np.ndarray:
    """``samples`` of the values, first and last among them."""
    known = floats(values)
    if len(known) > samples:
        known = known[np.linspace(0, len(known) - 1, samples).round().astype(int)]
    return np.pad(known, (0, samples - len(known)), constant_values=np.nan)


# ---- convergence ---------------------------------------------------------------------------------


def of_convergence(layout: Layout, quantity: str) -> Iterator[Column]:
    """What refinement makes of a quantity at each point, where there is any."""
    if not layout.refinements:
        return
    points = layout.points
    found = {place: converge_runs(runs, quantity) for place, runs in layout.refined().items()}
    name = f"{quantity}_converged"

    def numbers(pick: Callable[[Convergence], float]) -> np.ndarray:
        return points.numbers(lambda cell: pick(found[cell.index]))

    yield name, numbers(lambda one: one.value)
    yield f"{name}_uncertainty", numbers(lambda one: one.uncertainty)
    yield f"{name}_uncertainty_mesh", numbers(lambda one: one.mesh)
    yield f"{name}_uncertainty_offsets", numbers(lambda one: one.offsets)
    yield f"{name}_uncertainty_measurement", numbers(lambda one: one.measurement)
    yield f"{name}_order", numbers(lambda one: one.order)
    yield f"{name}_extrapolated", numbers(lambda one: one.extrapolated)
    yield f"{name}_gci", numbers(lambda one: one.gci)
    yield (
        f"{name}_verdict",
        points.integers(lambda cell: VERDICTS.index(found[cell.index].verdict), np.int8),
    )
    yield f"{name}_reason", points.texts(lambda cell: found[cell.index].reason)


def converge_runs(runs: Iterable[Cell], quantity: str) -> Convergence:
    """The verdict over the runs of one point."""
    return converge(_sample(cell, cell.measurements.get(quantity)) for cell in runs)


def _sample(cell: Cell, measured: Any | None) -> Sample:
    """A run as convergence sees it; one that did not succeed has no value."""
    spacing = 1.0 / cell.coordinates.get(RESOLUTION, 1.0)  # in diameters; one alone has no name
    if measured is None or cell.result is None or cell.state != "succeeded":
        return Sample(spacing, np.nan)
    if measured.value is None:
        return Sample(spacing, np.nan, nothing=True)
    rest = math.hypot(*(size for part, size in measured.parts.items() if part != SUB_CELL))
    doubts = (*cell.result.flags, *measured.flags)
    return Sample(spacing, measured.value, measured.parts.get(SUB_CELL, 0.0), rest, doubts=doubts)


# ---- laws and observations -----------------------------------------------------------------------


@dataclass(frozen=True)
class LawChoice:
    """A law with one of its stated variants: one label of the law dimension."""

    law: Any  # studies.laws.Law
    variant: str

    @property
    def label(self) -> str:
        return f"{self.law.name}/{self.variant}" if self.variant else self.law.name


@dataclass(frozen=True)
class NoAnswer:
    """What a law says that cannot be asked."""

    reason: str
    value: float = np.nan
    in_range: bool = False


LAW_WORDS: Mapping[str, Callable[[Any], str]] = {
    "name": lambda law: law.name,
    "title": lambda law: law.title,
    "equation": lambda law: law.equation,
    "source": lambda law: law.source,
    "range": lambda law: law.range.words,
    "confidence": lambda law: f"equation: {law.confidence}; range: {law.range.confidence}",
}


def of_laws(layout: Layout, quantity: str, catalogue: Catalogue) -> Iterator[Column]:
    """What each law, with each of its variants, answers for each run; and the laws' own words."""
    choices = _choices(catalogue, quantity, [cell.shot for cell in layout.cells])
    if not choices:
        return
    answers = {
        cell.index: [_answer(choice, cell.shot) for choice in choices] for cell in layout.cells
    }
    size = len(choices)
    yield f"{quantity}_law", labels(choice.label for choice in choices)
    yield (
        f"{quantity}_by_law",
        layout.numbers(lambda cell: [a.value for a in answers[cell.index]], size),
    )
    yield (
        f"{quantity}_by_law_in_range",
        layout.integers(lambda cell: [a.in_range for a in answers[cell.index]], np.int8, size),
    )
    yield (
        f"{quantity}_by_law_reason",
        layout.texts(lambda cell: [a.reason for a in answers[cell.index]], size),
    )
    yield f"{quantity}_law_variant", labels(choice.variant for choice in choices)
    for key, words in LAW_WORDS.items():
        yield f"{quantity}_law_{key}", labels(words(choice.law) for choice in choices)


def _choices(catalogue: Catalogue, quantity: str, shots: Sequence[Any | None]) -> list[LawChoice]:
    """Each law of a quantity with each variant that it states for one of the shots."""
    return [
        LawChoice(law, variant)
        for law in catalogue.laws
        if law.quantity == quantity
        for variant in _variants(law, shots)
    ]


def _variants(law: Any, shots: Iterable[Any]) -> list[str]:
    """In the order in which they are first stated."""
    return list(
        dict.fromkeys(
            variant for shot in shots if shot is not None for variant in law.variants(shot)
        )
    )


def _answer(choice: LawChoice, shot: Any | None) -> Any:
    if shot is None:
        return NoAnswer("this run does not describe one shot")
    if choice.variant not in choice.law.variants(shot):
        return NoAnswer(f"{choice.variant} is not stated for this material")
    return choice.law.evaluate(shot, choice.variant)


def of_observations(words: Vocabulary, catalogue: Catalogue) -> Iterator[Column]:
    """The shots that the sweep brought, and what the laws answer for each."""
    seen = catalogue.observations
    if not seen:
        return
    yield "observation", np.arange(len(seen), dtype=np.int32)
    yield "observation_source", labels(shot.source for shot in seen)
    yield (
        "observation_equivalent_diameter",
        floats(getattr(one.shot, "projectile_diameter", None) for one in seen),
    )
    for name, parameter in words.parameters.items():
        values = [one.parameters.get(name) for one in seen]
        if any(value is not None for value in values):
            yield f"observation_{variable_name(name)}", _column(parameter, values)
    for quantity in words.quantities:
        if any(one.quantity == quantity for one in seen):
            yield from _observed(seen, quantity, catalogue)


def _observed(seen: Sequence[Observed], quantity: str, catalogue: Catalogue) -> Iterator[Column]:
    """The shots of one quantity; the constants of laws are those of the shots' own materials."""
    mine = [one if one.quantity == quantity else None for one in seen]
    yield f"{quantity}_observed", floats(one.value if one else None for one in mine)
    yield (
        f"{quantity}_observed_uncertainty",
        floats(one.uncertainty if one else None for one in mine),
    )
    choices = _choices(catalogue, quantity, [one.shot for one in mine if one])
    if choices:
        yield f"{quantity}_observed_law", labels(choice.label for choice in choices)
        yield f"{quantity}_observed_law_title", labels(choice.law.title for choice in choices)
        answers = [[_answer(choice, one.shot) for choice in choices] for one in seen]
        yield (
            f"{quantity}_by_law_at_observation",
            np.array([[answer.value for answer in row] for row in answers], float),
        )
        yield (
            f"{quantity}_by_law_at_observation_in_range",
            np.array([[answer.in_range for answer in row] for row in answers], np.int8),
        )
