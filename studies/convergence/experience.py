"""The mesh error of a measured number, known from experience: how far the same shots were off on coarse grids.

An ensemble of shots on several grids each (docs/pages/mesh_error.py) says what a value on one grid is off by, and how
sure that is. A scenario tells the ``MeshGrid`` of a run for each of its measurements; ``mesh_error`` answers for a
quantity where the grid lies in the domain that the ensemble has tested, and is silent elsewhere. ``cells_for`` asks the
other way round. The constants are stored by ``python -m docs.mesh_fit`` and count for one version of the physics.
"""

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from pydantic import TypeAdapter

from solver import PHYSICS_VERSION
from studies.quantities.measured import BY_ONE_GRID, MESH, OF_MESH, Measured, numerical_parts

STORED = Path(__file__).with_name("experience.json")

FREEDOM = 5.0  # degrees of Student's distribution: Lange, Little and Taylor (1989), J. Am. Stat. Assoc. 84, 881
NINETY_FIVE, NINETY_NINE = 2.5706, 4.0321  # its quantiles of 97.5 and 99.5 %
SPEED, STRENGTH = 4e3, 3e8  # m/s and Pa: units of speed and strength in the terms
THROUGH_ORDER = 2  # of the error by cells through a plate: that of the scheme
ACROSS_ORDER = 1  # by cells across what hits: the surface of what is hit is blurred by part of a cell
FEWEST_CELLS, MOST_CELLS = 2, 512  # across, that an accuracy may ask for: those that a scenario takes


@dataclass(frozen=True)
class MeshGrid:
    """The grid of a run, with what its mesh error depends on."""

    quantity: str  # whose experience it is: the hole of a bumper is that of any plate
    across: float  # cells across the diameter of the projectile or bar
    through: float  # cells through the plate; infinite of blocks and bars
    speed: float  # m/s
    strength: float  # yield stress of the target or bar at its first slip, Pa
    density_ratio: float = 1.0  # projectile over target
    length: float = 1.0  # of the projectile or bar, in its diameters
    obliquity: float = 0.0  # rad
    in_space: bool = False  # three dimensions

    @property
    def thickness(self) -> float:
        """Thickness of the plate, in projectile diameters."""
        return self.through / self.across

    def refined(self, across: float) -> "MeshGrid":
        """The same shot on another number of cells."""
        return replace(self, across=across, through=self.through * across / self.across)


@dataclass(frozen=True)
class MeshError:
    """What the mesh does to a value, relative."""

    bias: float  # expected ln(value on the grid / value without mesh error)
    scale: float  # of Student's distribution, of what is left
    independent: bool = False  # whether what is left on another grid of the shot is another, so that both narrow a bar

    def corrected(self, value: float) -> float:
        """A value without the expected error."""
        return value * math.exp(-self.bias)

    @property
    def bar(self) -> float:
        """Half-width of 95 % of the relative error that is left."""
        return NINETY_FIVE * self.scale


def without_mesh_error(reading: Measured, error: MeshError) -> Measured:
    """A measurement without its expected mesh error, whose uncertainty is a bar of what is left and of its reading."""
    if reading.value is None:
        return reading
    value = error.corrected(reading.value)
    parts = {part: size for part, size in reading.parts.items() if part not in OF_MESH}
    parts[MESH] = error.bar * abs(value)
    flags = tuple(flag for flag in reading.flags if flag not in BY_ONE_GRID)
    uncertainty = math.hypot(*numerical_parts(parts).values())
    return replace(reading, value=value, uncertainty=uncertainty, parts=parts, flags=flags)


@dataclass(frozen=True)
class Domain:
    """The shots and grids about which an ensemble says something; each range is closed."""

    across: tuple[float, float]
    through: tuple[float, float]
    speed: tuple[float, float]
    strength: tuple[float, float]
    density_ratio: tuple[float, float]
    length: tuple[float, float]
    thickness: tuple[float, float]
    obliquity: tuple[float, float]

    def why_not(self, grid: MeshGrid) -> str:
        """What of a grid lies outside, in words; empty inside."""
        outside = []
        for name, (low, high) in vars(self).items():
            value = getattr(grid, name)
            # A finer grid than any is inside, and so is the end of a range as a quotient of rounded numbers has it.
            is_cells = name in ("across", "through")
            within = value >= low * (1.0 - 1e-9) and (is_cells or value <= high * (1.0 + 1e-9))
            if not within:
                outside.append(f"{name.replace('_', ' ')} {value:.3g} outside of {low:.3g} to {high:.3g}")
        return "; ".join(outside)


@dataclass(frozen=True)
class MeshModel:
    """Bias and scale of the relative mesh error of a quantity; each is a coefficient by its term."""

    bias: Mapping[str, float]
    scale: Mapping[str, float]
    in_space: float | None = None  # factor of the scale in three dimensions; None where nothing is known of these
    independent: bool = False  # as in ``MeshError``

    def error_on(self, grid: MeshGrid) -> MeshError:
        """The mesh error on a grid."""
        bias = math.fsum(self.bias[name] * value for name, value in bias_terms(grid).items() if name in self.bias)
        parts = (self.scale[name] * value for name, value in scale_terms(grid).items() if name in self.scale)
        wider = (self.in_space or math.inf) if grid.in_space else 1.0
        return MeshError(bias, wider * math.hypot(*parts), self.independent)


def bias_terms(grid: MeshGrid) -> dict[str, float]:
    """Every term that a bias may have: a power of the cells, alone and times a factor of the shot.

    >>> terms = bias_terms(MeshGrid("hole_diameter", across=10.0, through=2.0, speed=SPEED, strength=STRENGTH))
    >>> terms["through"], terms["across"], terms["across strength"]
    (0.25, 0.1, 0.0)
    """
    powers = {
        "through": grid.through**-THROUGH_ORDER,
        "across": grid.across**-ACROSS_ORDER,
        "across squared": grid.across**-THROUGH_ORDER,
    }
    factors = {"strength": math.log(grid.strength / STRENGTH), "density": math.log(grid.density_ratio)}
    return {
        **powers,
        **{f"{power} {factor}": value * times for power, value in powers.items() for factor, times in factors.items()},
    }


def scale_terms(grid: MeshGrid) -> dict[str, float]:
    """Every part of a scale; that of the rim, from which pieces break on any grid, goes with speed over strength."""
    return {
        "always": 1.0,
        "through": grid.through**-THROUGH_ORDER,
        "across": grid.across**-ACROSS_ORDER,
        "rim": grid.speed / SPEED * math.sqrt(STRENGTH / grid.strength) if math.isfinite(grid.through) else 0.0,
    }


@dataclass(frozen=True)
class Experience:
    """Model and domain of the mesh error of a quantity."""

    model: MeshModel
    domain: Domain


EXPERIENCES = TypeAdapter(dict[str, Experience])  # by quantity, as ``STORED`` has them


@cache
def stored() -> Mapping[str, Experience]:
    """Experience by quantity; none where another version of the physics computed the ensemble."""
    plain = json.loads(STORED.read_text(encoding="utf-8"))
    if plain["physics"] != PHYSICS_VERSION:
        return {}
    return EXPERIENCES.validate_python(plain["quantities"])


def mesh_error(grid: MeshGrid | None) -> MeshError | None:
    """The mesh error of what is measured on a grid; None where no experience covers it."""
    if grid is None or why_unknown(grid):
        return None
    return stored()[grid.quantity].model.error_on(grid)


def why_unknown(grid: MeshGrid | None) -> str:
    """Why ``mesh_error`` has no answer, in words; empty where it has one."""
    if grid is None or grid.quantity not in stored():
        return "the ensemble of shots on several grids has no such quantity, or not with these numerics and failures"
    known = stored()[grid.quantity]
    if grid.in_space and known.model.in_space is None:
        return "the ensemble has no such quantity in three dimensions"
    return known.domain.why_not(grid)


def cells_for(bar: float, grids: Iterable[MeshGrid]) -> float | None:
    """The fewest cells across on which all that is measured has a bar of at most so much, relative.

    ``grids`` are those of a run, one for each measurement; None where the error of one of them is unknown on any.
    """
    fewest = [_cells(bar, grid) for grid in grids]
    return None if not fewest or None in fewest else max(cells for cells in fewest if cells is not None)


def _cells(bar: float, grid: MeshGrid) -> float | None:
    def holds(cells: float) -> bool:
        error = mesh_error(grid.refined(cells))
        return error is not None and error.bar <= bar

    return next((float(cells) for cells in range(FEWEST_CELLS, MOST_CELLS + 1) if holds(cells)), None)


@dataclass(frozen=True)
class Combined:
    """The corrected values of one point on several grids as one."""

    value: float
    bar: float  # half-width of 95 %, in the unit of the value
    disagree: bool  # whether two grids or offsets differ by more than 99 % of what their mesh errors expect


def combined(grids: Sequence[tuple[Sequence[float], MeshError]]) -> Combined:
    """One value from the raw values on different resolutions, each of them at some offsets, the finest first.

    Each resolution has its mean and its mesh error, and counts by the inverse square of its scale. Where the finest and
    another, or an offset and the mean of its resolution, differ by more than is expected the bar holds what is seen.
    """
    values = [[error.corrected(value) for value in offsets] for offsets, error in grids]
    means = [math.fsum(offsets) / len(offsets) for offsets in values]
    weights = [error.scale**-2 for _, error in grids]
    total = math.fsum(weights)
    value = math.fsum(weight * mean for weight, mean in zip(weights, means, strict=True)) / total
    independent = all(error.independent for _, error in grids)
    bar = NINETY_FIVE * abs(value) * (total**-0.5 if independent else min(error.scale for _, error in grids))
    finest = grids[0][1].scale
    disagree = any(
        abs(mean - means[0]) > NINETY_NINE * math.hypot(error.scale, finest) * abs(means[0])
        or any(abs(one - mean) > NINETY_NINE * error.scale * abs(mean) for one in offsets)
        for offsets, mean, (_, error) in zip(values, means, grids, strict=True)
    )
    seen = max(abs(one - value) for offsets in values for one in offsets) if disagree else 0.0
    return Combined(value, max(bar, seen), disagree)
