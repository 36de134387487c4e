"""``python -m docs.recipe_study DIRECTORY``: compute the study, choose by its rule, and draw it."""

import json
import sys
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from docs.pages import table
from docs.recipe_study.choice import (
    candidates,
    change_of_hole,
    converges,
    failures,
    final_changes,
    margins,
    mean_holes,
    missed,
    scatter,
    total_cost,
    winner,
)
from docs.recipe_study.measure import FINAL_CELLS, FINAL_SPEEDS, OFFSETS, final_hole, known, measured
from docs.recipe_study.variants import Variant, scan, variants
from studies.quantities.numerical_defaults import Recipe

PROCESSES = 2
Results = dict[str, dict[str, Any]]


def main(directory: Path) -> None:
    """Compute what the directory does not hold yet; print the tables and the choice."""
    directory.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(PROCESSES, mp_context=get_context("spawn")) as pool:
        scanned = compute(directory / "scan.json", pool, scan(), known)
        finals = compute_finals(directory / "candidates.json", pool, scanned)
        results = compute(directory / "results.json", pool, variants(), measured)
    text = "\n".join((variant_table(results), scan_table(scanned), final_table(finals)))
    (directory / "tables.md").write_text(text)
    print(text)
    print(f"chosen: {winner(scanned, finals)}")
    from docs.recipe_study.figures import draw, draw_finals

    draw(results, directory / "variants.png")
    draw_finals(finals, directory / "candidates.png")


def compute(
    file: Path, pool: ProcessPoolExecutor, asked: Iterable[Variant], measure: Callable[[Recipe], dict[str, Any]]
) -> Results:
    """Every variant, stored one by one, so that an interrupted study goes on."""
    results: Results = json.loads(file.read_text()) if file.exists() else {}
    missing = [variant for variant in asked if variant.name not in results]
    jobs = {variant: pool.submit(measure, variant.recipe) for variant in missing}
    for variant, job in jobs.items():
        results[variant.name] = {"group": variant.group, **job.result()}
        file.write_text(json.dumps(results, indent=1))
        print(variant.name, flush=True)
    return results


def compute_finals(file: Path, pool: ProcessPoolExecutor, scanned: Results) -> Results:
    """Holes of the candidates over grids and sub-cell positions, up to the first candidate that converges."""
    finals: Results = json.loads(file.read_text()) if file.exists() else {}
    for name in candidates(scanned):
        if any(converges(one["holes"]) for one in finals.values()):
            break
        if name in finals:
            continue
        recipe = Recipe(**scanned[name]["recipe"])
        jobs = {
            (speed, cells, offset): pool.submit(final_hole, recipe, speed, cells, offset)
            for cells in reversed(FINAL_CELLS)
            for speed in FINAL_SPEEDS
            for offset in OFFSETS
        }
        holes = {
            f"{speed:g}": {
                str(cells): [jobs[speed, cells, offset].result()[0] for offset in OFFSETS] for cells in FINAL_CELLS
            }
            for speed in FINAL_SPEEDS
        }
        finals[name] = {"holes": holes, "seconds": sum(job.result()[1] for job in jobs.values())}
        file.write_text(json.dumps(finals, indent=1))
        print(f"candidate {name}", flush=True)
    return finals


def variant_table(results: Mapping[str, Mapping[str, Any]]) -> str:
    """The variants as a table in Markdown."""
    header = (
        "variant | worst error, %: P | Us | particle density | from spacing | scatter, % | bar: time, % | rebound "
        "| Taylor bar: changes, from experiment, % | D at 4, 8 cells, mm: 2 km/s | 6 km/s | crater p, D, mm | cost, s "
        "| eligible"
    )
    return table(header.split(" | "), [_row(name, figures) for name, figures in results.items()])


def _row(name: str, figures: Mapping[str, Any]) -> list[str]:
    bar, taylor = figures["bar"], figures["taylor"]
    verdict = "; ".join([*sorted(set(failures(figures))), *missed(figures)])
    return [
        name,
        *(_worst(figures, quantity) for quantity in ("pressure", "shock_speed", "particle_density", "spacing_density")),
        f"{100.0 * scatter(figures):.1f}",
        f"{100.0 * bar['time']:+.1f}" if "time" in bar else "-",
        f"{bar['rebound']:.3f}" if "rebound" in bar else "-",
        _taylor(taylor),
        *(_millimetres(holes.values(), "hole_diameter") for holes in figures["holes"].values()),
        _millimetres([figures["crater"]], "crater_depth") + " " + _millimetres([figures["crater"]], "crater_diameter"),
        f"{total_cost(figures):.0f}" if change_of_hole(figures, "2000") is not None else "-",
        f"no: {verdict}" if verdict else "yes",
    ]


def scan_table(scanned: Mapping[str, Mapping[str, Any]]) -> str:
    """The viscosities as a table in Markdown: the smallest margin, and the gate that it is of."""
    rows = []
    for name, figures in scanned.items():
        gate, least = min(margins(figures).items(), key=lambda one: one[1])
        rows.append([name, f"{least:+.2f}", gate, f"{100.0 * scatter(figures):.1f}", _taylor(figures["taylor"])])
    return table(["viscosity", "smallest margin", "of", "scatter, %", "Taylor bar: changes, from experiment, %"], rows)


def _taylor(figures: Mapping[str, Any]) -> str:
    """Changes from grid to grid, and the differences from the experiment on the coarsest and on the finest."""
    if "changes" not in figures:
        return "-"
    changes, errors = (
        ", ".join(f"{100.0 * value:.2f}" for value in values)
        for values in (figures["changes"], (figures["mean_error"], figures["finest_error"]))
    )
    return f"{changes}; {errors}"


def _worst(figures: Mapping[str, Any], quantity: str) -> str:
    errors = [error for one in figures["shocks"].values() for error in one.get(quantity, [])]
    return f"{100.0 * max(errors, key=abs):+.2f}" if errors else "-"


def _millimetres(runs: Iterable[Mapping[str, Any]], key: str) -> str:
    return " ".join(f"{1e3 * one[key]:.2f}" if one.get(key) is not None else "-" for one in runs)


def final_table(finals: Mapping[str, Mapping[str, Any]]) -> str:
    """The candidates as a table in Markdown."""
    header = "candidate | cost, s | speed | D at 4, 8, 16 cells, mm, mean of three positions | 4 to 8, % | 8 to 16, %"
    rows = []
    for name, final in finals.items():
        holes = final["holes"]
        changes = zip(final_changes(holes, "32"), final_changes(holes, "64"), strict=True)
        for (speed, means), (first, last) in zip(mean_holes(holes).items(), changes, strict=True):
            values = " ".join(f"{1e3 * value:.2f}" for value in means.values())
            where = f"{float(speed) / 1e3:g} km/s"
            change = [f"{100.0 * first:+.1f}", f"{100.0 * last:+.1f}"]
            rows.append([name, f"{final['seconds']:.0f}", where, values, *change])
    return table(header.split(" | "), rows)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
