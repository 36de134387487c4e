"""Results in a notebook: progress as it goes, the folder of a sweep, its figures, and films of its runs."""

import base64
import re
from pathlib import Path

import pytest
from matplotlib.figure import Figure as Drawing

import whipple
from service.notebooks.folder import SweepFolder
from studies.cubes.groups import as_tree
from studies.cubes.opening import open_file, whole_cube
from studies.films.film import Film
from studies.quantities.findings import InvalidInput
from studies.reports.publish import publish_sweep
from studies.reports.report import report_of
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
    assert re.search(f"<th[^>]*>runs</th><td[^>]*>{len(fakes.holes().runs())}</td>", html)
    assert str(folder / "report.html") in html
    assert SweepFolder(tmp_path)._repr_html_() is None


@pytest.mark.claim("pages", "notebook", minutes=0.2)
def test_figures__are_those_of_the_report(folder: SweepFolder) -> None:
    """``plot`` draws the figures of the report, by their names, and ``plot_laws`` a panel on Matplotlib's axes."""
    expected = [figure.name for figure in report_of(whole_cube(folder)).head.figures]
    with whipple.open_cube(folder) as cube:
        axes = Drawing().subplots()
        assert cube.whipple.plot_laws(ax=axes) is axes
        assert axes.get_ylabel() == "hole diameter (mm)"
        assert "simulation" in [text.get_text() for text in axes.get_legend().get_texts()]
        with pytest.raises(InvalidInput, match="did you mean 'hole_diameter'"):
            cube.whipple.plot_laws("hole_diamter")
    figures = folder.plot()
    assert figures.names == expected
    [first, *_] = re.findall('data:image/svg[+]xml;base64,([^"]*)', figures._repr_html_())
    assert b"<svg" in base64.b64decode(first)


def test_cube__is_selected_by_values_with_units_and_its_table_has_words(folder: SweepFolder) -> None:
    with whipple.open_cube(folder) as cube:
        part = cube.whipple.sel(speed=["3 km/s", 4e3], plate_thickness="2 mm")
        assert dict(part["laws"].hole_diameter_by_law.sizes) == {"speed": 2, "hole_diameter_law": 7}
        assert part.whipple.sel(speed=slice("3.5 km/s", "9 km/s")).speed.values.tolist() == [4e3]
        assert part.whipple.sel(speed=slice("3.5 km/s", None)).speed.values.tolist() == [4e3]
        with pytest.raises(InvalidInput, match="2 km/s, 3 km/s"):
            cube.whipple.sel(speed="3.5 km/s")
        with pytest.raises(InvalidInput, match="did you mean 'plate_thickness'"):
            cube.whipple.sel(plate_thicknes="2 mm")
        table = cube.whipple.to_dataframe()
        assert table.index.names == ["speed", "plate_thickness"]
        assert "equivalent_diameter" not in table
    trouble = as_tree(fakes.cube_of(fakes.holes(), fakes.with_trouble(fakes.holes()))).whipple.to_dataframe()
    assert trouble.run_state.tolist()[:3] == ["failed", "cancelled", "succeeded"]
    assert trouble.hole_diameter_flags.tolist()[3] == "not_perforated"


@pytest.mark.parametrize("is_remote", [False, True])
def test_open_cube__refuses_one_of_another_layout(is_remote: bool, folder: SweepFolder, tmp_path: Path) -> None:
    older = tmp_path / "cube.nc"
    whole_cube(folder).to_netcdf(older)
    with pytest.raises(InvalidInput, match=r"all variables in one group.*: compute its sweep again"):
        open_file(older.open("rb"), "http://127.0.0.1/cube.nc") if is_remote else whipple.open_cube(tmp_path)


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
