"""Shots held against a posterior: predicted sizes with intervals, also of a series that the posterior never had.

The shots of a series are not independent: one lot made them all, which the posterior may not know. How many of them
fall into their intervals varies far more than as many independent shots would. So their number is held against series
that are drawn from the posterior itself (posterior predictive checks: Gelman et al. 2013, Bayesian Data Analysis,
section 6.3).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from studies.fits.calibration.posterior import (
    FREEDOM,
    SEED,
    Calibration,
    Posterior,
    deviation_of,
    posterior_of,
    strains_of,
)
from studies.fits.calibration.shots import BarStrains

LEVEL = 0.90  # of the intervals


@dataclass(frozen=True)
class PredictedShots:
    """Measured sizes beside predicted ones: median and ends of the interval at ``LEVEL``, (shots,) m."""

    shots: BarStrains
    measured: np.ndarray
    median: np.ndarray
    low: np.ndarray
    high: np.ndarray
    repeated: np.ndarray  # (draws, shots) whether sizes that are drawn from the posterior, a series at once, are inside

    @property
    def inside(self) -> np.ndarray:
        """Whether each measured size is in its interval."""
        return (self.measured >= self.low) & (self.measured <= self.high)

    @property
    def coverage(self) -> float:
        """Share of the shots in their intervals."""
        return float(np.mean(self.inside))

    @property
    def offset(self) -> float:
        """Mean of measured over predicted size, less 1."""
        return float(np.mean(self.measured / self.median)) - 1.0

    def of(self, quantity: str) -> "PredictedShots":
        """The shots of one quantity."""
        kept = self.shots.quantities == quantity
        columns = ("measured", "median", "low", "high", "repeated")
        return replace(self, shots=self.shots.where(kept), **{name: getattr(self, name)[..., kept] for name in columns})


def chances(series: Sequence[PredictedShots]) -> tuple[float, float]:
    """The chances that no more, and that no fewer, sizes than measured are inside, of series that are as predicted."""
    counted = sum(int(shots.inside.sum()) for shots in series)
    repeated = np.sum([shots.repeated.sum(axis=1) for shots in series], axis=0)
    return float(np.mean(repeated <= counted)), float(np.mean(repeated >= counted))


def predict(posterior: Posterior, shots: BarStrains) -> PredictedShots:
    """The sizes of shots: by the A of their lot where the posterior has it, else by that of a lot that was not shot."""
    rng, known = np.random.default_rng(SEED), posterior.calibration.shots.lots
    constants, draws = posterior.constants, len(posterior.constants)
    further = {lot: posterior.further_lots(SEED + number)[:, 0] for number, lot in enumerate(shots.lots)}
    yields = np.column_stack(
        [posterior.lots[:, known.index(lot)] if lot in known else further[lot] for lot in shots.series.tolist()]
    )
    strains = np.empty((draws, len(shots.strains)))
    for number, name in enumerate(posterior.calibration.shots.names):
        rows = shots.quantities == name
        mine, emulator = shots.where(rows), posterior.calibration.emulators[name]
        computed = strains_of(emulator, constants, mine, yields[:, rows])
        size = deviation_of(mine, computed, posterior.scatters[:, number, None], emulator.error)
        noise = size * rng.standard_t(FREEDOM, computed.shape)
        strains[:, rows] = np.exp(posterior.biases[:, number, None]) * computed + noise
    sizes = shots.sizes(strains)
    ends = np.quantile(sizes, (0.5 - 0.5 * LEVEL, 0.5, 0.5 + 0.5 * LEVEL), axis=0)
    low, median, high = ends
    return PredictedShots(shots, shots.sizes(shots.strains), median, low, high, (sizes >= low) & (sizes <= high))


def leave_series_out(calibration: Calibration) -> Iterator[tuple[str, PredictedShots]]:
    """Each series, predicted by a posterior that never had it.

    A quantity of which no other series has a shot is not predicted.
    """
    for lot in calibration.shots.lots:
        out = calibration.shots.series == lot
        others = replace(calibration, shots=calibration.shots.where(~out))
        shots = calibration.shots.where(out & np.isin(calibration.shots.quantities, others.shots.names))
        yield lot, predict(posterior_of(others), shots)
