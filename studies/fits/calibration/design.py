"""The bars that are computed for a calibration: over prior ranges of constants, speeds and lengths of those shot."""

import numpy as np

from studies.bars.taylor_bar import END_PER_LENGTH
from studies.fits.calibration.shots import SCENARIO, BarStrains
from studies.materials import Material
from studies.observations import written
from studies.quantities.findings import refusal
from studies.quantities.parameters import Plain
from studies.quantities.units import round_quantity
from studies.sweeps.sampling import LATIN, Sampling

JOHNSON_COOK = "johnson-cook"
LOGARITHMIC = ("A", "B")  # constants whose logarithms are uniform beforehand, and stand in for them everywhere
RUNS = 96  # about ten for each of seven inputs (Loeppky, Sacks and Welch 2009, Technometrics 51, 366), and some more
CELLS = 10.0  # across the diameter, as in Ma (2005), section 2.3.2: length to 1 %, mushroom to 4 % of the strain
SEED = 1
LATEST = 2.0  # latest end, over that by default of the longest bar: soft bars flatten longer than a bar as it ships
MARGIN = 0.03  # of the ranges of speeds and lengths beyond the shots, in logarithms: no shot lies on an edge


CONSTANTS = ("A", "B", "n", "C", "m")
# Least and largest factor of the constant in the file of the material.
FACTORS = {
    # Copper yields at 11 ksi annealed and at 44 to 48 ksi hard (Copper Development Association, alloy C12700);
    # published A of copper reach from 65 to 157 MPa.
    "A": (1.0 / 3.0, 4.0),
    "B": (1.0 / 3.0, 3.0),  # published B of aluminium alloys reach from 114 to 684 MPa
}
# Ranges of published sets.
RANGES = (
    (0.12, 0.74),  # n: tungsten alloy 0.12 to Al 2024-T3 0.73 and copper 0.74
    (0.0, 0.060),  # C: none to Armco iron 0.060 (Johnson and Cook 1983)
    (0.55, 1.70),  # m: Armco iron 0.55 (Johnson and Cook 1983) to Al 2024-T3 1.7 (Lesuer)
)


def prior_of(material: Material) -> np.ndarray:
    """The range (5, 2) in which each constant is equally likely beforehand; of A and B ln(Pa).

    Raises InvalidInput where the material's strength is no Johnson-Cook.
    """
    if material.strength.kind != JOHNSON_COOK:
        cure = "choose a material with the constants A, B, n, C and m, such as copper-ofhc"
        raise refusal("--material", f"{material.name} ({material.strength.kind})", f"strength {JOHNSON_COOK}", cure)
    own = material.strength.constants
    return np.array([*(np.log(own[name] * np.array(factors)) for name, factors in FACTORS.items()), *RANGES])


def names_of_axes() -> list[str]:
    """The axes of the sweep in the order of the inputs of an emulator."""
    return [*(f"bar.strength.{name}" for name in CONSTANTS), "speed", "bar_length"]


def sweep_of(material: Material, shots: BarStrains, runs: int = RUNS) -> dict[str, Plain]:
    """The sweep of bars of one diameter (the median of those shot): a Latin hypercube, stated point by point.

    The shape depends on length over diameter; on the diameter itself only through the strain rate, whose logarithm
    differs by 0.24 between bars of 6 and 7.6 mm: 1 % of the flow stress at most.
    """
    prior, diameter = prior_of(material), shots.diameter
    bounds = np.vstack([prior, *([_range(np.log(column))] for column in (shots.speeds, shots.ratios))])
    shares = np.array(Sampling(LATIN, runs, SEED).coordinates(len(bounds)))
    columns = bounds[:, :1] + (bounds[:, 1:] - bounds[:, :1]) * shares
    columns[[0, 1, 5, 6]] = np.exp(columns[[0, 1, 5, 6]])
    columns[6] *= diameter
    units = ["Pa", "Pa", "1", "1", "1", "m/s", "m"]
    axes = {
        name: [written(round_quantity(value), unit) for value in column.tolist()]
        for name, unit, column in zip(names_of_axes(), units, columns, strict=True)
    }
    return {
        "name": f"bars-{material.name}",
        "title": f"Taylor bars of {material.name} over the prior ranges of its constants",
        "scenario": SCENARIO,
        "fixed": {
            "bar": material.name,
            "bar_diameter": written(diameter, "m"),
            "stop": "settled",
            "end_time": written(round_quantity(LATEST * END_PER_LENGTH * float(columns[6].max())), "s"),
        },
        "axes": axes,
        "combine": "zip",
        "resolution": CELLS,
    }


def _range(logarithms: np.ndarray) -> tuple[float, float]:
    return float(logarithms.min()) - MARGIN, float(logarithms.max()) + MARGIN
