"""Surrogates of cubes and Sobol indices: known answers, and runs that were left out."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from service.cli.commands.computing import DEMO
from service.cli.local import run_sweep
from studies import examples
from studies.fits.indices import InputIndices, indices_of
from studies.fits.measured import open_cube
from studies.fits.surrogate import ComputedRuns, LeftOut, Surrogate, SurrogateInput, surrogate_of
from studies.sweeps.document import read_yaml
from studies.sweeps.sampling import LATIN, SOBOL, Sampling
from tests.claims import Row, at_least, claim
from tests.claims.computed import scratch

# Ishigami and Homma (1990) with a = 7, b = 0.1. With V = a^2/8 + b pi^4/5 + b^2 pi^8/18 + 1/2: S1 = (1 + b pi^4/5)^2 /
# (2 V), S2 = a^2 / (8 V), S3 = 0, and x3 acts through x1 alone: ST3 = 8 b^2 pi^8 / (225 V).
A, B = 7.0, 0.1
VARIANCE = A**2 / 8 + B * np.pi**4 / 5 + B**2 * np.pi**8 / 18 + 0.5
FIRST = ((1 + B * np.pi**4 / 5) ** 2 / (2 * VARIANCE), A**2 / (8 * VARIANCE), 0.0)
JOINT = 8 * B**2 * np.pi**8 / (225 * VARIANCE)
TOTAL = (FIRST[0] + JOINT, FIRST[1], JOINT)
BOUNDS = [(-np.pi, np.pi)] * 3
NAMES = ("x1", "x2", "x3")
SEEDS = range(20)
COVERED = (0.90, 0.99)  # share of intervals of 95 % that hold what they are about
MADE_UP = 12  # functions; each is computed at PLACES points and predicted at UNSEEN others
PLACES, UNSEEN = 16, 40


def ishigami(x: np.ndarray) -> np.ndarray:
    """sin x1 + a sin^2 x2 + b x3^4 sin x1 of (places, 3)."""
    return np.sin(x[:, 0]) + A * np.sin(x[:, 1]) ** 2 + B * x[:, 2] ** 4 * np.sin(x[:, 0])


@claim(
    "ishigami-indices",
    says="the Sobol indices of Ishigami's function, 0.314, 0.442 and 0 by themselves, lie within their intervals",
)
def ishigami_indices() -> Iterator[Row]:
    for place, index in enumerate(indices_of(ishigami, NAMES, BOUNDS)):
        for kind, exact, got in (
            ("by itself", FIRST[place], index.first),
            ("with interactions", TOTAL[place], index.total),
        ):
            text = f"{got.value:.3f} ({got.low:.3f} to {got.high:.3f})"
            yield Row(f"{index.name}, {kind}", round(exact, 3), text, got.low <= exact <= got.high)


@claim("sobol-intervals", says="the intervals of Sobol indices hold Ishigami's exact ones at 90 % or more of 20 seeds")
def sobol_intervals() -> Iterator[Row]:
    every = [indices_of(ishigami, NAMES, BOUNDS, samples=1024, seed=seed) for seed in SEEDS]
    yield at_least("share inside", limit=COVERED[0], got=float(np.mean([_inside(e) for e in every])))


def _inside(indices: list[InputIndices]) -> list[bool]:
    pairs = [
        (got, exact)
        for place, index in enumerate(indices)
        for got, exact in ((index.first, FIRST[place]), (index.total, TOTAL[place]))
    ]
    return [got.low <= exact <= got.high for got, exact in pairs]


@claim(
    "surrogate-left-out",
    says="surrogates of the demo's cubes predict each run from the others: errors printed, their 95 % intervals cover "
    "90 to 99 % of all runs",
)
def surrogate_left_out() -> Iterator[Row]:
    every = []
    for name in DEMO:
        folder = Path(scratch().name) / f"demo-{name}"
        run_sweep(read_yaml(examples.text(name), name), folder)
        dataset = open_cube(folder)
        for quantity in ("hole_diameter", "crater_depth", "crater_diameter"):
            # The sphere of the demo is a single point.
            if quantity in dataset and dataset.sizes["speed"] > 1:
                left = surrogate_of(dataset, quantity).left_out
                every.append(np.abs(left.errors) <= left.predicted.intervals)
                yield from _rows(f"{name}, {quantity}", left)
    yield _covered("all runs", float(np.concatenate(every).mean()))


def _rows(where: str, left: LeftOut) -> Iterator[Row]:
    errors = ", ".join(f"{1e3 * error:+.3f}" for error in left.errors)
    yield Row(f"{where}: predicted minus computed (mm)", "", errors, None)
    text = f"rms {1e3 * left.rms:.3f} mm, largest {1e3 * left.largest:.3f} mm, Q2 {left.explained:.4f}"
    yield Row(f"{where}: errors", "", text, None)
    # A dozen runs: the share of one cube is 11 of 12, or outside of these limits.
    yield Row(f"{where}: coverage", "", round(left.coverage, 3), None)


def _covered(where: str, share: float) -> Row:
    low, high = COVERED
    return Row(f"{where}: coverage", f"{low} to {high}", round(share, 3), low <= share <= high)


@claim(
    "surrogate-unseen",
    says="the 95 % intervals of surrogates over 16 points hold 90 to 99 % of the values of made-up laws with scatter "
    "at points that they have not seen",
)
def surrogate_unseen() -> Iterator[Row]:
    rng = np.random.default_rng(18)
    inside, lengths = [], []
    for number in range(MADE_UP):
        c, m, n, b = rng.uniform((0.5, 0.3, 0.2, 0.0), (2.5, 1.0, 0.9, 1.5))
        scatter = 10 ** rng.uniform(-3.0, -1.5)

        def size(x: np.ndarray, c: float = c, m: float = m, n: float = n, b: float = b) -> np.ndarray:
            return c * x[:, 0] ** m * x[:, 1] ** n + b

        inputs = (SurrogateInput("v", "1", 2.0, 7.0), SurrogateInput("t", "1", 0.1, 0.6))
        points, unseen = (
            np.column_stack(
                [
                    each.low + (each.high - each.low) * np.array(column)
                    for each, column in zip(inputs, Sampling(method, count, number).coordinates(2), strict=True)
                ]
            )
            for method, count in ((SOBOL, PLACES), (LATIN, UNSEEN))
        )
        values, exact = size(points), size(unseen)
        noise = scatter * values.std()
        values = values + noise * rng.standard_normal(len(values))
        seen = exact + noise * rng.standard_normal(len(exact))
        runs = ComputedRuns("y", "1", "made up", inputs, points, values)
        predicted = Surrogate(runs).predict(unseen)
        inside.append(float(np.mean(np.abs(predicted.values - seen) <= predicted.intervals)))
        lengths.append(float(np.median(predicted.intervals) / noise))
    yield Row("share inside, by function", "", [round(share, 2) for share in inside], None)
    yield Row("median half length over the scatter", "", round(float(np.median(lengths)), 2), None)
    yield _covered("unseen points", float(np.mean(inside)))
