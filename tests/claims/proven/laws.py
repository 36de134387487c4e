"""The report's numbers about each law: against the converged hole, within an error bar that includes the scatter."""

import functools
import json
import math
import statistics
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import xarray as xr

from studies.convergence.richardson import Convergence, Sample, converge_series
from studies.reports.publish import publish
from studies.runs.run import Run
from studies.sweeps.sweep import Sweep
from tests.claims import Row, claim
from tests.claims.computed import result_of, scratch

# Coarse, so that it takes a minute: this claim is about what is compared with what. At 9 km/s a law answers outside of
# its range, so that its report is about three points of four.
SWEEP: dict[str, Any] = {
    "name": "laws",
    "scenario": "thin_plate",
    "fixed": {
        "projectile": "copper-ofhc",
        "target": "copper-ofhc",
        "projectile_diameter": "8 mm",
        "plate_thickness": "2 mm",
    },
    "axes": {"speed": ["2 km/s", "4 km/s", "6 km/s", "9 km/s"]},
    "resolution": [8, 12, 16],
    "offsets": 3,
}
GRIDS = ", ".join(map(str, SWEEP["resolution"]))
NAME = "hole_diameter"
ROUND_OFF = 1e-12  # relative: the same operations in another order

Pair = tuple[float, Convergence]  # the answer of a law at a point (m), and the hole there


@functools.cache
def computed() -> tuple[list[tuple[Run, dict[str, Any]]], xr.Dataset, dict[str, Any]]:
    """The runs with their results as read from their files, the cube, and report.json."""
    folder = Path(scratch().name) / "laws"
    runs = [(point.run, result_of(point.run, folder)) for point in Sweep.parse(SWEEP).runs()]
    publish(SWEEP, {run.id: result for run, result in runs}, folder)
    document = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    with xr.open_dataset(folder / "cube.nc") as cube:
        return runs, cube.load(), document


def _samples(speed: float) -> list[Sample]:
    """The runs at one speed, from the results alone."""
    samples = []
    for run, result in computed()[0]:
        if run.parameters["speed"] == speed:
            measured = result["measurements"][NAME]
            parts = dict(measured["parts"])
            unseen = parts.pop("resolution", 0.0)
            spacing = 1.0 / float(run.parameters["cells_per_diameter"] or math.nan)
            samples.append(Sample(spacing, measured["value"], unseen, math.hypot(*parts.values())))
    return samples


@claim(
    "laws-in-the-report",
    says="the numbers of the report about each law, recomputed from the runs: how far it is from the converged hole, "
    f"and how often inside an error bar that includes the scatter over offsets; on grids of {GRIDS} cells per diameter",
)
def laws_in_the_report() -> Iterator[Row]:
    _, cube, document = computed()
    holes = converge_series(_samples(float(speed)) for speed in cube.speed.values)
    (table,) = [each for each in document["convergence"]["quantities"] if each["quantity"] == NAME]
    for point, hole in zip(table["points"], holes, strict=True):
        where = f"{point['at']['speed'] / 1e3:g} km/s"
        bar = math.hypot(hole.mesh, hole.offsets, hole.measurement)
        yield _same(f"{where}: converged hole (m)", hole.value, point["value"])
        yield _same(f"{where}: its error bar (m)", bar, point["uncertainty"])
        scatter = hole.levels[0].scatter
        yield Row(
            f"{where}: scatter over offsets in it (m)", "above 0", point["offsets"], point["offsets"] == scatter > 0.0
        )
    laws = [each for each in document["residuals"] if each["quantity"] == NAME]
    yield Row("laws in the report", "at least 4", len(laws), len(laws) >= 4)
    for residual in laws:
        label = {f"{NAME}_law": residual["subject"]}
        answers = cube[f"{NAME}_by_law"].sel(label).values
        in_range = cube[f"{NAME}_by_law_in_range"].sel(label).values == 1
        answered = [
            (float(law), hole, inside)
            for law, hole, inside in zip(answers, holes, in_range, strict=True)
            if math.isfinite(law)
        ]
        for group, pairs in (
            ("everywhere", [(law, hole) for law, hole, _ in answered]),
            ("in_range", [(law, hole) for law, hole, inside in answered if inside]),
        ):
            yield from _rows(f"{residual['subject']}, {group}", residual[group], pairs)


def _rows(subject: str, reported: dict[str, Any], pairs: list[Pair]) -> Iterator[Row]:
    """One law over some points: how far from the holes, how many converged, how often inside the error bar."""
    yield _equal(f"{subject}: points", len(pairs), reported["n"])
    if not pairs:
        return
    settled = sum(hole.verdict == "converging" for _, hole in pairs)
    yield _equal(f"{subject}: converged points", settled, reported["converged"])
    relative = [(law - hole.value) / hole.value for law, hole in pairs]
    for key, least_or_most in (("relative_smallest", min), ("relative_greatest", max)):
        yield _same(f"{subject}: {key.replace('_', ' ')}", least_or_most(relative), reported[key])
    sizes = [abs(each) for each in relative]
    if len(pairs) == 1 or (min(relative) * max(relative) > 0 and max(sizes) <= 2 * min(sizes)):
        mean = math.fsum(relative) / len(pairs)
        yield _same(f"{subject}: mean relative difference", mean, reported["relative_bias"])
    else:
        yield Row(f"{subject}: mean", None, reported["bias"], reported["bias"] is None)
    barred = [(law, hole) for law, hole in pairs if math.isfinite(hole.mesh)]
    yield _equal(f"{subject}: points with an error bar", len(barred), reported["judged"])
    inside = sum(abs(law - hole.value) <= hole.uncertainty for law, hole in barred)
    yield _equal(f"{subject}: points inside the error bar", inside, reported["within"])
    if barred:
        median = statistics.median(hole.uncertainty / hole.value for _, hole in barred)
        yield _same(f"{subject}: median error bar, relative", median, reported["relative_bar"])


def _equal(claim: str, expected: int, got: int) -> Row:
    return Row(claim, expected, got, got == expected)


def _same(claim: str, expected: float, got: float) -> Row:
    close = bool(abs(got - expected) <= ROUND_OFF * abs(expected))
    return Row(claim, f"{expected:.6g}", f"{got:.6g}", close)
