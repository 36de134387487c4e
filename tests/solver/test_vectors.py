"""Eight numbers at a time: the same answers in kernels, for vectors and for numbers, as in plain Python."""

import math
from typing import Any

import numpy as np
import pytest

from solver.jit import device, kernel
from solver.vectors import (
    LANES,
    absolute,
    alike,
    anywhere,
    exp,
    exponent,
    finite,
    first_lanes,
    floor,
    fraction,
    largest,
    line,
    load,
    log,
    maximum,
    minimum,
    nearest,
    power,
    power_of_two,
    sqrt,
    store,
    total,
    where,
)

# Units in the last place of numbers from 1 to 2; compiled code fuses multiply and add.
LAST_PLACE = 2.3e-16
SMALLEST, LARGEST = 2.2250738585072014e-308, 1.7976931348623157e308
RNG = np.random.default_rng(1)


@device
def exact(x, y):
    """What is computed without rounding, or rounded once: the same bits wherever it runs."""
    return (
        sqrt(x),
        floor(x),
        nearest(x),
        absolute(x),
        minimum(x, y),
        maximum(x, y),
        minimum(x, 0.5),
        maximum(x, 0.5),
        where(x < y, x, y),
        where(x <= y, x, 1.0),
        where(x > y, 1.0, y),
        where((x >= y) & ~(x == y), x, y),
        where((x == y) | (y > 1.0), x, y),
        where(finite(x), x, y),
        where(finite(y), 1.0, x + y),
        alike(2.0, x) + y,
        x + y,
        x - y,
        x * y,
        x / y,
        -x,
        2.0 * y,
        1.0 / y,
    )


@device
def elementary(x, y):
    """Functions of a normal positive number x and of any y; the last three have no rounding."""
    base = maximum(minimum(x, 1e5), 1e-5)
    held = maximum(minimum(exponent(x), 1023.0), -1022.0)
    powers = power(x, 0.31), power(base, minimum(absolute(y), 40.0))
    return (log(x), exp(y), *powers, fraction(x), exponent(x), power_of_two(held))


EXACT, ELEMENTARY = len(exact(1.0, 1.0)), len(elementary(1.0, 1.0))


@kernel
def by_eights(table, out):
    """Both sets of functions of the rows x and y; the last eight only as far as they go."""
    count = table.shape[1]
    for p in range(0, count, LANES):
        lanes = first_lanes(count - p)
        x, y = load(table, 0, p, lanes), load(table, 1, p, lanes)
        values, others = exact(x, y), elementary(x, y)
        for row in range(EXACT):
            store(out, row, p, values[row], lanes)
        for row in range(ELEMENTARY):
            store(out, EXACT + row, p, others[row], lanes)


@kernel
def one_by_one(table, out):
    for p in range(table.shape[1]):
        x, y = table[0, p], table[1, p]
        values, others = exact(x, y), elementary(x, y)
        for row in range(EXACT):
            out[row, p] = values[row]
        for row in range(ELEMENTARY):
            out[EXACT + row, p] = others[row]


compiled_forms = pytest.mark.parametrize("compiled", [by_eights, one_by_one])


def computed(compiled: Any, table: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The exact and the elementary functions of a table (2, n), as a kernel gives them."""
    out = np.zeros((EXACT + ELEMENTARY, table.shape[1]))
    compiled(table, out)
    return out[:EXACT], out[EXACT:]


def same_bits(values: Any, other: Any) -> bool:
    """Whether two arrays have the same bits; any NaN is like any other."""
    values, other = np.asarray(values, float), np.asarray(other, float)
    nan = np.isnan(values) & np.isnan(other)
    return bool((nan | (values.view(np.int64) == other.view(np.int64))).all())


SPECIAL = [0.0, -0.0, 0.5, -0.5, 1.0, 1.5, -1.5, 2.5, 1e300, -1e300, math.inf, -math.inf, math.nan]


def pairs() -> np.ndarray:
    """Pairs of anything, (2, n): special numbers with one another and ordinary ones; no multiple of eight."""
    special = np.array(np.meshgrid(SPECIAL, SPECIAL)).reshape(2, -1)
    return np.concatenate([special, RNG.normal(0.0, 3.0, (2, 300))], axis=1)


@compiled_forms
@np.errstate(invalid="ignore", divide="ignore", over="ignore")
def test_exact_functions__have_the_same_bits_compiled_and_plain(compiled: Any) -> None:
    table = pairs()
    assert table.shape[1] % LANES
    plain = np.array([np.broadcast_to(row, table.shape[1]) for row in exact(*table)])
    assert same_bits(computed(compiled, table)[0], plain)


# Logarithm, exponential, power


def positive() -> np.ndarray:
    """Normal positive numbers of all sizes, many near 1."""
    return np.concatenate(
        [
            np.exp(RNG.uniform(-708.0, 709.7, 20_000)),
            RNG.uniform(0.5, 2.0, 20_000),
            1.0 + RNG.uniform(-1e-6, 1e-6, 20_000),
            [SMALLEST, LARGEST, 1.0, 0.5, 2.0, math.sqrt(0.5), np.nextafter(1.0, 0.0)],
        ]
    )


@compiled_forms
def test_elementary_functions__are_those_of_numpy_compiled_and_plain(compiled: Any) -> None:
    """Logarithm and exponential to two last places, powers to round-off of their logarithm, parts to the bit."""
    x = positive()
    y = RNG.uniform(-708.0, 709.0, x.size)
    plain = np.array(elementary(x, y))
    _, got = computed(compiled, np.array([x, y]))
    assert same_bits(got[4:], plain[4:])
    powers = np.array([x**0.31, np.clip(x, 1e-5, 1e5) ** np.minimum(np.abs(y), 40.0)])
    for values in (got, plain):
        for row, expected in enumerate((np.log(x), np.exp(y), *powers)):
            places = 2.0 + (np.abs(np.log(expected)) if row > 1 else 0.0)
            assert (np.abs(values[row] - expected) <= places * LAST_PLACE * np.abs(expected)).all()


# Reductions


@kernel
def reduced(table):
    """Largest and sum of a line, and whether anything of it is above zero."""
    values = line(table, 0)
    return largest(values), total(values), anywhere(values > 0.0), anywhere(~(values > 0.0))


@pytest.mark.claim("speed", "nan-seen")
@pytest.mark.parametrize("lane", range(LANES))
def test_reductions__pass_over_a_nan_or_show_it(lane: int) -> None:
    """No lane of eight hides a NaN: the largest passes over it, the sum does not, and no comparison holds for it."""
    values = np.arange(1.0, 1.0 + LANES)
    values[lane] = math.nan
    for function in (reduced, reduced.py_func):
        highest, sum_, some, others = function(values[None])
        assert highest == np.nanmax(values)
        assert math.isnan(sum_)
        assert some
        assert others
