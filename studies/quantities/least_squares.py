"""Least squares with intervals by Student's t, and the information criterion by which fits are compared."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

CONFIDENCE = 0.95  # of the intervals
# Relative tolerances of the iteration of a non-linear fit: near round-off, so that exact data give exact constants.
EXACT = 1e-14
# A column (its length set to 1) that is nearer than this to a sum of others tells no constant apart; derivatives by
# finite differences are themselves exact to about 1e-8.
DEPENDENT, DEPENDENT_DERIVATIVE = 1e-10, 1e-5


@dataclass(frozen=True)
class Solution:
    """Constants that fit data best."""

    constants: np.ndarray  # (constants,)
    intervals: np.ndarray  # (constants,) half lengths at CONFIDENCE; infinite without a degree of freedom
    residuals: np.ndarray  # (data,) in units of the data
    freedom: int  # data minus constants


class NotIdentified(Exception):
    """The data do not tell the constants apart."""


def linear(columns: Sequence[np.ndarray], y: np.ndarray, errors: np.ndarray | None = None) -> Solution:
    """The constants c of y = sum of c x column, (data,) each; raises NotIdentified.

    ``errors`` are standard uncertainties of y: their relative sizes weight the data, and the scatter sets the scale.

    >>> x = np.array([1.0, 2.0, 3.0, 4.0])
    >>> solution = linear([x, np.ones(4)], np.array([1.1, 1.9, 3.1, 3.9]))
    >>> solution.constants.round(12).tolist(), float(solution.intervals[0].round(3))
    ([0.96, 0.1], 0.243)
    """
    scale = np.ones(len(y)) if errors is None else errors
    matrix = np.column_stack(columns) / scale[:, np.newaxis]
    _check_rank(matrix, DEPENDENT)
    constants, *_ = np.linalg.lstsq(matrix, y / scale, rcond=None)
    return _solution(constants, matrix, y - np.column_stack(columns) @ constants, scale)


def nonlinear(
    function: Callable[[np.ndarray], np.ndarray], start: np.ndarray, y: np.ndarray, errors: np.ndarray | None = None
) -> Solution:
    """The constants for which ``function(constants)`` is nearest to y, from a start; raises NotIdentified.

    The intervals are those of the function made linear at the constants (Seber and Wild 2003, section 2.1.2).
    """
    from scipy.optimize import least_squares

    scale = np.ones(len(y)) if errors is None else errors
    answer = least_squares(
        lambda constants: (function(constants) - y) / scale,
        start,
        method="lm",
        x_scale="jac",
        xtol=EXACT,
        ftol=EXACT,
        gtol=EXACT,
    )
    _check_rank(answer.jac, DEPENDENT_DERIVATIVE)
    return _solution(answer.x, answer.jac, y - function(answer.x), scale)


def aic(mean_square: float, count: int, constants: int) -> float:
    """Akaike's criterion n ln(RSS/n) + 2 k of a fit by least squares, k constants with the variance.

    Burnham and Anderson (2002), Model Selection and Multimodel Inference, 2nd edition, section 2.2 (recalled, not
    read). Fits are comparable whose mean squares are of the same data in the same units.
    """
    return count * math.log(mean_square) + 2.0 * (constants + 1)


def aicc(mean_square: float, count: int, constants: int) -> float:
    """Akaike's criterion, corrected for few data; infinite where these are too few for the correction.

    AICc = AIC + 2 k (k + 1) / (n - k - 1): Hurvich and Tsai (1989), Biometrika 76, 297.
    """
    k = constants + 1
    if count <= k + 1:
        return math.inf
    return aic(mean_square, count, constants) + 2.0 * k * (k + 1.0) / (count - k - 1)


def _check_rank(matrix: np.ndarray, tolerance: float) -> None:
    sizes = np.linalg.norm(matrix, axis=0)
    scaled = matrix / np.where(sizes > 0.0, sizes, 1.0)
    if len(matrix) < matrix.shape[1] or np.linalg.matrix_rank(scaled, tol=tolerance) < matrix.shape[1]:
        raise NotIdentified


def _solution(constants: np.ndarray, matrix: np.ndarray, residuals: np.ndarray, scale: np.ndarray) -> Solution:
    """Intervals and likelihood; ``matrix`` has the derivatives of the data over their scale."""
    from scipy.special import stdtrit

    freedom = len(residuals) - len(constants)
    squares = float(((residuals / scale) ** 2).sum())
    intervals = np.full(len(constants), math.inf)
    if freedom > 0:
        covariance = np.linalg.inv(matrix.T @ matrix) * squares / freedom
        reach = float(stdtrit(freedom, 0.5 * (1.0 + CONFIDENCE)))
        intervals = reach * np.sqrt(np.diag(covariance))
    return Solution(constants, intervals, residuals, freedom)
