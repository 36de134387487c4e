"""Pictures of the runs and of their set-up: what each shows, with its texts and measured lengths."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from studies.quantities.parameters import Plain
from studies.reports.picture import Picture
from studies.reports.section import Files, Part, Section, Source, Words
from studies.scenarios.parts.outline import Outline

if TYPE_CHECKING:
    from markupsafe import Markup


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


def _part(source: Source) -> Part | None:
    from studies.pictures.shown import pictures_of

    return Part(pictures_of(source.dataset, source.files))


def _words(report: Mapping[str, Plain], files: Files) -> Words:
    from studies.pictures.page import words

    return words(report, files)


def _cover(report: Mapping[str, Plain], files: Files) -> "tuple[str, Markup, Markup] | None":
    from studies.pictures.page import cover

    return cover(report, files)


SECTION = Section(
    "pictures",
    "Pictures",
    70,
    Pictures,
    _part,
    template="studies.pictures:page.html",
    beside="studies.pictures:beside.html",
    appendix="studies.pictures:appendix.html",
    words=_words,
    cover=_cover,
)
