"""The report's numbers about each law: against the converged hole, within an error bar that includes the scatter."""

import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from studies.convergence.richardson import Convergence, Sample, converge
from studies.cubes.cells import OF_MESH, SUB_CELL
from studies.cubes.opening import whole_cube
from studies.quantities.measured import numerical_parts
from studies.reports.publish import publish
from studies.runs.execution import execute
from studies.runs.run import Run
from studies.sweeps.sweep import Sweep
from tests.claims.rows import Row, equal, relative

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
    cube = whole_cube(tmp_path)
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
    reported = [each for each in document["laws"]["judgements"] if each["quantity"] == NAME]
    compared(Row("laws in the report", "at least 4", len(reported), len(reported) >= 4))
    for law in reported:
        for row in _rows(law, cube, holes):
            compared(row)


def _sample(run: Any, result: dict[str, Any]) -> Sample:
    measured = result["measurements"][NAME]
    parts = numerical_parts(measured["parts"])
    rest = (size for part, size in parts.items() if part not in OF_MESH)
    spacing = 1.0 / float(run.parameters["cells_per_diameter"])
    return Sample(spacing, measured["value"], parts.get(SUB_CELL, 0.0), math.hypot(*rest))


def _rows(reported: dict[str, Any], cube: xr.Dataset, holes: list[Convergence]) -> Iterator[Row]:
    """One law: how far from the holes, and how often inside the bar with models, over the points in its range."""
    law = reported["law"]
    of_law = {f"{NAME}_law": law}
    answers = cube[f"{NAME}_by_law"].sel(of_law).values.tolist()
    in_range = (cube[f"{NAME}_by_law_in_range"].sel(of_law).values == 1).tolist()
    models = cube[f"{NAME}_model_part"].isel(cells_per_diameter=-1, offset=0).values.tolist()
    definitions = cube[f"{NAME}_definition_part"].values.tolist()
    yield equal(f"{law}: points in its range", expected=sum(in_range), got=reported["in_range"])
    mine = [each for each in zip(answers, holes, in_range, models, definitions, strict=True) if each[2]]
    if not mine:
        yield equal(f"{law}: outcome", expected="not_comparable", got=reported["outcome"])
        return
    apart = [(answer - hole.value) / hole.value for answer, hole, *_ in mine]
    yield _same(f"{law}: relative smallest", min(apart), reported["low"])
    yield _same(f"{law}: relative greatest", max(apart), reported["high"])
    parts = [
        (hole, [hole.mesh, hole.offsets, hole.measurement, model, definition]) for _, hole, _, model, definition in mine
    ]
    bars = [
        math.hypot(*(part for part in each if math.isfinite(part))) / hole.value if math.isfinite(hole.mesh) else None
        for hole, each in parts
    ]
    tested = [(difference, bar) for difference, bar in zip(apart, bars, strict=True) if bar is not None]
    yield equal(f"{law}: points with an error bar", expected=len(tested), got=reported["tested"])
    inside = sum(abs(difference) <= bar for difference, bar in tested)
    yield equal(f"{law}: points within the bars", expected=inside, got=reported["within"])
    if tested:
        yield _same(f"{law}: largest bar, relative", max(bar for _, bar in tested), reported["bar"])


def _same(claim: str, expected: float, got: float) -> Row:
    return relative(claim, expected=expected, got=got, within=ROUND_OFF)
