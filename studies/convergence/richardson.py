"""Convergence of a measured number under refinement: observed order, Richardson's value, error bar, verdict.

- The value of a resolution is the mean over its sub-cell offsets, without those that failed. The three finest
  resolutions count; coarser ones are shown and decide nothing.
- Their differences are compared with the noise first: a difference that is not above it says nothing about the mesh.
  Then a change of sign is ``oscillatory``; an order outside of ``ORDERS`` is ``not in the asymptotic range``, and one
  above the formal where no noise is known that may have raised it.
- One rule holds for all points of a series, which a curve joins: either all are extrapolated with the mean order of
  those that converge by themselves, at least half of all (the global average of Celik et al. 2008 for the points of a
  profile), or each has the value of its finest resolution. A point alone is a series of one.
- The error bar is the root of the sum of the squares of three parts: ``mesh``, the error that is left and what the
  noise makes of the value; ``offsets``, the noise of the finest resolution over the root of the number of its offsets;
  ``measurement``, all else that the finest runs state (growth, azimuth), root mean square over their offsets.

``studies.reports.report.RULES`` says which mesh error goes with which verdict. The bars are made to hold the limit in
95 of 100 cases. ``COVERAGE`` and ``LEFT`` are set by synthetic series of known limit
(``tests/studies/convergence/series.py``; ``make claims bars``), never by the solver's results.

Sources: Richardson (1911); Roache (1994), J. Fluids Eng. 116, 405; Celik et al. (2008), J. Fluids
Eng. 130, 078001; Eça and Hoekstra (2014), J. Comput. Phys. 262, 104.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

from studies.convergence.orders import FORMAL_ORDER, HIGHEST_WITHOUT_NOISE, ORDERS, fit, observed_order
from studies.quantities.measured import TOO_COARSE

ConvergenceVerdict = Literal[
    "mesh error known",  # from experience (``experience``)
    "grids disagree",  # by more than that expects
    "converging",
    "oscillatory",
    "not in the asymptotic range",
    "two grids",
    "single grid",
    "no value",
    "grids agree",  # of an outcome (``outcomes``)
    "open",
]
VERDICTS: tuple[ConvergenceVerdict, ...] = get_args(ConvergenceVerdict)

# Of two grids, which cannot show one: shocks and free surfaces are of first order whatever the scheme is (Banks, Aslam
# and Rider 2008, J. Comput. Phys. 227, 6985).
ASSUMED_ORDER = 1.0
# Factors of safety of Roache (1994): three grids with an observed order, two with an assumed one.
# Eça and Hoekstra (2014), Appendix A, take the same two: 1.25 for an observed order that they
# accept, and 3 for one that they do not.
SAFETY, SAFETY_UNOBSERVED = 1.25, 3.0
# Standard uncertainties within which the noise is believed to lie: more than the 2 of a known normal deviation, since a
# few offsets tell it badly. Set with ``LEFT`` by synthetic series.
COVERAGE = 3.0
# Of the correction that an extrapolation makes, what it may have got wrong. Stern et al. (2001), J. Fluids Eng. 123,
# 793, keep the factor of safety less 1, a quarter; synthetic series whose coarsest grid is outside of the asymptotic
# range ask for more.
LEFT = 0.6
ROUND_OFF = 1e-9  # relative: values that differ by less are equal


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
    scatter: float  # over the offsets; NaN for fewer than two
    values: int  # offsets that have a value
    runs: int  # offsets that were asked
    sub_cell: float  # root mean square over the offsets that have a value
    rest: float
    nothing: int = 0  # offsets that succeeded and found nothing to measure
    quality_flags: tuple[str, ...] = ()  # of the offsets that have a value, each once

    @property
    def noise(self) -> float:
        """The uncertainty due to the position of the grid: the scatter, or the statement of a single run."""
        if math.isnan(self.scatter):
            return self.sub_cell
        return self.scatter if self.values == self.runs else max(self.scatter, self.sub_cell)

    @property
    def uncertainty(self) -> float:
        """Standard uncertainty of the mean over its offsets, due to the position of the grid."""
        return self.noise / math.sqrt(max(self.values, 1))


@dataclass(frozen=True)
class Convergence:
    """The converged value of a quantity, its error bar, and the verdict on its convergence."""

    verdict: ConvergenceVerdict
    reason: str  # in words; what was left out, too
    value: float  # extrapolated where converging and more certain so, else of the finest resolution with a value
    mesh: float  # parts of the uncertainty; the mesh's is NaN where nothing tells it
    offsets: float
    measurement: float
    order: float = math.nan  # as observed; NaN where there is none
    extrapolated: float = math.nan  # NaN unless converging
    gci: float = math.nan  # grid convergence index of the finest resolution, relative to its value
    levels: tuple[Level, ...] = ()  # the finest first, those without a value too

    @property
    def rule(self) -> str:
        """What the value is: extrapolated with an order, or that of the finest resolution."""
        if self.value == self.extrapolated:
            return f"extrapolated with p = {min(self.order, FORMAL_ORDER):.2g}"
        return "finest grid"

    @property
    def uncertainty(self) -> float:
        """Root of the sum of the squares of the known parts; NaN without any."""
        if math.isnan(self.mesh):
            return _unknown_if_zero(math.hypot(self.offsets, self.measurement))
        return math.hypot(self.mesh, self.offsets, self.measurement)


def converge(samples: Iterable[Sample]) -> Convergence:
    """The verdict over runs of one point at several spacings and offsets, in any order."""
    (point,) = converge_series([samples])
    return point


def converge_series(points: Iterable[Iterable[Sample]]) -> list[Convergence]:
    """The verdicts over the points of a series: all that have a value are extrapolated with one order, or none is."""
    finest = [_of_finest(levels_of(samples)) for samples in points]
    valued = [each for each in finest if each.verdict != "no value"]
    orders = sorted(each.order for each in valued if each.verdict == "converging")
    if not orders:
        return finest
    apart = len(valued) - len(orders)
    if apart > len(orders):
        reason = f"{apart} of {len(valued)} points of the series do not converge"
        return [_explained(each, reason) for each in finest]
    order = math.fsum(orders) / len(orders)
    name = f"the {'observed' if order <= FORMAL_ORDER else 'formal'} order {min(order, FORMAL_ORDER):.2g}"
    if len(valued) > 1:
        name += " of the series"
    extrapolated = [_extrapolated(each, order, name) for each in finest]
    fitted = [each for each in extrapolated if each is not None]
    if len(fitted) < len(finest):
        apart = len(finest) - len(fitted)
        reason = f"{apart} of {len(valued)} points of the series do not fit {name}"
        return [_explained(each, reason) for each in finest]
    if _size(fitted) > _size(finest):
        reason = f"an extrapolation with {name} multiplies the noise"
        return [_explained(each, reason) for each in finest]
    return fitted


def levels_of(samples: Iterable[Sample]) -> tuple[Level, ...]:
    """The resolutions, the finest first."""
    groups: dict[float, list[Sample]] = {}
    for sample in samples:
        groups.setdefault(sample.spacing, []).append(sample)
    return tuple(_level(spacing, groups[spacing]) for spacing in sorted(groups))


def extrapolate(fine: Level, middle: Level, order: float) -> float:
    """Richardson's value at spacing zero: f1 + (f1 - f2)/(r^p - 1)."""
    return fine.value - _error(fine, middle, order)


# ---- series --------------------------------------------------------------------------------------


def _of_finest(levels: tuple[Level, ...]) -> Convergence:
    """The verdict on a point by itself, with the value of its finest resolution."""
    valued = [level for level in levels if level.values]
    if not valued:
        nothing = (math.nan, math.nan, math.nan, math.nan)
        return Convergence("no value", "no run has a value", *nothing, levels=levels)
    judged = (_of_one, _of_two, _of_three)[min(len(valued), 3) - 1](valued)
    return _convergence(levels, _too_coarse(valued) or _contradicted(levels, valued) or judged)


def _convergence(levels: tuple[Level, ...], judged: "_Judged") -> Convergence:
    """A verdict with the parts of the uncertainty that no mesh decides, and notes on what was left out."""
    verdict, reason, value, mesh, more = judged
    valued = [level for level in levels if level.values]
    finest = valued[0]
    unknown = TOO_COARSE in finest.quality_flags
    notes = (reason, *_unstated(valued), *_flagged(valued), *notes_on_gaps(levels))
    return Convergence(
        verdict,
        "; ".join(filter(None, notes)),
        value,
        mesh,
        math.nan if unknown else finest.uncertainty,
        math.nan if unknown else finest.rest,
        levels=levels,
        **more,
    )


def _extrapolated(point: Convergence, order: float, name: str) -> Convergence | None:
    """A point extrapolated with the order of its series; None where its values neither converge nor fit that order."""
    three = [level for level in point.levels if level.values][:3]
    if point.verdict == "no value":
        return point
    if len({level.value for level in three}) == 1 and len(three) == 3:
        return replace(point, order=order, extrapolated=point.value)
    if len(three) < 3 or math.isnan(point.mesh):
        return None
    used = min(order, FORMAL_ORDER)
    reason = f"extrapolated with {name}"
    if point.verdict != "converging":
        if _limit_within_noise(three, used) is None:
            return None
        reason += f", which fits its values within their noise; by itself {point.verdict}"
    return _convergence(point.levels, _of_order(three, order, reason, point))


def _explained(point: Convergence, reason: str) -> Convergence:
    """A point with the reason why it is not extrapolated, where it converges by itself."""
    if point.verdict != "converging":
        return point
    reason = f"the finest resolution, because {reason}"
    return replace(point, reason="; ".join(filter(None, (reason, point.reason))))


def _size(points: Sequence[Convergence]) -> float:
    """Sum of the squares of the mesh errors that are known."""
    return math.fsum(point.mesh**2 for point in points if math.isfinite(point.mesh))


# ---- resolutions ---------------------------------------------------------------------------------


def _level(spacing: float, samples: Sequence[Sample]) -> Level:
    valued = [sample for sample in samples if math.isfinite(sample.value)]
    values = sorted(sample.value for sample in valued)  # so that their order changes no bit
    return Level(
        spacing,
        math.fsum(values) / len(values) if values else math.nan,
        _scatter(values),
        len(values),
        len(samples),
        _root_mean_square([sample.sub_cell for sample in valued]),
        _root_mean_square([sample.rest for sample in valued]),
        sum(sample.nothing for sample in samples),
        tuple(sorted({flag for sample in valued for flag in sample.quality_flags})),
    )


def _scatter(values: Sequence[float]) -> float:
    """Half the range of two or three ascending values, the standard deviation of more; NaN of fewer."""
    if len(values) < 2:
        return math.nan
    if len(values) <= 3:
        return 0.5 * (values[-1] - values[0])
    mean = math.fsum(values) / len(values)
    return math.sqrt(math.fsum((value - mean) ** 2 for value in values) / (len(values) - 1))


def _root_mean_square(values: Sequence[float]) -> float:
    valued = sorted(value for value in values if math.isfinite(value))
    return math.sqrt(math.fsum(value**2 for value in valued) / len(valued)) if valued else 0.0


def _unstated(valued: Sequence[Level]) -> Iterator[str]:
    """A note where differences stand against no noise."""
    alone = any(math.isnan(level.scatter) and not level.sub_cell for level in valued[:3])
    if alone and len(valued) > 1:
        yield "the runs have one offset and state no uncertainty for their position on the grid"


def _flagged(valued: Sequence[Level]) -> Iterator[str]:
    """The quality flags of the resolutions that count, in words."""
    counted = valued[:3]
    for flag in sorted({flag for level in counted for flag in level.quality_flags}):
        places = [place for place, level in enumerate(counted) if flag in level.quality_flags]
        which = " and ".join(("the finest", "the second", "the third")[place] for place in places)
        yield f"{flag.replace('_', ' ')} at {which} of the resolutions that count"


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


# ---- verdicts ------------------------------------------------------------------------------------

_Judged = tuple[ConvergenceVerdict, str, float, float, dict[str, float]]  # with value, mesh, and more numbers


def _too_coarse(valued: Sequence[Level]) -> _Judged | None:
    """The verdict where even the finest resolution with a value is too coarse to have an error bar."""
    if TOO_COARSE not in valued[0].quality_flags:
        return None
    verdict: ConvergenceVerdict = "single grid" if len(valued) == 1 else "not in the asymptotic range"
    reason = "the finest resolution has too few cells for an error bar"
    return verdict, reason, valued[0].value, math.nan, {}


def _contradicted(levels: Sequence[Level], valued: Sequence[Level]) -> _Judged | None:
    """The verdict where runs that count found nothing to measure; None where none did, or one grid stands alone."""
    counted = valued[:3]
    judged = [level for level in levels if level.spacing <= counted[-1].spacing]
    nothing = sum(level.nothing for level in judged)
    if len(valued) == 1 or not nothing:
        return None
    runs = sum(level.runs for level in judged)
    reason = f"{nothing} of {runs} runs found nothing to measure, and the others did"
    return "not in the asymptotic range", reason, valued[0].value, math.nan, {}


def _of_one(valued: Sequence[Level]) -> _Judged:
    return ("single grid", "one resolution says nothing about the mesh", valued[0].value, math.nan, {})


def _of_two(valued: Sequence[Level]) -> _Judged:
    fine, coarse = valued
    index = SAFETY_UNOBSERVED * abs(_error(fine, coarse, ASSUMED_ORDER))
    reason = f"two resolutions show no order; order {ASSUMED_ORDER:g} assumed, factor of safety {SAFETY_UNOBSERVED:g}"
    hidden = _noise(fine, coarse) / (coarse.spacing / fine.spacing - 1.0)  # of first order, too
    mesh = _unknown_if_zero(max(index, hidden, _noise(fine, coarse)))
    return "two grids", reason, fine.value, mesh, {"gci": _relative(index, fine)}


def _of_three(valued: Sequence[Level]) -> _Judged:
    fine, middle, coarse = three = valued[:3]
    steps = middle.value - fine.value, coarse.value - middle.value
    order = observed_order([level.spacing for level in three], [level.value for level in three])
    mesh = _unsettled(three)
    if not (_resolved(fine, middle) and _resolved(middle, coarse)):
        return "not in the asymptotic range", _unresolved(three), fine.value, mesh, {}
    if steps[0] * steps[1] < 0.0:
        reason = "the differences between resolutions change sign"
        if abs(steps[0]) >= abs(steps[1]):
            reason += " and do not shrink"
        return "oscillatory", reason, fine.value, mesh, {}
    highest = ORDERS[1] if _noise_of(three, fine) else HIGHEST_WITHOUT_NOISE
    if not ORDERS[0] <= order <= highest:
        reason = f"the observed order {order:.2g} is outside of {ORDERS[0]:g} to {highest:g}"
        if order <= 0.0:
            reason = "the differences between resolutions grow with refinement"
        return "not in the asymptotic range", reason, fine.value, mesh, {"order": order}
    return _converging(three, order)


def _converging(three: Sequence[Level], order: float) -> _Judged:
    """The finest value of three grids with an observed order, and Richardson's value beside it."""
    fine, middle = three[:2]
    used = min(order, FORMAL_ORDER)
    error = SAFETY * abs(_error(fine, middle, used))
    mesh = _mesh(error, fine.value, _limits_within_noise(three), _noise_of(three, fine))
    limit = extrapolate(fine, middle, used)
    more = {"order": order, "extrapolated": limit, "gci": _relative(error, fine)}
    return "converging", "", fine.value, mesh, more


def _of_order(three: Sequence[Level], order: float, reason: str, point: Convergence) -> _Judged:
    """The value that the order of a series extrapolates; ``point`` is the verdict on the three grids by themselves."""
    fine, middle = three[:2]
    used = min(order, FORMAL_ORDER)
    correction = abs(_error(fine, middle, used))
    value = extrapolate(fine, middle, used)
    limits = _limits_within_noise(three)
    if point.verdict == "converging":
        limits.append(extrapolate(fine, middle, point.order))
    # f1 + (f1 - f2)/(r^p - 1) of two values with noise.
    share = _error_of_unit(fine, middle, used)
    spread = math.hypot((1.0 + share) * _noise_of(three, fine), share * _noise_of(three, middle))
    mesh = _mesh(LEFT * correction, value, limits, spread)
    more = {"order": order, "extrapolated": value, "gci": _relative(SAFETY * correction, fine)}
    return "converging", reason, value, mesh, more


def _mesh(error: float, value: float, limits: Sequence[float], spread: float) -> float:
    """Mesh part of a value: what is left of its error, or the farthest of possible limits, and its noise."""
    return math.hypot(max(error, *(abs(limit - value) for limit in limits), 0.0), COVERAGE * spread)


def _unsettled(three: Sequence[Level]) -> float:
    """Mesh error of three grids that are not extrapolated; NaN where neither they nor noise tell any."""
    fine, middle, coarse = three
    noise = _noise_of(three, fine)
    errors = [abs(limit - fine.value) for limit in _limits_within_noise(three)]
    if not errors:
        near, far = abs(middle.value - fine.value), abs(coarse.value - middle.value)
        order = -math.inf
        if noise and near and far:
            order = observed_order([level.spacing for level in three], (0.0, near, near + far))
        if order >= ORDERS[0]:
            errors = [SAFETY * abs(_error(fine, middle, min(order, ASSUMED_ORDER)))]
        else:
            errors = [_error_by_least_squares(three)]
    return _unknown_if_zero(math.hypot(max(errors), COVERAGE * noise))


def _error_by_least_squares(three: Sequence[Level]) -> float:
    """Uncertainty of the finest of three grids whose order is not asymptotic: Eça and Hoekstra (2014), Appendix A."""
    spacings, values = [level.spacing for level in three], [level.value for level in three]
    fits = []
    for order in (ASSUMED_ORDER, FORMAL_ORDER):
        for weights in ([1.0 for _ in three], [1.0 / h for h in spacings]):
            fitted = fit(spacings, values, [weight**-0.5 for weight in weights], order)
            # Standard deviation, Eq. 9: as many degrees of freedom as grids beyond two constants.
            deviation = fitted.misfit * math.sqrt(len(three) / math.fsum(weights) / (len(three) - 2))
            fits.append((deviation, abs(fitted.limit - fitted.finest), abs(values[0] - fitted.finest)))
    deviation, error, misfit = min(fits)
    spread = (max(values) - min(values)) / (len(three) - 1)  # Eq. 19
    if deviation < spread:
        return SAFETY_UNOBSERVED * error + deviation + misfit  # Eq. 20
    return SAFETY_UNOBSERVED * deviation / spread * (error + deviation + misfit) if spread else 0.0  # Eq. 21


def _limits_within_noise(three: Sequence[Level]) -> list[float]:
    """Limits of the orders, from the assumed to the formal one, that fit three values within their noise."""
    orders = (ASSUMED_ORDER, 0.5 * (ASSUMED_ORDER + FORMAL_ORDER), FORMAL_ORDER)
    limits = (_limit_within_noise(three, order) for order in orders)
    return [limit for limit in limits if limit is not None]


def _limit_within_noise(three: Sequence[Level], order: float) -> float | None:
    """The limit of a power law of an order that fits three values within their noise; None where none does."""
    noise = [_noise_of(three, level) for level in three]
    if not all(noise):
        return None
    fitted = fit([level.spacing for level in three], [level.value for level in three], noise, order)
    return fitted.limit if fitted.misfit <= COVERAGE else None


def _noise_of(three: Sequence[Level], level: Level) -> float:
    """Standard uncertainty of a resolution's value: the share of a cell that three have in common."""
    shares = [each.uncertainty / each.spacing for each in three]
    return _root_mean_square(shares) * level.spacing


def _unresolved(three: Sequence[Level]) -> str:
    """The reason why differences give no mesh error, as a text."""
    values = [level.value for level in three]
    if max(values) == min(values):
        return "the values do not differ"
    if not any(level.noise for level in three):
        return "two resolutions have the same value"
    if all(math.isnan(level.scatter) for level in three):
        return "a difference between resolutions is within the uncertainty of a single run"
    return "a difference between resolutions is within the scatter over offsets"


def _resolved(fine: Level, coarse: Level) -> bool:
    """Whether two resolutions differ by more than the noise of either."""
    least = ROUND_OFF * max(abs(fine.value), abs(coarse.value))
    return abs(coarse.value - fine.value) > max(least, _noise(fine, coarse))


def _noise(fine: Level, coarse: Level) -> float:
    """Noise of the difference of two resolutions: the larger of theirs."""
    return max(fine.noise, coarse.noise)


def _unknown_if_zero(error: float) -> float:
    """An error that something tells; NaN for zero, which nothing can tell."""
    return error or math.nan


def _error(fine: Level, coarse: Level, order: float) -> float:
    """Estimated error of the finer of two resolutions: (f2 - f1)/(r^p - 1)."""
    return (coarse.value - fine.value) * _error_of_unit(fine, coarse, order)


def _error_of_unit(fine: Level, coarse: Level, order: float) -> float:
    """Error of the finer of two resolutions over their difference: 1/(r^p - 1)."""
    return 1.0 / math.expm1(order * math.log(coarse.spacing / fine.spacing))


def _relative(index: float, fine: Level) -> float:
    return index / abs(fine.value) if fine.value else math.nan
