"""One figure of the study: a row for each variant, a column for each figure it is judged by."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib import pyplot

from studies.recipe_study.choice import change_of_hole, cost, failures

matplotlib.use("Agg")

SPEEDS = {"2000": ("2 km/s", "#0072b2", "o"), "6000": ("6 km/s", "#d55e00", "s")}
ROW, WIDTH = 0.24, 12.0  # inches

Figures = Mapping[str, Any]


def draw(results: Mapping[str, Figures], directory: Path) -> None:
    """``recipe.png`` in the directory."""
    names = list(results)
    columns: list[tuple[str, Callable[[Figures, str], float | None], float | None]] = [
        ("plateau pressure,\nerror / %", _shock("pressure"), 1.5),
        ("scatter of the\npressure / %", _shock("scatter"), None),
        ("shock speed,\nerror / %", _shock("shock_speed"), 1.0),
        ("hole, change from 4 to 8\ncells through the plate / %", _hole, None),
        ("cost of a hole,\ntimes linear cells", _cost(results["linear"]), None),
    ]
    figure, panels = pyplot.subplots(
        1, len(columns), sharey=True, figsize=(WIDTH, 1.2 + ROW * len(names)), layout="constrained"
    )
    for panel, (title, value, limit) in zip(panels, columns, strict=True):
        if limit is not None:
            panel.axvspan(-limit, limit, color="#e8e8e8", lw=0)
        panel.axvline(0.0, color="#8a8a8a", lw=0.8)
        for speed, (label, colour, mark) in SPEEDS.items():
            points = [(value(results[name], speed), row) for row, name in enumerate(names)]
            known = [(x, row) for x, row in points if x is not None]
            panel.plot(*zip(*known, strict=True), mark, color=colour, ms=4, label=label)
        panel.set_title(title, fontsize=9)
        panel.grid(axis="y", color="#eeeeee")
        panel.tick_params(labelsize=8)
    labels = [f"{name}  (failed)" if failures(results[name]) else name for name in names]
    panels[0].set_yticks(range(len(names)), labels, fontsize=8)
    panels[0].invert_yaxis()
    panels[-1].legend(fontsize=8, loc="lower right")
    figure.savefig(directory / "recipe.png", dpi=120)


def _shock(name: str) -> Callable[[Figures, str], float | None]:
    def percent(figures: Figures, speed: str) -> float | None:
        value = figures["shocks"][speed].get(name)
        return None if value is None else 100.0 * float(value)

    return percent


def _hole(figures: Figures, speed: str) -> float | None:
    change = change_of_hole(figures, speed)
    return None if change is None else 100.0 * change


def _cost(base: Figures) -> Callable[[Figures, str], float | None]:
    def ratio(figures: Figures, speed: str) -> float | None:
        own, one = cost(figures, speed), cost(base, speed)
        return None if own is None or one is None else own / one

    return ratio
