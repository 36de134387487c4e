"""The posterior of Johnson-Cook constants: what is assumed beforehand, the likelihood of shots, and samples of both.

A series of shots (one source) is one lot of the material, with a yield stress A of its own: tempers differ in A. The
strain of a bar is that of the emulator times exp(bias), and about it shots scatter:

    strain = exp(bias of the quantity) f(A of the lot, B, n, C, m; speed, length / diameter) + s t
    s^2 = reading^2 + (scatter of the quantity x f)^2 + (error of the emulator x f)^2

with t of Student's distribution, whose tails keep shots that contradict each other from deciding (Lange, Little and
Taylor 1989, J. Am. Stat. Assoc. 84, 881).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from studies.fits.calibration.emulator import Emulator
from studies.fits.calibration.shots import BarStrains
from studies.quantities.findings import MissingExtra

FREEDOM = 4.0  # degrees of freedom of t: the value that Lange, Little and Taylor (1989) recommend
# Prior standard deviation of the logarithm of a bias. The grid of the design leaves 1 % of the strain of the length and
# 4 % of that of the mushroom (10 against 16 cells, copper at 190 m/s); friction of the wall and the form of the law are
# not in the model, and a source for their size is not known: a tenth is a choice, made before the first calibration.
BIAS = 0.10
# Scale of the half-normal priors of the scatter: speeds are stated to 1 m/s of 50 to 600, the strain goes with their
# square; differences from bar to bar come on top, of which the papers state none.
SCATTER = 0.10
# Scale of the half-normal prior of the standard deviation of ln A between lots: published A of copper (65, 90, 118 and
# 157 MPa) have 0.37; tempers from annealed to hard are ln 4 = 1.4 apart.
LOTS = 0.5
LEAST = 0.005  # of scatter and of lots: smaller ones make no difference
MOST = 3.0

WALKERS = 64
BURN_IN, STEPS, THIN = 1500, 1500, 25
SEED = 1


@dataclass(frozen=True)
class Calibration:
    """What is calibrated: shots, emulators of their quantities, and prior ranges."""

    shots: BarStrains
    emulators: Mapping[str, Emulator]
    prior: np.ndarray  # (5, 2) ranges of the constants


@dataclass(frozen=True)
class Posterior:
    """Draws of what a calibration is about, equally likely."""

    calibration: Calibration
    constants: np.ndarray  # (draws, 5): ln A (the middle of all lots), ln B, n, C, m; SI
    lots_deviation: np.ndarray  # (draws,) standard deviation of ln A between lots
    lots: np.ndarray  # (draws, series) ln A of each series
    biases: np.ndarray  # (draws, quantities)
    scatters: np.ndarray  # (draws, quantities)
    autocorrelation: float  # longest autocorrelation time of a chain, steps
    steps: int  # of a chain, that count

    @property
    def effective(self) -> float:
        """Independent draws that the chains are worth, at least."""
        return self.steps * WALKERS / self.autocorrelation

    def further_lots(self, seed: int = SEED) -> np.ndarray:
        """The constants with ln A of a lot that was not shot, (draws, 5)."""
        from scipy.stats import truncnorm

        drawn, shares = self.constants.copy(), np.random.default_rng(seed).uniform(size=len(self.constants))
        middle, deviation = drawn[:, 0], self.lots_deviation
        low, high = ((end - middle) / deviation for end in self.calibration.prior[0])
        drawn[:, 0] = truncnorm.ppf(shares, low, high, middle, deviation)
        return drawn


def posterior_of(
    calibration: Calibration, *, steps: int = STEPS, burn_in: int = BURN_IN, seed: int = SEED
) -> Posterior:
    """Sample the posterior by walkers that move along each other's differences.

    ``emcee``: differential evolution (ter Braak 2006, Stat. Comput. 16, 239) and stretches (Goodman and Weare 2010,
    Comm. App. Math. Comp. Sci. 5, 65).
    """
    import emcee

    density, rng = _Density(calibration), np.random.default_rng(seed)
    moves = [(emcee.moves.DEMove(), 0.7), (emcee.moves.StretchMove(), 0.3)]
    sampler = emcee.EnsembleSampler(WALKERS, density.dimensions, density, moves=moves, vectorize=True)
    sampler.random_state = np.random.RandomState(seed).get_state()
    sampler.run_mcmc(density.start(rng), burn_in + steps)
    times = sampler.get_autocorr_time(discard=burn_in, quiet=True, tol=0)
    drawn = sampler.get_chain(discard=burn_in, thin=THIN, flat=True)
    places = density.places
    return Posterior(
        calibration,
        constants=drawn[:, places["constants"]],
        lots_deviation=np.exp(drawn[:, places["lots_deviation"]][:, 0]),
        lots=drawn[:, places["lots"]],
        biases=drawn[:, places["biases"]],
        scatters=np.exp(drawn[:, places["scatters"]]),
        autocorrelation=float(np.max(times)),
        steps=steps,
    )


def check_extras() -> None:
    """Raise MissingExtra without emcee or scikit-learn."""
    try:
        import emcee  # noqa: F401
        import sklearn.gaussian_process  # noqa: F401
    except ImportError as error:
        raise MissingExtra(f"a calibration needs {error.name}: pip install 'whipple[calibrate]'") from None


class _Density:
    """The logarithm of the posterior density, up to a constant, of many parameter vectors at once."""

    def __init__(self, calibration: Calibration) -> None:
        self.calibration, shots = calibration, calibration.shots
        counts = {"constants": 5, "lots_deviation": 1, "lots": len(shots.lots)}
        counts |= {"biases": len(shots.names), "scatters": len(shots.names)}
        ends = np.cumsum([0, *counts.values()]).tolist()
        self.places = {name: slice(*ends[number : number + 2]) for number, name in enumerate(counts)}
        self.dimensions: int = ends[-1]
        self.parts = [shots.where(shots.quantities == name) for name in shots.names]
        self.columns = [[shots.lots.index(lot) for lot in part.series.tolist()] for part in self.parts]

    def start(self, rng: np.random.Generator) -> np.ndarray:
        """A place of each walker, (walkers, dimensions), in the middle of the prior."""
        bounds, start = self.calibration.prior, np.empty((WALKERS, self.dimensions))
        start[:, self.places["constants"]] = bounds[:, 0] + np.ptp(bounds, axis=1) * rng.uniform(
            0.25, 0.75, (WALKERS, 5)
        )
        start[:, self.places["lots_deviation"]] = np.log(rng.uniform(0.05, 0.3, (WALKERS, 1)))
        lots = start[:, self.places["lots"]]
        lots[:] = start[:, :1] + 0.1 * rng.standard_normal(lots.shape)
        biases = start[:, self.places["biases"]]
        biases[:] = 0.5 * BIAS * rng.standard_normal(biases.shape)
        start[:, self.places["scatters"]] = np.log(rng.uniform(0.02, 0.1, biases.shape))
        return start

    def __call__(self, parameters: np.ndarray) -> np.ndarray:
        """(vectors,) of (vectors, dimensions)."""
        density = self._prior(parameters)
        inside = np.isfinite(density)
        density[inside] += self._likelihood(parameters[inside])
        return density

    def _prior(self, parameters: np.ndarray) -> np.ndarray:
        from scipy.special import ndtr

        constants, lots, biases = (parameters[:, self.places[name]] for name in ("constants", "lots", "biases"))
        sizes = np.column_stack([parameters[:, self.places["lots_deviation"]], parameters[:, self.places["scatters"]]])
        low, high = self.calibration.prior.T
        inside = ((constants >= low) & (constants <= high)).all(axis=1)
        inside &= ((lots >= low[0]) & (lots <= high[0])).all(axis=1)
        inside &= ((sizes >= math.log(LEAST)) & (sizes <= math.log(MOST))).all(axis=1)
        # Half-normal in the size, which is sampled by its logarithm: the Jacobian adds the logarithm.
        scales = np.array([LOTS, *[SCATTER] * len(self.parts)])
        density = (sizes - 0.5 * (np.exp(sizes) / scales) ** 2).sum(axis=1)
        density -= 0.5 * ((biases / BIAS) ** 2).sum(axis=1)
        # ln A of each lot: normal about that of the material, within the range of A.
        middle, deviation = constants[:, 0], np.exp(sizes[:, 0])
        within = ndtr((high[0] - middle) / deviation) - ndtr((low[0] - middle) / deviation)
        away = (lots - middle[:, None]) / deviation[:, None]
        density -= (0.5 * away**2 + np.log(deviation * np.maximum(within, 1e-300))[:, None]).sum(axis=1)
        return np.where(inside, density, -np.inf)

    def _likelihood(self, parameters: np.ndarray) -> np.ndarray:
        shots, density = self.calibration.shots, np.zeros(len(parameters))
        constants, lots = parameters[:, self.places["constants"]], parameters[:, self.places["lots"]]
        for number, (name, mine, columns) in enumerate(zip(shots.names, self.parts, self.columns, strict=True)):
            emulator = self.calibration.emulators[name]
            computed = strains_of(emulator, constants, mine, lots[:, columns])
            bias = np.exp(parameters[:, self.places["biases"]][:, number, None])
            scatter = np.exp(parameters[:, self.places["scatters"]][:, number, None])
            size = deviation_of(mine, computed, scatter, emulator.error)
            away = (mine.strains - bias * computed) / size
            density -= (np.log(size) + 0.5 * (FREEDOM + 1.0) * np.log1p(away**2 / FREEDOM)).sum(axis=1)
        return density


def strains_of(emulator: Emulator, constants: np.ndarray, shots: BarStrains, yields: np.ndarray) -> np.ndarray:
    """Strains of shots, (draws, shots), by constants (draws, 5) with ln A of each shot's lot (draws, shots)."""
    places = np.empty((*yields.shape, 7))
    places[..., :5] = constants[:, None]
    places[..., 0] = yields
    places[..., 5], places[..., 6] = np.log(shots.speeds), np.log(shots.ratios)
    return emulator.strains(places.reshape(-1, 7)).reshape(yields.shape)


def deviation_of(shots: BarStrains, computed: np.ndarray, scatter: np.ndarray, error: float) -> np.ndarray:
    """The scale s of the scatter of shots about computed strains (draws, shots)."""
    return np.sqrt(shots.errors**2 + (scatter**2 + error**2) * computed**2)
