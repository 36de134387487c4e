"""Logarithm, exponential and power, from operations that vectors have: one text for a number and for eight."""

from solver.jit import device
from solver.vectors.plain import (
    exponent,
    finite,
    fraction,
    maximum,
    minimum,
    nearest,
    power_of_two,
    where,
)

_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_LOG2_E = 1.44269504088896338700
SMALLEST = 2.2250738585072014e-308  # normal number
_LOWEST, _HIGHEST = -708.0, 709.0  # exponents of e whose powers are normal numbers


@device
def log(value):
    """Natural logarithm of a positive number, to one unit in the last place.

    ln(1 + f) = f - (f^2 / 2 - s (f^2 / 2 + R)) with s = f / (2 + f), R an even polynomial in s; coefficients of
    fdlibm's ``e_log.c`` (Sun Microsystems, 1993).
    """
    part, power = fraction(value), exponent(value)
    low = part < 0.70710678118654752
    part = where(low, part + part, part)
    power = where(low, power - 1.0, power)
    f = part - 1.0
    s = f / (2.0 + f)
    z = s * s
    w = z * z
    odd = w * (
        3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01)
    )
    even = z * (
        6.666666666666735130e-01
        + w
        * (2.857142874366239149e-01 + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01))
    )
    half = 0.5 * f * f
    found = power * _LN2_HIGH - ((half - (s * (half + (odd + even)) + power * _LN2_LOW)) - f)
    return where(finite(value), found, value)


@device
def exp(value):
    """e to a power, held within -708 .. 709; to two units in the last place.

    2^k times the Taylor polynomial of degree 13 of the rest r, |r| <= ln 2 / 2, whose error is 4e-18.
    """
    inside = minimum(maximum(value, _LOWEST), _HIGHEST)
    k = nearest(inside * _LOG2_E)
    r = (inside - k * _LN2_HIGH) - k * _LN2_LOW
    r2 = r * r
    r4 = r2 * r2
    r8 = r4 * r4
    low = (1.0 + r) + r2 * (0.5 + r * 1.66666666666666666667e-01)
    second = (4.16666666666666666667e-02 + r * 8.33333333333333333333e-03) + r2 * (
        1.38888888888888888889e-03 + r * 1.98412698412698412698e-04
    )
    third = (2.48015873015873015873e-05 + r * 2.75573192239858906526e-06) + r2 * (
        2.75573192239858906526e-07 + r * 2.50521083854417187751e-08
    )
    last = 2.08767569878680989792e-09 + r * 1.60590438368216145994e-10
    return ((low + r4 * second) + r8 * (third + r4 * last)) * power_of_two(k)


@device
def power(base, exponent):
    """A number that is not negative to a power: e to the product with its logarithm.

    Zero to a power above zero is zero. Relative error: 1e-16 times the logarithm of the answer.
    """
    raised = exp(exponent * log(maximum(base, SMALLEST)))
    return where(base > 0.0, raised, where(exponent > 0.0, 0.0, 1.0) + 0.0 * base)
