"""Accuracies: the resolutions and sub-cell offsets of a sweep under one name."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from studies.quantities.numerical_defaults import FEW_PARTICLES


@dataclass(frozen=True)
class Accuracy:
    """Resolutions and offsets at which a sweep computes each of its points."""

    resolutions: tuple[float, ...]  # cells across the projectile's diameter, coarse to fine
    offsets: int  # sub-cell positions of the grid at each resolution, evenly spaced over a cell
    meaning: str
    few_particles: bool = False  # whether ``FEW_PARTICLES`` do where the user states no number


# Three grids, because an observed order needs them (Celik et al. 2008, J. Fluids Eng. 130, 078001, who ask for a
# ratio of more than 1.3). Through a plate of a quarter diameter 16, 32 and 64 cells are 4, 8 and 16: below 4 a plate
# has too few particles for a stress wave (flag ``under_resolved``). Three offsets, because an order counts only above
# the scatter over them: of an error that varies once over a cell, two see between all and nothing, three always more
# than four fifths.
ACCURACY: Mapping[str, Accuracy] = MappingProxyType(
    {
        "draft": Accuracy(
            (16.0,),
            1,
            f"one grid, for trends: 16 cells across the diameter, {FEW_PARTICLES} particles along each direction",
            few_particles=True,
        ),
        "standard": Accuracy(
            (16.0, 24.0, 36.0),
            3,
            "three grids at three sub-cell offsets; an order and a mesh error where they differ by enough",
        ),
        "fine": Accuracy(
            (16.0, 32.0, 64.0), 3, "three finer grids, each twice as fine as the one before, at three sub-cell offsets"
        ),
    }
)
