"""Pictures of runs in a report: from stored sections, with what they measure; and words where there are none."""

import base64
import io
import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from studies.pictures import shown as pictures
from studies.quantities.display import printed
from studies.reports.publish import publish_sweep
from studies.sections.section import END, read_sections
from studies.sweeps.axes import Axis
from studies.sweeps.sweep import Sweep
from tests.studies.runs.solved import solved
from tests.studies.support import fakes
from tests.studies.support.fakes import sweep_of
from tests.studies.support.printed import undrawn

Reported = tuple[dict, str]


def reported(sweep: Sweep, folder: Path, sections: dict[str, Path]) -> Reported:
    with undrawn():
        files = publish_sweep(sweep, fakes.results(sweep), folder, fakes.catalogue(sweep.scenario), sections)
    document = json.loads(Path(files["report.json"]).read_text())
    return document, Path(files["appendix.html"]).read_text()


def pictures_of_run(document: dict, number: int) -> list[dict]:
    return document["pictures"]["runs"][number]["pictures"]


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Reported:
    """A run with sections, one with a torn file, one without, and one that failed."""
    folder = tmp_path_factory.mktemp("report")
    sweep = sweep_of(Axis("speed", "m s-1", (2e3, 3e3, 4e3)))
    file = solved("thin_plate") / "sections.npz"
    torn = folder / "torn.npz"
    torn.write_bytes(file.read_bytes()[:1000])
    first, second, _ = (point.run.id for point in sweep.runs())
    return reported(sweep, folder / "out", {first: file, second: torn})


def test_picture__says_what_was_measured_and_when(report: Reported) -> None:
    document, html = report
    [end] = [p for p in pictures_of_run(document, 0) if p["kind"] == "end" and p["field"] == "plastic_strain"]
    hole = document["runs"]["runs"][0]["values"]["hole_diameter"]
    assert end["across"] == [{"quantity": "hole_diameter", "label": "hole diameter", "value": hole}]
    assert f"hole diameter {printed(hole, 'length')} mm" in end["alt"]
    assert end["alt"] in html
    assert re.search(rf">{printed(hole, 'length')} mm</text>", html)
    sections = read_sections(solved("thin_plate") / "sections.npz")
    state = sections.at(END)
    assert state
    assert end["time"] == state.time


def test_picture__that_is_missing_leaves_its_reason(report: Reported) -> None:
    document, html = report
    torn, absent = (document["pictures"]["runs"][number]["missing"] for number in (1, 2))
    assert "cannot be read" in torn
    assert "no section was kept" in absent
    late = [picture["missing"] for picture in pictures_of_run(document, 0) if picture["missing"]]
    assert len(late) == 1
    assert "the run ended before" in late[0]
    for reason in (torn, absent, *late):
        assert reason in html


def test_pictures__of_many_runs_are_of_some_of_the_finest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pictures, "MOST_RUNS", 1)
    sweep = fakes.refined_holes((16.0, 32.0), offsets=1)
    file = solved("thin_plate") / "sections.npz"
    document, _ = reported(sweep, tmp_path, {p.run.id: file for p in sweep.runs()})
    runs = document["pictures"]["runs"]
    assert len(runs) == 1
    assert document["pictures"]["left_out"] == len(sweep.runs()) - len(runs)
    assert {document["runs"]["runs"][run["run"]]["at"]["cells_per_diameter"] for run in runs} == {32.0}


def test_page__embeds_pictures_that_can_be_opened(report: Reported) -> None:
    _, html = report
    runs = re.findall(r'<svg class="picture of-run.*?</svg>', html, re.DOTALL)
    # Thumbnails of the end and of one moment; five fields and that moment in full.
    assert len(runs) == 2 + 5 + 1
    for drawn in runs:
        embedded = re.findall(r'href="data:image/png;base64,([^"]+)"', drawn)
        assert len(embedded) == (1 if "thumbnail" in drawn else 2)  # with a colour bar
        shown = np.asarray(Image.open(io.BytesIO(base64.b64decode(embedded[0]))).convert("RGBA"))
        assert 0.0 < (shown[..., 3] > 0).mean() < 1.0
        np.testing.assert_array_equal(shown, shown[:, ::-1])  # the mirror image


def test_setup__is_to_scale_with_the_values_of_the_sweep(tmp_path: Path) -> None:
    axes = Axis("speed", "m s-1", (2e3, 7e3)), Axis("plate_thickness", "m", (2e-3, 4e-3))
    sweep = sweep_of(*axes, fixed={"plate_radius": 28e-3})
    with undrawn():
        files = publish_sweep(sweep, fakes.results(sweep), tmp_path, fakes.catalogue())
    setup = json.loads(Path(files["report.json"]).read_text())["pictures"]["setup"]
    assert setup["labels"] == {
        "projectile_diameter": "8 mm",
        "plate_thickness": "2 to 4 mm",
        "plate_radius": "28 mm",
        "speed": "2 to 7 km/s",
    }
    html = Path(files["report.html"]).read_text()
    (disc, _), (wide, high) = (size_of(body, html) for body in ("projectile", "target"))
    assert disc / wide == pytest.approx(8 / 56, rel=0.01)
    assert high / wide == pytest.approx(2 / 56, rel=0.03)


def size_of(body: str, html: str) -> np.ndarray:
    """Width and height of the outline of a body in the sketch."""
    outlines = re.findall(rf'<g class="{body}"> *<path d="([^"]*)"', html)
    return np.ptp(np.array(re.findall(r"(-?[\d.]+) (-?[\d.]+)", outlines[0]), float), axis=0)
