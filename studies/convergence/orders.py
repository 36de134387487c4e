"""Orders of convergence: the one that three values show, and the limit that an order gives them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import mul

# Orders that count as asymptotic. Below 0.5 an extrapolation runs further than the three values do;
# Oberkampf and Roy (2010), Verification and Validation in Scientific Computing, chapter 8, and Eça
# and Hoekstra (2014), Appendix A, stop there too. Above 3, half as much again as the formal order,
# the differences vanish faster than any term of the scheme: two values agree by chance.
ORDERS = (0.5, 3.0)
# Of the scheme for smooth fields. A higher observed order is not used to extrapolate. (So in Oberkampf and Roy, who
# take a factor of safety of 3 where the orders differ by more than a tenth; here it is Roache's 1.25 for three grids.)
FORMAL_ORDER = 2.0
# The highest order that counts where no noise is known that may have raised it: Eça and Hoekstra (2014), Appendix A.
HIGHEST_WITHOUT_NOISE = 1.05 * FORMAL_ORDER
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


@dataclass(frozen=True)
class Fit:
    """A power law of one order through the values of three grids, by weighted least squares."""

    limit: float  # at cells of no size
    finest: float  # at the first of the spacings
    misfit: float  # root of the sum of the squares of the residuals, each over the standard uncertainty of its value


def fit(spacings: Sequence[float], values: Sequence[float], uncertainties: Sequence[float], order: float) -> Fit:
    """The fit f(h) = f(0) + C h^p of an order; standard uncertainties above zero.

    Exact values of first order, f(h) = 20 + h/2:

    >>> exact = fit((1.0, 2.0, 4.0), (20.5, 21.0, 22.0), (0.1, 0.2, 0.4), 1.0)
    >>> round(exact.limit, 9), round(exact.misfit, 9)
    (20.0, 0.0)
    """
    powers = [spacing**order for spacing in spacings]
    weights = [uncertainty**-2.0 for uncertainty in uncertainties]
    total = math.fsum(weights)
    power = math.fsum(map(mul, weights, powers)) / total
    value = math.fsum(map(mul, weights, values)) / total
    apart = [each - power for each in powers]
    slope = math.fsum(w * x * (f - value) for w, x, f in zip(weights, apart, values, strict=True)) / math.fsum(
        w * x * x for w, x in zip(weights, apart, strict=True)
    )
    residuals = ((f - value - slope * x) / u for f, x, u in zip(values, apart, uncertainties, strict=True))
    return Fit(value - slope * power, value + slope * apart[0], math.hypot(*residuals))


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
