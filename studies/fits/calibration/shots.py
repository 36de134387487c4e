"""Taylor bars that were shot: measured strains with their reading errors, and the series that each belongs to."""

from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from studies import observations
from studies.materials import Material
from studies.observations import Observation
from studies.observations.compared import FEWEST
from studies.quantities.findings import Finding, Findings, InvalidInput, refusal
from studies.sweeps.document import text_of
from studies.sweeps.reading import vocabulary

SCENARIO = "taylor_bar"
# Measured sizes: the dimension of the bar that each is compared with, and the sign of its logarithmic strain. The width
# at a fifth of the length is left out: of no metal are there five, so that its own bias and scatter stay unknown.
SIZES = {"final_length": ("bar_length", -1.0), "mushroom_diameter": ("bar_diameter", 1.0)}
NEEDED = ("speed", "bar_length", "bar_diameter")


@dataclass(frozen=True)
class BarStrains:
    """Measured strains of bars, |ln(size / initial size)|, each (strains,)."""

    quantities: np.ndarray  # names
    series: np.ndarray  # sources: bars of one source are of one lot
    speeds: np.ndarray  # m/s
    ratios: np.ndarray  # initial length over diameter
    initial: np.ndarray  # size before the impact, m
    strains: np.ndarray
    errors: np.ndarray  # standard uncertainties of reading them
    diameter: float  # median of the bars, m

    def where(self, kept: np.ndarray) -> "BarStrains":
        """Some of the strains."""
        names = ("quantities", "series", "speeds", "ratios", "initial", "strains", "errors")
        return replace(self, **{name: getattr(self, name)[kept] for name in names})

    @property
    def names(self) -> list[str]:
        """The quantities that occur, in the order of ``SIZES``."""
        return [name for name in SIZES if name in self.quantities]

    @property
    def lots(self) -> list[str]:
        """The series that occur, in their order."""
        return list(dict.fromkeys(self.series.tolist()))

    def sizes(self, strains: np.ndarray) -> np.ndarray:
        """The sizes, m, at some strains (..., strains)."""
        signs = np.array([SIZES[name][1] for name in self.quantities])
        return np.asarray(self.initial * np.exp(signs * strains))


def read_shots(source: str, material: Material) -> BarStrains:
    """The strains of a published table, by name, or of a CSV file, whose bars are of a material.

    A quantity with fewer than ``FEWEST`` shots is left out. Raises InvalidInput: no table of Taylor bars, a shot
    without speed, sizes or uncertainty, a bar that did not shorten, too few shots.
    """
    shots = [shot for shot in _read(source) if shot.quantity in SIZES and shot.value is not None]
    bars = Counter(str(shot.parameters.get("bar", material.name)) for shot in shots)
    shots = [shot for shot in shots if shot.parameters.get("bar", material.name) == material.name]
    counts = Counter(shot.quantity for shot in shots)
    if counts["final_length"] < FEWEST:
        others = ", ".join(f"{count} of {name}" for name, count in bars.items()) or "no length of a bar"
        limit = f"{FEWEST} or more final lengths of bars of {material.name}"
        cure = f"add shots, or choose another --material (the table has {others})"
        raise refusal("SHOTS", f"{counts['final_length']} final lengths of {material.name}", limit, cure)
    kept = [shot for shot in shots if counts[shot.quantity] >= FEWEST]
    findings = Findings(finding for shot in kept for finding in _findings(shot))
    findings.check()
    initial = np.array([shot.parameters[SIZES[shot.quantity][0]] for shot in kept], float)
    speeds, lengths, diameters = (np.array([shot.parameters[name] for shot in kept], float) for name in NEEDED)
    sizes = np.array([shot.value for shot in kept], float)
    return BarStrains(
        quantities=np.array([shot.quantity for shot in kept]),
        series=np.array([shot.source for shot in kept]),
        speeds=speeds,
        ratios=lengths / diameters,
        initial=initial,
        strains=np.array([SIZES[shot.quantity][1] for shot in kept]) * np.log(sizes / initial),
        errors=np.array([shot.uncertainty for shot in kept], float) / sizes,
        diameter=float(np.median(diameters)),
    )


def _read(source: str) -> Collection[Observation]:
    """The rows of a table of Taylor bars; raises InvalidInput."""
    allowed = vocabulary(SCENARIO, {"bar": ()}, {})
    raw = source
    if source not in observations.names():
        tables = ", ".join(name for name in observations.names() if name.startswith("taylor-bars"))
        raw = text_of(Path(source), "SHOTS", f"give a CSV file of Taylor bars, or one of {tables}")
    try:
        return observations.read_observations(raw, allowed, "SHOTS")
    except InvalidInput as error:
        cure = f"its columns are {', '.join(NEEDED)}, final_length, final_length_uncertainty, source: docs/calibrate.md"
        first = Finding("SHOTS", source, "a table of Taylor bars", cure)
        raise InvalidInput([first, *error.findings]) from None


def _findings(shot: Observation) -> list[Finding]:
    """What is wrong with a shot of a bar."""
    where = f"SHOTS: {shot.quantity} of {shot.source}, {shot.parameters.get('speed', 'no speed')} m/s"
    if absent := [name for name in NEEDED if not isinstance(shot.parameters.get(name), float)]:
        return [Finding(where, f"no {', '.join(absent)}", "speed, length and diameter of each bar", "state them")]
    if not shot.uncertainty:
        cure = f"add a column {shot.quantity}_uncertainty"
        return [Finding(where, "no uncertainty", "a standard uncertainty above zero of each size", cure)]
    dimension, sign = SIZES[shot.quantity]
    initial = shot.parameters[dimension]
    assert isinstance(initial, float)
    assert shot.value is not None
    if sign * (shot.value - initial) < -shot.uncertainty or shot.value <= 0.0:
        limit = f"{'at most' if sign < 0.0 else 'at least'} the initial {1e3 * initial:g} mm: a bar flattens"
        return [Finding(where, f"{1e3 * shot.value:g} mm", limit, "correct the size, or the dimension of the bar")]
    return []
