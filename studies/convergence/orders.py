"""Orders of convergence: the one that three values show, and what it leaves open where they are noisy."""

import math
from collections.abc import Sequence

# Orders that count as asymptotic. Below 0.5 an extrapolation runs further than the three values do;
# Oberkampf and Roy (2010), Verification and Validation in Scientific Computing, chapter 8, and Eça
# and Hoekstra (2014), Appendix A, stop there too. Above 3, half as much again as the formal order,
# the differences vanish faster than any term of the scheme: two values agree by chance.
ORDERS = (0.5, 3.0)
# Of the scheme for smooth fields. A higher observed order is not used to extrapolate. (So in Oberkampf and Roy, who
# take a factor of safety of 3 where the orders differ by more than a tenth; here it is Roache's 1.25 for three grids.)
FORMAL_ORDER = 2.0
STEEPEST = 60.0  # order at which a search ends; anything beyond is as good as infinite


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


def farthest_limit(
    spacings: Sequence[float], values: Sequence[float], noise: Sequence[float], origin: float
) -> float:
    """Distance from ``origin`` to the farthest limit of a power law that passes three values within their noise.

    The limit f1 - (f2 - f1)/(r^p - 1) runs away as f1 and f2 part and as p falls, so it is farthest at the corner where
    f1 and f2 are farthest apart. Where p is below the lowest accepted order there, it is farthest at the nearest place
    where p is that order: f3 moves first, then f2, then f1. Zero where no such law is within the noise.
    """
    # f3 - f2 over f2 - f1 at the lowest order.
    least = math.exp(_growth(ORDERS[0], *spacings))
    farthest = 0.0
    for sign in (1.0, -1.0):
        # f2 - f1 and f3 - f2; the law rises with the size of the cell, or falls.
        near, far = sign * (values[1] - values[0]), sign * (values[2] - values[1])
        of_fine, of_middle = -noise[0], noise[1]
        of_coarse = max(-noise[2], least * (near + noise[0] + noise[1]) - far + noise[1])
        if of_coarse > noise[2]:
            of_coarse = noise[2]
            of_middle = (far + noise[2] - least * (near + noise[0])) / (1.0 + least)
        if of_middle < -noise[1]:
            of_middle = -noise[1]
            of_fine = near - noise[1] - (far + noise[2] + noise[1]) / least
        near += of_middle - of_fine
        far += of_coarse - of_middle
        if of_fine <= noise[0] and near > 0.0 and far > 0.0:
            order = observed_order(spacings, (0.0, near, near + far))
            used = min(max(order, ORDERS[0]), FORMAL_ORDER)
            error = sign * near / math.expm1(used * math.log(spacings[1] / spacings[0]))
            farthest = max(farthest, abs(values[0] + sign * of_fine - error - origin))
    return farthest


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
