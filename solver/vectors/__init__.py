"""Eight numbers at a time: a vector type for kernels, and the elementary functions of the laws.

The laws are written once, without ``if``: ``where``, ``minimum`` and ``maximum`` choose, and the same text acts on a
number, on eight numbers inside a kernel, and on arrays of numpy in plain Python. Inside kernels eight doubles are one
value of the type ``Vector`` and eight truths one of the type ``Mask`` (LLVM's <8 x double> and <8 x i1>), because
numba's own loops over scalar text with calls and branches are not vectorised.

``bare``                an array without its reference count, which costs more than the work in inner loops
``load``, ``store``     eight neighbours in a row of a table, only the first so many of them
``line``, ``set_line``  the eight numbers of a row of a table with eight columns
``transposed``          eight vectors as a matrix, rows and columns changed over

A NaN stays visible: comparisons with it are false, and ``minimum`` and ``maximum`` keep one in their first argument.

The plain Python here says what each function means, for numbers and arrays of numpy; ``compiled.py`` gives kernels the
code for it. ``log``, ``exp`` and ``power`` are made of the others, and so are one text for both.
"""

import importlib

import numpy as np

from solver.jit import device, when_compiling

LANES = 8
_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_LOG2_E = 1.44269504088896338700
SMALLEST = 2.2250738585072014e-308  # normal number
_LOWEST, _HIGHEST = -708.0, 709.0  # exponents of e whose powers are normal numbers


def where(condition, value, other):
    """``value`` where the condition holds, else ``other``."""
    return np.where(condition, value, other)[()]


def minimum(value, bound):
    """The smaller of two; NaN where the first is."""
    return where(bound < value, bound, value)


def maximum(value, bound):
    """The larger of two; NaN where the first is."""
    return where(bound > value, bound, value)


def absolute(value):
    """The value without its sign."""
    return np.abs(value)


def sqrt(value):
    """Square root; NaN below zero."""
    return np.sqrt(value)


def floor(value):
    """The largest whole number that is not larger."""
    return np.floor(value)


def nearest(value):
    """The nearest whole number."""
    return np.rint(value)


def fraction(value):
    """m of value = m 2^e with m in 1/2 .. 1, for normal positive numbers."""
    return np.frexp(value)[0]


def exponent(value):
    """e of value = m 2^e with m in 1/2 .. 1, for normal positive numbers."""
    return np.float64(1.0) * np.frexp(value)[1]


def power_of_two(exponent):
    """2^e of a whole number e within -1022 .. 1023."""
    return np.ldexp(1.0, np.asarray(exponent).astype(np.int64))[()]


def anywhere(condition):
    """Whether a condition holds for any of the numbers."""
    return bool(np.any(condition))


def counted(condition):
    """Number of lanes for which a condition holds."""
    return int(np.sum(condition))


def finite(value):
    """Whether a value is a number and not infinite."""
    return np.isfinite(value)


def first_lanes(count):
    """The mask of the first ``count`` lanes; all of them from eight on."""
    return np.arange(LANES) < count


def alike(value, other):
    """The value as a scalar or as a vector, like ``other``."""
    return value + np.zeros(np.shape(other))[()]


def spread(value):
    """A number as a vector of eight."""
    return np.full(LANES, float(value))


def load(table, row, place, lanes):
    """Eight neighbours of a row of a table from a place on; zero where a lane is masked."""
    neighbours = np.zeros(LANES)
    stop = min(place + LANES, table.shape[1])
    neighbours[: stop - place] = table[row, place:stop]
    return np.where(lanes, neighbours, 0.0)


def store(table, row, place, values, lanes):
    """Write eight neighbours of a row of a table from a place on, but for the masked lanes."""
    for lane in np.flatnonzero(lanes):
        table[row, place + lane] = np.broadcast_to(values, LANES)[lane]


def store_whole(places, place, values):
    """Write eight neighbours of a row of whole numbers, from a place on."""
    places[place : place + LANES] = np.broadcast_to(values, LANES).astype(np.int64)


def bare(array):
    """A contiguous array of one or two dimensions as inner loops take it; its owner must outlive it."""
    return array


def number(table, row, place):
    """One number of a table; negative places do not wrap."""
    return table[row, place]


def element(array, place):
    """One number of an array; negative places do not wrap."""
    return array[place]


def mark(flags, place):
    """Set one of an array of flags."""
    flags[place] = 1


def line(table, row):
    """The eight columns of a row of a table."""
    return table[row].copy()


def set_line(table, row, values):
    """Write the eight columns of a row of a table."""
    table[row] = values


def transposed(a, b, c, d, e, f, g, h):
    """The columns of the matrix whose rows are eight vectors."""
    return tuple(np.stack([np.broadcast_to(row, LANES) for row in (a, b, c, d, e, f, g, h)], axis=1))


def largest(vector):
    """The largest of eight numbers, ignoring NaN."""
    return float(np.fmax.reduce(np.broadcast_to(vector, LANES)))


def total(vector):
    """The sum of eight numbers."""
    return float(np.sum(np.broadcast_to(vector, LANES)))


@device
def log(value):
    """Natural logarithm of a positive number, to one unit in the last place.

    ln(1 + f) = f - (f^2 / 2 - s (f^2 / 2 + R)) with s = f / (2 + f), R an even polynomial in s; coefficients of
    fdlibm's ``e_log.c`` (Sun Microsystems, 1993).
    """
    part, whole = fraction(value), exponent(value)
    low = part < 0.70710678118654752
    part = where(low, part + part, part)
    whole = where(low, whole - 1.0, whole)
    f = part - 1.0
    s = f / (2.0 + f)
    z = s * s
    w = z * z
    odd = w * (3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01))
    even = z * (
        6.666666666666735130e-01
        + w * (2.857142874366239149e-01 + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01))
    )
    half = 0.5 * f * f
    logarithm = whole * _LN2_HIGH - ((half - (s * (half + (odd + even)) + whole * _LN2_LOW)) - f)
    return where(finite(value), logarithm, value)


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


@when_compiling
def _register() -> None:
    """Import what registers the code of the functions above, by name: it imports them, and takes numba."""
    importlib.import_module(f"{__name__}.compiled")
