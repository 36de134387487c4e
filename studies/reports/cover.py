"""The cover of a report: what the list of sweeps, and the page of one, show of it without reading the whole.

``cover.zip`` holds ``cover.json``, the record of this module, and drawings as SVG files, each where there is one:
``figure-wide.svg`` and ``figure-narrow.svg``, with which the report opens, ``picture.svg``, that beside it, and
``thumbnail.svg``, a small one without words.
"""

import json
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from markupsafe import Markup

from studies.quantities.files import write_atomically
from studies.quantities.parameters import Plain
from studies.reports.figure import Figure
from studies.reports.section import Files, sections

ABOUT = "cover.json"
FIGURE, PICTURE, THUMBNAIL = ("figure-wide.svg", "figure-narrow.svg"), "picture.svg", "thumbnail.svg"
FEWEST = 3  # points of a line that a thumbnail shows
DRAWINGS = (*FIGURE, PICTURE, THUMBNAIL)


@dataclass(frozen=True)
class Cover:
    """What stands on a cover, and which of its drawings there are."""

    headline: str
    figure: str  # title
    caption: str
    picture: str  # what it shows
    drawings: tuple[str, ...]


def write_cover(report: Mapping[str, Plain], files: Files, file: Path) -> Path:
    """Write the cover of a report's document; ``files`` are those of sections by run id."""
    from studies.reports.drawing import charts  # with Matplotlib, which readers need not load
    from studies.reports.drawing.images import as_files
    from studies.reports.page import FIGURES, opening_figure

    every = FIGURES.validate_python(report["figures"])
    number = opening_figure(every)
    drawings: dict[str, str] = {}
    title = caption = ""
    if number is not None:
        figure = every[number]
        title, caption = figure.title, figure.caption
        drawings |= zip(FIGURE, as_files(charts.opening(figure)), strict=False)
        if _is_curve(figure):
            drawings |= zip([THUMBNAIL], as_files(charts.thumbnail(figure)), strict=False)
    words, picture, small = next(_pictures(report, files), ("", Markup(""), Markup("")))
    drawings |= zip([PICTURE], as_files(picture), strict=False)
    drawings = dict(zip([THUMBNAIL], as_files(small), strict=False)) | drawings
    cover = Cover(str(report["headline"]), title, caption, words, tuple(drawings))

    def fill(part: Path) -> None:
        with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr(ABOUT, json.dumps(asdict(cover), ensure_ascii=False))
            for name, content in drawings.items():
                archive.writestr(name, content)

    return write_atomically(file, fill)


def read_cover(file: Path) -> Cover:
    """The record of a cover; raises OSError, KeyError and ValueError where it cannot be read."""
    return Cover(**json.loads(drawing(file, ABOUT)))


def drawing(file: Path, name: str) -> bytes:
    """A file of a cover; raises as ``read_cover`` does."""
    try:
        with zipfile.ZipFile(file) as archive:
            return archive.read(name)
    except zipfile.BadZipFile as error:
        raise ValueError(f"{file.name} is damaged: {error}") from error


def _is_curve(figure: Figure) -> bool:
    """Whether the first panel of a figure says something without words."""
    return figure.z is not None or any(len(series.x) >= FEWEST for series in figure.panels[0].series)


def _pictures(report: Mapping[str, Plain], files: Files) -> Iterator[tuple[str, Markup, Markup]]:
    """What sections show beside the figure: its words, the drawing, and a small one."""
    for section in sections():
        if section.cover and section.name in report and (shown := section.cover(report, files)):
            yield shown
