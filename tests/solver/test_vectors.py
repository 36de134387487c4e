"""Eight numbers at a time: the same answers in kernels, for vectors and for numbers, as in plain Python."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

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
    number,
    power,
    power_of_two,
    set_line,
    spread,
    sqrt,
    store,
    store_whole,
    total,
    transposed,
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
def halves(x):
    """The two parts of normal positive numbers."""
    return fraction(x), exponent(x), power_of_two(maximum(minimum(exponent(x), 1023.0), -1022.0))


@device
def elementary(x, y):
    """Functions of a positive number and of any."""
    base = maximum(minimum(x, 1e5), 1e-5)
    return log(x), exp(y), power(x, 0.31), power(base, minimum(absolute(y), 40.0))


@kernel
def exact_of_vectors(table, out):
    """By eights; the last ones only as far as they go."""
    count = table.shape[1]
    for p in range(0, count, LANES):
        lanes = first_lanes(count - p)
        found = exact(load(table, 0, p, lanes), load(table, 1, p, lanes))
        for row in range(len(found)):
            store(out, row, p, found[row], lanes)


@kernel
def exact_of_numbers(table, out):
    """One by one."""
    for p in range(table.shape[1]):
        found = exact(table[0, p], table[1, p])
        for row in range(len(found)):
            out[row, p] = found[row]


@kernel
def elementary_of_vectors(table, out):
    """By eights."""
    count = table.shape[1]
    for p in range(0, count, LANES):
        lanes = first_lanes(count - p)
        x, y = load(table, 0, p, lanes), load(table, 1, p, lanes)
        found, parts = elementary(x, y), halves(x)
        for row in range(4):
            store(out, row, p, found[row], lanes)
        for row in range(3):
            store(out, 4 + row, p, parts[row], lanes)


@kernel
def elementary_of_numbers(table, out):
    """One by one."""
    for p in range(table.shape[1]):
        found, parts = elementary(table[0, p], table[1, p]), halves(table[0, p])
        for row in range(4):
            out[row, p] = found[row]
        for row in range(3):
            out[4 + row, p] = parts[row]


def same_bits(one: Any, other: Any) -> bool:
    """Whether two arrays have the same bits; any NaN is like any other."""
    one, other = np.asarray(one, float), np.asarray(other, float)
    nan = np.isnan(one) & np.isnan(other)
    return bool((nan | (one.view(np.int64) == other.view(np.int64))).all())


SPECIAL = [0.0, -0.0, 0.5, -0.5, 1.0, 1.5, -1.5, 2.5, 1e300, -1e300, math.inf, -math.inf, math.nan]


def pairs() -> np.ndarray:
    """Pairs of anything, (2, n): special numbers with one another and ordinary ones; no multiple of eight."""
    special = np.array(np.meshgrid(SPECIAL, SPECIAL)).reshape(2, -1)
    return np.concatenate([special, RNG.normal(0.0, 3.0, (2, 300))], axis=1)


@pytest.mark.parametrize("compiled", [exact_of_vectors, exact_of_numbers])
@np.errstate(invalid="ignore", divide="ignore", over="ignore")
def test_exact_functions__have_the_same_bits_compiled_and_plain(compiled: Any) -> None:
    table = pairs()
    assert table.shape[1] % LANES
    plain = np.array([np.broadcast_to(row, table.shape[1]) for row in exact(*table)])
    got = np.zeros_like(plain)
    compiled(table, got)
    assert same_bits(got, plain)


@np.errstate(invalid="ignore", divide="ignore", over="ignore")
def test_plain_functions__act_on_numbers_as_on_arrays() -> None:
    table = pairs()
    arrays = exact(*table)
    for p in range(table.shape[1]):
        for row, found in enumerate(exact(table[0, p], table[1, p])):
            assert np.shape(found) == ()
            assert same_bits(found, np.broadcast_to(arrays[row], table.shape[1])[p])


# Logarithm, powers


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


def test_log__is_that_of_numpy_to_two_last_places() -> None:
    x = positive()
    assert np.allclose(log(x), np.log(x), rtol=2.0 * LAST_PLACE, atol=0.0)
    assert log(1.0) == 0.0
    with np.errstate(invalid="ignore"):
        assert log(math.inf) == math.inf


def test_exp__is_that_of_numpy_to_two_last_places() -> None:
    y = np.concatenate([RNG.uniform(-708.0, 709.0, 40_000), RNG.uniform(-1.0, 1.0, 20_000)])
    assert np.allclose(exp(y), np.exp(y), rtol=2.0 * LAST_PLACE, atol=0.0)
    assert exp(0.0) == 1.0


@pytest.mark.parametrize(("beyond", "held"), [(-1e9, -708.0), (-math.inf, -708.0), (1e9, 709.0)])
def test_exp__holds_on_to_normal_numbers(beyond: float, held: float) -> None:
    assert exp(beyond) == exp(held)
    assert math.isclose(exp(held), math.exp(held), rel_tol=2.0 * LAST_PLACE)


def test_power__is_that_of_numpy_to_round_off_of_its_logarithm() -> None:
    base = np.exp(RNG.uniform(-30.0, 30.0, 40_000))
    to = RNG.uniform(-20.0, 20.0, 40_000)
    expected = base**to
    error = np.abs(power(base, to) / expected - 1.0)
    assert (error <= LAST_PLACE * (2.0 + np.abs(np.log(expected)))).all()


def test_power__of_zero_is_zero_and_to_zero_is_one() -> None:
    assert power(0.0, 0.31) == 0.0
    assert power(0.0, 2.0) == 0.0
    assert power(3.0, 0.0) == power(0.0, 0.0) == 1.0


def test_parts__make_the_number() -> None:
    x = positive()
    part, whole = fraction(x), exponent(x)
    assert ((part >= 0.5) & (part < 1.0)).all()
    inside = np.abs(whole) <= 1022.0
    assert (part[inside] * power_of_two(whole[inside]) == x[inside]).all()


@pytest.mark.parametrize("compiled", [elementary_of_vectors, elementary_of_numbers])
def test_elementary_functions__are_the_same_compiled_and_plain(compiled: Any) -> None:
    """The parts of numbers to the bit; the others err as little, and so differ by twice that."""
    x = positive()
    y = RNG.uniform(-700.0, 700.0, x.size)
    plain = np.array([*elementary(x, y), *halves(x)])
    got = np.zeros_like(plain)
    compiled(np.array([x, y]), got)
    assert same_bits(got[4:], plain[4:])
    powers = np.array([x**0.31, np.clip(x, 1e-5, 1e5) ** np.minimum(np.abs(y), 40.0)])
    for one in (got, plain):
        for row, expected in enumerate((np.log(x), np.exp(y), *powers)):
            places = 2.0 + (np.abs(np.log(expected)) if row > 1 else 0.0)
            assert (np.abs(one[row] - expected) <= places * LAST_PLACE * np.abs(expected)).all()


# NaN


def plain_and_compiled(x: float, y: float) -> list[np.ndarray]:
    """log x, exp y, powers of them, plain and in both kernels."""
    table = np.full((2, LANES), [[x], [y]])
    found = [np.array(elementary(x, y), float)]
    for compiled in (elementary_of_vectors, elementary_of_numbers):
        out = np.zeros((7, LANES))
        compiled(table, out)
        found += [out[:4, 0], out[:4, LANES - 1]]
    return found


@pytest.mark.filterwarnings("ignore:invalid value encountered in cast")
def test_nan__stays_visible_in_logarithm_and_powers() -> None:
    for found in plain_and_compiled(math.nan, 1.0):
        assert np.isnan(found).tolist() == [True, False, True, True]
    for found in plain_and_compiled(2.0, math.nan):
        assert np.isnan(found).tolist() == [False, True, False, True]


def test_nan__stays_visible_in_the_first_argument_of_a_bound() -> None:
    """And passes through a choice; what is compared with it fails."""
    nan = math.nan
    assert np.isnan([minimum(nan, 1.0), maximum(nan, 1.0)]).all()
    assert [minimum(1.0, nan), maximum(1.0, nan)] == [1.0, 1.0]
    assert np.isnan(where(True, nan, 1.0))
    assert where(nan <= nan, 1.0, 2.0) == where(nan > 0.0, 1.0, 2.0) == 2.0
    assert not finite(nan)
    assert not finite(math.inf)


# Lanes and memory


@kernel
def copied(table, out, row, place, count):
    """Some neighbours of a row to the same place of another table."""
    lanes = first_lanes(count)
    store(out, row, place, load(table, row, place, lanes), lanes)


@kernel
def loaded(table, out, row, place, count):
    """Some neighbours of a row, and what stands in the masked lanes, to a line of eight."""
    set_line(out, 0, load(table, row, place, first_lanes(count)))


@given(st.integers(0, 2), st.integers(0, 11), st.integers(-1, 10))
def test_load__reads_its_lanes_and_zero(row: int, place: int, count: int) -> None:
    """What is masked is not read: NaN stands there, and beyond the last row nothing."""
    count = min(count, 12 - place)
    table = np.full((3, 12), math.nan)
    inside = max(min(count, LANES), 0)
    table[row, place : place + inside] = 1.0 + np.arange(inside)
    expected = np.zeros(LANES)
    expected[:inside] = table[row, place : place + inside]
    for function in (loaded, loaded.py_func):
        out = np.full((1, LANES), 7.0)
        function(table, out, row, place, count)
        assert same_bits(out[0], expected)


@given(st.integers(0, 2), st.integers(0, 11), st.integers(-1, 10))
def test_store__touches_its_lanes_only(row: int, place: int, count: int) -> None:
    count = min(count, 12 - place)
    table = RNG.normal(size=(3, 12))
    expected = np.full((3, 12), 7.0)
    inside = max(min(count, LANES), 0)
    expected[row, place : place + inside] = table[row, place : place + inside]
    for function in (copied, copied.py_func):
        out = np.full((3, 12), 7.0)
        function(table, out, row, place, count)
        assert same_bits(out, expected)


@kernel
def stored_numbers(out, mask):
    """A number in each lane, and whole numbers."""
    store(out, 0, 0, spread(3.0), load(mask, 0, 0, first_lanes(LANES)) > 0.5)


@given(st.integers(0, 2**LANES - 1))
def test_store__takes_any_mask(bits: int) -> None:
    mask = np.array([[float(bits >> lane & 1) for lane in range(LANES)]])
    for function in (stored_numbers, stored_numbers.py_func):
        out = np.full((1, LANES), 7.0)
        function(out, mask)
        assert (out == np.where(mask > 0.0, 3.0, 7.0)).all()


@kernel
def moved(table, places, out):
    """Whole numbers, single numbers and lines."""
    store_whole(places, 2, line(table, 1))
    set_line(out, 0, line(table, 2))
    out[1, 0] = number(table, 2, 5)


def test_lines__and_whole_numbers_come_to_their_places() -> None:
    table = np.floor(RNG.uniform(-1e9, 1e9, (3, LANES)))
    for function in (moved, moved.py_func):
        places, out = np.zeros(12, np.int64), np.zeros((2, LANES))
        function(table, places, out)
        assert places.tolist() == [0, 0, *table[1].astype(int).tolist(), 0, 0]
        assert (out[0] == table[2]).all()
        assert out[1, 0] == table[2, 5]


@kernel
def turned(table, out):
    """The eight lines of a table as columns."""
    found = transposed(
        line(table, 0),
        line(table, 1),
        line(table, 2),
        line(table, 3),
        line(table, 4),
        line(table, 5),
        line(table, 6),
        line(table, 7),
    )
    for row in range(LANES):
        set_line(out, row, found[row])


@pytest.mark.parametrize("function", [turned, turned.py_func], ids=["compiled", "plain"])
def test_transposed__changes_rows_and_columns(function: Any) -> None:
    table, out = RNG.normal(size=(LANES, LANES)), np.zeros((LANES, LANES))
    function(table, out)
    assert (out == table.T).all()


# Reductions


@kernel
def reduced(table):
    """Largest and sum of a line, and whether anything of it is above zero."""
    values = line(table, 0)
    return largest(values), total(values), anywhere(values > 0.0), anywhere(~(values > 0.0))


@given(st.lists(st.floats(-1e6, 1e6), min_size=LANES, max_size=LANES))
def test_reductions__are_those_of_the_eight_numbers(values: list[float]) -> None:
    above = [value > 0.0 for value in values]
    for function in (reduced, reduced.py_func):
        highest, sum_, some, others = function(np.array([values]))
        assert highest == max(values)
        assert math.isclose(sum_, math.fsum(values), rel_tol=1e-12, abs_tol=1e-8)
        assert (bool(some), bool(others)) == (any(above), not all(above))


@pytest.mark.parametrize("lane", range(LANES))
def test_reductions__pass_over_a_nan_or_show_it(lane: int) -> None:
    """The largest passes over it, the sum does not, and no comparison holds for it."""
    values = np.arange(1.0, 1.0 + LANES)
    values[lane] = math.nan
    for function in (reduced, reduced.py_func):
        highest, sum_, some, others = function(values[None])
        assert highest == np.nanmax(values)
        assert math.isnan(sum_)
        assert some
        assert others
