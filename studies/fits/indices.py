"""Sobol indices: the share of the variance of a function that each of its inputs explains, with intervals."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from studies.fits.surrogate import Surrogate
from studies.quantities.least_squares import CONFIDENCE

# Points of each of the two designs, a power of two; the function is evaluated (inputs + 2) times as often.
SAMPLES = 4096
RESAMPLES = 500  # of the bootstrap
SEED = 1


@dataclass(frozen=True)
class SobolIndex:
    """A share of the variance with its interval at ``CONFIDENCE``, by the bootstrap."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class InputIndices:
    """The shares of one input."""

    name: str
    first: SobolIndex  # by itself
    total: SobolIndex  # with its interactions


def indices_of(
    function: Callable[[np.ndarray], np.ndarray],
    names: Sequence[str],
    bounds: Sequence[tuple[float, float]],
    *,
    samples: int = SAMPLES,
    seed: int = SEED,
) -> list[InputIndices]:
    """Sobol indices of a function of (places, inputs) whose inputs are uniform between bounds.

    Estimators of Saltelli et al. (2010), Comput. Phys. Commun. 181, 259, on a Sobol sequence: ``scipy.stats``.
    """
    from scipy.stats import qmc, sobol_indices

    if len(names) == 1:
        whole = SobolIndex(1.0, 1.0, 1.0)
        return [InputIndices(names[0], whole, whole)]
    count = len(names)
    lows, highs = np.array(bounds).T
    both = qmc.Sobol(2 * count, rng=seed).random(samples)
    a, b = (lows + (highs - lows) * half for half in (both[:, :count], both[:, count:]))
    mixed = np.array([function(np.where(np.arange(count) == place, b, a)) for place in range(count)])
    f_a, f_b = function(a), function(b)

    def estimates(chosen: np.ndarray | slice) -> np.ndarray:
        """First and total indices from some of the points: (2, inputs)."""
        values = {"f_A": f_a[None, chosen], "f_B": f_b[None, chosen], "f_AB": mixed[:, None, chosen]}
        result = sobol_indices(func=values, n=samples)
        return np.array([result.first_order, result.total_order]).reshape(2, count)

    rng = np.random.default_rng(seed)
    drawn = [estimates(rng.integers(samples, size=samples)) for _ in range(RESAMPLES)]
    ends = np.quantile(drawn, (0.5 - 0.5 * CONFIDENCE, 0.5 + 0.5 * CONFIDENCE), axis=0)
    indices = np.stack([estimates(slice(None)), *ends])
    return [
        InputIndices(name, SobolIndex(*indices[:, 0, place].tolist()), SobolIndex(*indices[:, 1, place].tolist()))
        for place, name in enumerate(names)
    ]


def indices_of_surrogate(surrogate: Surrogate) -> list[InputIndices]:
    """Shares of the axes of a cube in the variance of its surrogate, on the finest grid.

    The intervals are those of the estimate; the surrogate's own error is that of its predictions.
    """
    inputs = surrogate.runs.inputs
    axes = [number for number, varied in enumerate(inputs) if varied.is_axis]
    if not axes:
        return []

    def function(places: np.ndarray) -> np.ndarray:
        every = np.tile([varied.high for varied in inputs], (len(places), 1))
        every[:, axes] = places
        return surrogate.mean(every)

    return indices_of(
        function,
        [inputs[number].name for number in axes],
        [(inputs[number].low, inputs[number].high) for number in axes],
    )
