"""What the functions of vectors mean: plain Python, for numbers and arrays of numpy.

A NaN stays visible: comparisons with it are false, and ``minimum`` and ``maximum`` keep one in their first argument.
"""

import numpy as np

LANES = 8


def where(condition, one, other):
    """``one`` where the condition holds, else ``other``."""
    return np.where(condition, one, other)[()]


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
    found = np.zeros(LANES)
    stop = min(place + LANES, table.shape[1])
    found[: stop - place] = table[row, place:stop]
    return np.where(lanes, found, 0.0)


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
    return tuple(
        np.stack([np.broadcast_to(one, LANES) for one in (a, b, c, d, e, f, g, h)], axis=1)
    )


def largest(vector):
    """The largest of eight numbers, ignoring NaN."""
    return float(np.fmax.reduce(np.broadcast_to(vector, LANES)))


def total(vector):
    """The sum of eight numbers."""
    return float(np.sum(np.broadcast_to(vector, LANES)))
