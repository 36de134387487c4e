"""Convergence of a measured number under refinement: observed order, Richardson's value, error bar, verdict.

The rules:

- The value of a resolution is the mean over its sub-cell offsets; its scatter is half the range of two or three
  offsets, the standard deviation of more. An offset without a value is left out, and counted in the reason.
- The three finest resolutions count; coarser ones are shown and decide nothing.
- The noise of a resolution is its scatter, or, where only one offset has a value, what the
  measurement says a single run cannot see.
- Their differences are compared with the noise first: a difference that is not above it says
  nothing about the mesh. Then a change of sign is ``oscillatory``; an order outside of ``ORDERS``
  is ``not in the asymptotic range``.
- Only ``converging`` gives an extrapolated number, and then it is the value. Otherwise the finest
  resolution is.
- The error bar is the root of the sum of the squares of three parts:

  ``mesh``
      The grid convergence index (factor of safety 1.25; 3 for two grids, whose order is assumed),
      taken whole. Three grids that do not converge have the largest of their range, of the noise of
      the finest difference, and of the index that this difference would have at the lowest order of
      ``ORDERS``: no bar is smaller than one that the same difference could have by converging. The
      factor of that index is 3 where the observed order is lower still (Eça and Hoekstra 2014,
      Appendix A), which covers power laws of orders down to 0.2 where cells are halved. Unknown for
      a single grid, and where grids do not differ and no noise is stated.
  ``offsets``
      The noise of the finest resolution.
  ``measurement``
      All else that the finest runs state (growth, azimuth), root mean square over their offsets.

Sources: Richardson (1911); Roache (1994), J. Fluids Eng. 116, 405; Celik et al. (2008), J. Fluids
Eng. 130, 078001; Eça and Hoekstra (2014), J. Comput. Phys. 262, 104.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

Verdict = Literal[
    "converging",
    "oscillatory",
    "not in the asymptotic range",
    "two grids",
    "single grid",
    "no value",
]
VERDICTS: tuple[Verdict, ...] = (
    "converging",
    "oscillatory",
    "not in the asymptotic range",
    "two grids",
    "single grid",
    "no value",
)

# Orders that count as asymptotic. Below 0.5 an extrapolation runs further than the three values do;
# Oberkampf and Roy (2010), Verification and Validation in Scientific Computing, chapter 8, and Eça
# and Hoekstra (2014), Appendix A, stop there too. Above 3, half as much again as the formal order,
# the differences vanish faster than any term of the scheme: two values agree by chance.
ORDERS = (0.5, 3.0)
# Of the scheme for smooth fields. A higher observed order is not used to extrapolate. (So in Oberkampf and Roy, who
# take a factor of safety of 3 where the orders differ by more than a tenth; here it is Roache's 1.25 for three grids.)
FORMAL_ORDER = 2.0
# Of two grids, which cannot show one: shocks and free surfaces are of first order whatever the scheme is (Banks, Aslam
# and Rider 2008, J. Comput. Phys. 227, 6985).
ASSUMED_ORDER = 1.0
# Factors of safety of Roache (1994): three grids with an observed order, two with an assumed one.
# Eça and Hoekstra (2014), Appendix A, take the same two: 1.25 for an observed order that they
# accept, and 3 for one that they do not.
SAFETY, SAFETY_UNOBSERVED = 1.25, 3.0
ROUND_OFF = 1e-9  # relative: values that differ by less are equal
STEEPEST = 60.0  # order at which a search ends; anything beyond is as good as infinite


@dataclass(frozen=True)
class Sample:
    """What one run says about one quantity; lengths in any unit, the same for all."""

    spacing: float  # size of a cell
    value: float  # NaN where the run has none
    sub_cell: float = 0.0  # standard uncertainty that it states for what a single run cannot see
    rest: float = 0.0  # root of the sum of the squares of all else that it states


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

    @property
    def noise(self) -> float:
        """What the position of the grid leaves open: the scatter, or what a run alone states."""
        return self.sub_cell if math.isnan(self.scatter) else self.scatter


@dataclass(frozen=True)
class Convergence:
    """What a quantity is worth, with its error bar, and what refinement says about it."""

    verdict: Verdict
    reason: str  # in words; what was left out, too
    value: float  # extrapolated where converging, else of the finest resolution with a value
    mesh: float  # parts of the uncertainty; the mesh's is NaN where nothing tells it
    offsets: float
    measurement: float
    order: float = math.nan  # as observed; NaN where there is none
    extrapolated: float = math.nan  # NaN unless converging
    gci: float = math.nan  # grid convergence index of the finest resolution, relative to its value
    levels: tuple[Level, ...] = ()  # the finest first, those without a value too

    @property
    def uncertainty(self) -> float:
        """Root of the sum of the squares of the known parts; NaN without any."""
        if math.isnan(self.mesh):
            return _known(math.hypot(self.offsets, self.measurement))
        return math.hypot(self.mesh, self.offsets, self.measurement)


def converge(samples: Iterable[Sample]) -> Convergence:
    """The verdict over runs at several spacings and offsets, in any order."""
    levels = levels_of(samples)
    known = [level for level in levels if level.values]
    if not known:
        nothing = (math.nan, math.nan, math.nan, math.nan)
        return Convergence("no value", "no run has a value", *nothing, levels=levels)
    judged = (_of_one, _of_two, _of_three)[min(len(known), 3) - 1](known)
    verdict, reason, value, mesh, more = judged
    finest = known[0]
    return Convergence(
        verdict,
        "; ".join([reason, *_unstated(known), *_left_out(levels)]),
        value,
        mesh,
        finest.noise,
        finest.rest,
        levels=levels,
        **more,
    )


def levels_of(samples: Iterable[Sample]) -> tuple[Level, ...]:
    """The resolutions, the finest first."""
    groups: dict[float, list[Sample]] = {}
    for sample in samples:
        groups.setdefault(sample.spacing, []).append(sample)
    return tuple(_level(spacing, groups[spacing]) for spacing in sorted(groups))


def observed_order(spacings: Sequence[float], values: Sequence[float]) -> float:
    """The p of f(h) = f(0) + C h^p through three points, the finest first; any ratios of spacings.

    Negative where the values diverge; NaN where they change direction or not at all.
    Celik et al. (2008), Table 1, reattachment length: r21 = 1.5, r32 = 1.333, p = 1.53; axial velocity: r21 = 2.0,
    r32 = 2.143, p = 0.75.

    >>> round(observed_order((1.0, 1.5, 2.0), (6.063, 5.972, 5.863)), 2)
    1.53
    >>> round(observed_order((1.0, 2.0, 4.286), (10.7880, 10.7250, 10.6050)), 2)
    0.75
    """
    fine, middle, coarse = spacings
    # (f3 - f2)/(f2 - f1) = (h3^p - h2^p)/(h2^p - h1^p): strictly increasing in p from 0 to infinity, so one p.
    steps = values[1] - values[0], values[2] - values[1]
    if steps[0] == 0.0 or steps[1] / steps[0] <= 0.0:
        return math.nan
    wanted = math.log(steps[1] / steps[0])
    low, high = -STEEPEST, STEEPEST
    if not _growth(low, fine, middle, coarse) < wanted < _growth(high, fine, middle, coarse):
        return math.copysign(math.inf, wanted)
    while high - low > 1e-13 * STEEPEST:
        p = 0.5 * (low + high)
        if _growth(p, fine, middle, coarse) < wanted:
            low = p
        else:
            high = p
    return 0.5 * (low + high)


def extrapolate(fine: Level, middle: Level, order: float) -> float:
    """Richardson's value at spacing zero: f1 + (f1 - f2)/(r^p - 1)."""
    return fine.value - _error(fine, middle, order)


# ---- resolutions ---------------------------------------------------------------------------------


def _level(spacing: float, samples: Sequence[Sample]) -> Level:
    known = [sample for sample in samples if math.isfinite(sample.value)]
    values = sorted(sample.value for sample in known)  # so that their order changes no bit
    return Level(
        spacing,
        math.fsum(values) / len(values) if values else math.nan,
        _scatter(values),
        len(values),
        len(samples),
        _root_mean_square([sample.sub_cell for sample in known]),
        _root_mean_square([sample.rest for sample in known]),
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
    known = sorted(value for value in values if math.isfinite(value))
    return math.sqrt(math.fsum(value**2 for value in known) / len(known)) if known else 0.0


def _unstated(known: Sequence[Level]) -> Iterator[str]:
    """That differences stand against no noise, in words."""
    alone = any(math.isnan(level.scatter) and not level.sub_cell for level in known[:3])
    if alone and len(known) > 1:
        yield "one offset, and no statement of what it cannot see"


def _left_out(levels: Sequence[Level]) -> list[str]:
    """What has no value, in words."""
    empty = [level for level in levels if not level.values]
    gaps = [level for level in levels if 0 < level.values < level.runs]
    words = []
    if empty:
        words.append(f"{len(empty)} of {len(levels)} resolutions without a value")
        if not levels[0].values:
            words.append("the finest among them")
    if gaps:
        lost = sum(level.runs - level.values for level in gaps)
        words.append(f"{lost} of {sum(level.runs for level in gaps)} offsets without a value")
    return words


# ---- verdicts ------------------------------------------------------------------------------------

_Judged = tuple[Verdict, str, float, float, dict[str, float]]  # with value, mesh, and more numbers


def _of_one(known: Sequence[Level]) -> _Judged:
    return "single grid", "one resolution says nothing about the mesh", known[0].value, math.nan, {}


def _of_two(known: Sequence[Level]) -> _Judged:
    fine, coarse = known
    index = SAFETY_UNOBSERVED * abs(_error(fine, coarse, ASSUMED_ORDER))
    reason = (
        f"two resolutions show no order; order {ASSUMED_ORDER:g} assumed, "
        f"factor of safety {SAFETY_UNOBSERVED:g}"
    )
    mesh = _known(max(index, _noise(fine, coarse)))
    return "two grids", reason, fine.value, mesh, {"gci": _relative(index, fine)}


def _of_three(known: Sequence[Level]) -> _Judged:
    fine, middle, coarse = three = known[:3]
    steps = middle.value - fine.value, coarse.value - middle.value
    order = observed_order([level.spacing for level in three], [level.value for level in three])
    mesh = _unsettled(three, order)
    if not (_resolved(fine, middle) and _resolved(middle, coarse)):
        return "not in the asymptotic range", _unresolved(three), fine.value, mesh, {}
    if steps[0] * steps[1] < 0.0:
        reason = "the differences between resolutions change sign"
        if abs(steps[0]) >= abs(steps[1]):
            reason += " and do not shrink"
        return "oscillatory", reason, fine.value, mesh, {}
    if not ORDERS[0] <= order <= ORDERS[1]:
        reason = f"the observed order {order:.2g} is outside of {ORDERS[0]:g} to {ORDERS[1]:g}"
        if order <= 0.0:
            reason = "the differences between resolutions grow with refinement"
        return "not in the asymptotic range", reason, fine.value, mesh, {"order": order}
    used = min(order, FORMAL_ORDER)
    value = extrapolate(fine, middle, used)
    index = SAFETY * abs(value - fine.value)
    reason = f"extrapolated with the {'observed' if used == order else 'formal'} order {used:.2g}"
    more = {"order": order, "extrapolated": value, "gci": _relative(index, fine)}
    return "converging", reason, value, index, more


def _unsettled(three: Sequence[Level], order: float) -> float:
    """Mesh error of three grids that do not converge; NaN where neither they nor noise tell any."""
    fine, middle = three[:2]
    values = [level.value for level in three]
    turned = (values[1] - values[0]) * (values[2] - values[1]) < 0.0
    safety = SAFETY if turned or order >= ORDERS[0] else SAFETY_UNOBSERVED
    slowest = safety * abs(_error(fine, middle, ORDERS[0]))
    return _known(max(max(values) - min(values), slowest, _noise(fine, middle)))


def _unresolved(three: Sequence[Level]) -> str:
    """Why differences say nothing about the mesh, in words."""
    values = [level.value for level in three]
    if max(values) == min(values):
        return "the values do not differ"
    if not any(level.noise for level in three):
        return "two resolutions have the same value"
    if all(math.isnan(level.scatter) for level in three):
        return "a difference between resolutions is not above what a single run cannot see"
    return "a difference between resolutions is not above the scatter over offsets"


def _resolved(fine: Level, coarse: Level) -> bool:
    """Whether two resolutions differ by more than the noise of either."""
    least = ROUND_OFF * max(abs(fine.value), abs(coarse.value))
    return abs(coarse.value - fine.value) > max(least, _noise(fine, coarse))


def _noise(fine: Level, coarse: Level) -> float:
    """Noise of the difference of two resolutions: the larger of theirs."""
    return max(fine.noise, coarse.noise)


def _known(error: float) -> float:
    """An error that something tells; NaN for zero, which nothing can tell."""
    return error or math.nan


def _error(fine: Level, coarse: Level, order: float) -> float:
    """Estimated error of the finer of two resolutions: (f2 - f1)/(r^p - 1)."""
    ratio = coarse.spacing / fine.spacing
    return (coarse.value - fine.value) / math.expm1(order * math.log(ratio))


def _relative(index: float, fine: Level) -> float:
    return index / abs(fine.value) if fine.value else math.nan


def _growth(p: float, fine: float, middle: float, coarse: float) -> float:
    """Logarithm of (h3^p - h2^p)/(h2^p - h1^p), which has no gap at p = 0 and never overflows."""
    near, far = math.log(middle / fine), math.log(coarse / middle)
    return p * near + _log_slope(p, far) - _log_slope(p, near)


def _log_slope(p: float, logarithm: float) -> float:
    """Logarithm of (r^p - 1)/p for the logarithm of a ratio r > 1."""
    power = p * logarithm
    if abs(power) < 1e-12:
        return math.log(logarithm)
    if power > 0.0:
        return power + math.log(-math.expm1(-power) / p)
    return math.log(math.expm1(power) / p)
