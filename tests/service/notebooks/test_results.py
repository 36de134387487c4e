"""Results in a notebook: progress as it goes, the folder of a sweep, its figures, and films of its runs."""

import base64
import re
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

import whipple
from service.cli.progress import showing_progress
from service.client.client import Client
from service.notebooks.folder import SweepFolder
from studies.films.film import Film
from studies.quantities.findings import InvalidInput
from studies.reports.publish import publish_sweep
from studies.reports.report import report_of
from tests.service.support.api import Api, sweep_of
from tests.studies.films.test_film import small_problem, states
from tests.studies.support import fakes


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> SweepFolder:
    """The folder of a sweep without runs of its own, and a film in it."""
    folder = tmp_path_factory.mktemp("sweep")
    sweep = fakes.holes()
    publish_sweep(sweep, fakes.results(sweep), folder, fakes.catalogue())
    film = Film(small_problem())
    for state in states(2):
        film.add(state)
    (folder / "runs" / "12ab").mkdir(parents=True)
    film.save(folder / "runs" / "12ab" / "film.npz")
    return SweepFolder(folder)


@pytest.mark.claim("pages", "notebook", minutes=0.2)
def test_folder__is_a_path_that_a_notebook_shows(folder: SweepFolder, tmp_path: Path) -> None:
    """The folder of a sweep is a path, and a notebook shows the headline of its report."""
    assert folder == Path(folder)
    assert "cube.nc" in {file.name for file in folder.iterdir()}
    html = folder._repr_html_()
    assert html is not None
    assert "headline" in html
    assert str(folder / "report.html") in html
    assert SweepFolder(tmp_path)._repr_html_() is None


@pytest.mark.claim("pages", "notebook", minutes=0.2)
def test_figures__are_those_of_the_report_and_are_saved(folder: SweepFolder, tmp_path: Path) -> None:
    """``plot`` and ``plot_laws`` draw the figures of the report, by their names."""
    with whipple.open_cube(folder) as cube:
        expected = [figure.name for figure in report_of(cube).head.figures]
        of_laws = cube.whipple.plot_laws("hole_diameter")
        with pytest.raises(InvalidInput, match="did you mean 'hole_diameter'"):
            cube.whipple.plot_laws("hole_diamter")
        assert cube.whipple.plot_laws().names == of_laws.names == ["hole_diameter_laws"]
    figures = folder.plot()
    assert figures.names == expected
    [first, *_] = re.findall('data:image/svg[+]xml;base64,([^"]*)', figures._repr_html_())
    assert b"<svg" in base64.b64decode(first)
    assert [file.name for file in of_laws.save(tmp_path / "figures", "svg")] == ["hole_diameter_laws.svg"]
    assert figures.drawing("hole_diameter_laws").axes


@pytest.mark.claim("pages", "notebook", minutes=0.2)
def test_film__of_a_run_is_a_moving_picture(folder: SweepFolder, tmp_path: Path) -> None:
    """The film of a run is a GIF that a notebook shows."""
    film = folder.film(field="pressure")
    assert film.gif[:6] == b"GIF89a"
    assert "data:image/gif;base64," in film._repr_html_()
    assert folder.film().gif != film.gif  # coloured by speed
    assert film.save(tmp_path / "film.gif").read_bytes() == film.gif == folder.film("12", "pressure").gif
    with pytest.raises(InvalidInput, match="keep: film"):
        folder.film("ff")


def test_progress__in_a_notebook_takes_the_place_of_the_last(
    shared_api: Api, url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[str] = []
    handle = SimpleNamespace(update=shown.append)
    display: Any = ModuleType("IPython.display")
    display.HTML, display.display = str, lambda html, display_id: handle
    ipython: Any = ModuleType("IPython")
    ipython.get_ipython = lambda: SimpleNamespace(kernel=True)
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    with Client(url) as client:
        status = client.submit(sweep_of(name="watched <b>")).status()
    with showing_progress("watched") as show:
        for progress in (0.0, 0.5):
            show(replace(status, progress=progress))
    assert ["0%" in text for text in shown] == [True, True]
    assert "50%" in shown[-1]
    assert "watched &lt;b&gt;" in shown[0]
