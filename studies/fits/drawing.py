"""The figure of a surrogate: each run predicted from the others over what was computed."""

from pathlib import Path

from studies.fits.surrogate import Surrogate
from studies.quantities.display import display_of, with_unit
from studies.quantities.files import write_atomically
from studies.quantities.findings import Finding, InvalidInput

FORMATS = ("png", "svg", "pdf")


def draw_left_out(surrogate: Surrogate, file: Path) -> Path:
    """Draw into a file, whose ending is its format; raises InvalidInput."""
    format = file.suffix.removeprefix(".").lower()
    if format not in FORMATS:
        raise InvalidInput([Finding("--plot", str(file), ", ".join(FORMATS), "end it in .png")])
    from matplotlib.figure import Figure

    runs, predicted = surrogate.runs, surrogate.left_out.predicted
    factor = display_of(runs.unit).factor
    figure = Figure(figsize=(5.0, 5.0), layout="constrained")
    axes = figure.subplots()
    x, y, bars = (factor * each for each in (runs.values, predicted.values, predicted.intervals))
    axes.plot([x.min(), x.max()], [x.min(), x.max()], color="#888888", linewidth=0.8)
    axes.errorbar(x, y, bars, fmt="o", markersize=4, capsize=2)
    label = with_unit(runs.quantity.replace("_", " "), runs.unit)
    axes.set(xlabel=f"{label}, computed", ylabel="predicted from the other runs, 95 % interval")
    return write_atomically(file, lambda part: figure.savefig(part, format=format))
