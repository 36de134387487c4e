"""``python -m studies.recipe_study DIRECTORY``: compute the study, choose by its rule, and draw it."""

import json
import sys
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from studies.recipe_study.choice import (
    change_of_hole,
    eligible,
    failures,
    score,
    total_cost,
    winner,
)
from studies.recipe_study.measure import measured
from studies.recipe_study.variants import variants

PROCESSES = 2
Results = dict[str, dict[str, Any]]


def main(directory: Path) -> None:
    """Compute the variants that ``results.json`` in the directory does not hold yet; print the table and the choice."""
    directory.mkdir(parents=True, exist_ok=True)
    results = compute(directory / "results.json")
    (directory / "table.md").write_text(table(results))
    print(table(results))
    print(f"chosen: {winner(results)}")
    try:
        from studies.recipe_study.figures import draw
    except ImportError:
        print("the figure needs matplotlib: pip install 'whipple[figures]'")
        return
    draw(results, directory)


def compute(file: Path) -> Results:
    """Every variant, stored one by one, so that an interrupted study goes on."""
    results: Results = json.loads(file.read_text()) if file.exists() else {}
    missing = [variant for variant in variants() if variant.name not in results]
    with ProcessPoolExecutor(PROCESSES, mp_context=get_context("spawn")) as pool:
        jobs = {variant: pool.submit(measured, variant.recipe) for variant in missing}
        for variant, job in jobs.items():
            results[variant.name] = {"group": variant.group, **job.result()}
            file.write_text(json.dumps(results, indent=1))
            print(variant.name, flush=True)
    return results


def table(results: Mapping[str, Mapping[str, Any]]) -> str:
    """The study as a table in Markdown."""
    lines = [
        "| variant | P, % at 2, 6 km/s | scatter, % | Us, % | D at 4, 8 cells, mm, 2 km/s "
        "| 6 km/s | sum of changes, % | crater p, D, mm | cost, s | eligible |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    lines += [_line(name, figures) for name, figures in results.items()]
    return "\n".join(lines) + "\n"


def _line(name: str, figures: Mapping[str, Any]) -> str:
    shocks = figures["shocks"].values()
    cells = [
        name,
        *(_percents(shocks, key) for key in ("pressure", "scatter", "shock_speed")),
        *(_millimetres(holes.values(), "hole_diameter") for holes in figures["holes"].values()),
        f"{100.0 * score(figures):.1f}" if change_of_hole(figures, "2000") is not None else "-",
        _millimetres([figures["crater"]], "crater_depth")
        + " "
        + _millimetres([figures["crater"]], "crater_diameter"),
        f"{total_cost(figures):.0f}",
        "yes" if eligible(figures) else "; ".join(sorted(set(failures(figures)))) or "no: shock",
    ]
    return "| " + " | ".join(cells) + " |"


def _percents(shocks: Any, key: str) -> str:
    return " ".join(f"{100.0 * one[key]:+.2f}" if key in one else "-" for one in shocks)


def _millimetres(runs: Any, key: str) -> str:
    return " ".join(f"{1e3 * one[key]:.2f}" if one.get(key) is not None else "-" for one in runs)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
