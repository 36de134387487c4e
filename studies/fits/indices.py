"""Sobol indices: the share of the variance of a function that each of its inputs explains, with intervals."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from studies.fits.least_squares import CONFIDENCE
from studies.fits.surrogate import Surrogate

# Points of each of the two designs, a power of two; the function is evaluated (inputs + 2) times as often.
SAMPLES = 4096
RESAMPLES = 1000  # of the bootstrap
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
    from scipy.stats import sobol_indices, uniform

    if len(names) == 1:
        whole = SobolIndex(1.0, 1.0, 1.0)
        return [InputIndices(names[0], whole, whole)]
    result = sobol_indices(
        func=lambda x: function(x.T)[np.newaxis],
        n=samples,
        dists=[uniform(low, high - low) for low, high in bounds],
        rng=seed,
    )
    intervals = result.bootstrap(confidence_level=CONFIDENCE, n_resamples=RESAMPLES)

    def read(kind: str, number: int) -> SobolIndex:
        value = np.ravel(getattr(result, kind))[number]
        ends = getattr(intervals, kind).confidence_interval
        return SobolIndex(float(value), *(float(np.ravel(end)[number]) for end in ends))

    return [
        InputIndices(name, read("first_order", number), read("total_order", number))
        for number, name in enumerate(names)
    ]


def indices_of_surrogate(surrogate: Surrogate) -> list[InputIndices]:
    """Shares of the axes of a cube in the variance of its surrogate, on the finest grid.

    The intervals are those of the estimate; the surrogate's own error is that of its predictions.
    """
    inputs = surrogate.runs.inputs
    axes = [number for number, each in enumerate(inputs) if each.is_axis]

    def function(places: np.ndarray) -> np.ndarray:
        every = np.tile([each.high for each in inputs], (len(places), 1))
        every[:, axes] = places
        return surrogate.mean(every)

    return indices_of(
        function,
        [inputs[number].name for number in axes],
        [(inputs[number].low, inputs[number].high) for number in axes],
    )
