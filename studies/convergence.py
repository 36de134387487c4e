"""Convergence of a measured number under refinement: observed order, Richardson's value, error bar, verdict.

The rules, fixed before any run was looked at:

- The value of a resolution is the mean over its sub-cell offsets; its scatter is half the range of two or three
  offsets, the standard deviation of more. An offset without a value is left out, and counted in the reason.
- The three finest resolutions count; coarser ones are shown and decide nothing.
- Their differences are compared with the scatter first: a difference that is not above it says nothing about the mesh.
  Then a change of sign is ``oscillatory``; an order outside of ``ORDERS`` is ``not in the asymptotic range``.
- Only ``converging`` gives an extrapolated number, and then it is the value. Otherwise the finest resolution is.
- The error bar is the root of the sum of the squares of three parts. ``mesh``: the grid convergence index (factor of
  safety 1.25; 3 for two grids, whose order is assumed), taken whole; half the range of the three finest where they
  oscillate and the swing shrinks (Stern et al. 2001, J. Fluids Eng. 123, 793, Eq. 32); their whole range where it
  grows, or where they are not in the asymptotic range; none for a single grid, whose mesh error nobody has asked
  about. ``offsets``: the scatter at the finest resolution, or, where only one offset has a value, what the
  measurement says a single run cannot see. ``measurement``: all else that the finest runs state (growth, azimuth),
  root mean square over their offsets.

Sources: Richardson (1911); Roache (1994), J. Fluids Eng. 116, 405; Celik et al. (2008), J. Fluids Eng. 130, 078001.
"""

import math
from collections.abc import Iterable, Sequence
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

# Orders that count as asymptotic. Below 0.5 an extrapolation runs further than the three values do (Oberkampf and Roy
# 2010, Verification and Validation in Scientific Computing, chapter 8, stop there too); above 3, half as much again as
# the formal order, the differences vanish faster than any term of the scheme: two values agree by chance.
ORDERS = (0.5, 3.0)
# Of the scheme for smooth fields. A higher observed order is not used to extrapolate. (So in Oberkampf and Roy, who
# take a factor of safety of 3 where the orders differ by more than a tenth; here it is Roache's 1.25 for three grids.)
FORMAL_ORDER = 2.0
# Of two grids, which cannot show one: shocks and free surfaces are of first order whatever the scheme is (Banks, Aslam
# and Rider 2008, J. Comput. Phys. 227, 6985).
ASSUMED_ORDER = 1.0
# Factors of safety of Roache (1994): three grids with an observed order, two with an assumed one.
SAFETY, SAFETY_OF_TWO = 1.25, 3.0
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


@dataclass(frozen=True)
class Convergence:
    """What a quantity is worth, with its error bar, and what refinement says about it."""

    verdict: Verdict
    reason: str  # in words; what was left out, too
    value: float  # extrapolated where converging, else of the finest resolution with a value
    mesh: float  # parts of the uncertainty; the mesh's is NaN where nobody has asked about it
    offsets: float
    measurement: float
    order: float = math.nan  # as observed; NaN where there is none
    extrapolated: float = math.nan  # NaN unless converging
    gci: float = math.nan  # grid convergence index of the finest resolution, relative to its value
    levels: tuple[Level, ...] = ()  # the finest first, those without a value too

    @property
    def uncertainty(self) -> float:
        """Root of the sum of the squares of the known parts; NaN without a value."""
        if self.verdict == "no value":
            return math.nan
        mesh = 0.0 if math.isnan(self.mesh) else self.mesh
        return math.hypot(mesh, self.offsets, self.measurement)


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
        "; ".join([reason, *_left_out(levels)]),
        value,
        mesh,
        finest.sub_cell if math.isnan(finest.scatter) else finest.scatter,
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
    index = SAFETY_OF_TWO * abs(_error(fine, coarse, ASSUMED_ORDER))
    reason = f"two resolutions show no order; order {ASSUMED_ORDER:g} assumed, factor of safety {SAFETY_OF_TWO:g}"
    return "two grids", reason, fine.value, index, {"gci": _relative(index, fine)}


def _of_three(known: Sequence[Level]) -> _Judged:
    fine, middle, coarse = three = known[:3]
    values = [level.value for level in three]
    span = max(values) - min(values)
    if not (_resolved(fine, middle) and _resolved(middle, coarse)):
        reason = "a difference between resolutions is not above the scatter over offsets"
        if span == 0.0:
            reason = "the values do not differ"
        elif all(math.isnan(level.scatter) for level in three):
            reason = "two resolutions have the same value"
        return "not in the asymptotic range", reason, fine.value, span, {}
    if (values[1] - values[0]) * (values[2] - values[1]) < 0.0:
        reason = "the differences between resolutions change sign"
        if abs(values[1] - values[0]) < abs(values[2] - values[1]):
            return "oscillatory", reason, fine.value, 0.5 * span, {}
        return "oscillatory", f"{reason} and do not shrink", fine.value, span, {}
    order = observed_order([level.spacing for level in three], values)
    if not ORDERS[0] <= order <= ORDERS[1]:
        reason = f"the observed order {order:.2g} is outside of {ORDERS[0]:g} to {ORDERS[1]:g}"
        if order <= 0.0:
            reason = "the differences between resolutions grow with refinement"
        return "not in the asymptotic range", reason, fine.value, span, {"order": order}
    used = min(order, FORMAL_ORDER)
    value = extrapolate(fine, middle, used)
    index = SAFETY * abs(value - fine.value)
    reason = f"extrapolated with the {'observed' if used == order else 'formal'} order {used:.2g}"
    more = {"order": order, "extrapolated": value, "gci": _relative(index, fine)}
    return "converging", reason, value, index, more


def _resolved(fine: Level, coarse: Level) -> bool:
    """Whether two resolutions differ by more than the scatter over the offsets of either."""
    noise = [s for s in (fine.scatter, coarse.scatter) if not math.isnan(s)]
    least = ROUND_OFF * max(abs(fine.value), abs(coarse.value))
    return abs(coarse.value - fine.value) > max([least, *noise])


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
