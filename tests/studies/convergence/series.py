"""Synthetic series of known limit: how often an error bar holds it, and how wide it is."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from random import Random

from studies.convergence.richardson import Sample, converge, converge_series

LIMIT = 20.0
KINDS = ("quiet", "steep", "within scatter", "noisy", "coarsest outside")
POINTS = 6  # of a curve
CURVES = (
    *("one order", "exact", "noisy", "within scatter", "own orders", "own orders, exact"),
    *("one outside", "all outside", "one steep", "all steep"),
)
# Spacings and offsets of ``accuracy: standard`` and ``fine``, each with one offset too, and of the demo, too.
LAYOUTS = (
    ((1.0, 1.5, 2.25), 3),
    ((1.0, 2.0, 4.0), 3),
    ((1.0, 1.5, 2.25), 1),
    ((1.0, 2.0, 4.0), 1),
    ((1.0, 4.0 / 3.0, 2.0), 1),
    ((1.0, 4.0 / 3.0, 2.0), 3),
)


@dataclass(frozen=True)
class Width:
    """Coverage of some series of one kind, and the widths of their bars."""

    kind: str  # "all" for all kinds together
    covered: float  # share of the series whose limit lies within the bar
    bar: float  # median
    error: float  # root mean square of value minus limit
    ratio: float  # median of bar over error


def widths(spacings: Sequence[float], offsets: int, count: int, seed: int = 20261123) -> Iterator[Width]:
    """Coverage and widths of ``count`` series of each kind, and of all together."""
    random = Random(seed)
    pairs = {kind: [_judged(kind, random, spacings, offsets) for _ in range(count)] for kind in KINDS}
    for kind, mine in pairs.items():
        yield _width(kind, mine)
    yield _width("all", [pair for mine in pairs.values() for pair in mine])


def _judged(kind: str, random: Random, spacings: Sequence[float], offsets: int) -> tuple[float, float]:
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
    result = converge(_samples(random, spacings, offsets, (order, error, noise, outside)))
    return result.uncertainty, abs(result.value - LIMIT)


Law = tuple[float, float, float, float]  # order, error at a cell of 1, noise, what the coarsest has


def _samples(random: Random, spacings: Sequence[float], offsets: int, law: Law) -> list[Sample]:
    """Runs at several spacings and offsets."""
    order, error, noise, outside = law
    samples = []
    for place, spacing in enumerate(spacings):
        value = LIMIT + error * spacing**order + (outside if place == 2 else 0.0)
        for _ in range(offsets):
            shifted = value + random.gauss(0.0, noise * spacing)
            samples.append(Sample(spacing, shifted, sub_cell=noise * spacing))
    return samples


def curves(spacings: Sequence[float], offsets: int, count: int, seed: int = 20261124) -> Iterator[Width]:
    """The same of ``count`` curves of each kind, of ``POINTS`` points each."""
    random = Random(seed)
    every = []
    for kind in CURVES:
        pairs = []
        for _ in range(count):
            laws = _curve(kind, random, spacings)
            points = converge_series(_samples(random, spacings, offsets, law) for law in laws)
            assert len({point.rule for point in points}) == 1
            pairs += [(point.uncertainty, abs(point.value - LIMIT)) for point in points]
        yield _width(kind, pairs)
        every += pairs
    yield _width("all", every)


def _curve(kind: str, random: Random, spacings: Sequence[float]) -> list[Law]:
    """The points of a curve: errors of one sign, and one order unless the kind says otherwise."""
    order, noise, sign = random.uniform(1.0, 2.0), 0.0, random.choice((-1.0, 1.0))
    if kind not in ("exact", "own orders, exact"):
        noise = _between(random, *((0.2, 1.0) if kind == "noisy" else (0.05, 0.2)))
    bad = random.randrange(POINTS)
    laws = []
    for place in range(POINTS):
        mine, error, outside = order, sign * random.uniform(0.3, 1.0), 0.0
        if kind.startswith("own orders"):
            mine = random.uniform(1.0, 2.0)
        if kind == "all steep" or (kind == "one steep" and place == bad):
            mine = random.uniform(3.2, 6.0)
            error /= spacings[2] ** mine
        if kind == "all outside" or (kind == "one outside" and place == bad):
            outside = random.uniform(-3.0, 3.0)
        if kind == "within scatter":
            error = random.uniform(-0.5, 0.5) * noise
        laws.append((mine, error, noise, outside))
    return laws


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
        sorted(bar / error if error else math.inf for bar, error in pairs)[len(pairs) // 2],
    )
