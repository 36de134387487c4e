"""Convergence of a measured number under refinement: observed order, Richardson's value, GCI, verdict.

- The value of a point is that of its finest resolution, the mean over its sub-cell offsets; the grid convergence index
  (GCI) is an error band about it (Celik et al. 2008, step 5), and Richardson's value, noisier, stands beside it.
- The three finest resolutions count: ``converging`` where their differences exceed the noise and have one sign,
  the observed order lies within ``ORDERS``, and the noise cannot have raised it from below them.
- The mesh error is then the GCI of the values with the noise against them: each shifted by ``COVERAGE`` times its
  standard uncertainty to where the order is lowest and the error largest.
- Else it is unknown: no order is assumed. What is known of the reading is stated: ``offsets``, the noise of the finest
  resolution over the root of its offsets, and ``measurement``, all else that its runs state (growth, azimuth).

Sources: Richardson (1911); Roache (1994), J. Fluids Eng. 116, 405; Celik et al. (2008), J. Fluids Eng. 130, 078001; Eça
and Hoekstra (2014), J. Comput. Phys. 262, 104. ``make claims bars`` counts how often the bars hold a known limit.
"""

import math
from bisect import bisect
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import Literal, get_args

from studies.quantities.measured import TOO_COARSE, flags_in_words

ConvergenceVerdict = Literal[
    "converging",
    "order unknown",
    "single grid",
    "no value",
    "grids agree",  # of an outcome (``outcomes``)
    "open",
    "mesh error known",  # from experience (``experience``)
    "grids disagree",  # by more than that expects
]
VERDICTS: tuple[ConvergenceVerdict, ...] = get_args(ConvergenceVerdict)

# Orders that count, of a scheme of the formal order 2: Eça and Hoekstra (2014), Appendix A, use an observed order
# between them as it is, and none below or above.
ORDERS = (0.5, 2.1)
SAFETY = 1.25  # factor of safety of three grids with an observed order: Roache (1994); Celik et al. (2008), Eq. 7
COVERAGE = 2.0  # standard uncertainties that hold about 95 %: JCGM 100:2008 (GUM), 6.3.3
ROUND_OFF = 1e-9  # relative: values that differ by less are equal
STEEPEST, STEP = 20, 1e-12  # orders that are told apart, and by how much


@dataclass(frozen=True)
class Sample:
    """The value of a quantity in one run; all lengths have the same, arbitrary unit."""

    spacing: float  # size of a cell
    value: float  # NaN where the run has none
    sub_cell: float = 0.0  # standard uncertainty that it states for what a single run cannot see
    rest: float = 0.0  # root of the sum of the squares of all else that it states
    nothing: bool = False  # without a value because there was nothing to measure, not because it failed
    quality_flags: tuple[str, ...] = ()  # flags of the run that concern its value


@dataclass(frozen=True)
class Level:
    """One resolution."""

    spacing: float
    value: float  # mean over the offsets that have a value; NaN without any
    scatter: float  # standard deviation over these offsets; NaN for fewer than two
    values: int  # offsets that have a value
    runs: int  # offsets that were asked
    sub_cell: float  # root mean square over the offsets that have a value
    rest: float
    nothing: int = 0  # offsets that succeeded and found nothing to measure
    quality_flags: tuple[str, ...] = ()  # of the offsets that have a value, each once

    @property
    def uncertainty(self) -> float:
        """Standard uncertainty of the mean due to the position of the grid: by the scatter, or as a run states it."""
        noise = self.sub_cell if math.isnan(self.scatter) else self.scatter
        if self.values < self.runs:
            noise = max(noise, self.sub_cell)
        return noise / math.sqrt(max(self.values, 1))


@dataclass(frozen=True)
class Convergence:
    """The value of a quantity over its grids, the parts of its error bar, and the verdict on its convergence."""

    verdict: ConvergenceVerdict
    reason: str  # in words; what was left out, too
    value: float  # of the finest resolution with a value
    mesh: float = math.nan  # parts of the uncertainty; the mesh's is NaN where nothing tells it
    offsets: float = math.nan
    measurement: float = math.nan
    order: float = math.nan  # as observed; NaN unless converging
    extrapolated: float = math.nan  # Richardson's value
    gci: float = math.nan  # grid convergence index of the finest resolution, relative to its value
    levels: tuple[Level, ...] = ()  # the finest first, those without a value too

    @property
    def uncertainty(self) -> float:
        """Root of the sum of the squares of the known parts; NaN without any."""
        mesh = 0.0 if math.isnan(self.mesh) else self.mesh
        return math.hypot(mesh, self.offsets, self.measurement) or math.nan


def converge(samples: Iterable[Sample]) -> Convergence:
    """The verdict over runs of one point at several spacings and offsets, in any order."""
    levels = levels_of(samples)
    three = [level for level in levels if level.values][:3]
    if not three:
        return Convergence("no value", "no run has a value", math.nan, levels=levels)
    finest, notes = three[0], [*_flagged(three), *notes_on_gaps(levels)]
    parts = (math.nan, math.nan) if TOO_COARSE in finest.quality_flags else (finest.uncertainty, finest.rest)
    if why := _why_unknown(levels, three):
        verdict: ConvergenceVerdict = "single grid" if len(three) == 1 else "order unknown"
        return Convergence(verdict, "; ".join([why, *notes]), finest.value, math.nan, *parts, levels=levels)
    values, shifted = [level.value for level in three], _against(three)
    order = observed_order(three, values)
    error = _error(three, values, order)
    return Convergence(
        "converging",
        "; ".join([f"the grids show the order {order:.2g}", *notes]),
        finest.value,
        SAFETY * abs(_error(three, shifted, observed_order(three, shifted))),
        *parts,
        order,
        finest.value - error,
        SAFETY * abs(error / finest.value) if finest.value else math.nan,
        levels,
    )


def levels_of(samples: Iterable[Sample]) -> tuple[Level, ...]:
    """The resolutions, the finest first."""
    groups: dict[float, list[Sample]] = {}
    for sample in samples:
        groups.setdefault(sample.spacing, []).append(sample)
    return tuple(_level(spacing, groups[spacing]) for spacing in sorted(groups))


def observed_order(grids: Sequence[Level], values: Sequence[float]) -> float:
    """The p of f(h) = f(0) + C h^p through three values, the finest first; NaN unless differences shrink with h.

    Celik et al. (2008), Table 1, reattachment length: r21 = 1.5, r32 = 1.333, p = 1.53.

    >>> grids = levels_of(Sample(h, 0.0) for h in (1.0, 1.5, 2.0))
    >>> round(observed_order(grids, (6.063, 5.972, 5.863)), 2)
    1.53
    """
    fine, coarse = (math.log(grid.spacing / grids[0].spacing) for grid in grids[1:])

    def growth(steps: int) -> float:
        """(h3^p - h2^p)/(h2^p - h1^p): strictly increasing in p."""
        return math.expm1(STEP * steps * coarse) / math.expm1(STEP * steps * fine) - 1.0

    first, second = values[1] - values[0], values[2] - values[1]
    orders = range(1, round(STEEPEST / STEP))
    place = bisect(orders, second / first, key=growth) if first else 0
    return STEP * orders[place] if 0 < place < len(orders) else math.nan


def notes_on_gaps(levels: Sequence[Level]) -> list[str]:
    """Notes on resolutions and offsets without a value."""
    empty = [level for level in levels if not level.values]
    gaps = [level for level in levels if 0 < level.values < level.runs]
    notes = []
    if empty:
        notes.append(f"{len(empty)} of {len(levels)} resolutions without a value")
        if not levels[0].values:
            notes.append("the finest among them")
    if gaps:
        lost = sum(level.runs - level.values for level in gaps)
        notes.append(f"{lost} of {sum(level.runs for level in gaps)} offsets without a value")
    return notes


def _why_unknown(levels: Sequence[Level], three: Sequence[Level]) -> str:
    """The reason why up to three grids with a value tell no mesh error; empty where they do."""
    if TOO_COARSE in three[0].quality_flags:
        return "the finest resolution has too few cells for an error bar"
    if len(three) == 1:
        return "one resolution says nothing about the mesh"
    counted = [level for level in levels if level.spacing <= three[-1].spacing]
    if nothing := sum(level.nothing for level in counted):
        runs = sum(level.runs for level in counted)
        return f"{nothing} of {runs} runs found nothing to measure, and the others did"
    if len(three) < 3:
        return "two resolutions show no order"
    values, noise = [level.value for level in three], _noise(three)
    steps, least = (values[1] - values[0], values[2] - values[1]), ROUND_OFF * max(map(abs, values))
    if any(abs(step) <= max(least, noise[n] + noise[n + 1]) for n, step in enumerate(steps)):
        return "a difference between resolutions is not above the noise"
    if steps[0] * steps[1] < 0.0:
        return "the differences between resolutions change sign"
    order = observed_order(three, values)
    if math.isnan(order):
        return "the differences between resolutions do not shrink as those of any order"
    if not ORDERS[0] <= order <= ORDERS[1]:
        return f"the observed order {order:.2g} is outside of {ORDERS[0]:g} to {ORDERS[1]:g}"
    if not observed_order(three, _against(three)) >= ORDERS[0]:
        return f"with the noise against it the observed order {order:.2g} may be below {ORDERS[0]:g}"
    return ""


def _error(three: Sequence[Level], values: Sequence[float], order: float) -> float:
    """Richardson's estimate of the error of the finest of three values: (f2 - f1)/(r21^p - 1)."""
    return (values[1] - values[0]) / math.expm1(order * math.log(three[1].spacing / three[0].spacing))


def _against(three: Sequence[Level]) -> list[float]:
    """Three values, each shifted by its noise to where the order is lowest and the error largest."""
    sign = math.copysign(1.0, three[1].value - three[0].value)
    shifts = zip(three, _noise(three), (-sign, sign, -sign), strict=True)
    return [level.value + way * noise for level, noise, way in shifts]


def _noise(three: Sequence[Level]) -> list[float]:
    """Expanded uncertainty of each of three values: by the share of a cell that they have in common."""
    share = _root_mean_square([level.uncertainty / level.spacing for level in three])
    return [COVERAGE * share * level.spacing for level in three]


def _level(spacing: float, samples: Sequence[Sample]) -> Level:
    valued = [sample for sample in samples if math.isfinite(sample.value)]
    mean, count = fmean(sample.value for sample in valued) if valued else math.nan, len(valued)
    squares = math.fsum((sample.value - mean) ** 2 for sample in valued)
    return Level(
        spacing,
        mean,
        math.sqrt(squares / (count - 1)) if count > 1 else math.nan,
        count,
        len(samples),
        _root_mean_square([sample.sub_cell for sample in valued]),
        _root_mean_square([sample.rest for sample in valued]),
        sum(sample.nothing for sample in samples),
        tuple(sorted({flag for sample in valued for flag in sample.quality_flags})),
    )


def _root_mean_square(values: Sequence[float]) -> float:
    squares = [value**2 for value in values if math.isfinite(value)]
    return math.sqrt(fmean(squares)) if squares else 0.0


def _flagged(three: Sequence[Level]) -> Iterator[str]:
    """The quality flags of the resolutions that count, in words."""
    for flag in sorted({flag for level in three for flag in level.quality_flags}):
        which = " and ".join(
            place
            for place, level in zip(("finest", "second", "third"), three, strict=False)
            if flag in level.quality_flags
        )
        yield f"{flags_in_words([flag])[0]} at the {which} resolution"
