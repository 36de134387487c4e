"""Figures as files: what the specification says is drawn, and what is no cube is refused."""

import builtins
import re
from pathlib import Path
from typing import Any

import pytest

from studies.cubes import cube
from studies.reports import figures, plot
from studies.reports.compare import compare
from studies.reports.printing import draw, draw_figures
from studies.values.errors import InvalidInput, MissingExtra
from tests.studies.support import fakes
from tests.studies.support.fakes import Axis, Sweep

WORDS = Sweep(
    (Axis("projectile", None, ("tin", "lead")),), fixed={"projectile_diameter": fakes.DIAMETER, "plate_thickness": 2e-3}
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a cube with several figures."""
    sweep = Sweep((Axis("speed", "m s-1", (3e3, 5e3)),), fixed=WORDS.fixed)
    folder = tmp_path_factory.mktemp("cube")
    dataset = cube.build(sweep, fakes.results(sweep), fakes.catalogue(sweep.scenario, fakes.SHOTS))
    cube.write(dataset, folder / "cube.nc")
    return folder


def test_draw_figures__writes_one_file_a_figure_with_its_titles_and_labels(folder: Path, tmp_path: Path) -> None:
    import xarray as xr

    with xr.open_dataset(folder / "cube.nc") as dataset:
        every = figures.figures(dataset, compare(dataset))
    files = draw_figures(folder, tmp_path, "svg")
    assert [file.name for file in files] == [f"{figure.name}.svg" for figure in every]
    for figure, file in zip(every, files, strict=True):
        # Matplotlib writes each text beside its outlines, as a comment.
        texts = set(re.findall(r"<!-- (.*?) -->", file.read_text()))
        panels = {panel.title for panel in figure.panels if panel.title}
        assert panels <= texts, figure.name
        assert any(figure.y.label in text for text in texts), figure.name


def test_draw__writes_the_flags_at_their_marks(tmp_path: Path) -> None:
    trace = {
        "xaxis": "x",
        "yaxis": "y",
        "mode": "markers+text",
        "x": [1.0],
        "y": [2.0],
        "text": ["near rim"],
        "textposition": ["bottom left"],
        "textfont": {"color": "#a3003c", "size": 12},
        "marker": {"color": "#a3003c", "size": 17, "symbol": "circle-open"},
    }
    axis = {"domain": [0.0, 1.0], "range": [0.0, 3.0]}
    margin = {"l": 60, "r": 10, "t": 30, "b": 60}
    layout = {"width": 400, "height": 300, "margin": margin, "xaxis": axis, "yaxis": axis}
    title = {"text": "<b>two<br>lines</b><br>note", "x": 0.0, "y": 1.0, "xref": "paper"}
    specification = {"data": [trace], "layout": {**layout, "annotations": [title]}}
    file = draw(specification, tmp_path / "flag.svg")
    texts = set(re.findall(r"<!-- (.*?) -->", file.read_text()))
    assert {"near rim", "two", "lines", "note"} <= texts


@pytest.mark.parametrize("format", ["png", "pdf"])
def test_draw__writes_the_format_of_the_ending(format: str, tmp_path: Path) -> None:
    dataset = cube.build(WORDS, fakes.results(WORDS), fakes.catalogue(WORDS.scenario, ()))
    first = figures.figures(dataset, compare(dataset))[0]
    file = draw(plot.plot(first), tmp_path / f"words.{format}")
    assert file.read_bytes()[:5] in (b"\x89PNG\r", b"%PDF-")
    assert len(list(tmp_path.iterdir())) == 1


def test_draw__without_matplotlib_names_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plain_import = builtins.__import__

    def refuse(name: str, *rest: Any) -> Any:
        if name.startswith("matplotlib"):
            raise ImportError(name)
        return plain_import(name, *rest)

    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(MissingExtra, match=r"whipple\[plot\]"):
        draw({"data": [], "layout": {}}, tmp_path / "x.png")


def test_draw_figures__of_another_file_says_that_it_is_no_cube(tmp_path: Path) -> None:
    (tmp_path / "cube.nc").write_text("no")
    with pytest.raises(InvalidInput, match="a cube of whipple"):
        draw_figures(tmp_path, tmp_path, "png")
