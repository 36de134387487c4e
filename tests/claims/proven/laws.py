"""What a report says of a law: against the converged hole, within an error bar that holds the scatter over offsets."""

import functools
import math
import statistics
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import xarray as xr

from studies.convergence.richardson import Convergence, Sample, converge
from studies.reports.compare import Residual, compare, sentence
from studies.reports.publish import publish
from studies.runs.run import Run
from studies.sweeps.sweep import Sweep
from studies.values.formats import of_share
from tests.claims import Row, claim
from tests.claims.computed import result_of, scratch

# Coarse, so that it takes a minute: this claim is about what is compared with what. At 9 km/s a law answers outside of
# its range, so that its sentence is about three points of four.
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

Pair = tuple[float, Convergence]  # what a law answers at a point (m), and the hole there


@functools.cache
def computed() -> tuple[list[tuple[Run, dict[str, Any]]], xr.Dataset]:
    """The runs with their results as read from their files, and the cube."""
    folder = Path(scratch().name) / "laws"
    found = [(point.run, result_of(point.run, folder)) for point in Sweep.parse(SWEEP).runs()]
    publish(SWEEP, {run.id: result for run, result in found}, folder)
    with xr.open_dataset(folder / "cube.nc") as cube:
        return found, cube.load()


def _converged(speed: float) -> Convergence:
    """The hole at one speed, from the results alone."""
    samples = []
    for run, result in computed()[0]:
        if run.parameters["speed"] == speed:
            measured = result["measurements"][NAME]
            parts = dict(measured["parts"])
            unseen = parts.pop("resolution", 0.0)
            spacing = 1.0 / float(run.parameters["cells_per_diameter"] or math.nan)
            samples.append(Sample(spacing, measured["value"], unseen, math.hypot(*parts.values())))
    return converge(samples)


@claim(
    "law-sentences",
    says="the sentence about each law, rebuilt from the runs: how far it is from the converged hole, and how often "
    f"inside an error bar that holds the scatter over offsets; on grids of {GRIDS} cells per diameter",
)
def law_sentences() -> Iterator[Row]:
    _, cube = computed()
    holes = [_converged(float(speed)) for speed in cube.speed.values]
    for speed, hole in zip(cube.speed.values, holes, strict=True):
        where = f"{speed / 1e3:g} km/s"
        yield _same(
            f"{where}: hole that the cube calls converged (mm)",
            1e3 * hole.value,
            1e3 * float(cube[f"{NAME}_converged"].sel(speed=speed)),
        )
        bar = math.hypot(hole.mesh, hole.offsets, hole.measurement)
        yield _same(
            f"{where}: its error bar from mesh, offsets and measurement (mm)",
            1e3 * bar,
            1e3 * float(cube[f"{NAME}_converged_uncertainty"].sel(speed=speed)),
        )
        scatter = hole.levels[0].scatter
        yield Row(
            f"{where}: scatter over offsets in it (mm)",
            "above 0",
            1e3 * hole.offsets,
            hole.offsets == scatter > 0.0,
        )
    for residual in compare(cube).residuals:
        if residual.quantity == NAME:
            yield from _rows(residual, cube, holes)


def _rows(residual: Residual, cube: xr.Dataset, holes: list[Convergence]) -> Iterator[Row]:
    """One law: the mean difference, how often it is inside the error bar, and the sentence that says so."""
    answers = cube[f"{NAME}_by_law"].sel({f"{NAME}_law": residual.subject}).values.ravel()
    pairs = [
        (float(law), hole) for law, hole in zip(answers, holes, strict=True) if math.isfinite(law)
    ]
    everywhere = residual.everywhere
    bias = math.fsum(law - hole.value for law, hole in pairs) / len(pairs)
    yield _same(
        f"{residual.subject}: mean difference from the converged hole (mm)",
        1e3 * bias,
        1e3 * (everywhere.bias or math.nan),
    )
    inside = sum(abs(law - hole.value) <= hole.uncertainty for law, hole in pairs)
    yield Row(
        f"{residual.subject}: points inside the error bar",
        inside,
        everywhere.within,
        inside == everywhere.within,
    )
    in_range = cube[f"{NAME}_by_law_in_range"].sel({f"{NAME}_law": residual.subject}).values.ravel()
    stated = [
        (float(law), hole)
        for law, hole, inside in zip(answers, holes, in_range, strict=True)
        if inside == 1 and math.isfinite(law)
    ]
    yield _spoken(sentence(residual), stated, pairs, len(holes))


def _spoken(said: str, stated: list[Pair], answered: list[Pair], points: int) -> Row:
    """Whether a sentence has the words and figures of its points: those in the law's range if any, else all."""
    share = "all" if len(stated) == points else f"{len(stated)} of {points}"
    opening = f"({share} points)" if stated else "no point inside its stated range"
    words = (opening, *_figures(stated or answered))
    missing = [part for part in words if part not in said]
    return Row(said, "; ".join(words), f"without {missing}" if missing else "the same", not missing)


def _figures(compared: list[Pair]) -> Iterator[str]:
    """What a sentence says of laws and holes: how far apart, how settled, how often inside the error bar."""
    mean = math.fsum((law - hole.value) / hole.value for law, hole in compared) / len(compared)
    yield f" {of_share(abs(mean))} {'larger' if mean > 0.0 else 'smaller'} than"
    settled = sum(hole.verdict == "converging" for _, hole in compared)
    yield (
        "the converged simulation"
        if settled == len(compared)
        else f"(converged at {settled or 'none'} of {len(compared)} points)"
    )
    bars = [(law, hole) for law, hole in compared if math.isfinite(hole.mesh)]
    median = statistics.median(hole.uncertainty / hole.value for _, hole in bars)
    inside = sum(abs(law - hole.value) <= hole.uncertainty for law, hole in bars)
    many = "s" if len(bars) > 1 else ""
    yield f"inside the error bar (median ± {of_share(median)}) at {inside} of {len(bars)} point{many}."


def _same(claim: str, expected: float, got: float) -> Row:
    return Row(
        claim,
        f"{expected:.6g}",
        f"{got:.6g}",
        bool(abs(got - expected) <= ROUND_OFF * abs(expected)),
    )
