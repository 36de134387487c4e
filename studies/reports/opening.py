"""What a report opens with: the numbers first, the nearest laws, then what was measured.

``opening_of`` gathers a record from the cube, and ``templates/headline.txt`` puts it into words: from the longest form
to the shortest, the first that has few enough of them.
"""

import json
import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache

import numpy as np
import xarray as xr
from jinja2 import Template

from studies.cubes import variables as cubes
from studies.cubes.points import Place, axes_of, error_bars, main_quantities, places_of, simulated
from studies.cubes.reading import doubts_at, finite, flag_words
from studies.quantities.display import printed_beside
from studies.quantities.findings import InvalidInput
from studies.quantities.measured import COARSER_THAN_FRAGMENTS
from studies.reports.judgement import nearest
from studies.reports.records import Doubt, Judgement, MeasuredShot
from studies.reports.wording import number_of, size, text_environment, unit_of, worded, words
from studies.runs.run import estimate
from studies.sweeps.accuracy import USUAL, in_percent
from studies.sweeps.reading import ACCEPTED
from studies.sweeps.sweep import Sweep

MOST_LISTED = 3  # values along one axis that are listed; of more the smallest and the largest stand
NOUNS = {"hole_diameter": "hole", "bumper_hole_diameter": "bumper hole"}


@dataclass(frozen=True)
class Computed:
    """The value of a quantity at a point, SI."""

    at: Place
    value: float
    bar: float | None  # None where the mesh error is unknown
    flagged: bool  # on the quantity or on the run


@dataclass(frozen=True)
class Given:
    """What a law gives at the point of a shot, SI, and whether that is what was measured."""

    law: str
    value: float
    reaches: bool


@dataclass(frozen=True)
class QuantityOpening:
    """What is said of a quantity."""

    quantity: str
    unit: str
    values: tuple[Computed, ...]  # each along one axis, or the smallest and the largest
    bar: float | None  # largest error bar of all points over its value; None where one is unknown
    points: int  # with a value
    flagged: int  # of these, with a flag on the quantity or on the run
    laws: tuple[Judgement, ...]  # that are compared with the simulation, nearest first
    has_laws: bool  # whether any law answers at all
    shots: tuple[MeasuredShot, ...]
    at_shot: tuple[Given, ...]  # by each law in its range, beside the first shot
    beside_shots: Judgement | None  # the law that is nearest to the shots of the sweep's own table

    @property
    def noun(self) -> str:
        """What people call it."""
        return NOUNS.get(self.quantity, words(self.quantity).removesuffix(" percent"))

    @property
    def is_compared(self) -> bool:
        """Whether a law or a shot is about it."""
        return bool(self.laws or self.shots)


@dataclass(frozen=True)
class Opening:
    """What a report about measured values opens with."""

    quantities: tuple[QuantityOpening, ...]
    axes: tuple[str, ...]  # names of those that vary
    shots: tuple[MeasuredShot, ...]  # of the first quantity that has any
    run_with: str  # the accuracy that tells the mesh error; empty where it is told or nothing does
    run_seconds: float  # of one core


def opening_of(points: xr.Dataset, judgements: Sequence[Judgement], shots: Sequence[MeasuredShot]) -> Opening | None:
    """What the report on a cube of points says first; None where no main quantity has a value."""
    quantities = [
        each
        for name in main_quantities(points)
        if (each := _of_quantity(points, name, judgements, [shot for shot in shots if shot.quantity == name]))
    ]
    if not quantities:
        return None
    # Those with laws or shots first, of these the lengths; ratios last.
    quantities.sort(key=lambda told: (told.unit == "1", not told.is_compared, told.is_compared and told.unit != "m"))
    is_unknown = quantities[0].bar is None
    accuracy, seconds = _to_run(points) if is_unknown else ("", 0.0)
    varied = tuple(name for name in axes_of(points) if len(np.unique(points[name].values)) > 1)
    with_shots = next((told.shots for told in quantities if told.shots), ())
    return Opening(tuple(quantities), varied, with_shots, accuracy, seconds)


def _of_quantity(
    points: xr.Dataset, name: str, judgements: Sequence[Judgement], shots: Sequence[MeasuredShot]
) -> QuantityOpening | None:
    computed = computed_of(points, name)
    if not computed:
        return None
    count, flagged = len(computed), sum(point.flagged for point in computed)
    bars = [point.bar / abs(point.value) for point in computed if point.bar is not None and point.value]
    axes = {axis for axis in axes_of(points) if len({point.at[axis] for point in computed}) > 1}
    if len(axes) > 1 or count > MOST_LISTED:
        computed = [*ends_of(computed)]
    mine = [law for law in judgements if law.quantity == name]
    laws = nearest(mine, "simulation")
    return QuantityOpening(
        quantity=name,
        unit=str(points[name].attrs["units"]),
        values=tuple(computed),
        bar=max(bars) if len(bars) == count else None,
        points=count,
        flagged=flagged,
        laws=tuple(laws),
        has_laws=any(law.reference == "simulation" and not law.drawn_only for law in mine),
        shots=tuple(shots),
        at_shot=tuple(
            Given(law.name, at.law, shot.ends[0] <= at.law <= shot.ends[1])
            for shot in shots[:1]
            for law in laws
            for at in law.points
            if at.at == shot.point and at.law and not at.outside
        ),
        beside_shots=next(iter(nearest(mine, "observation")), None),
    )


def computed_of(points: xr.Dataset, name: str) -> list[Computed]:
    """The value of a quantity at each point that has one, without those that are no answer."""
    values, bars = simulated(points, name).values.ravel(), error_bars(points, name).values.ravel()
    told = np.isfinite(values) & ~is_made_by_mesh(points, name)
    columns = zip(places_of(points), values, bars, doubts_at(points, name), told, strict=True)
    return [
        Computed(at, float(value), finite(float(bar)), bool(flags))
        for at, value, bar, flags, is_told in columns
        if is_told
    ]


def ends_of(computed: Sequence[Computed]) -> tuple[Computed, Computed]:
    """The smallest and the largest value."""
    return min(computed, key=lambda point: point.value), max(computed, key=lambda point: point.value)


def is_made_by_mesh(points: xr.Dataset, name: str) -> np.ndarray:
    """Whether a value (points,) speaks of pieces that the mesh alone made, so that it is no answer."""
    flags = flag_words(cubes.FLAGS.of(points, name))
    return np.array([COARSER_THAN_FRAGMENTS in words for words in flags]) & np.isfinite(points[name].values.ravel())


def _to_run(points: xr.Dataset) -> tuple[str, float]:
    """The accuracy with which the same sweep has error bars, and its core seconds."""
    document = json.loads(points.attrs["sweep"])
    kept = {key: value for key, value in document.items() if key not in ("resolution", "cells", "offsets", "accuracy")}
    with suppress(InvalidInput):
        sweep = Sweep.parse({**kept, "accuracy": in_percent(USUAL)}, ACCEPTED)
        return in_percent(USUAL), math.fsum(estimate(point.run).core_seconds for point in sweep.runs())
    return "", 0.0


# ---- in words ------------------------------------------------------------------------------------


def headline(opening: Opening, units: Mapping[str, str | None]) -> str:
    """The opening in words; ``units`` are those of the axes."""

    def place(at: Place, names: bool = True) -> str:
        told = [(axis, at[axis]) for axis in opening.axes if axis in at]
        texts = (
            ("" if axis == "speed" or not names else f"{words(axis)} ")
            + (value if isinstance(value, str) else f"{number_of(value, units[axis])}{unit_of(units[axis])}")
            for axis, value in told
        )
        return ", ".join(texts)

    def along(values: Sequence[Computed]) -> str:
        axis = next(iter(opening.axes))
        shown = (point.at[axis] for point in values)
        name = "" if axis == "speed" else f"{words(axis)} "
        return name + ", ".join(number_of(at, units[axis]) for at in shown) + unit_of(units[axis])

    return worded(_template(), opening=opening, place=place, along=along)


def _barred(computed: Computed, unit: str) -> str:
    """ "14.2 ± 1.0"."""
    if not computed.bar:
        return size(computed.value, unit)
    return f"{printed_beside(computed.value, unit, computed.bar)} ± {printed_beside(computed.bar, unit, computed.bar)}"


def _measured(shot: MeasuredShot) -> str:
    """ "14.0", "27.5 to 34.5", "above 18.3"."""
    if shot.value is not None:
        return size(shot.value, shot.unit)
    if shot.lower is None or shot.upper is None:
        bound = shot.upper if shot.lower is None else shot.lower
        return f"{'below' if shot.lower is None else 'above'} {size(bound or 0.0, shot.unit)}"
    return f"{size(shot.lower, shot.unit)} to {size(shot.upper, shot.unit)}"


def _off(shots: Sequence[MeasuredShot]) -> list[float]:
    """The differences of the simulation from the measured values of shots of the same size, ascending."""
    same = [shot for shot in shots if Doubt.OTHER_SIZE not in shot.doubts]
    return sorted(shot.simulation / shot.value - 1.0 for shot in same if shot.value and shot.simulation is not None)


@cache
def _template() -> Template:
    environment = text_environment()
    environment.filters.update(barred=_barred, measured=_measured, off=_off)
    return environment.get_template("headline.txt")
