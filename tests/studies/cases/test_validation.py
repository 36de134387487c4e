"""Validation cases: sweeps of each level, published numbers, rows and pages."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import pytest

from solver.errors import ProblemError
from studies.cases import validation
from studies.cases.compared import ComparedReading, Picture, PublishedNumber, compared
from studies.cases.validation import LEVELS, ValidationCase
from studies.quantities.comparison import Comparison, reported
from studies.quantities.measured import Measured
from studies.runs.results import RunResult
from studies.sweeps.sweep import Sweep

NAN = math.nan
CELLS = (5.0, 10.0, 20.0)


@pytest.mark.parametrize("name", validation.names())
def test_case__has_sweeps_at_each_level(name: str) -> None:
    case = validation.load(name)
    assert case.says
    assert case.source
    for level in LEVELS:
        sizes = [Sweep.parse(document).size for document in case.documents(level).values()]
        assert sizes
        assert all(sizes)


@pytest.fixture(scope="module")
def cube() -> Any:
    """Craters of Table 3.4 on three grids with made-up depths: of second order, 16 mm without a mesh."""
    document = validation.load("table-3-4").documents("fine")["craters"]
    return cube_of(document, {"crater_depth": lambda at: 16e-3 - 2e-3 * (5.0 / at["cells_per_diameter"]) ** 2})


def numbers() -> list[PublishedNumber]:
    return validation.of_observations("craters-thesis", "thick_plate", "MPM3D")


def rows_of(cube: Any, speed: float) -> list[Comparison]:
    quantity = ComparedReading(cube, "crater_depth", {"speed": speed})
    there = [each for each in numbers() if each.at("speed") == speed]
    return list(compared("there", quantity, there, "MPM3D", mesh=(5.0, "1 mm"), within=0.5))


def test_rows__gate_the_mesh_of_the_source_and_report_the_converged_value(cube: Any) -> None:
    own, converged = rows_of(cube, 5e3)
    assert (own.verdict, own.expected) == ("PASS", 14.0)
    assert own.got == pytest.approx(14.0)
    assert converged.verdict == "REPORT"
    assert converged.got == pytest.approx(15.875)  # on 20 cells
    assert isinstance(converged.got, float)
    assert converged.bar is not None
    assert 16.0 - converged.got < converged.bar < 0.5
    assert rows_of(cube, 6e3)[0].verdict == "FAIL"


def cube_of(document: Any, values: Mapping[str, Callable[[Mapping[str, Any]], float]]) -> Any:
    """The cube of a sweep with made-up values by quantity, as functions of the coordinates."""
    from studies.cubes import cube as cubes

    sweep = Sweep.parse(document)
    results = {}
    for point in sweep.runs():
        measurements = {
            name: Measured(of(point.coordinates), 1e-6, {"resolution": 1e-6}, (), {"time": [], "value": []}, 1)
            for name, of in values.items()
        }
        results[point.run.id] = RunResult(point.run.id, "succeeded", measurements=measurements)
    return cubes.build(sweep, results)


def made_up(rows: Callable[[], Iterable[Comparison]], *pictures: Picture) -> ValidationCase:
    return ValidationCase(
        name="made-up",
        says="a < b",
        source="nobody",
        sweeps=lambda level: {},
        rows=lambda level, cubes: rows(),
        pictures=lambda cubes: pictures,
    )


def test_case__of_which_the_solver_fails_has_a_comparison_that_failed() -> None:
    def rows() -> Iterator[Comparison]:
        yield reported("first", 1.0)
        raise ProblemError("no particles")

    first, last = made_up(rows).compared("quick", {})
    assert (first.verdict, last.verdict) == ("REPORT", "FAIL")
    assert "no particles" in str(last.got)
