"""The strength part of a hole or crater: its spread over draws of calibrated constants, in place of a fixed 10 %.

``whipple calibrate`` writes the draws; ``relative`` stands for ``strength`` of ``screening.contributions_of``.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from studies.quantities.findings import refusal
from studies.runs.run import Run, materials_of, resolve

LEVEL = 0.90  # of intervals, as of a calibration
CONSTANTS = ("A", "B", "n", "C", "m")
FEWEST = 8  # draws: the standard deviation of so few has itself a relative standard error of 1 / sqrt(2 (8 - 1)) = 27 %


@dataclass(frozen=True)
class StrengthPart:
    """What the uncertainty of a material's constants leaves open of one value."""

    quantity: str
    material: str  # whose constants were drawn
    values: tuple[float, ...]  # of the draws that gave one, SI
    drawn: int  # draws that were asked

    @property
    def median(self) -> float:
        """Middle of the values, SI."""
        return float(np.median(self.values))

    @property
    def uncertainty(self) -> float:
        """Standard deviation of the values, SI."""
        return float(np.std(self.values, ddof=1))

    @property
    def relative(self) -> float:
        """The standard deviation over the median: the contribution ``strength`` of a model part."""
        return self.uncertainty / abs(self.median)

    @property
    def relative_error(self) -> float:
        """Standard error of the standard deviation itself, relative: few draws give a rough one."""
        return 1.0 / math.sqrt(2.0 * (len(self.values) - 1))

    @property
    def interval(self) -> tuple[float, float]:
        """Ends of the interval at ``LEVEL``, SI."""
        low, high = np.quantile(self.values, (0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL)).tolist()
        return low, high


def read_draws(file: Path, count: int) -> tuple[str, list[dict[str, float]]]:
    """The material of ``calibration.nc``, and evenly spaced draws of the constants of a lot that was not shot, SI.

    Raises InvalidInput.
    """
    import xarray as xr

    try:
        with xr.open_dataset(file) as opened:
            dataset = opened.load()
        columns = {name: dataset["A_of_further_lot" if name == "A" else name].values for name in CONSTANTS}
        material = str(dataset.attrs["material"])
    except (OSError, ValueError, KeyError) as error:
        cure = f"give calibration.nc of `whipple calibrate`: {error}"
        raise refusal("calibration", str(file), "the draws of a calibration", cure) from None
    numbers = np.linspace(0, dataset.sizes["draw"] - 1, count).round().astype(int)
    return material, [{name: float(column[number]) for name, column in columns.items()} for number in numbers]


def runs_of_draws(run: Run, material: str, draws: Sequence[Mapping[str, float]]) -> Iterator[Run]:
    """The run with each draw in every role that the material has; raises InvalidInput where it has none."""
    before = materials_of(run)
    roles = [role for role, each in before.items() if each.name == material]
    if not roles:
        names = ", ".join(each.name for each in before.values())
        raise refusal("calibration", material, f"draws of a material of the run: {names}", "calibrate that material")
    for draw in draws:
        changed = dict(before)
        for role in roles:
            for name, value in draw.items():
                changed[role] = changed[role].with_value(f"strength.{name}", value, source="a draw of a calibration")
        yield resolve(run.scenario, run.parameters, changed)


def strength_part(
    run: Run, quantity: str, material: str, draws: Sequence[Mapping[str, float]], answer: Callable[[Run], float | None]
) -> StrengthPart:
    """The spread of a quantity of a run over draws of a material.

    ``answer`` gives the value of a changed run, SI, or None where it has none: by computing it, or from a surrogate.
    Raises InvalidInput for fewer than ``FEWEST`` values, because a spread of the rest would say nothing.
    """
    answers = [answer(each) for each in runs_of_draws(run, material, draws)]
    values = tuple(value for value in answers if value is not None and math.isfinite(value))
    if len(values) < FEWEST:
        limit = f"{FEWEST} or more draws with a {quantity.replace('_', ' ')}"
        raise refusal("draws", f"{len(values)} of {len(draws)}", limit, "take more draws")
    return StrengthPart(quantity, material, values, len(draws))
