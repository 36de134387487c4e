"""The folder of a sweep that was computed here, for notebooks."""

import json
import tempfile
from pathlib import Path, PosixPath
from typing import TYPE_CHECKING

from service.client.html import Animation, table
from studies.quantities.files import CUBE, FILM, REPORT_HTML, REPORT_JSON
from studies.quantities.findings import refusal

if TYPE_CHECKING:
    from studies.cubes.reading import Dataset
    from studies.reports.notebook import Figures


class SweepFolder(PosixPath):
    """The folder with the results of a sweep, a path as any other; a notebook shows what its report says."""

    def with_segments(self, *segments: "str | Path") -> Path:  # what is inside is a plain path
        return Path(*segments)

    def _repr_html_(self) -> str | None:
        report = Path(self, REPORT_JSON)
        if not report.is_file():
            return None
        document = json.loads(report.read_bytes())
        rows = [
            ("headline", document["headline"]),
            ("runs", len(document["runs"]["runs"])),
            ("report", Path(self, REPORT_HTML)),
        ]
        return table(document["title"], rows)

    def open_cube(self) -> "Dataset":
        """The cube, in memory; raises InvalidInput where there is none."""
        import studies.reports.notebook  # noqa: F401 # its figures: cube.whipple
        from studies.cubes.reading import open_cube

        return open_cube(Path(self, CUBE))

    def plot(self) -> "Figures":
        """The figures of the report."""
        return self.open_cube().whipple.plot()

    def film(self, run: str = "", field: str = "speed") -> Animation:
        """The film of a run, by default of the first one, of a sweep that kept films.

        ``run`` is the beginning of its id. Raises InvalidInput.
        """
        from studies.films.film_dataset import open_film
        from studies.reports.drawing.animation import animate

        films = sorted(Path(self).glob(f"runs/{run}*/{FILM}"))
        if not films:
            raise refusal("run", run, "a run with a film", "compute the sweep with keep: film")
        with tempfile.TemporaryDirectory() as folder:
            return Animation(animate(open_film(films[0]), Path(folder) / "film.gif", field).read_bytes())
