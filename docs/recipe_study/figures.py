"""Figures of the study: variants by what they are judged by, candidates by their holes against the cell."""

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib import pyplot

from docs.recipe_study.choice import change_of_hole, cost, eligible
from studies.cases.verification.plate_impact import PRESSURE, SHOCK_SPEED

matplotlib.use("Agg")

SPEEDS = {"2000": ("2 km/s", "#0072b2", "o"), "6000": ("6 km/s", "#d55e00", "s")}
APART = 0.3  # of a row, between the marks of the two speeds
ROW, WIDTH = 0.24, 12.0  # inches
WIDEST = 3.0  # axis of an error, in limits of its gate; what lies beyond is an arrow at the edge
CELLS_THROUGH = 4.0  # cells across the sphere for each cell through the plate of a quarter diameter

Figures = Mapping[str, Any]


def draw(results: Mapping[str, Figures], file: Path) -> None:
    """A row for each variant, a column for each figure."""
    names = list(results)
    columns: list[tuple[str, Callable[[Figures, str], float | None], float | None]] = [
        ("pressure behind the\nshock, error / %", _shock("pressure"), 100.0 * PRESSURE["gimp"]),
        ("its scatter / %", _shock("scatter"), None),
        ("shock speed,\nerror / %", _shock("shock_speed"), 100.0 * SHOCK_SPEED),
        ("hole, change from 4 to 8\ncells through the plate / %", _hole, None),
        ("cost of a hole,\ntimes linear cells", _cost(results["linear"]), None),
    ]
    figure, panels = pyplot.subplots(
        1, len(columns), sharey=True, figsize=(WIDTH, 1.4 + ROW * len(names)), layout="constrained"
    )
    for panel, (title, value, limit) in zip(panels, columns, strict=True):
        if limit is not None:
            panel.axvspan(-limit, limit, color="#e8e8e8", lw=0)
            panel.set_xlim(-WIDEST * limit, WIDEST * limit)
        panel.axvline(0.0, color="#8a8a8a", lw=0.8)
        for place, (speed, (label, colour, mark)) in enumerate(SPEEDS.items()):
            rows = [row + APART * (place - 0.5) for row in range(len(names))]
            points = [(value(results[name], speed), row) for row, name in zip(rows, names, strict=True)]
            end = math.inf if limit is None else WIDEST * limit
            for x, row in points:
                if x is not None:
                    beyond = {-1: "<", 0: mark, 1: ">"}[(x > end) - (x < -end)]
                    panel.plot(min(max(x, -end), end), row, beyond, color=colour, ms=4, clip_on=False)
            panel.plot([], [], mark, color=colour, ms=4, label=label)
        panel.set_title(title, fontsize=9)
        panel.grid(axis="y", color="#eeeeee")
        panel.tick_params(labelsize=8)
    labels = [f"{name}{'' if eligible(results[name]) else '  (out)'}" for name in names]
    panels[0].set_yticks(range(len(names)), labels, fontsize=8)
    panels[0].set_ylim(len(names) - 0.5, -0.5)
    figure.legend(*panels[0].get_legend_handles_labels(), fontsize=8, loc="upper left")
    figure.savefig(file, dpi=120)


def draw_finals(finals: Mapping[str, Figures], file: Path) -> None:
    """A panel for each speed: holes against cells through the plate, a mark for each position, a line for the mean."""
    speeds = list(next(iter(finals.values()))["holes"])
    figure, panels = pyplot.subplots(1, len(speeds), figsize=(WIDTH, 4.0), layout="constrained", squeeze=False)
    for panel, speed in zip(panels[0], speeds, strict=True):
        for (name, final), (_, colour, mark) in zip(finals.items(), SPEEDS.values(), strict=False):
            grids = final["holes"][speed]
            through = [int(cells) / CELLS_THROUGH for cells in grids]
            for cells, values in zip(through, grids.values(), strict=True):
                panel.plot([cells] * len(values), [1e3 * v for v in values], mark, color=colour, ms=4)
            means = [1e3 * sum(values) / len(values) for values in grids.values()]
            panel.plot(through, means, color=colour, label=name)
        panel.set_xscale("log", base=2)
        panel.set_xticks(through, [f"{cells:g}" for cells in through])
        panel.set_xlabel("cells through the plate")
        panel.set_title(f"{float(speed) / 1e3:g} km/s", fontsize=10)
        panel.grid(color="#eeeeee")
    panels[0][0].set_ylabel("hole diameter / mm")
    panels[0][0].legend(fontsize=8)
    figure.savefig(file, dpi=120)


def _shock(name: str) -> Callable[[Figures, str], float | None]:
    def percent(figures: Figures, speed: str) -> float | None:
        both = figures["shocks"][f"Cu on Cu, {speed}"].get(name)
        return None if both is None else 100.0 * float(sum(both)) / len(both)

    return percent


def _hole(figures: Figures, speed: str) -> float | None:
    change = change_of_hole(figures, speed)
    return None if change is None else 100.0 * change


def _cost(base: Figures) -> Callable[[Figures, str], float | None]:
    def ratio(figures: Figures, speed: str) -> float | None:
        if change_of_hole(figures, speed) is None:  # a run that failed cost little
            return None
        own, one = cost(figures, speed), cost(base, speed)
        return None if own is None or one is None else own / one

    return ratio
