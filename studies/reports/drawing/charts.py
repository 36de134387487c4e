"""A figure as a drawing: its panels side by side or in rows, and the legend below them."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from textwrap import wrap

from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawing
from matplotlib.legend import Legend

from studies.quantities.files import write_atomically
from studies.reports.drawing.canvas import as_file, as_svg, canvas, drawn_in_style
from studies.reports.drawing.layout import LEFT, WIDTHS, Grid, prepare
from studies.reports.drawing.maps import map_chart
from studies.reports.drawing.marks import Marks
from studies.reports.drawing.styles import styles_of
from studies.reports.figure import Figure, Panel, Scale, Series

PANELS = 6  # in one drawing of a page, so that it fits a sheet of A4
# The drawings with which a page opens, in the widths of its two columns and of a telephone, and their panels.
OPENING = {"wide": (520.0, 2), "narrow": (WIDTHS["narrow"], 1)}
SMALL = (126.0, 84.0)  # a thumbnail
OF_LINES = 360.0  # width of a drawing of lines alone
MOST_LETTERS = 44  # in a line of the legend: as many as fit a telephone
LEGEND_COLUMNS = 3  # at most


def chart(figure: Figure, width: float = WIDTHS["wide"], panels: Sequence[Panel] | None = None) -> Drawing:
    """The drawing of a figure, with a width in points.

    ``panels`` are those to draw where one drawing does not hold the whole figure; axes are those of the figure.
    """
    panels = figure.panels if panels is None else panels
    if figure.z is not None:
        return map_chart(figure, width, panels)
    marks = Marks(figure, styles_of(figure))
    grid = Grid(figure, panels, width)
    drawing = canvas(width, grid.height)
    for number, panel in enumerate(panels):
        axes = drawing.add_axes((0.0, 0.0, 1.0, 1.0))
        _fill(axes, figure, panel, marks, has_label=number % grid.columns == 0)
        grid.title(axes, number)
    grid.place(drawing, _legend(drawing, marks, width))
    return drawing


def draw_panel(axes: Axes, figure: Figure, panel: Panel) -> None:
    """Draw one panel of a figure into axes of somebody else, with title and legend."""
    marks = Marks(figure, styles_of(figure))
    _fill(axes, figure, panel, marks, has_label=True)
    axes.set_title(panel.title or figure.title, wrap=True)
    labels = sorted(marks.entries, key=lambda label: marks.styles[label].rank)
    axes.legend([marks.entries[label] for label in labels], labels, fontsize="x-small")


def _fill(axes: Axes, figure: Figure, panel: Panel, marks: Marks, *, has_label: bool) -> None:
    prepare(axes, figure, panel, marks.words, has_label)
    for series in panel.series:
        marks.draw(axes, series)
    marks.name_laws(axes, panel.series)


def _legend(drawing: Drawing, marks: Marks, width: float) -> Legend:
    """One entry for each label, in as many columns as there is room for."""
    labels = sorted(marks.entries, key=lambda label: marks.styles[label].rank)
    handles = [marks.entries[label] for label in labels]
    texts = ["\n".join(wrap(label, MOST_LETTERS)) for label in labels]
    for columns in range(LEGEND_COLUMNS, 0, -1):
        legend = drawing.legend(handles, texts, loc="lower left", ncols=columns)
        if columns == 1 or legend.get_window_extent().width <= width - LEFT:
            return legend
        legend.remove()
    raise AssertionError("one column always fits")


def of_page(figure: Figure, name: str) -> Markup:
    """The drawings of a figure of a page, in each of its widths, in pieces that fit a sheet of A4."""
    pieces = [figure.panels[first : first + PANELS] for first in range(0, len(figure.panels), PANELS)]
    with drawn_in_style():
        return Markup("").join(
            as_svg(chart(figure, width, panels), f"chart {kind}", figure.title, f"{name}-{number}-{kind}")
            for number, panels in enumerate(pieces)
            for kind, width in WIDTHS.items()
        )


def opening(figure: Figure) -> Markup:
    """The drawings with which a page opens: the first panels alone, as many as stand side by side."""
    with drawn_in_style():
        return Markup("").join(
            as_svg(chart(figure, width, figure.panels[:count]), f"chart {kind}", figure.title, f"opening-{kind}")
            for kind, (width, count) in OPENING.items()
        )


def thumbnail(figure: Figure) -> Markup:
    """A drawing without words of the first panel, for lists."""
    size = (0.0, 0.0, 1.0, 1.0)
    with drawn_in_style():
        drawing = map_chart(figure, OPENING["wide"][0], figure.panels[:1]) if figure.z else canvas(*SMALL)
        if figure.z is None:
            panel = figure.panels[0]
            marks, axes = Marks(figure, styles_of(figure)), drawing.add_axes(size)
            prepare(axes, figure, panel, marks.words, has_label=False)
            for series in panel.series:
                marks.draw(axes, replace(series, doubts=(), notes=(), outer=()))
        else:
            drawing.set_size_inches(SMALL[0] / 72.0, SMALL[1] / 72.0)
            axes, bar = drawing.axes
            axes.set(position=size, title="")
            bar.remove()
        axes.set(xlabel="", ylabel="", xticks=[], yticks=[])
        return Markup(re.sub("<title>.*?</title>", "", as_svg(drawing, "chart", figure.title, "thumbnail")))


def lines(title: str, x: Scale, y: Scale, series: Sequence[Series]) -> Markup:
    """Lines over one abscissa."""
    figure = Figure("lines", title, "", x, y, (Panel(title, {}, tuple(series)),))
    with drawn_in_style():
        return as_svg(chart(figure, OF_LINES), "chart", title, figure.name)


def draw(figure: Figure, file: Path) -> Path:
    """Draw a figure into a file, whose ending is its format."""
    with drawn_in_style():
        drawing = chart(figure)
        return write_atomically(file, lambda part: as_file(drawing, part, file.suffix.removeprefix(".")))
