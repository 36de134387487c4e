"""Convergence: manufactured series of known order, and everything that must not be extrapolated."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies.cases.rows import Row, at_least, at_most
from studies.convergence.orders import FORMAL_ORDER, ORDERS
from studies.convergence.richardson import (
    LEFT,
    SAFETY,
    SAFETY_UNOBSERVED,
    VERDICTS,
    Convergence,
    Sample,
    converge,
    converge_series,
)
from tests.claims.marked import in_full
from tests.studies.convergence.series import LAYOUTS, curves, widths

HALVING = (1.0, 2.0, 4.0)
UNEVEN = (1.0, 1.4, 2.6)  # r21 = 1.4, r32 = 1.857
LIMIT, ERROR = 20.0, 0.5  # of the manufactured series f(h) = LIMIT + ERROR h^p
QUIET = 1e-5  # noise that is known and small
SOLVED = 1e-9  # relative: what bisection leaves of an order, and round-off of differences


def series(order: float, spacings: Sequence[float], error: float = ERROR) -> list[Sample]:
    return [Sample(h, LIMIT + error * h**order) for h in spacings]


def alone(*values: float) -> Convergence:
    """Values on meshes that are halved, the finest first, one offset each."""
    return converge(Sample(2.0**place, value) for place, value in enumerate(values))


# --- known order ------------------------------------------------------------------------------------


@pytest.mark.parametrize("spacings", [HALVING, UNEVEN, (0.3, 0.31, 0.4)])
@pytest.mark.parametrize("order", [0.5, 1.0, 1.37, 2.0])
@pytest.mark.parametrize("error", [ERROR, -ERROR])
def test_series_of_known_order__gives_order_limit_and_index(
    spacings: Sequence[float], order: float, error: float
) -> None:
    result = converge(series(order, spacings, error))
    assert result.verdict == "converging"
    assert result.order == pytest.approx(order, rel=1e-6)  # differences of numbers near 20
    assert result.extrapolated == pytest.approx(LIMIT, rel=SOLVED)
    assert result.value == result.extrapolated
    true_error = abs(error * spacings[0] ** order)
    assert result.mesh == pytest.approx(LEFT * true_error, rel=1e-6)
    finest = abs(LIMIT + error * spacings[0] ** order)
    assert result.gci == pytest.approx(SAFETY * true_error / finest, rel=1e-6)


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


def test_order__that_noise_may_have_raised_above_the_formal_one_is_reported_and_not_used() -> None:
    result = converge(replace(sample, sub_cell=QUIET) for sample in series(2.6, HALVING))
    assert result.order == pytest.approx(2.6)
    fine, middle = result.levels[0].value, result.levels[1].value
    expected = fine - (middle - fine) / (2.0**FORMAL_ORDER - 1.0)
    assert result.extrapolated == pytest.approx(expected)


# --- what must not be extrapolated ------------------------------------------------------------------


def by_least_squares(values: Sequence[float]) -> float:
    """The uncertainty of the finest value, of cells that are halved: Eça and Hoekstra (2014), Appendix A."""
    f, fits = np.array(values), []
    for order in (1.0, 2.0):
        powers = np.array(HALVING) ** order
        for weights in (np.ones(3), 1.0 / np.array(HALVING)):
            slope, limit = np.polyfit(powers, f, 1, w=np.sqrt(weights))
            residuals = f - limit - slope * powers
            deviation = math.sqrt(float(np.average(residuals**2, weights=weights)) * len(f))
            fits.append((deviation, abs(slope), abs(residuals[0])))
    deviation, error, misfit = min(fits)
    spread = 0.5 * (max(values) - min(values))
    if deviation < spread:
        return SAFETY_UNOBSERVED * error + deviation + misfit
    return SAFETY_UNOBSERVED * deviation / spread * (error + deviation + misfit)


OUTSIDE = [
    ((20.0, 19.0, 22.0), "oscillatory", "change sign"),
    ((20.0, 20.5, 19.9), "oscillatory", "change sign"),
    ((20.0, 17.0, 18.0), "oscillatory", "do not shrink"),
    ((20.0, 20.05, 10.0), "oscillatory", "change sign"),
    ((20.0, 22.0, 23.0), None, "grow with refinement"),
    ((20.0, 21.0, 22.0), None, "grow with refinement"),  # order 0
    ((20.0, 21.0, 21.0), None, "the same value"),
    ((20.0, 20.1, 21.0), None, "outside of 0.5 to 2.1"),  # order 3.2
    ((20.0, 21.0, 22.2), None, "outside of"),  # order 0.26
]
LOW = [values for values, *_ in OUTSIDE if abs(values[2] - values[1]) < math.sqrt(2.0) * abs(values[1] - values[0])]


@pytest.mark.parametrize(("values", "verdict", "reason"), OUTSIDE)
def test_grids_without_noise__that_do_not_converge_have_an_uncertainty_by_least_squares(
    values: Sequence[float], verdict: str | None, reason: str
) -> None:
    result = alone(*values)
    assert result.verdict == (verdict or "not in the asymptotic range")
    assert reason in result.reason
    assert result.value == values[0]
    assert result.mesh == pytest.approx(by_least_squares(values))
    assert math.isnan(result.extrapolated)
    assert math.isnan(result.gci)


@pytest.mark.parametrize("values", [values for values, *_ in OUTSIDE])
def test_grids_with_noise__that_do_not_converge_have_an_index_where_their_differences_shrink(
    values: Sequence[float],
) -> None:
    result = converge(Sample(h, value, sub_cell=QUIET) for h, value in zip(HALVING, values, strict=True))
    index = SAFETY * abs(values[1] - values[0])  # of first order, of cells that are halved
    assert result.mesh == pytest.approx(by_least_squares(values) if values in LOW else index, rel=1e-6)


# --- a worse verdict has no smaller bar -----------------------------------------------------------

RATIOS = st.floats(1.3, 3.0)  # Celik et al. (2008) ask for more than 1.3
FOUND = 1e-6  # relative: what round-off of differences near 20 leaves of an order


def power_law(order: float, ratios: tuple[float, float], difference: float) -> list[Sample]:
    """A power law with this difference of the two finest grids."""
    spacings = (1.0, ratios[0], ratios[0] * ratios[1])
    grown = [math.expm1(order * math.log(h)) / order for h in spacings]
    return [Sample(h, LIMIT + difference * size / grown[1]) for h, size in zip(spacings, grown, strict=True)]


@given(st.floats(ORDERS[0], 6.0), RATIOS, RATIOS, st.sampled_from((ERROR, -ERROR)))
def test_error_bar__covers_the_limit_of_a_power_law(
    order: float, first: float, second: float, difference: float
) -> None:
    # From the lowest asymptotic order on: the lower the order, the less of its error do three grids show.
    result = converge(power_law(order, (first, second), difference))
    limit = LIMIT - difference / math.expm1(order * math.log(first))
    assert abs(result.value - limit) <= result.mesh * (1.0 + FOUND) + FOUND


# --- noise ----------------------------------------------------------------------------------------


def test_two_grids__assume_first_order_and_a_factor_of_three() -> None:
    result = converge([Sample(1.0, 20.0), Sample(1.5, 20.3)])
    assert result.verdict == "two grids"
    assert result.value == 20.0
    assert result.mesh == pytest.approx(SAFETY_UNOBSERVED * 0.3 / 0.5)
    assert math.isnan(result.order)
    assert math.isnan(result.extrapolated)


# --- what noise leaves open of the limit ------------------------------------------------------------


@pytest.mark.claim("bars", "bars", minutes=2.0, short=True)
@pytest.mark.parametrize(("spacings", "offsets"), LAYOUTS)
def test_error_bar__of_synthetic_series_covers_the_limit(
    spacings: tuple[float, ...], offsets: int, compared: Callable[[Row], None]
) -> None:
    """Error bars of three grids hold the limit of at least 94 % of synthetic series, and are no wider than needed.

    Series are monotone of order 1 to 2, steeper than 3, within the scatter of the offsets, noisy, or have a coarsest
    grid outside the asymptotic range; the median bar is at most three times the root mean square of the true errors.
    """
    count, least = (1000, 0.94) if in_full() else (50, 0.91)  # 250 series tell it to 3 of 100
    for width in widths(spacings, offsets, count):
        name = f"{width.kind}, offsets {offsets}, cells of {', '.join(f'{spacing:.3g}' for spacing in spacings)}"
        if width.kind == "all":
            compared(at_least(f"{name}: share covered", limit=least, got=width.covered))
            compared(at_most(f"{name}: median bar over rms error", limit=3.0, got=width.bar / width.error))
        text = f"{width.covered:.1%} covered, median of bar over error {width.ratio:.1f}"
        compared(Row(name, "", text, None))


@pytest.mark.parametrize(("spacings", "offsets"), LAYOUTS)
def test_error_bar__of_synthetic_curves_covers_the_limit_and_is_no_wider_than_needed(
    spacings: tuple[float, ...], offsets: int
) -> None:
    *_, together = curves(spacings, offsets, 10)  # each asserts that its points have one rule
    assert together.covered >= 0.91
    assert together.bar <= 3.0 * together.error


# --- one rule for a series ------------------------------------------------------------------------


def test_series__of_one_order_is_extrapolated_with_it() -> None:
    points = converge_series(series(1.4, UNEVEN, error) for error in (0.2, 0.5, 1.0))
    assert {point.rule for point in points} == {"extrapolated with p = 1.4"}
    assert [point.value for point in points] == pytest.approx([LIMIT] * 3)
    assert "the observed order 1.4 of the series" in points[0].reason


@pytest.mark.parametrize(
    "bad",
    [
        [Sample(h, v) for h, v in zip(HALVING, (20.0, 19.0, 22.0), strict=True)],
        [Sample(h, LIMIT + h) for h in HALVING[1:]],
        [*series(1.0, HALVING), Sample(0.9, math.nan, nothing=True)],
    ],
    ids=["oscillatory", "two grids", "contradicted"],
)
def test_series__with_a_point_that_cannot_be_extrapolated_has_the_finest_values(bad: list[Sample]) -> None:
    points = converge_series([series(1.0, HALVING), bad, series(1.0, HALVING)])
    assert {point.rule for point in points} == {"finest grid"}
    assert "1 of 3 points of the series do not fit the observed order 1" in points[0].reason
    assert points[0].mesh == pytest.approx(SAFETY * ERROR)
    assert repr(points[1]) == repr(converge(bad))  # a repr, because NaN is not NaN


# --- parts of the error bar -------------------------------------------------------------------------


def test_uncertainty__is_the_root_of_the_squares_of_its_parts() -> None:
    samples = [Sample(h, LIMIT + ERROR * h, sub_cell=0.01, rest=0.7) for h in HALVING]
    result = converge(samples)
    parts = (result.mesh, 0.01, 0.7)
    assert (result.offsets, result.measurement) == pytest.approx(parts[1:])
    assert result.uncertainty == pytest.approx(math.hypot(*parts))


# --- failed runs ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("offsets", "runs"), [(0, 4), (2, 7)])
def test_grid_or_offset_without_anything_to_measure__contradicts_the_others(offsets: int, runs: int) -> None:
    """A run that failed says nothing, and one of a coarse grid that does not count decides nothing."""
    spacings = [1.0] * offsets + [h for h in (2.0, 4.0, 8.0) for _ in range(max(offsets, 1))]
    others = [Sample(h, LIMIT + ERROR * h) for h in spacings]
    assert converge([*others, Sample(1.0, math.nan)]).verdict == "converging"
    assert converge([*others, Sample(16.0, math.nan, nothing=True)]).verdict == "converging"
    result = converge([*others, Sample(1.0, math.nan, nothing=True)])
    assert result.verdict == "not in the asymptotic range"
    assert result.value == others[0].value
    assert math.isnan(result.mesh)
    assert math.isnan(result.extrapolated)
    assert f"1 of {runs} runs found nothing to measure" in result.reason


@pytest.mark.parametrize("values", [(), (math.nan,), (math.nan, math.inf)])
def test_nothing__has_no_value(values: Sequence[float]) -> None:
    result = alone(*values)
    assert result.verdict == "no value"
    assert math.isnan(result.value)
    assert math.isnan(result.uncertainty)


# --- properties -------------------------------------------------------------------------------------

VALUES = st.floats(1.0, 100.0, width=32)
LEVELS = st.lists(st.lists(VALUES | st.just(math.nan), min_size=1, max_size=4), max_size=5)
NUMBERS = ("value", "uncertainty", "mesh", "offsets", "measurement", "extrapolated")


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


@given(LEVELS, st.integers(-20, 20), st.integers(-20, 20))
def test_converge__does_not_see_the_units(levels: list[list[float]], of_value: int, of_length: int) -> None:
    plain = converge(samples_of(levels))
    factor = 2.0**of_value  # exact, so that no decision is on the edge
    scaled = converge(
        Sample(s.spacing * 2.0**of_length, s.value * factor, s.sub_cell * factor, s.rest * factor)
        for s in samples_of(levels)
    )
    assert scaled.verdict == plain.verdict
    for name in NUMBERS:
        expected = getattr(plain, name) * factor
        assert getattr(scaled, name) == pytest.approx(expected, rel=SOLVED, nan_ok=True)
    for name in ("order", "gci"):
        expected = getattr(plain, name)
        assert getattr(scaled, name) == pytest.approx(expected, rel=SOLVED, nan_ok=True)


@given(LEVELS)
def test_converge__extrapolates_only_what_converges(levels: list[list[float]]) -> None:
    result = converge(samples_of(levels))
    assert result.verdict in VERDICTS
    assert math.isfinite(result.extrapolated) == (result.verdict == "converging")
    if result.verdict == "converging":
        assert ORDERS[0] <= result.order <= ORDERS[1]
        assert result.value == result.extrapolated
    elif result.verdict != "no value":
        assert result.value == next(level.value for level in result.levels if level.values)
    assert result.verdict == "no value" or result.uncertainty >= result.offsets


@pytest.mark.parametrize("grids", [1, 2, 3])
def test_finest_grid__that_is_too_coarse_has_no_error_bar(grids: int) -> None:
    samples = [
        Sample(2.0**n, 10.0 + 2.0**n, 0.1, 0.1, quality_flags=("too_coarse",) if n == 0 else ()) for n in range(grids)
    ]
    result = converge(samples)
    assert result.verdict == ("single grid" if grids == 1 else "not in the asymptotic range")
    assert result.value == 11.0
    assert math.isnan(result.uncertainty)
    assert math.isnan(result.extrapolated)
    assert "too coarse at the finest" in result.reason
