"""The strain of a bar as a fast function of constants, speed and length: a Gaussian process over computed bars."""

import math
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from studies.cubes.reading import still_growing
from studies.cubes.variable import variable_name
from studies.fits.calibration.design import names_of_axes
from studies.fits.calibration.shots import SIZES
from studies.fits.surrogate import Surrogate, SurrogateInput, runs_of

# Added to a strain before its logarithm is taken, in which the process is nearly a straight line: what is smaller
# cannot be read, 0.1 mm of 25.
SMALL = 0.005
BY_LOGARITHM = ("bar.strength.A", "bar.strength.B", "speed", "bar_length")


@dataclass(frozen=True)
class Emulator:
    """A strain of bars as a function."""

    process: Surrogate

    @property
    def error(self) -> float:
        """Root mean square, relative to the strain."""
        return self.process.error

    def strains(self, places: np.ndarray) -> np.ndarray:
        """Strains at (places, 7): ln A, ln B, n, C, m, ln speed (SI), ln(length / diameter)."""
        return np.exp(self.process.mean(_inputs(places))) - SMALL


def emulator_of(dataset: xr.Dataset, diameter: float, quantity: str) -> Emulator:
    """The emulator of a quantity of the cube of ``design.sweep_of``, for a diameter in m; raises InvalidInput."""
    runs = runs_of(dataset, quantity)
    order = [runs.names.index(variable_name(name)) for name in names_of_axes()]
    places = runs.places[:, order].copy()
    initial = places[:, 6].copy() if SIZES[quantity][0] == "bar_length" else diameter
    places[:, 6] /= diameter
    chosen = [number for number, name in enumerate(names_of_axes()) if name in BY_LOGARITHM]
    places[:, chosen] = np.log(places[:, chosen])
    columns = zip(names_of_axes(), _inputs(places).T, strict=True)
    inputs = tuple(SurrogateInput(name, "1", float(column.min()), float(column.max())) for name, column in columns)
    with np.errstate(invalid="ignore"):
        values = np.log(SIZES[quantity][1] * np.log(runs.values / initial) + SMALL)
    growing = still_growing(dataset)  # soft bars; those that bounced back, longer than at first, have no logarithm
    kept = np.isfinite(values) & [id not in growing for id in runs.ids]
    used = replace(runs, unit="1", inputs=inputs, places=_inputs(places)[kept], values=values[kept])
    return Emulator(Surrogate(used))


def _inputs(places: np.ndarray) -> np.ndarray:
    """Inputs of the process at (places, 7): the damage number v^2 / Y of Johnson (1972) in place of the speed.

    The strain is nearly a function of it alone; Y is the flow stress at a strain of 0.1 and 1e4/s.
    """
    a, b, n, c, _, speed, _ = places.T
    stress = (np.exp(a) + np.exp(b) * 0.1**n) * (1.0 + c * math.log(1e4))
    return np.column_stack([places[:, :5], 2.0 * speed - np.log(stress), places[:, 6]])
