"""Maps: a quantity over two axes as colours, with a bar that says what they mean."""

import math
from collections.abc import Sequence
from textwrap import wrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure as Drawing

from studies.quantities.display import with_unit
from studies.reports.drawing.canvas import canvas, number
from studies.reports.drawing.marks import scaled
from studies.reports.figure import Figure, Panel

# points
LEFT, RIGHT, ABOVE, BELOW, GAP = 50.0, 76.0, 20.0, 42.0, 14.0
BAR_GAP, BAR = 10.0, 12.0
LETTER = 5.6  # width of a letter of the label beside the bar
PANEL_WIDTH, FLATNESS = 150.0, 0.75  # least width of a panel; its height in its width
MARK = 9.0  # area of a point where the points fill no grid
VALUES, DIFFERENCES = "viridis", "RdBu_r"  # colours; differences have white at zero


def map_chart(figure: Figure, width: float, panels: Sequence[Panel]) -> Drawing:
    """The drawing of some panels of a map, with a width in points."""
    assert figure.z is not None
    inside = width - LEFT - RIGHT
    columns = min(len(panels), max(1, int(inside // PANEL_WIDTH)), 3)
    rows = math.ceil(len(panels) / columns)
    part = (inside - GAP * (columns - 1)) / columns
    tall = min(FLATNESS * part, 260.0)
    height = rows * (ABOVE + tall + BELOW)
    drawing = canvas(width, height)
    every = np.concatenate([scaled(series.z, figure.z) for panel in figure.panels for series in panel.series])
    low, high = (float(end) for end in (np.nanmin(every), np.nanmax(every)))
    is_signed = figure.z.name == "residual"
    reach = max(-low, high)
    colours = DIFFERENCES if is_signed else VALUES
    norm = Normalize(-reach, reach) if is_signed else Normalize(low, high)
    for place, panel in enumerate(panels):
        row, column = divmod(place, columns)
        bottom = height - (row + 1) * (ABOVE + tall + BELOW) + BELOW
        left = LEFT + column * (part + GAP)
        axes = drawing.add_axes((left / width, bottom / height, part / width, tall / height))
        for series in panel.series:
            x, y, z = (scaled(getattr(series, name), getattr(figure, name)) for name in ("x", "y", "z"))
            _colour(axes, x, y, z, norm, colours)
        axes.set_title(panel.title)
        axes.grid(visible=False)
        axes.xaxis.set_major_formatter(number)
        axes.yaxis.set_major_formatter(number)
        axes.locator_params(nbins=5)
        axes.set_xlabel(with_unit(figure.x.label, figure.x.unit))
        axes.tick_params(axis="y", labelleft=column == 0)
        if column == 0:
            axes.set_ylabel(with_unit(figure.y.label, figure.y.unit))
    bar = drawing.add_axes(
        ((width - RIGHT + BAR_GAP) / width, BELOW / height, BAR / width, (height - ABOVE - BELOW) / height)
    )
    drawing.colorbar(ScalarMappable(norm, colours), cax=bar, format=_percent if is_signed else number)
    label = with_unit(figure.z.label, None if is_signed else figure.z.unit)
    bar.set_ylabel("\n".join(wrap(label, int((height - ABOVE - BELOW) / LETTER))))
    return drawing


def _colour(axes: Axes, x: np.ndarray, y: np.ndarray, z: np.ndarray, norm: Normalize, colours: str) -> None:
    """Cells where the points fill a grid, else marks; as pixels, which are smaller than so many marks."""
    columns, rows = np.unique(x), np.unique(y)
    if len(columns) * len(rows) != len(z):
        axes.scatter(x, y, c=z, s=MARK, linewidths=0.0, cmap=colours, norm=norm, rasterized=True)
        return
    grid = np.full((len(rows), len(columns)), np.nan)
    grid[np.searchsorted(rows, y), np.searchsorted(columns, x)] = z
    axes.pcolormesh(columns, rows, grid, shading="nearest", cmap=colours, norm=norm, rasterized=True)


def _percent(value: float, _: float | None = None) -> str:
    return f"{number(100.0 * value)}\u202f%"
