"""Pictures of the runs and of their set-up: what each shows, with its texts and measured lengths."""

from collections.abc import Mapping
from dataclasses import dataclass

from studies.reports.picture import Picture
from studies.reports.section import Section, when_called
from studies.scenarios.parts.outline import Outline


@dataclass(frozen=True)
class DrawnSetUp:
    """The set-up of the first run, to scale."""

    outline: Outline
    labels: Mapping[str, str]  # of dimensions and speed, by parameter
    materials: Mapping[str, str]  # by body
    alt: str


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


SECTION = Section(
    "pictures",
    "Pictures",
    70,
    Pictures,
    when_called("studies.pictures.shown:part_of"),
    template="studies.pictures:page.html",
    beside="studies.pictures:beside.html",
    appendix="studies.pictures:appendix.html",
    words=when_called("studies.pictures.page:words"),
    cover=when_called("studies.pictures.page:cover"),
)
