"""Cube and report of real runs: each says what the other says, and a run that fails stays in its cell."""

import functools
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from studies.cubes.variables import STATES
from studies.reports.publish import outcome_from_json, publish
from studies.sweeps.sweep import Sweep
from tests.claims import Row, claim
from tests.claims.computed import result_of, scratch
from tests.studies.support import compliance
from tests.studies.support.printed import Page, at, read_page

# Coarse, so that it takes seconds: these claims are about bookkeeping, not about holes.
SWEEP: dict[str, Any] = {
    "name": "claims",
    "scenario": "thin_plate",
    "fixed": {"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": "8 mm"},
    "axes": {"speed": ["5 km/s", "6 km/s"], "plate_thickness": ["2 mm", "3 mm"]},
    "resolution": 8,
    "observations": [
        {
            "speed": "5.5 km/s",
            "plate_thickness": "2 mm",
            "quantity": "hole_diameter",
            "value": "18 mm",
            "uncertainty": "0.5 mm",
            "source": "invented, to have one",
        }
    ],
}
# A step of 100 us carries particles across many cells: the solver must refuse to go on.
FAILING: dict[str, Any] = {
    "name": "failing",
    "scenario": "thin_plate",
    "fixed": {**SWEEP["fixed"], "plate_thickness": "2 mm"},
    "axes": {"fixed_dt": ["10 ns", "100 us"], "speed": ["5 km/s", "6 km/s"]},
    "resolution": 8,
}
ROUND_OFF = 1e-12  # relative: the same operations in another order


@functools.cache
def computed(name: str) -> tuple[dict[str, Any], Path]:
    """The outcomes of a sweep's runs, and the folder with its three files."""
    document = {"claims": SWEEP, "failing": FAILING}[name]
    folder = Path(scratch().name) / name
    outcomes = {point.run.id: result_of(point.run, folder) for point in Sweep.parse(document).runs()}
    publish(document, outcomes, folder)
    return outcomes, folder


def opened(folder: Path) -> xr.Dataset:
    with xr.open_dataset(folder / "cube.nc") as dataset:
        return dataset.load()


def twin(folder: Path) -> dict[str, Any]:
    plain: dict[str, Any] = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    return plain


def page_in(folder: Path) -> Page:
    return read_page((folder / "report.html").read_text(encoding="utf-8"))


@claim("cube-redoes-figures", says='xarray.open_dataset("cube.nc") alone redoes the main figure of the report')
def cube_redoes_figures() -> Iterator[Row]:
    _, folder = computed("claims")
    dataset, figure = opened(folder), twin(folder)["figures"][0]
    ratio = dataset.hole_diameter / dataset.equivalent_diameter
    laws = dataset.hole_diameter_by_law / dataset.equivalent_diameter
    for panel in figure["panels"]:
        place = f"t = {1e3 * panel['at']['plate_thickness']:g} mm"
        series = {each["label"]: each for each in panel["series"]}
        yield _same(f"simulation, {place}", ratio.sel(panel["at"]).values, series["simulation"]["y"])
        for title, answers in laws.sel(panel["at"]).groupby("hole_diameter_law_title"):
            drawn = next((each for label, each in series.items() if label.startswith(str(title))), None)
            if drawn is None:
                yield Row(f"{title}, {place}: named in the caption", "", "", str(title) in figure["caption"])
                continue
            edges = ("y", "y") if drawn["kind"] == "law" else ("low", "high")
            least, most = answers.min("hole_diameter_law"), answers.max("hole_diameter_law")
            yield _same(f"{title}, {place}", least.values, drawn[edges[0]])
            yield _same(f"{title}, {place}, upper edge", most.values, drawn[edges[1]])
    yield Row("observed shots drawn", 1, _observed(figure), passed=_observed(figure) == 1)


def _observed(figure: dict[str, Any]) -> int:
    return sum(
        len(each["x"]) for panel in figure["panels"] for each in panel["series"] if each["kind"] == "observation"
    )


def _same(what: str, mine: np.ndarray, stated: list[float | None]) -> Row:
    """Whether numbers redone from the cube are those of the figure."""
    other = np.array([math.nan if value is None else value for value in stated])
    fits = np.allclose(mine, other, rtol=ROUND_OFF, atol=0.0, equal_nan=True)
    return Row(f"{what}: {len(other)} points", "equal", "equal" if fits else "different", bool(fits))


@claim("html-json-cube", says="every number in the HTML equals the JSON and the cube")
def html_json_cube() -> Iterator[Row]:
    _, folder = computed("claims")
    dataset, stated, page = opened(folder), twin(folder), page_in(folder)
    numbers = [mark for mark in page.marks if mark.value is not None]
    wrong = [mark.path for mark in numbers if mark.value != _full(at(stated, mark.path))]
    yield Row(f"{len(numbers)} numbers of the HTML, other than in the JSON", 0, len(wrong), not wrong)
    stray = sum(letter.isdecimal() for letter in page.unmarked)
    yield Row("digits of the HTML that have no place in the JSON", 0, stray, stray == 0)
    left_out = dataset.attrs["undeclared_numbers"]
    yield Row("numbers of runs that the cube does not declare", "none", left_out or "none", not left_out)
    cells = [pair for run in stated["runs"] for pair in _cells(run, dataset)]
    unlike = [name for name, each, other in cells if each != other]
    yield Row(f"{len(cells)} numbers of the JSON's runs, other than in the cube", 0, len(unlike), not unlike)
    residuals = list(_residuals(stated, dataset))
    apart = [name for name, each, other in residuals if not math.isclose(each, other, rel_tol=ROUND_OFF)]
    yield Row(f"{len(residuals)} residuals of the JSON, other than from the cube", 0, len(apart), not apart)


def _full(value: Any) -> str:
    return "" if value is None else json.dumps(value, ensure_ascii=False)


def _cells(run: dict[str, Any], dataset: xr.Dataset) -> Iterator[tuple[str, Any, Any]]:
    """Each number of a run beside the one in its cell of the cube."""
    cell = dataset.sel(run["at"])
    for name, value in run["values"].items():
        number = float(cell[name])
        yield name, value, None if math.isnan(number) else number


def _residuals(stated: dict[str, Any], dataset: xr.Dataset) -> Iterator[tuple[str, float, float]]:
    """The largest residual of each law against the simulation beside the one redone from the cube."""
    difference = dataset.hole_diameter_by_law - dataset.hole_diameter
    inside = difference.where(dataset.hole_diameter_by_law_in_range == 1)
    for row in stated["residuals"]:
        if row["reference"] == "simulation" and row["quantity"] == "hole_diameter":
            for key, values in (("everywhere", difference), ("in_range", inside)):
                mine = values.sel(hole_diameter_law=row["subject"])
                assert row[key]["n"] == int(mine.count())
                if row[key]["n"]:
                    yield row["subject"], row[key]["greatest"], float(mine.max())


@claim(
    "failed-run-is-a-result",
    says="a run that fails is NaN with state and reason in cube and report; its neighbours are untouched",
)
def failed_run_is_a_result() -> Iterator[Row]:
    outcomes, folder = computed("failing")
    dataset, page = opened(folder), page_in(folder)
    texts = {mark.text for mark in page.marks}
    for step in (1e-8, 1e-4):
        cells = dataset.sel(fixed_dt=step)
        states = {STATES[int(state)] for state in cells.run_state.values}
        expected = "succeeded" if step < 1e-6 else "failed"
        yield Row(f"state at a step of {step:g} s", expected, " ".join(states), states == {expected})
        if expected == "failed":
            reasons = [str(reason) for reason in cells.run_reason.values]
            nan = bool(cells.hole_diameter.isnull().all())
            yield Row("its hole in the cube", "NaN", "NaN" if nan else "a number", nan)
            yield Row("its reason in the cube", "a reason", reasons[0], all(reasons))
            is_reported = all(reason in texts for reason in reasons)
            yield Row("its reason in the report", "the same", "the same" if is_reported else "none", is_reported)
        else:
            alone = [outcome_from_json(outcomes[run]) for run in cells.run_id.values]
            values = [each.measurements["hole_diameter"].value for each in alone]
            untouched = values == cells.hole_diameter.values.tolist()
            yield Row("holes of its neighbours", values, cells.hole_diameter.values.tolist(), untouched)


@claim("cube-is-cf", says="compliance-checker finds no error against CF-1.11")
def cube_is_cf() -> Iterator[Row]:
    for name in ("claims", "failing"):
        complaints = compliance.complaints(computed(name)[1] / "cube.nc")
        yield Row(f"errors in the cube {name!r}", "none", "; ".join(complaints) or "none", not complaints)
