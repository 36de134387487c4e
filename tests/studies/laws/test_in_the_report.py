"""The report's numbers about each law: against the converged hole, within an error bar that includes the scatter."""

import json
import math
import statistics
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from studies.cases.rows import Row, equal, relative
from studies.convergence.richardson import Convergence, Sample, converge
from studies.cubes.cells import OF_MESH, SUB_CELL
from studies.laws import DRAWN_ONLY, load
from studies.quantities.measured import numerical_parts
from studies.reports.publish import publish
from studies.runs.execution import execute
from studies.runs.run import Run
from studies.sweeps.sweep import Sweep

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
NAME = "hole_diameter"
ROUND_OFF = 1e-12  # relative: the same operations in another order

Pair = tuple[float, Convergence]  # the answer of a law at a point (m), and the hole there


def result_of(run: Run, directory: Path) -> dict[str, Any]:
    """The result of a run as a program reads it from its file."""
    directory.mkdir(parents=True)
    execute(run, directory)
    return json.loads((directory / "result.json").read_text(encoding="utf-8"))


@pytest.mark.claim("report", "laws-in-the-report", minutes=1.0)
def test_report__has_the_numbers_about_each_law_that_its_runs_give(
    compared: Callable[[Row], None], tmp_path: Path
) -> None:
    """How far each law is from the converged hole, and how often inside its error bar, recomputed from the runs."""
    results = [
        (point.run, result_of(point.run, tmp_path / "runs" / point.run.id)) for point in Sweep.parse(SWEEP).runs()
    ]
    publish(SWEEP, {run.id: result for run, result in results}, tmp_path)
    document = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    with xr.open_dataset(tmp_path / "cube.nc") as opened:
        cube = opened.load()
    speeds = cube.speed.values.tolist()
    holes = [
        converge(_sample(run, result) for run, result in results if run.parameters["speed"] == speed)
        for speed in speeds
    ]
    (table,) = [each for each in document["convergence"]["quantities"] if each["quantity"] == NAME]
    for point, hole in zip(table["points"], holes, strict=True):
        where = f"{point['at']['speed'] / 1e3:g} km/s"
        bar = math.hypot(hole.mesh, hole.offsets, hole.measurement)
        compared(_same(f"{where}: converged hole (m)", hole.value, point["value"]))
        compared(equal(f"{where}: verdict", expected=hole.verdict, got=point["verdict"]))
        if math.isnan(bar):
            compared(equal(f"{where}: its error bar (m)", expected=None, got=point["uncertainty"]))
        else:
            compared(_same(f"{where}: its error bar (m)", bar, point["uncertainty"]))
        finest = hole.levels[0]
        is_scatter = point["offsets"] == finest.scatter / math.sqrt(finest.values) > 0.0
        compared(Row(f"{where}: scatter over offsets in it (m)", "above 0", point["offsets"], is_scatter))
    reported = [each for each in document["residuals"] if each["quantity"] == NAME]
    compared(Row("laws in the report", "at least 4", len(reported), len(reported) >= 4))
    for residual in reported:
        label = {f"{NAME}_law": residual["subject"]}
        answers = cube[f"{NAME}_by_law"].sel(label).values.tolist()
        in_range = cube[f"{NAME}_by_law_in_range"].sel(label).values == 1
        answered = [each for each in zip(answers, holes, in_range, strict=True) if math.isfinite(each[0])]
        groups = {"everywhere": answered, "in_range": [each for each in answered if each[2]]}
        for group, mine in groups.items():
            pairs = [(law, hole) for law, hole, _ in mine]
            for row in _rows(residual["subject"], group, residual[group], pairs):
                compared(row)


def _sample(run: Any, result: dict[str, Any]) -> Sample:
    measured = result["measurements"][NAME]
    parts = numerical_parts(measured["parts"])
    rest = (size for part, size in parts.items() if part not in OF_MESH)
    spacing = 1.0 / float(run.parameters["cells_per_diameter"])
    return Sample(spacing, measured["value"], parts.get(SUB_CELL, 0.0), math.hypot(*rest))


def _rows(law: str, group: str, reported: dict[str, Any], pairs: list[Pair]) -> Iterator[Row]:
    """One law over some points: how far from the holes, how many converged, how often inside the error bar."""
    subject = f"{law}, {group}"
    yield equal(f"{subject}: points", expected=len(pairs), got=reported["n"])
    if not pairs:
        return
    settled = sum(hole.verdict == "converging" for _, hole in pairs)
    yield equal(f"{subject}: converged points", expected=settled, got=reported["converged"])
    apart = [(law - hole.value) / hole.value for law, hole in pairs]
    yield _same(f"{subject}: relative smallest", min(apart), reported["relative_smallest"])
    yield _same(f"{subject}: relative greatest", max(apart), reported["relative_greatest"])
    sizes = [abs(each) for each in apart]
    tells = len(pairs) == 1 or (min(apart) * max(apart) > 0 and max(sizes) <= 2 * min(sizes))
    # One point is no average; of several, none of a law that enters no average.
    if tells and (len(pairs) == 1 or load(law.partition("/")[0]).confidence not in DRAWN_ONLY):
        mean = math.fsum(apart) / len(pairs)
        yield _same(f"{subject}: mean relative difference", mean, reported["relative_bias"])
    else:
        yield equal(f"{subject}: mean", expected=None, got=reported["relative_bias"])
    barred = [(law, hole) for law, hole in pairs if math.isfinite(hole.mesh)]
    yield equal(f"{subject}: points with an error bar", expected=len(barred), got=reported["judged"])
    inside = sum(abs(law - hole.value) <= hole.uncertainty for law, hole in barred)
    yield equal(f"{subject}: points inside the error bar", expected=inside, got=reported["within"])
    if barred:
        median = statistics.median(hole.uncertainty / hole.value for _, hole in barred)
        yield _same(f"{subject}: median error bar, relative", median, reported["relative_bar"])


def _same(claim: str, expected: float, got: float) -> Row:
    return relative(claim, expected=expected, got=got, within=ROUND_OFF)
