"""The cover of a report: what lists and pages show of it."""

from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from studies.reports.cover import DRAWINGS, FIGURE, THUMBNAIL, drawing, read_cover, write_cover
from studies.reports.report import report_of
from studies.reports.view import MOST_POINTS
from studies.sweeps.axes import Axis
from tests.studies.runs.solved import solved
from tests.studies.support import fakes
from tests.studies.support.fakes import sweep_of

LARGEST_THUMBNAIL = 20_000  # bytes: five hundred of them are on a page
SPEEDS = (2e3, 3e3, 4e3, 5e3)


MANY = tuple(1e-3 + 1e-4 * place for place in range(MOST_POINTS // 4 + 1))  # of which a figure is a map


def cover_of(folder: Path, speeds: tuple[float, ...] = SPEEDS, thicknesses: tuple[float, ...] = (2e-3,)) -> Path:
    sweep = sweep_of(Axis("speed", "m s-1", speeds), Axis("plate_thickness", "m", thicknesses))
    dataset = fakes.cube_of(sweep)
    files = {point.run.id: solved("thin_plate") / "sections.npz" for point in sweep.runs()}
    return write_cover(report_of(dataset, files).as_json(), files, folder / "cover.zip")


def test_cover__has_the_headline_and_the_drawings_of_the_first_screen(tmp_path: Path) -> None:
    file = cover_of(tmp_path)
    cover = read_cover(file)
    assert cover.headline
    assert {*cover.drawings} == {*DRAWINGS}
    words = " ".join(ET.fromstring(drawing(file, FIGURE[0])).itertext())
    assert "speed (km/s)" in words
    assert "simulation" in words
    file.write_bytes(file.read_bytes()[:100])
    with pytest.raises(ValueError, match="damaged"):
        read_cover(file)


def test_thumbnail__is_small_and_has_no_words(tmp_path: Path) -> None:
    # Of a single point it is the picture.
    for speeds, thicknesses in ((SPEEDS, MANY[:1]), (SPEEDS[:1], MANY[:1]), (SPEEDS, MANY)):
        thumbnail = drawing(cover_of(tmp_path, speeds, thicknesses), THUMBNAIL)
        assert len(thumbnail) < LARGEST_THUMBNAIL
        assert (b"<image" in thumbnail) is (len(speeds) == 1 or thicknesses == MANY)
        titles = [each.tag for each in ET.fromstring(thumbnail).iter() if each.tag.endswith("title")]
        assert not titles
