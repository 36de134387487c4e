"""Convergence: manufactured series of known order, and everything that shows no order."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies.convergence.richardson import COVERAGE, ORDERS, SAFETY, VERDICTS, Convergence, Sample, converge
from tests.claims.marked import in_full
from tests.claims.rows import Row, at_least, at_most
from tests.studies.convergence.series import LAYOUTS, coverages

HALVING = (1.0, 2.0, 4.0)
LIMIT, ERROR = 20.0, 0.5  # of the manufactured series f(h) = LIMIT + ERROR h^p
SOLVED = 1e-9  # relative: what bisection leaves of an order, and round-off of differences
ROUND = 1e-6  # relative: what round-off of differences of numbers near 20 leaves


def series(order: float, spacings: Sequence[float], error: float = ERROR) -> list[Sample]:
    return [Sample(h, LIMIT + error * h**order) for h in spacings]


def alone(*values: float) -> Convergence:
    """Values on meshes that are halved, the finest first, one offset each, without noise."""
    return converge(Sample(2.0**place, value) for place, value in enumerate(values))


# --- known order ------------------------------------------------------------------------------------


@given(
    st.floats(0.51, 2.09), st.floats(1.1, 3.0), st.floats(1.1, 3.0), st.sampled_from((ERROR, -ERROR))
)  # within ``ORDERS``
def test_series_of_known_order__gives_order_limit_and_index(
    order: float, first: float, second: float, error: float
) -> None:
    result = converge(series(order, (1.0, first, first * second), error))
    assert result.verdict == "converging"
    assert result.order == pytest.approx(order, rel=ROUND)
    assert result.extrapolated == pytest.approx(LIMIT, rel=SOLVED)
    assert result.value == LIMIT + error
    assert result.mesh == pytest.approx(SAFETY * abs(error), rel=ROUND)
    assert result.gci == pytest.approx(result.mesh / result.value)


@pytest.mark.parametrize(
    ("values", "cells", "order", "limit", "index"),
    [
        ((6.063, 5.972, 5.863), (18_000, 8_000, 4_500), 1.53, 6.1685, 0.022),
        ((10.7880, 10.7250, 10.6050), (18_000, 4_500, 980), 0.75, 10.8801, 0.011),
    ],
)
def test_published_example__of_celik_et_al_2008_table_1(
    values: Sequence[float], cells: Sequence[int], order: float, limit: float, index: float
) -> None:
    result = converge(Sample(n**-0.5, value) for n, value in zip(cells, values, strict=True))
    assert round(result.order, 2) == order
    assert round(result.extrapolated, 4) == limit
    assert round(result.gci, 3) == index


# --- no known order ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ((20.0, 19.0, 22.0), "change sign"),
        ((20.0, 17.0, 18.0), "change sign"),
        ((20.0, 22.0, 23.0), "do not shrink"),
        ((20.0, 21.0, 22.0), "do not shrink"),  # order 0
        ((20.0, 21.0, 21.0), "not above the noise"),
        ((20.0, 20.1, 21.0), "order 3.2 is outside of 0.5 to 2.1"),
        ((20.0, 21.0, 22.2), "order 0.26 is outside of"),
        ((20.0, 20.3), "two resolutions show no order"),
    ],
)
def test_grids_that_show_no_order__have_the_finest_value_and_no_mesh_error(
    values: Sequence[float], reason: str
) -> None:
    result = alone(*values)
    assert result.verdict == "order unknown"
    assert reason in result.reason
    assert result.value == values[0]
    assert all(math.isnan(number) for number in (result.mesh, result.order, result.extrapolated, result.gci))


def test_single_grid__states_the_error_of_its_reading_alone() -> None:
    result = converge([Sample(1.0, 20.0, sub_cell=0.3, rest=0.4)])
    assert result.verdict == "single grid"
    assert math.isnan(result.mesh)
    assert result.uncertainty == pytest.approx(0.5)


# --- noise ----------------------------------------------------------------------------------------


def test_noise__shifts_each_value_to_the_lowest_order_and_the_largest_error() -> None:
    noise, values = 0.01, [sample.value for sample in series(1.0, HALVING)]
    result = converge(replace(sample, sub_cell=noise * sample.spacing) for sample in series(1.0, HALVING))
    shifts = [COVERAGE * noise * h * way for h, way in zip(HALVING, (-1.0, 1.0, -1.0), strict=True)]
    fine, middle, coarse = (value + shift for value, shift in zip(values, shifts, strict=True))
    # Of halved cells: r^p = (f3 - f2)/(f2 - f1).
    assert result.mesh == pytest.approx(SAFETY * (middle - fine) / ((coarse - middle) / (middle - fine) - 1.0))
    assert result.order == pytest.approx(1.0, rel=ROUND)
    assert result.gci * result.value == pytest.approx(SAFETY * ERROR)


@pytest.mark.parametrize(("noise", "reason"), [(0.05, "may be below 0.5"), (0.2, "not above the noise")])
def test_noise__that_may_have_raised_the_order_leaves_it_unknown(noise: float, reason: str) -> None:
    result = converge(replace(sample, sub_cell=noise * sample.spacing) for sample in series(0.8, HALVING))
    assert result.verdict == "order unknown"
    assert reason in result.reason


@pytest.mark.claim("bars", "bars", minutes=1.0, short=True)
@pytest.mark.parametrize(("spacings", "offsets"), LAYOUTS)
def test_error_bar__of_synthetic_series_covers_the_limit(
    spacings: tuple[float, ...], offsets: int, compared: Callable[[Row], None]
) -> None:
    """Where three grids are called converging, their bar holds the limit of at least 95 % of noisy synthetic series.

    Of series of one order from 0.6 to 2; the median bar is at most three times the true error. What three grids cannot
    see is counted beside it: of series whose coarsest grid is outside of the asymptotic range fewer limits are held.
    """
    for each in coverages(spacings, offsets, 2000 if in_full() else 200):
        name = f"{each.kind}, offsets {offsets}, cells of {', '.join(f'{spacing:.3g}' for spacing in spacings)}"
        if each.kind == "of one order":
            compared(at_least(f"{name}: share covered", limit=0.95, got=each.covered))
            compared(at_most(f"{name}: median of bar over error", limit=3.0, got=each.ratio))
        if each.kind == "quiet":
            compared(at_least(f"{name}: share converging", limit=0.5, got=each.judged))
        text = f"{each.judged:.1%} converging, {each.covered:.1%} covered, median of bar over error {each.ratio:.1f}"
        compared(Row(name, "", text, None))


# --- failed runs ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("offsets", "runs"), [(0, 4), (2, 7)])
def test_grid_or_offset_without_anything_to_measure__contradicts_the_others(offsets: int, runs: int) -> None:
    """A run that failed says nothing, and one of a coarse grid that does not count decides nothing."""
    spacings = [1.0] * offsets + [h for h in (2.0, 4.0, 8.0) for _ in range(max(offsets, 1))]
    others = [Sample(h, LIMIT + ERROR * h) for h in spacings]
    assert converge([*others, Sample(1.0, math.nan)]).verdict == "converging"
    assert converge([*others, Sample(16.0, math.nan, nothing=True)]).verdict == "converging"
    result = converge([*others, Sample(1.0, math.nan, nothing=True)])
    assert result.verdict == "order unknown"
    assert result.value == others[0].value
    assert math.isnan(result.mesh)
    assert f"1 of {runs} runs found nothing to measure" in result.reason


@pytest.mark.parametrize("values", [(), (math.nan,), (math.nan, math.inf)])
def test_nothing__has_no_value(values: Sequence[float]) -> None:
    result = alone(*values)
    assert result.verdict == "no value"
    assert math.isnan(result.value)
    assert math.isnan(result.uncertainty)


@pytest.mark.parametrize("grids", [1, 2, 3])
def test_finest_grid__that_is_too_coarse_has_no_error_bar(grids: int) -> None:
    samples = [
        Sample(2.0**n, 10.0 + 2.0**n, 0.1, 0.1, quality_flags=("too_coarse",) if n == 0 else ()) for n in range(grids)
    ]
    result = converge(samples)
    assert result.verdict == ("single grid" if grids == 1 else "order unknown")
    assert result.value == 11.0
    assert math.isnan(result.uncertainty)
    assert "too coarse at the finest" in result.reason


# --- properties -------------------------------------------------------------------------------------

VALUES = st.floats(1.0, 100.0, width=32)
LEVELS = st.lists(st.lists(VALUES | st.just(math.nan), min_size=1, max_size=4), max_size=5)


def samples_of(levels: Sequence[Sequence[float]]) -> list[Sample]:
    return [
        Sample(1.5**place, value, sub_cell=0.01, rest=0.02) for place, level in enumerate(levels) for value in level
    ]


@given(LEVELS, st.randoms(use_true_random=False))
def test_converge__does_not_see_the_order_of_runs(levels: list[list[float]], random: object) -> None:
    samples = samples_of(levels)
    shuffled = list(samples)
    random.shuffle(shuffled)  # type: ignore[attr-defined]
    assert repr(converge(shuffled)) == repr(converge(samples))  # a repr, because NaN is not NaN


@given(LEVELS)
def test_converge__has_a_mesh_error_only_where_converging(levels: list[list[float]]) -> None:
    result = converge(samples_of(levels))
    assert result.verdict in VERDICTS
    assert math.isfinite(result.mesh) == math.isfinite(result.extrapolated) == (result.verdict == "converging")
    if result.verdict == "converging":
        assert ORDERS[0] <= result.order <= ORDERS[1]
        assert result.mesh >= result.gci * abs(result.value) * (1.0 - ROUND)
    if result.verdict != "no value":
        assert result.value == next(level.value for level in result.levels if level.values)
        assert result.uncertainty >= result.offsets
