"""Records of pictures of states of a run: what each shows, with its texts and measured lengths."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Length:
    """A measured length that a picture shows, m."""

    quantity: str
    label: str
    value: float


@dataclass(frozen=True)
class Frame:
    """The part of a section that a picture shows, m."""

    left: float
    right: float
    top: float  # lowest coordinate along the line of flight, where the projectile comes from
    bottom: float

    @property
    def width(self) -> float:
        return self.right - self.left

    @property
    def height(self) -> float:
        return self.bottom - self.top


@dataclass(frozen=True)
class Picture:
    """A state of a run, coloured by a field; without a frame there is none, for a reason."""

    kind: str  # "end" or "debris"
    missing: str | None = None  # why there is no picture
    moment: int = 0
    time: float = 0.0  # s
    field: str = ""
    label: str = ""
    unit: str = ""
    factor: float = 1.0  # from SI to the unit
    limits: tuple[float, float] = (0.0, 1.0)  # of the colours
    frame: Frame | None = None
    middle: float = 0.0  # of what is measured across, m
    across: tuple[Length, ...] = ()
    along: tuple[Length, ...] = ()
    alt: str = ""
    sign: float = 1.0  # -1 where the line of flight points up


def rounded_up(value: float) -> float:
    """The next number at or above a value that reads well; 1 for what is not above 0.

    >>> rounded_up(0.83), rounded_up(2.1), rounded_up(4.1e9), rounded_up(0.0)
    (1.0, 2.5, 5000000000.0, 1.0)
    """
    if value <= 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    step = next(
        step for step in (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0) if step * power >= value * 0.999
    )
    return float(f"{step * power:.12g}")
