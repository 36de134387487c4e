"""A Gaussian process over the runs of a cube: it predicts a run that was not computed, with an interval.

The mean is a straight line over every input and the covariance a Matern function of smoothness 5/2 with a length for
each input, on top of it a noise of its own (Rasmussen and Williams 2006, chapters 2 and 5; ``scikit-learn``). Lengths,
size and noise are the most likely ones, with which a dozen runs look closer to the process than another run would be;
so intervals are scaled by what the process misses when runs are left out (Bachoc 2013, Comput. Stat. Data Anal. 66,
55).
"""

import warnings
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from studies.cubes import reading
from studies.cubes.points import SUCCEEDED, axes_of, by_run, main_quantities, refinements_of, simulated
from studies.cubes.variables import FLAGS, RUN_ID
from studies.fits.measured import number_or_text, source_of
from studies.quantities.display import display_of, with_unit
from studies.quantities.files import write_atomically
from studies.quantities.findings import Finding, Findings, InvalidInput, MissingExtra, nearest_cure, refusal, shown
from studies.quantities.least_squares import CONFIDENCE
from studies.quantities.measured import CLOSED_ON_AXIS, TOO_COARSE
from studies.quantities.parameters import Parameter, parse_value
from studies.quantities.units import readable
from studies.sweeps.reading import OFFSET, RESOLUTION

if TYPE_CHECKING:
    from sklearn.gaussian_process import GaussianProcessRegressor

FORMATS = ("png", "svg", "pdf")  # of its drawing
KERNEL = "straight line + Matern 5/2 with a length for each input + noise"
FOLDS = 60  # the most processes of which each never had some runs
RESTARTS = 8  # of the search for the most likely lengths, size and noise, from places drawn within their bounds
SEED = 1  # of these places
# Prior standard deviation of the constants of the line, in standard deviations of the runs over ranges of the inputs:
# so wide that the runs alone decide.
WIDE = 10.0
# Bounds of lengths, sizes and noises (variances), in the same units: a length beyond them is a straight line, or a
# noise. A dozen runs do not tell a noise of less than 0.3 % of their deviation from bending: with a bound of 1e-8
# intervals of 95 % over 16 points of 36 made-up laws with scatter held 87 % of unseen ones, with 1e-5 92 %.
LENGTHS, SIZES, NOISES = (0.05, 20.0), (1e-4, 1e2), (1e-5, 1.0)


@dataclass(frozen=True)
class SurrogateInput:
    """A number that varies between the runs."""

    name: str  # an axis, or the resolution
    unit: str  # SI
    low: float  # of the runs
    high: float

    @property
    def is_axis(self) -> bool:
        """Whether it is a parameter of the shot, and no refinement of the grid."""
        return self.name != RESOLUTION

    @property
    def parameter(self) -> Parameter:
        """The parameter that a prediction is given, bounded by the smallest and the largest value of the runs."""
        return Parameter(
            name=self.name, kind="quantity", unit=self.unit, meaning=self.name, minimum=self.low, maximum=self.high
        )

    def scaled(self, values: np.ndarray) -> np.ndarray:
        """Values from 0 to 1; of the resolution by the size of a cell, with which errors of the grid go."""
        if self.name == RESOLUTION:
            return (1.0 / values - 1.0 / self.high) / (1.0 / self.low - 1.0 / self.high)
        return (values - self.low) / (self.high - self.low)


@dataclass(frozen=True)
class ComputedRuns:
    """Values of a quantity with the inputs of their runs."""

    quantity: str
    unit: str  # SI
    source: str
    inputs: tuple[SurrogateInput, ...]
    places: np.ndarray  # (runs, inputs), SI
    values: np.ndarray  # (runs,), SI
    axes_not_used: Mapping[str, str] = field(default_factory=dict)  # reasons, by name
    too_coarse: int = 0  # runs whose grid is: they count, for what is predicted is a run
    ids: tuple[str, ...] = ()  # of the runs
    left_out: tuple[tuple[str, str], ...] = ()  # other runs of the cube: id and reason

    @property
    def names(self) -> list[str]:
        """Names of the inputs."""
        return [varied.name for varied in self.inputs]

    @property
    def not_used(self) -> dict[str, int]:
        """How many other runs of the cube do not count, by reason; the most frequent one first."""
        return dict(Counter(reason for _, reason in self.left_out).most_common())

    @property
    def scope(self) -> str:
        """How many runs of the cube count, what is left out and why."""
        used, others = len(self.values), sum(self.not_used.values())
        texts = [f"{used} of {used + others} runs"]
        texts += [f"{count} left out: {reason}" for reason, count in self.not_used.items()]
        texts += [f"axis {name} left out: {why}" for name, why in self.axes_not_used.items()]
        if self.too_coarse:
            texts.append(f"{self.too_coarse} of those used have too coarse a grid for an error bar")
        return "; ".join(texts)

    @property
    def scaled(self) -> np.ndarray:
        """The inputs of each run from 0 to 1, (runs, inputs)."""
        return self.scale(self.places)

    def scale(self, places: np.ndarray) -> np.ndarray:
        """Some inputs, (places, inputs), from 0 to 1 within the runs."""
        return np.column_stack([varied.scaled(column) for varied, column in zip(self.inputs, places.T, strict=True)])

    def read_place(self, texts: Sequence[str]) -> np.ndarray:
        """Inputs from texts, "speed=6 km/s": (inputs,), SI; the resolution is the finest unless stated.

        Raises InvalidInput: an unknown input, one that is missing, one outside of the runs.
        """
        parts = (text.partition("=") for text in texts)
        stated = {name.strip(): value.strip() for name, _, value in parts}
        unknown = (name for name in stated if name not in self.names)
        findings, place = Findings(), []
        findings.extend(
            Finding("--at", name, "an input of the surrogate", nearest_cure(name, self.names)) for name in unknown
        )
        for varied in self.inputs:
            name, parameter = varied.name, varied.parameter
            if name in stated:
                place.append(findings.attempt(parse_value, parameter, number_or_text(stated[name]), f"--at {name}"))
            elif varied.is_axis:
                low, high = (readable(end, varied.unit) for end in (varied.low, varied.high))
                limit, cure = f"{name} from {low} to {high}", f"add --at '{name}={low}'"
                findings.append(Finding("--at", shown("nothing"), limit, cure))
            else:
                place.append(varied.high)
        findings.check()
        return np.array(place, float)


def runs_of(dataset: xr.Dataset, quantity: str) -> ComputedRuns:
    """The runs of a cube with a value of a quantity.

    Runs at several offsets are the same inputs again: what differs between them is noise. Raises InvalidInput where an
    axis is no number, too few runs are left, or the runs that are left have one value of an axis that has several.
    """
    values = simulated(dataset, quantity).values.ravel()
    reasons = _reasons(dataset, quantity)
    kept, ids = reasons == "", RUN_ID.of(dataset).values.ravel().astype(str)
    refinements = [name for name in refinements_of(dataset) if name != OFFSET]
    axes = [axis for axis in axes_of(dataset) if axis not in (RESOLUTION, OFFSET)]
    inputs, columns, axes_not_used = [], [], {}
    if OFFSET in refinements_of(dataset):
        axes_not_used[OFFSET] = "what differs between offsets is noise"
    for name in (*axes, *refinements):
        column, every = by_run(dataset, name)[kept], by_run(dataset, name)
        several, left = len(set(every)) > 1, len(set(column))
        if column.dtype.kind != "f" and left > 1:
            cure = "submit a sweep for each of its values"
            raise refusal("CUBE", name, "axes of numbers", cure)
        if several and left == 1 and name in axes:
            got = f"{name}: one value in the {int(kept.sum())} of {len(kept)} runs that count"
            lost = "; ".join(f"{count} {reason}" for reason, count in Counter(reasons[~kept]).most_common())
            cure = f"compute more points, or a sweep without this axis ({lost})"
            raise refusal("CUBE", got, "two values or more of each axis", cure)
        if left > 1:
            unit = dataset[name].attrs.get("units", "1")
            inputs.append(SurrogateInput(name, unit, float(column.min()), float(column.max())))
            columns.append(column)
        elif left:
            axes_not_used[name] = "the runs have one value of it"
    least = len(inputs) + 3
    if not inputs or kept.sum() < least:
        count = f"{int(kept.sum())} of {len(kept)} runs with a value of {quantity}, {len(inputs)} inputs"
        limit = f"one input or more, and {least} runs or more for {len(inputs)}"
        raise refusal("CUBE", count, limit, "compute more points")
    unit = dataset[quantity].attrs["units"]
    return ComputedRuns(
        quantity,
        unit,
        source_of(dataset),
        tuple(inputs),
        np.column_stack(columns),
        values[kept],
        axes_not_used,
        int((_flagged(dataset, quantity, TOO_COARSE) & kept).sum()),
        tuple(ids[kept].tolist()),
        tuple(zip(ids[~kept].tolist(), reasons[~kept].tolist(), strict=True)),
    )


def _reasons(dataset: xr.Dataset, quantity: str) -> np.ndarray:
    """Why each run of a cube, (runs,), does not count; empty texts for those that do."""
    reasons = np.full(dataset.run_state.size, "", object)
    reasons[~np.isfinite(simulated(dataset, quantity).values.ravel())] = f"no value of {quantity}"
    reasons[by_run(dataset, "run_state") != SUCCEEDED] = "did not succeed"
    reasons[_flagged(dataset, quantity, CLOSED_ON_AXIS)] = CLOSED_ON_AXIS.replace("_", " ")
    if reading.mixed_versions(dataset, quantity):
        reasons[reasons == ""] = "measured with several versions of the definition"
    return reasons


def _flagged(dataset: xr.Dataset, quantity: str, flag: str) -> np.ndarray:
    """Whether the value of each run, (runs,), has a flag."""
    flags = FLAGS.of(dataset, quantity)
    mask = sum(mask for mask, word in reading.flag_meanings(flags) if word == flag)
    return np.asarray(reading.by_run(dataset, flags.variable).ravel() & mask != 0)


@dataclass(frozen=True)
class Prediction:
    """Predicted values with their intervals."""

    values: np.ndarray  # (places,)
    intervals: np.ndarray  # (places,) half lengths at CONFIDENCE, for a run, its noise included


@dataclass(frozen=True)
class LeftOut:
    """Each run predicted from all others."""

    predicted: Prediction
    errors: np.ndarray  # (runs,) predicted minus computed

    @property
    def rms(self) -> float:
        """Root of the mean square of the errors."""
        return float(np.sqrt(np.mean(self.errors**2)))

    @property
    def largest(self) -> float:
        """Largest of the errors, on either side."""
        return float(np.abs(self.errors).max())

    @property
    def coverage(self) -> float:
        """Share of the runs inside their intervals."""
        return float(np.mean(np.abs(self.errors) <= self.predicted.intervals))

    @property
    def explained(self) -> float:
        """Share of the variance of the runs that the predictions explain, Q2."""
        values = self.predicted.values - self.errors
        return 1.0 - float((self.errors**2).sum() / ((values - values.mean()) ** 2).sum())


@dataclass(frozen=True)
class Surrogate:
    """A Gaussian process for one quantity of a cube."""

    runs: ComputedRuns

    def predict(self, places: np.ndarray) -> Prediction:
        """Values and intervals at some inputs (places, inputs), SI."""
        from scipy.special import stdtrit

        values, deviations = self._process.predict(self.runs.scale(places), return_std=True)
        quantile = stdtrit(self.degrees_of_freedom, 0.5 + 0.5 * CONFIDENCE)
        return Prediction(values, quantile * self.scale * deviations)

    def mean(self, places: np.ndarray) -> np.ndarray:
        """Values alone; of no places, which scikit-learn refuses, none."""
        if not len(places):
            return np.empty(0)
        return np.asarray(self._process.predict(self.runs.scale(places)))

    @property
    def degrees_of_freedom(self) -> int:
        """Runs beyond the constants that are fitted to them: a length for each input, size and noise."""
        return max(1, len(self.runs.values) - len(self.runs.inputs) - 2)

    @property
    def scale(self) -> float:
        """What the process misses when a run is left out, over the deviation that it expects there."""
        errors, deviations = self._missed
        return float(np.sqrt(((errors / deviations) ** 2).sum() / self.degrees_of_freedom))

    @property
    def error(self) -> float:
        """Error of a run predicted from all others, SI, from the same process and with the same degrees of freedom."""
        return float(np.sqrt((self._missed[0] ** 2).sum() / self.degrees_of_freedom))

    @cached_property
    def left_out(self) -> LeftOut:
        """Each run left out once; the other grids of its point stay, where it has some."""
        return self._left_out(np.arange(len(self.runs.values)))

    @cached_property
    def points_left_out(self) -> LeftOut:
        """Each point left out once, with the runs of all its grids."""
        axes = [number for number, varied in enumerate(self.runs.inputs) if varied.is_axis]
        _, points = np.unique(self.runs.places[:, axes], axis=0, return_inverse=True)
        points = points.ravel()
        return self.left_out if points.max() + 1 == len(points) else self._left_out(points)

    def _left_out(self, groups: np.ndarray) -> LeftOut:
        """The runs of each group (runs,) predicted by a process that never had them, in at most ``FOLDS`` processes.

        Each has lengths, size, noise and scale of its own.
        """
        folds, places, computed = groups % FOLDS, self.runs.places, self.runs.values
        values, intervals = np.empty((2, len(computed)))
        for fold in np.unique(folds):
            out = folds == fold
            others = Surrogate(replace(self.runs, places=places[~out], values=computed[~out]))
            predicted = others.predict(places[out])
            values[out], intervals[out] = predicted.values, predicted.intervals
        return LeftOut(Prediction(values, intervals), values - computed)

    @property
    def lengths(self) -> dict[str, float]:
        """The length of each input over which values bend, over the range of the input (cell sizes of resolutions)."""
        lengths = np.exp(self._process.kernel_.theta)[1:-1].tolist()
        return dict(zip(self.runs.names, lengths, strict=True))

    @property
    def deviations(self) -> dict[str, float]:
        """Standard deviations of what bends, and of the noise of a run; SI."""
        sizes = (np.exp(0.5 * self._process.kernel_.theta[[0, -1]]) * self._unit).tolist()
        return dict(zip(("bends", "noise"), sizes, strict=True))

    @cached_property
    def _process(self) -> "GaussianProcessRegressor":
        """The most likely process."""
        from sklearn.exceptions import ConvergenceWarning
        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import ConstantKernel, DotProduct, Matern, WhiteKernel

        line = ConstantKernel(WIDE**2, "fixed") * DotProduct(1.0, "fixed")
        bends = ConstantKernel(1.0, SIZES) * Matern(np.ones(len(self.runs.inputs)), LENGTHS, nu=2.5)
        process = GaussianProcessRegressor(
            line + bends + WhiteKernel(1e-4, NOISES), n_restarts_optimizer=RESTARTS, normalize_y=True, random_state=SEED
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)  # a number at its bound
            return process.fit(self.runs.scaled, self.runs.values)

    @cached_property
    def _missed(self) -> tuple[np.ndarray, np.ndarray]:
        """Errors and expected deviations of each run predicted from all others with the same lengths, size and noise.

        SI, (runs,) each: Rasmussen and Williams (2006), Eq. 5.12.
        """
        from scipy.linalg import cho_solve

        inverse = np.diag(cho_solve((self._process.L_, True), np.eye(len(self.runs.values))))
        return self._process.alpha_ / inverse * self._unit, self._unit / np.sqrt(inverse)

    @property
    def _unit(self) -> float:
        """Standard deviation of the values, by which the process divides them."""
        return float(self.runs.values.std()) or 1.0


def main_quantity(dataset: xr.Dataset, name: str | None) -> str:
    """The quantity of a name, or the first main one of a cube; raises InvalidInput."""
    if name is None:
        return main_quantities(dataset)[0]
    quantities = reading.quantities_of(dataset)
    if name not in quantities:
        cure = nearest_cure(name, quantities)
        raise refusal("--quantity", name, "a quantity of the cube", cure)
    return name


def surrogate_of(dataset: xr.Dataset, quantity: str) -> Surrogate:
    """The surrogate of a quantity of a cube; raises InvalidInput, and MissingExtra without scikit-learn."""
    check_extra()
    return Surrogate(runs_of(dataset, quantity))


def check_extra() -> None:
    """Raise MissingExtra without scikit-learn."""
    try:
        import sklearn.gaussian_process  # noqa: F401
    except ImportError:
        raise MissingExtra("a surrogate needs scikit-learn: pip install 'whipple[surrogate]'") from None


def as_json(surrogate: Surrogate) -> Mapping[str, object]:
    """The surrogate's inputs and its errors as plain values, SI."""
    runs, left = surrogate.runs, surrogate.left_out
    return {
        "quantity": runs.quantity,
        "unit": runs.unit,
        "source": runs.source,
        "runs": len(runs.values),
        "runs_of_the_cube": len(runs.values) + sum(runs.not_used.values()),
        "runs_not_used": [
            {"reason": reason, "runs": count, "ids": [id for id, why in runs.left_out if why == reason]}
            for reason, count in runs.not_used.items()
        ],
        "axes_not_used": [{"name": name, "reason": reason} for name, reason in runs.axes_not_used.items()],
        "runs_too_coarse": runs.too_coarse,
        "inputs": [asdict(varied) for varied in runs.inputs],
        "level": CONFIDENCE,
        "covariance": {
            "kernel": KERNEL,
            "lengths_over_ranges": [{"name": name, "value": length} for name, length in surrogate.lengths.items()],
            "deviations": [{"name": name, "value": size} for name, size in surrogate.deviations.items()],
        },
        "intervals": {"scale": surrogate.scale, "degrees_of_freedom": surrogate.degrees_of_freedom},
        "left_out": {
            **_errors(left),
            "runs": [
                {
                    "run": id,
                    "at": dict(zip(runs.names, place, strict=True)),
                    "computed": value,
                    "predicted": predicted,
                    "interval": interval,
                }
                for id, place, value, predicted, interval in zip(
                    runs.ids,
                    runs.places.tolist(),
                    runs.values.tolist(),
                    left.predicted.values.tolist(),
                    left.predicted.intervals.tolist(),
                    strict=True,
                )
            ],
        },
        "points_left_out": _errors(surrogate.points_left_out),
    }


def _errors(left: LeftOut) -> dict[str, float]:
    return {"rms": left.rms, "largest": left.largest, "explained": left.explained, "coverage": left.coverage}


def draw_left_out(surrogate: Surrogate, file: Path) -> Path:
    """Draw each run as predicted from the others, over what was computed, into a file whose ending is its format.

    Raises InvalidInput.
    """
    format = file.suffix.removeprefix(".").lower()
    if format not in FORMATS:
        raise InvalidInput([Finding("--plot", str(file), ", ".join(FORMATS), "end it in .png")])
    from matplotlib.figure import Figure

    runs, predicted = surrogate.runs, surrogate.left_out.predicted
    factor = display_of(runs.unit).factor
    figure = Figure(figsize=(5.0, 5.0), layout="constrained")
    axes = figure.subplots()
    x, y, bars = (factor * column for column in (runs.values, predicted.values, predicted.intervals))
    axes.plot([x.min(), x.max()], [x.min(), x.max()], color="#888888", linewidth=0.8)
    axes.errorbar(x, y, bars, fmt="o", markersize=4, capsize=2)
    label = with_unit(runs.quantity.replace("_", " "), runs.unit)
    axes.set(xlabel=f"{label}, computed", ylabel="predicted from the other runs, 95 % interval")
    return write_atomically(file, lambda part: figure.savefig(part, format=format))
