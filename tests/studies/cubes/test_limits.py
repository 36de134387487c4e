"""The cube of a search: the limits, and every value that was tried."""

import json
from pathlib import Path
from typing import Any

import pytest

from studies.cubes import cube
from studies.cubes.cells import MissingResult
from studies.cubes.limits import VERDICTS
from studies.quantities.measured import Measured
from studies.reports.publish import publish_sweep
from studies.runs.results import RunResult
from studies.runs.run import Run
from studies.sweeps.search import SearchVerdict
from studies.sweeps.sweep import Sweep

SWEEP = Sweep.parse(
    {
        "scenario": "plugging",
        "axes": {
            "speed": {"limit_of": "perforated", "between": ["100 m/s", "400 m/s"], "tolerance": "20 m/s"},
            "nose": ["blunt", "conical"],
        },
        "resolution": 8,
    }
)
EXACT = {"blunt": 180.0, "conical": 290.0}  # m/s
A, P = 0.8, 2.3  # of the residual velocities


def residual(speed: float, limit: float) -> float:
    return A * (speed**P - limit**P) ** (1.0 / P) if speed > limit else 0.0


def measured(value: float) -> Measured:
    return Measured(value, 1.0, {}, (), {"time": [0.0, 1e-4], "value": [None, value]}, 1)


def result_of(run: Run, exact: dict[str, float]) -> RunResult:
    speed, limit = float(run.parameters["speed"] or 0.0), exact[str(run.parameters["nose"])]
    values = {"perforated": float(speed >= limit), "residual_velocity": residual(speed, limit)}
    measurements = {name: measured(value) for name, value in values.items()}
    return RunResult(run.id, "succeeded", measurements=measurements, numbers={}, stop="end_time")


def results_of(exact: dict[str, float], *, failing: float | None = None) -> dict[str, Any]:
    """The results that a search of these limits leaves, whose runs at a speed failed."""
    results: dict[str, Any] = {}

    def outcome_of(run: Run) -> bool | None:
        if run.parameters["speed"] == failing:
            results[run.id] = MissingResult("crashed", "it crashed")
            return None
        results[run.id] = result_of(run, exact)
        return results[run.id].measurements["perforated"].value > 0.5

    SWEEP.limits(outcome_of)
    return results


def test_limits__stand_over_the_points_of_the_other_axes() -> None:
    dataset = cube.build(SWEEP, results_of(EXACT))
    assert dataset.limit_nose.values.tolist() == ["blunt", "conical"]
    for at, exact in enumerate(EXACT.values()):
        assert dataset.limit_lower[at] < exact <= dataset.limit_upper[at]
        assert dataset.limit_upper[at] - dataset.limit_lower[at] <= 20.0
        assert dataset.limit[at] == 0.5 * (dataset.limit_lower[at] + dataset.limit_upper[at])
        assert VERDICTS[int(dataset.limit_verdict[at])] is SearchVerdict.BRACKETED
    assert dataset.limit.attrs["units"] == "m s-1"
    assert (dataset.limit.attrs["limit_of"], dataset.limit.attrs["axis"]) == ("perforated", "speed")


@pytest.fixture(scope="module")
def published(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("search")
    publish_sweep(SWEEP, results_of(EXACT), folder)
    return folder


def test_report__states_limits_and_residual_velocities(published: Path) -> None:
    report = json.loads((published / "report.json").read_text())
    rows = {row["at"]["nose"]: row for row in report["limits"]["rows"]}
    for nose, exact in EXACT.items():
        assert rows[nose]["lower"] < exact <= rows[nose]["upper"]
    [blunt, *_] = report["residual_curves"]["rows"]
    # Exact data give exact constants.
    assert blunt["a"]["value"] == pytest.approx(A, rel=1e-4)
    assert blunt["p"]["value"] == pytest.approx(P, rel=1e-4)
    assert blunt["v_bl"]["value"] == pytest.approx(EXACT[blunt["at"]["nose"]], rel=1e-4)
    page = (published / "report.html").read_text()
    assert "Recht" in page
