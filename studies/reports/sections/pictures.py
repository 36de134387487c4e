"""Pictures of the runs and of their set-up: what each shows, with its texts and measured lengths."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from studies.reports.section import Part, Section, Source
from studies.scenarios.parts.outline import Outline


@dataclass(frozen=True)
class DrawnSetUp:
    """The set-up of the first run, to scale."""

    outline: Outline
    labels: Mapping[str, str]  # of dimensions and speed, by parameter
    materials: Mapping[str, str]  # by body
    alt: str

    @property
    def upward(self) -> float:
        """The factor that lets the coordinate along the line of flight point down: -1 where a body flies against it."""
        return -1.0 if any(shape.heading and shape.heading[1] < 0.0 for shape in self.outline.shapes) else 1.0


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


@dataclass(frozen=True)
class PicturedRun:
    """The pictures of a run."""

    run: int
    title: str
    missing: str | None
    full: bool  # whether it is shown in full size too
    finest: bool
    pictures: tuple[Picture, ...]


@dataclass(frozen=True)
class Pictures:
    """All pictured runs; those of the others are in their files."""

    setup: DrawnSetUp | None  # None where the scenario draws none
    runs: tuple[PicturedRun, ...]
    left_out: int


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


def _part(source: Source) -> Part | None:
    from studies.reports.pictures import pictures_of

    return Part(pictures_of(source.dataset, source.files))


SECTION = Section(
    "pictures", "Pictures", 70, Pictures, _part, "sections/pictures.html", "", "sections/pictures_appendix.html"
)
