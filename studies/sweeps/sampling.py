"""Points sampled from the ranges of several axes, in place of their product: Latin hypercubes and Sobol sequences."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeGuard

from studies.quantities.findings import Finding, Findings, refusal, shown, unknown_keys
from studies.quantities.parameters import Parameter, Plain
from studies.quantities.units import readable, round_quantity
from studies.sweeps.axes import Axis, AxisReader
from studies.sweeps.search import read_end

if TYPE_CHECKING:
    from scipy.stats.qmc import QMCEngine

LATIN, SOBOL = "latin-hypercube", "sobol"
METHODS = (LATIN, SOBOL)
KEYS = ("low", "high", "values")
EXAMPLE = "write {low: 2 km/s, high: 7 km/s}"
LARGEST_SEED = 2**32 - 1


@dataclass(frozen=True)
class Sampling:
    """The rule by which the points of a sweep were sampled."""

    method: str  # one of METHODS
    points: int
    seed: int

    def coordinates(self, dimensions: int) -> list[list[float]]:
        """The points in the unit cube, by dimension, scrambled as by Owen (1998), J. Complexity 14, 466."""
        from scipy.stats import qmc

        engine: Callable[..., QMCEngine] = {LATIN: qmc.LatinHypercube, SOBOL: qmc.Sobol}[self.method]
        points = engine(dimensions, rng=self.seed).random(self.points)
        rows: list[list[float]] = points.T.tolist()
        return rows


def read_sampling(method: str, document: Mapping[str, Plain], most_points: int) -> Sampling:
    """Count and seed of a document whose axes are sampled; raises InvalidInput with every finding."""
    findings = Findings()
    points = document.get("points")
    if not _is_whole(points) or not 1 <= points <= most_points:
        limit = f"a whole number from 1 to {most_points}"
        findings.append(Finding("points", shown(points), limit, "write points: 16"))
    elif method == SOBOL and points & (points - 1):
        below = 1 << (points.bit_length() - 1)
        cure = f"write points: {below} or points: {2 * below}"
        limit = "a power of two, without which a Sobol sequence loses its balance"
        findings.append(Finding("points", shown(points), limit, cure))
    seed = document.get("seed")
    if not _is_whole(seed) or not 0 <= seed <= LARGEST_SEED:
        limit = f"a whole number from 0 to {LARGEST_SEED}, so that the same points come again"
        findings.append(Finding("seed", shown(seed), limit, "write seed: 1"))
    findings.check()
    assert _is_whole(points)
    assert _is_whole(seed)
    return Sampling(method, points, seed)


def read_range(parameter: Parameter, name: str, raw: Plain, reader: AxisReader, points: int | None) -> Axis:
    """An axis that is sampled: low and high, and the values of an earlier reading, which stay; raises InvalidInput."""
    field = f"axes.{name}"
    if parameter.kind != "quantity" or not isinstance(raw, Mapping):
        limit = "low and high of a quantity, because the axes are sampled"
        raise refusal(field, raw, limit, f"{EXAMPLE}; what has one value belongs under fixed")
    findings = Findings()
    findings.extend(unknown_keys(raw, KEYS, field, "low and high"))
    ends = [
        findings.attempt(read_end, parameter, raw.get(key), f"{field}.{key}", "low and high", EXAMPLE)
        for key in ("low", "high")
    ]
    findings.check()
    low, high = (end for end in ends if end is not None)
    if not low < high:
        unit = parameter.unit or "1"
        raise refusal(f"{field}.high", raw["high"], f"more than {readable(low, unit)}", EXAMPLE)
    if raw.get("values") is None:
        return Axis(name, parameter.unit, (), (low, high))
    values = reader.read(parameter, name, raw["values"], f"{field}.values").values
    inside = all(isinstance(value, float) and low <= value <= high for value in values)
    if not inside or len(values) != points:
        limit = f"{points} values from low to high"
        raise refusal(f"{field}.values", f"{len(values)} values", limit, "leave values out")
    return Axis(name, parameter.unit, values, (low, high))


def sampled(sampling: Sampling, axes: Sequence[Axis]) -> tuple[Axis, ...]:
    """Axes with the values of the points; those that state all their values keep them."""
    if all(axis.values for axis in axes):
        return tuple(axes)
    drawn = []
    for axis, shares in zip(axes, sampling.coordinates(len(axes)), strict=True):
        assert axis.bounds is not None
        low, high = axis.bounds
        drawn.append(replace(axis, values=tuple(round_quantity(low + (high - low) * share) for share in shares)))
    return tuple(drawn)


def _is_whole(value: Plain) -> TypeGuard[int]:
    return isinstance(value, int) and not isinstance(value, bool)
