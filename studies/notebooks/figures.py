"""The figures of a report in a notebook, which shows them with their captions.

Importing the module adds ``cube.whipple`` to every dataset of xarray; Matplotlib is loaded when something is drawn.
"""

import base64
import io
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

from studies.quantities.findings import nearest_cure, refusal
from studies.reports.figure import Figure
from studies.reports.report import report_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

OF_LAWS = "_laws"  # in the name of a figure that shows laws


@dataclass(frozen=True)
class Figures:
    """Figures of a report; a notebook shows them, each with its caption."""

    figures: tuple[Figure, ...]

    def _repr_html_(self) -> str:
        return "".join(
            f'<figure><img src="data:image/svg+xml;base64,{_svg(figure)}" alt="{escape(figure.title)}" '
            f'style="background: white; max-width: 100%"><figcaption>{escape(figure.caption)}</figcaption></figure>'
            for figure in self.figures
        )

    @property
    def names(self) -> list[str]:
        """Names of the figures."""
        return [figure.name for figure in self.figures]

    def drawing(self, name: str = "") -> "Drawing":
        """A figure as one of Matplotlib, by default the first; raises InvalidInput for an unknown name."""
        from studies.reports.drawing.canvas import drawn_in_style
        from studies.reports.drawing.charts import chart

        with drawn_in_style():
            return chart(self.figures[self.names.index(_known(name, self.names)) if name else 0])

    def save(self, folder: str | Path, format: str = "png") -> list[Path]:
        """Write each figure into a folder, as png, svg or pdf."""
        from studies.reports.drawing.charts import draw

        Path(folder).mkdir(parents=True, exist_ok=True)
        return [draw(figure, Path(folder) / f"{figure.name}.{format}") for figure in self.figures]


@xr.register_dataset_accessor("whipple")
class CubeFigures:
    """What is drawn of a cube, as in its report."""

    def __init__(self, cube: xr.Dataset):
        self._cube = cube

    def plot(self) -> Figures:
        """Every figure of the report."""
        return Figures(report_of(self._cube).head.figures)

    def plot_laws(self, quantity: str = "") -> Figures:
        """Simulation, laws and observations: of every main quantity, or of one. Raises InvalidInput."""
        every = ((figure, figure.name.partition(OF_LAWS)) for figure in self.plot().figures)
        drawn = [(name, figure) for figure, (name, word, _) in every if word]
        wanted = _known(quantity, [name for name, _ in drawn]) if quantity else ""
        return Figures(tuple(figure for name, figure in drawn if wanted in ("", name)))


def _svg(figure: Figure) -> str:
    from studies.reports.drawing.canvas import as_file, drawn_in_style
    from studies.reports.drawing.charts import chart

    file = io.BytesIO()
    with drawn_in_style():
        as_file(chart(figure), file, "svg")
    return base64.b64encode(file.getvalue()).decode()


def _known(name: str, names: Iterable[str]) -> str:
    """The name, if it is one of these; raises InvalidInput with the nearest one."""
    known = list(dict.fromkeys(names))
    if name not in known:
        limit = ", ".join(known) or "none: this cube has no such figure"
        raise refusal("figure", name, limit, nearest_cure(name, known))
    return name
