"""Synthetic series of known limit: how often an error bar holds it, and how wide it is."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from random import Random

from studies.convergence.richardson import Sample, converge

LIMIT = 20.0
KINDS = ("quiet", "steep", "within scatter", "noisy", "coarsest outside")
# Spacings and offsets of ``accuracy: standard`` and ``fine``, each with one offset too, and of the demo.
LAYOUTS = (
    ((1.0, 1.5, 2.25), 3),
    ((1.0, 2.0, 4.0), 3),
    ((1.0, 1.5, 2.25), 1),
    ((1.0, 2.0, 4.0), 1),
    ((1.0, 4.0 / 3.0, 2.0), 1),
)


@dataclass(frozen=True)
class Width:
    """Coverage of some series of one kind, and the widths of their bars."""

    kind: str  # "all" for all kinds together
    covered: float  # share of the series whose limit lies within the bar
    bar: float  # median
    error: float  # root mean square of value minus limit
    ratio: float  # median of bar over error


def widths(
    spacings: Sequence[float], offsets: int, count: int, seed: int = 20261123
) -> Iterator[Width]:
    """Coverage and widths of ``count`` series of each kind, and of all together."""
    random = Random(seed)
    pairs = {
        kind: [_judged(kind, random, spacings, offsets) for _ in range(count)] for kind in KINDS
    }
    for kind, mine in pairs.items():
        yield _width(kind, mine)
    yield _width("all", [pair for mine in pairs.values() for pair in mine])


def _judged(
    kind: str, random: Random, spacings: Sequence[float], offsets: int
) -> tuple[float, float]:
    """Bar and error of one series: f(h) = LIMIT + C h^p, and a normal noise that is a share of the cell."""
    order, error, noise, outside = random.uniform(1.0, 2.0), random.choice((-1.0, 1.0)), 0.0, 0.0
    if kind in ("quiet", "coarsest outside"):
        noise = _between(random, 0.05, 0.2)
    if kind == "coarsest outside":
        outside = random.uniform(-3.0, 3.0)
    if kind == "noisy":
        noise = _between(random, 0.2, 1.0)
    if kind == "steep":
        order, noise = random.uniform(3.2, 6.0), _between(random, 0.01, 0.1)
        error /= spacings[2] ** order
    if kind == "within scatter":
        order, noise = 1.0, 0.1
        error = random.uniform(-0.5, 0.5) * noise
    samples = []
    for place, spacing in enumerate(spacings):
        value = LIMIT + error * spacing**order + (outside if place == 2 else 0.0)
        for _ in range(offsets):
            shifted = value + random.gauss(0.0, noise * spacing)
            samples.append(Sample(spacing, shifted, sub_cell=noise * spacing))
    result = converge(samples)
    return result.uncertainty, abs(result.value - LIMIT)


def _between(random: Random, low: float, high: float) -> float:
    """A number whose logarithm is spread evenly."""
    return math.exp(random.uniform(math.log(low), math.log(high)))


def _width(kind: str, pairs: list[tuple[float, float]]) -> Width:
    bars, errors = zip(*pairs, strict=True)
    return Width(
        kind,
        sum(error <= bar for bar, error in pairs) / len(pairs),
        sorted(bars)[len(bars) // 2],
        math.sqrt(math.fsum(error**2 for error in errors) / len(errors)),
        sorted(bar / error for bar, error in pairs)[len(pairs) // 2],
    )
