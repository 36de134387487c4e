"""The picture of a calibration: each pair of constants with the draws, and predicted over measured sizes."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from studies.fits.calibration.posterior import Posterior
from studies.fits.calibration.prediction import LEVEL, PredictedShots
from studies.fits.calibration.results import UNITS, values_of
from studies.quantities.files import write_atomically

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import SubFigure

DOTS = 1500  # draws that are drawn: more make one blot
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#555555")  # Okabe and Ito (2008)


def draw(posterior: Posterior, predicted: PredictedShots, file: Path) -> Path:
    """Draw into a file, whose ending is its format."""
    from matplotlib.figure import Figure

    quantities = predicted.shots.names
    figure = Figure(figsize=(15.0, 7.5), layout="constrained")
    [[left, right]] = figure.subfigures(1, 2, squeeze=False, width_ratios=(1.25, 1.0))
    _corner(left, posterior)
    axes = right.subplots(len(quantities), 1, squeeze=False)[:, 0]
    for below, quantity in zip(axes, quantities, strict=True):
        _predicted(below, predicted.of(quantity), posterior.calibration.shots.lots, quantity)
    axes[0].legend(fontsize="x-small", loc="upper left")
    format = file.suffix.removeprefix(".")
    return write_atomically(file, lambda part: figure.savefig(part, format=format, dpi=110))


def _corner(figure: "SubFigure", posterior: Posterior) -> None:
    """Histograms of the constants, and their pairs below."""
    values = {
        name: column / 1e6 if UNITS[name] == "Pa" else column
        for name, column in values_of(posterior, posterior.constants).items()
    }
    axes = figure.subplots(len(values), len(values))
    thinned = slice(None, None, max(1, len(posterior.constants) // DOTS))
    for row, (below, y) in enumerate(values.items()):
        for column, (name, x) in enumerate(values.items()):
            cell = axes[row, column]
            cell.tick_params(labelsize=7, labelbottom=row == len(values) - 1, labelleft=row > column == 0)
            if column > row:
                cell.set_axis_off()
            elif column == row:
                cell.hist(x, bins=40, color="#bbbbbb")
                for end in np.quantile(x, (0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL)):
                    cell.axvline(end, color=COLOURS[1], linewidth=0.8)
                cell.set_yticks([])
            else:
                cell.plot(x[thinned], y[thinned], ".", markersize=1.0, color=COLOURS[0], alpha=0.4)
            if row == len(values) - 1:
                cell.set_xlabel(_label(name))
            if column == 0 and row:
                cell.set_ylabel(_label(below))
    figure.suptitle(f"Draws of the posterior; lines: {100 * LEVEL:g} % of them")


def _label(name: str) -> str:
    return f"{name} (MPa)" if UNITS[name] == "Pa" else name


def _predicted(axes: "Axes", predicted: PredictedShots, lots: list[str], quantity: str) -> None:
    """Predicted over measured sizes of one quantity, relative to the initial size."""
    initial, ends = predicted.shots.initial, []
    for number, lot in enumerate(lots):
        mine = predicted.shots.series == lot
        measured, median, low, high = (
            (sizes / initial)[mine] for sizes in (predicted.measured, predicted.median, predicted.low, predicted.high)
        )
        if mine.any():
            colour = COLOURS[number % len(COLOURS)]
            bars = np.abs([median - low, high - median])
            axes.errorbar(measured, median, bars, fmt="o", markersize=3, linewidth=0.8, color=colour, label=lot)
            ends += [*measured, *median]
    axes.plot([min(ends), max(ends)], [min(ends), max(ends)], color="#888888", linewidth=0.8)
    words = quantity.replace("_", " ")
    axes.set(xlabel=f"{words} over initial size, measured", ylabel=f"predicted, {100 * LEVEL:g} %")
