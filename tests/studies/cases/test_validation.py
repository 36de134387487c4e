"""Validation cases: sweeps of each level, published numbers, rows and pages."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from studies.cases import validation, verification
from studies.cases.compared import ComparedReading, Line, Picture, PublishedNumber, against, compared
from studies.cases.pages import draw, write_case, write_index
from studies.cases.rows import Row, Verified, reported
from studies.cases.validation import LEVELS, ValidationCase
from studies.quantities.measured import Measured
from studies.runs.results import RunResult
from studies.sweeps.sweep import Sweep

CELLS = (5.0, 10.0, 20.0)


@pytest.mark.parametrize("name", validation.names())
def test_case__has_sweeps_at_each_level(name: str) -> None:
    case = validation.load(name)
    assert case.says
    assert case.source
    assert name not in verification.names()
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


def rows_of(cube: Any, speed: float) -> list[Row]:
    quantity = ComparedReading(cube, "crater_depth", {"speed": speed})
    there = [each for each in numbers() if each.at("speed") == speed]
    return list(compared("there", quantity, there, "MPM3D", mesh=(5.0, "1 mm"), within=0.5))


def test_rows__gate_the_mesh_of_the_source_and_report_the_converged_value(cube: Any) -> None:
    own, converged = rows_of(cube, 5e3)
    assert (own.verdict, own.expected, own.got) == ("PASS", 14.0, pytest.approx(14.0))
    assert converged.verdict == "REPORT"
    assert converged.got == pytest.approx(15.875)  # on 20 cells
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


def test_picture__has_each_grid_ours_and_theirs(cube: Any) -> None:
    picture = against("p", "Depth", cube, "crater_depth", "speed", numbers())
    labels = [line.label for line in picture.lines]
    assert labels[-2:] == ["whipple, converged", "MPM3D"]
    theirs = picture.lines[-1].points
    assert theirs == tuple((v, d, 0.0) for v, d in ((4.0, 12.0), (5.0, 14.0), (6.0, 16.0), (7.0, 17.0)))
    speed, depth, _ = picture.lines[-2].points[0]
    assert speed == 4.0
    assert depth == pytest.approx(15.875)


def test_pages__show_every_figure_and_escape_texts(tmp_path: Path) -> None:
    picture = Picture("depth", "Depth", "v", "p", (Line("a<b", ((1.0, 2.0, 0.1),)),))
    case = ValidationCase(
        name="made-up",
        says="a < b",
        source="nobody",
        sweeps=lambda level: {},
        rows=lambda level, cubes: (),
        pictures=lambda cubes: [picture],
    )
    row = Row("depth (mm)", 14.0, 14.5, False, 0.5, 0.4, bar=0.25, others={"SPH": 17.3})
    rows = [Verified("made-up", row, 0.1), Verified("made-up", reported("more", 3.0), 0.1)]
    page = write_case(case, rows, {}, tmp_path).read_text()
    for text in (
        "14.5\N{NO-BREAK SPACE}±\N{NO-BREAK SPACE}0.25",
        "0.5 of 0.4",
        "SPH 17.3",
        ">fail<",
        "A &lt; b",
        "<svg",
    ):
        assert text in page, text
    assert draw(picture) == draw(picture)  # without a clock
    index = write_index([(case, rows)], "fine", tmp_path).read_text()
    assert "0 passed, 1 failed, 1 reported" in index
    assert 'src="data:image/svg+xml;base64,' in index
