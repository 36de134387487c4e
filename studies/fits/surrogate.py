"""A Gaussian process over the runs of a cube: it predicts a run that was not computed, with an interval.

The mean is a straight line over every input and the covariance a Matern function of smoothness 5/2 with a length for
each input, on top of it a noise of its own (Rasmussen and Williams 2006, chapters 2 and 5; ``scikit-learn``). A dozen
runs do not fix lengths, size and noise, and intervals at their most likely values are too short; so these are sampled
from what the runs say of them (Handcock and Stein 1993, Technometrics 35, 403), and a prediction is the mixture over
the samples.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from studies.cubes import reading
from studies.cubes.points import SUCCEEDED, axes_of, by_run, main_quantities, refinements_of, simulated
from studies.cubes.variables import FLAGS, RUN_ID
from studies.fits.measured import number_or_text, source_of
from studies.laws.fitting.least_squares import CONFIDENCE
from studies.quantities.findings import Finding, Findings, MissingExtra, nearest_cure, refusal, shown
from studies.quantities.measured import CLOSED_ON_AXIS, TOO_COARSE
from studies.quantities.parameters import Parameter, parse_value
from studies.quantities.units import readable
from studies.sweeps.reading import OFFSET, RESOLUTION

KERNEL = "straight line + Matern 5/2 with a length for each input + noise"
SAMPLES = 200  # of lengths, size and noise
FOLDS = 60  # the most processes of which each never had some runs
BURN_IN = 20  # samples before these, which are left out: they remember where the first one began
SEED = 1  # of the samples
# Prior standard deviation of the constants of the line, in standard deviations of the runs over ranges of the inputs:
# so wide that the runs alone decide.
WIDE = 10.0
# Bounds of lengths, sizes and noises, in the same units, between which their logarithms are equally likely beforehand:
# a length beyond them is a straight line, or a noise.
LENGTHS, SIZES, NOISES = (0.05, 20.0), (1e-4, 1e2), (1e-10, 1.0)
NUGGET = 1e-10  # on the diagonal, over the variance of the runs: what keeps a factorisation stable
HALVINGS = 60  # of the interval in which a half length is searched: to round-off


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
        columns = [each.scaled(column) for each, column in zip(self.inputs, places.T, strict=True)]
        return np.column_stack(columns)

    def read_place(self, texts: Sequence[str]) -> np.ndarray:
        """Inputs from texts, "speed=6 km/s": (inputs,), SI; the resolution is the finest unless stated.

        Raises InvalidInput: an unknown input, one that is missing, one outside of the runs.
        """
        parts = (text.partition("=") for text in texts)
        stated = {name.strip(): value.strip() for name, _, value in parts}
        names, findings, place = [each.name for each in self.inputs], Findings(), []
        for name in stated:
            if name not in names:
                cure = nearest_cure(name, names)
                findings.append(Finding("--at", name, "an input of the surrogate", cure))
        for each in self.inputs:
            if each.name in stated:
                number = number_or_text(stated[each.name])
                place.append(findings.attempt(parse_value, each.parameter, number, f"--at {each.name}"))
            elif each.is_axis:
                low, high = (readable(end, each.unit) for end in (each.low, each.high))
                limit, cure = f"{each.name} from {low} to {high}", f"add --at '{each.name}={low}'"
                findings.append(Finding("--at", shown("nothing"), limit, cure))
            else:
                place.append(each.high)
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
class SampledNumber:
    """A number of the covariance: the median of its samples, and the ends of ``CONFIDENCE`` of them."""

    name: str
    median: float
    low: float
    high: float


@dataclass(frozen=True)
class Surrogate:
    """A Gaussian process for one quantity of a cube."""

    runs: ComputedRuns

    def predict(self, places: np.ndarray) -> Prediction:
        """Values and intervals at some inputs (places, inputs), SI."""
        return self._prediction(*self._mixture.at(self.runs.scale(places)))

    def mean(self, places: np.ndarray) -> np.ndarray:
        """Values alone."""
        scale, shift = self._scale
        return self._mixture.means(self.runs.scale(places)) * scale + shift

    @cached_property
    def left_out(self) -> LeftOut:
        """Each run left out once; the other grids of its point stay, where it has some."""
        return self._left_out(np.arange(len(self.runs.values)))

    @cached_property
    def points_left_out(self) -> LeftOut:
        """Each point left out once, with the runs of all its grids."""
        axes = [number for number, each in enumerate(self.runs.inputs) if each.is_axis]
        _, points = np.unique(self.runs.places[:, axes], axis=0, return_inverse=True)
        points = points.ravel()
        return self.left_out if points.max() + 1 == len(points) else self._left_out(points)

    def _left_out(self, groups: np.ndarray) -> LeftOut:
        """The runs of each group (runs,) predicted by a process that never had them, in at most ``FOLDS`` processes.

        Lengths, size and noise are sampled again for each: where they come from few runs, weighting the samples of all
        runs instead gives intervals of half the length.
        """
        folds, x, y = groups % FOLDS, self.runs.scaled, self._standard
        values, deviations = np.empty((2, SAMPLES, len(y)))
        for fold in np.unique(folds):
            out = folds == fold
            values[:, out], deviations[:, out] = _mixture_of(x[~out], y[~out]).at(x[out])
        predicted = self._prediction(values, deviations)
        return LeftOut(predicted, predicted.values - self.runs.values)

    @property
    def lengths(self) -> list[SampledNumber]:
        """The length of each input over which values bend, over the range of the input (cell sizes of resolutions)."""
        samples = self._numbers[:, 1:-1].T
        return [_sampled(each.name, column) for each, column in zip(self.runs.inputs, samples, strict=True)]

    @property
    def deviations(self) -> list[SampledNumber]:
        """Standard deviations of what bends, and of the noise of a run; SI."""
        samples = np.sqrt(self._numbers[:, [0, -1]]).T * self._scale[0]
        return [_sampled(name, column) for name, column in zip(("bends", "noise"), samples, strict=True)]

    @cached_property
    def typical(self) -> "TypicalProcess":
        """The process with the median size, lengths and noise, for functions that ask for very many places."""
        parameters = np.median([process.parameters for process in self._mixture.processes], axis=0)
        return TypicalProcess(self.runs, _process(parameters, self.runs.scaled, self._standard), *self._scale)

    @property
    def _numbers(self) -> np.ndarray:
        """Size, lengths and noise of each sample, (samples, inputs + 2)."""
        return np.exp([process.parameters for process in self._mixture.processes])

    @cached_property
    def _mixture(self) -> "_Mixture":
        return _mixture_of(self.runs.scaled, self._standard)

    @property
    def _standard(self) -> np.ndarray:
        """The values of the runs less their mean, over their standard deviation."""
        scale, shift = self._scale
        return (self.runs.values - shift) / scale

    @property
    def _scale(self) -> tuple[float, float]:
        """Standard deviation and mean of the values."""
        values = self.runs.values
        return float(values.std()) or 1.0, float(values.mean())

    def _prediction(self, values: np.ndarray, deviations: np.ndarray) -> Prediction:
        """Mean and interval of mixtures of normal distributions, (samples, places) each."""
        from scipy.special import ndtr

        means = values.mean(axis=0)
        away = values - means
        low = np.zeros_like(means)
        high = (np.abs(away) + 10.0 * deviations).max(axis=0)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            inside = ndtr((middle - away) / deviations) - ndtr((-middle - away) / deviations)
            is_short = inside.mean(axis=0) < CONFIDENCE
            low, high = np.where(is_short, middle, low), np.where(is_short, high, middle)
        scale, shift = self._scale
        return Prediction(means * scale + shift, high * scale)


@dataclass(frozen=True)
class _Process:
    """A Gaussian process with given lengths, size and noise."""

    parameters: np.ndarray  # logarithms of size, lengths and noise
    kernel: Any  # of scikit-learn
    x: np.ndarray  # (runs, inputs), from 0 to 1
    factor: np.ndarray  # of the covariance of the runs: lower triangle of Cholesky
    solved: np.ndarray  # (runs,) covariance^-1 y

    def likelihood(self, y: np.ndarray) -> float:
        """Logarithm of the likelihood of the runs, up to a constant: Rasmussen and Williams (2006), Eq. 2.30."""
        return float(-0.5 * y @ self.solved - np.log(np.diag(self.factor)).sum())

    def means(self, x: np.ndarray) -> np.ndarray:
        """Predicted values at some inputs (places, inputs): their Eq. 2.25."""
        return np.asarray(self.kernel(x, self.x) @ self.solved)

    def deviations(self, x: np.ndarray) -> np.ndarray:
        """Standard deviations of runs there, noise included: their Eq. 2.26."""
        from scipy.linalg import solve_triangular

        half = solve_triangular(self.factor, self.kernel(x, self.x).T, lower=True)
        return np.sqrt(np.maximum(self.kernel.diag(x) - (half**2).sum(axis=0), NUGGET))


@dataclass(frozen=True)
class TypicalProcess:
    """A single process in place of the mixture: as many times faster as that has samples."""

    runs: ComputedRuns
    process: _Process
    scale: float
    shift: float

    def mean(self, places: np.ndarray) -> np.ndarray:
        """Values at some inputs (places, inputs), SI."""
        return self.process.means(self.runs.scale(places)) * self.scale + self.shift

    @property
    def error(self) -> float:
        """Root mean square error of each run predicted from all others: Rasmussen and Williams (2006), Eq. 5.12."""
        from scipy.linalg import cho_solve

        inverse = cho_solve((self.process.factor, True), np.eye(len(self.process.x)))
        return float(np.sqrt(np.mean((self.process.solved / np.diag(inverse)) ** 2))) * self.scale


@dataclass(frozen=True)
class _Mixture:
    """Processes with sampled lengths, sizes and noises."""

    processes: list[_Process]

    def at(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values and standard deviations at some inputs (places, inputs): (samples, places) each."""
        values = np.array([process.means(x) for process in self.processes])
        return values, np.array([process.deviations(x) for process in self.processes])

    def means(self, x: np.ndarray) -> np.ndarray:
        """Values at some inputs, the mean over the samples."""
        return np.mean([process.means(x) for process in self.processes], axis=0)


def _mixture_of(x: np.ndarray, y: np.ndarray) -> _Mixture:
    """Processes of runs (runs, inputs) with values (runs,) about 0 and of about unit size."""
    bounds = np.log([SIZES, *[LENGTHS] * x.shape[1], NOISES])

    def likelihood(parameters: np.ndarray) -> float:
        return _process(parameters, x, y).likelihood(y)

    samples = sampled_slices(likelihood, bounds.mean(axis=1), bounds)
    return _Mixture([_process(sample, x, y) for sample in samples])


def _process(parameters: np.ndarray, x: np.ndarray, y: np.ndarray) -> _Process:
    """A process from the logarithms of its size, lengths and noise."""
    from scipy.linalg import cho_solve
    from sklearn.gaussian_process.kernels import ConstantKernel, DotProduct, Matern, WhiteKernel

    size, *lengths, noise = np.exp(parameters)
    line = ConstantKernel(WIDE**2) * DotProduct(1.0)
    bends = ConstantKernel(size) * Matern(np.array(lengths), nu=2.5)
    kernel = line + bends + WhiteKernel(noise)
    factor = np.linalg.cholesky(kernel(x) + NUGGET * np.eye(len(x)))
    return _Process(parameters, kernel, x, factor, cho_solve((factor, True), y))


def sampled_slices(logarithm: Callable[[np.ndarray], float], start: np.ndarray, bounds: np.ndarray) -> list[np.ndarray]:
    """Samples of a density between bounds (dimensions, 2), by slices along each dimension.

    ``logarithm`` is that of the density, up to a constant. Neal (2003), Ann. Statist. 31, 705: slices that begin as the
    whole range and shrink.
    """
    rng = np.random.default_rng(SEED)
    at = start
    height = logarithm(at)
    samples = []
    for number in range(BURN_IN + SAMPLES):
        for place, (low, high) in enumerate(bounds):
            level = height - rng.exponential()
            while True:
                moved = at.copy()
                moved[place] = rng.uniform(low, high)
                height = logarithm(moved)
                if height >= level:
                    at = moved
                    break
                if moved[place] < at[place]:
                    low = moved[place]
                else:
                    high = moved[place]
        if number >= BURN_IN:
            samples.append(at)
    return samples


def _sampled(name: str, samples: np.ndarray) -> SampledNumber:
    outside = 50.0 * (1.0 - CONFIDENCE)
    low, median, high = np.percentile(samples, (outside, 50.0, 100.0 - outside)).tolist()
    return SampledNumber(name, median, low, high)


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
        "inputs": [{"name": each.name, "unit": each.unit, "low": each.low, "high": each.high} for each in runs.inputs],
        "level": CONFIDENCE,
        "covariance": {
            "kernel": KERNEL,
            "samples": SAMPLES,
            "lengths_over_ranges": [asdict(each) for each in surrogate.lengths],
            "deviations": [asdict(each) for each in surrogate.deviations],
        },
        "left_out": {
            **_errors(left),
            "runs": [
                {
                    "run": id,
                    "at": dict(zip([each.name for each in runs.inputs], place, strict=True)),
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
