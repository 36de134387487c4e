"""The figures of a report in a notebook, which shows them with their captions."""

import base64
import io
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import xarray as xr

from studies.quantities.findings import nearest_cure, refusal
from studies.reports import compare, report
from studies.reports.drawing.canvas import as_file, drawn_in_style
from studies.reports.drawing.charts import chart, draw
from studies.reports.figures import Figure

OF_LAWS = ("_laws", "_residuals_map")  # in the name of a figure that shows laws, over one axis and over two


@dataclass(frozen=True)
class Figures:
    """Figures of a report; a notebook shows them, each with its caption."""

    figures: tuple[Figure, ...]

    def _repr_html_(self) -> str:
        return "".join(
            f'<figure><img src="data:image/svg+xml;base64,{_svg(each)}" alt="{escape(each.title)}" '
            f'style="background: white; max-width: 100%"><figcaption>{escape(each.caption)}</figcaption></figure>'
            for each in self.figures
        )

    @property
    def names(self) -> list[str]:
        """Names of the figures."""
        return [each.name for each in self.figures]

    def drawing(self, name: str = "") -> Any:
        """A figure as one of Matplotlib, by default the first; raises InvalidInput for an unknown name."""
        with drawn_in_style():
            return chart(self.figures[self.names.index(_known(name, self.names)) if name else 0])

    def save(self, folder: str | Path, format: str = "png") -> list[Path]:
        """Write each figure into a folder, as png, svg or pdf."""
        Path(folder).mkdir(parents=True, exist_ok=True)
        return [draw(each, Path(folder) / f"{each.name}.{format}") for each in self.figures]


def figures_of(cube: xr.Dataset) -> Figures:
    """Every figure of the report of a cube."""
    return Figures(tuple(report.every_figure(cube, compare.compare(cube))))


def figures_of_laws(cube: xr.Dataset, quantity: str) -> Figures:
    """Those that show laws, of every quantity if none is named; raises InvalidInput."""
    every = ((each, each.name.partition(word)) for each in figures_of(cube).figures for word in OF_LAWS)
    drawn = [(name, each) for each, (name, word, _) in every if word]
    wanted = _known(quantity, [name for name, _ in drawn]) if quantity else ""
    return Figures(tuple(each for name, each in drawn if wanted in ("", name)))


def _svg(figure: Figure) -> str:
    file = io.BytesIO()
    with drawn_in_style():
        as_file(chart(figure), file, "svg")
    return base64.b64encode(file.getvalue()).decode()


def _known(name: str, names: Iterable[str]) -> str:
    """The name, if it is one of these; raises InvalidInput with the nearest one."""
    known = list(dict.fromkeys(names))
    if name not in known:
        raise refusal("figure", name, ", ".join(known) or "none: this cube has no such figure", nearest_cure(name, known))
    return name
