"""Synthetic series of known limit: how many have a bar, how often it holds the limit, and how wide it is."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from random import Random

from studies.convergence.richardson import Sample, converge

LIMIT = 20.0
# Noise of one offset, share of a cell, where the finest grid is off by 1: between two bounds, evenly in its logarithm.
NOISE = {"quiet": (0.002, 0.05), "noisy": (0.05, 0.5), "within scatter": (0.1, 0.1)}
OTHERS = ("steep", "coarsest outside")  # not of an order from 0.6 to 2, of which the index speaks
# Spacings and offsets of 16, 24, 36 and of 16, 32, 64 cells, each with one offset too, and of uneven ratios.
LAYOUTS = (
    ((1.0, 1.5, 2.25), 3),
    ((1.0, 2.0, 4.0), 3),
    ((1.0, 1.5, 2.25), 1),
    ((1.0, 2.0, 4.0), 1),
    ((1.0, 4.0 / 3.0, 2.0), 3),
)


@dataclass(frozen=True)
class Coverage:
    """The bars of some series of one kind."""

    kind: str  # "of one order" for all but ``OTHERS`` together
    judged: float  # share of the series that are converging
    covered: float  # share of these whose limit lies within the bar
    ratio: float  # median of bar over error


def coverages(spacings: Sequence[float], offsets: int, count: int, seed: int = 20261128) -> Iterator[Coverage]:
    """Bars of ``count`` series of each kind, and of all of one order together."""
    random = Random(seed)
    pairs = {kind: [_judged(kind, random, spacings, offsets) for _ in range(count)] for kind in (*NOISE, *OTHERS)}
    for kind, mine in pairs.items():
        yield _coverage(kind, mine)
    yield _coverage("of one order", [pair for kind in NOISE for pair in pairs[kind]])


def _judged(kind: str, random: Random, spacings: Sequence[float], offsets: int) -> tuple[float, float] | None:
    """Bar and error of one series, f(h) = LIMIT + C h^p with normal noise; None unless it is converging."""
    order, error = random.uniform(0.6, 2.0), random.choice((-1.0, 1.0))
    low, high = NOISE.get(kind, NOISE["quiet"])
    noise = low * (high / low) ** random.random()
    if kind == "within scatter":
        error *= 0.5 * random.random() * noise
    if kind == "steep":
        order = random.uniform(3.2, 6.0)
        error /= spacings[2] ** order
    samples = []
    for spacing in spacings:
        outside = random.uniform(-3.0, 3.0) if kind == "coarsest outside" and spacing == spacings[2] else 0.0
        for _ in range(offsets):
            value = LIMIT + error * spacing**order + outside + random.gauss(0.0, noise * spacing)
            samples.append(Sample(spacing, value, sub_cell=noise * spacing))
    result = converge(samples)
    return (result.uncertainty, abs(result.value - LIMIT)) if result.verdict == "converging" else None


def _coverage(kind: str, pairs: Sequence[tuple[float, float] | None]) -> Coverage:
    judged = [pair for pair in pairs if pair is not None]
    covered = sum(error <= bar for bar, error in judged) / len(judged) if judged else math.nan
    ratios = sorted(bar / error if error else math.inf for bar, error in judged)
    return Coverage(kind, len(judged) / len(pairs), covered, ratios[len(ratios) // 2] if ratios else math.nan)
