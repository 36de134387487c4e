"""``python -m docs.recipe_study.particles FILE``: what two particles along each direction change against three.

The recipe ``whipple`` with either number: the Taylor bar, holes in copper plates of a quarter of the sphere's diameter,
and craters of the thesis, each over several grids and, for impacts, three sub-cell positions. FILE
keeps the figures as JSON; the tables of docs/recipe.md are printed. The part of the uncertainty that runs with two
particles state (``OF_FEW_PARTICLES`` in ``studies.scenarios.parts.impact``) is, by quantity, the root mean square
difference over all runs of 16 cells, and over all of finer grids, rounded up to a tenth of a per cent.
"""

import json
import math
import sys
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from typing import Any

from docs.pages import table
from docs.recipe_study.measure import OFFSETS, Figures, computed, hole, taylor
from studies.quantities.numerical_defaults import RECIPES, Recipe

PROCESSES = 2
COUNTS = (2, 3)
SPEEDS = (4e3, 6e3)  # m/s
CELLS = {"hole": (16, 24, 32), "crater": (16, 24)}  # across the projectile's diameter
# Ma (2005), section 3.2.2, in a smaller block: it compares particles, it does not predict.
CRATER = {
    **dict.fromkeys(("projectile", "target"), "copper-thesis-plastic"),
    **{"projectile_shape": "cylinder", "projectile_diameter": "5 mm", "projectile_length": "4 mm"},
    **{"geometry": "axisymmetric", "edges": "absorbing", "target_depth": "30 mm", "target_radius": "25 mm"},
}
OF_HOLES = ("hole_diameter", "hole_diameter_areal")
OF_CRATERS = ("crater_depth", "crater_diameter")
COMPANIONS = ("hole_diameter_midplane", "crater_depth_over_diameter")  # in no table


def main(file: Path) -> None:
    """Compute what the file does not hold yet, and print the tables."""
    figures: dict[str, Figures] = json.loads(file.read_text()) if file.exists() else {}
    with ProcessPoolExecutor(PROCESSES, mp_context=get_context("spawn")) as pool:
        jobs = {name: pool.submit(*call) for name, call in _calls().items() if name not in figures}
        names = {job: name for name, job in jobs.items()}
        for job in as_completed(names):
            name = names[job]
            figures[name] = job.result()
            file.write_text(json.dumps(figures, indent=1))
            print(name, file=sys.stderr, flush=True)
    print(tables(figures))


def tables(figures: Mapping[str, Figures]) -> str:
    """The figures as three tables in Markdown."""
    bars, values, changed = [], [], []
    for count in COUNTS:
        bar = figures[_name("taylor", count)]
        from_grid_to_grid = ", ".join(_percent(change) for change in bar["changes"])
        errors = ", ".join(_percent(bar[name]) for name in ("mean_error", "finest_error"))
        bars.append([f"{count} particles", from_grid_to_grid, errors])
    for quantity in (*OF_HOLES, *OF_CRATERS):
        for speed, cells in product(SPEEDS, CELLS[_problem(quantity)]):
            pairs, seconds = _pairs(figures, quantity, speed, cells)
            both = (_mean_and_range([pair[place] for pair in pairs]) for place in (0, 1))
            changes = [few / many - 1.0 for few, many in pairs]
            change = f"{100.0 * sum(changes) / len(changes):+.1f}, {100.0 * _rms(changes):.1f} %"
            where = f"{quantity.replace('_', ' ')}, {speed / 1e3:g} km/s"
            values.append([where, str(cells), *both, change, f"{seconds[1] / seconds[0]:.1f}"])
    for quantity in (*OF_HOLES, *OF_CRATERS, *COMPANIONS):
        changed.append([quantity.replace("_", " "), *map(_percent, parts(figures, quantity))])
    header = (
        "value | cells per diameter | 2 particles, mm | 3 particles, mm | difference: mean, root mean square "
        "| processor time, 3 over 2"
    )
    of_bars = ["Taylor bar", "change from 10 to 20, 20 to 40 cells", "from the experiment at 10, at 40 cells"]
    of_changes = ["root mean square difference", "16 cells", "finer"]
    return "\n".join([table(of_bars, bars), table(header.split(" | "), values), table(of_changes, changed)])


def parts(figures: Mapping[str, Figures], quantity: str) -> tuple[float, float]:
    """Root mean square difference of a quantity on 16 cells and on finer grids, over speeds and offsets."""
    first, *finer = CELLS[_problem(quantity)]
    coarse, fine = (
        _rms(
            [
                few / many - 1.0
                for speed, cells in product(SPEEDS, grids)
                for few, many in _pairs(figures, quantity, speed, cells)[0]
            ]
        )
        for grids in ([first], finer)
    )
    return coarse, fine


def crater(recipe: Recipe, speed: float, cells: int, offset: float) -> Figures:
    """A crater of the thesis."""
    return computed("thick_plate", recipe, speed, cells, {**CRATER, "offset": offset})


def _calls() -> dict[str, tuple[Any, ...]]:
    """Every computation of the study by its name: the function and its arguments."""
    recipes = {count: replace(RECIPES["whipple"], particles_per_cell=count) for count in COUNTS}
    calls: dict[str, tuple[Any, ...]] = {_name("taylor", count): (taylor, recipe) for count, recipe in recipes.items()}
    for problem in (hole, crater):
        kind = problem.__name__
        for cells, speed, offset, count in product(CELLS[kind], SPEEDS, OFFSETS, COUNTS):
            call = (problem, recipes[count], speed, cells, offset)
            calls[_name(kind, count, speed, cells, offset)] = call
    return calls


def _problem(quantity: str) -> str:
    """The name of the problem on which a quantity is measured."""
    return quantity.partition("_")[0]


def _pairs(
    figures: Mapping[str, Figures], quantity: str, speed: float, cells: int
) -> tuple[list[tuple[float, float]], tuple[float, float]]:
    """Values with two and with three particles at each offset, and the median processor seconds of both."""
    problem = _problem(quantity)
    runs = [[figures[_name(problem, count, speed, cells, offset)] for count in COUNTS] for offset in OFFSETS]
    few, many = (median(run[place]["seconds"] for run in runs) for place in (0, 1))
    return [(run[0][quantity], run[1][quantity]) for run in runs], (few, many)


def _name(problem: str, *of: float) -> str:
    return " ".join([problem, *(f"{value:.4g}" for value in of)])


def _percent(share: float) -> str:
    return f"{100.0 * share:.2f} %"


def _mean_and_range(values: list[float]) -> str:
    middle, half = sum(values) / len(values), 0.5 * (max(values) - min(values))
    return f"{1e3 * middle:.2f} ± {1e3 * half:.2f}"


def _rms(values: list[float]) -> float:
    return math.sqrt(sum(value**2 for value in values) / len(values))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
