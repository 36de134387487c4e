"""The report of a search: its limits, and the curves of residual velocities."""

import json
from pathlib import Path

import pytest

from studies.quantities.measured import Measured
from studies.reports.publish import publish_sweep
from studies.runs.results import RunResult
from studies.runs.run import Run
from studies.sweeps.sweep import Sweep
from tests.studies.support import fakes
from tests.studies.support.printed import undrawn

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


def result_of(run: Run) -> RunResult:
    speed, limit = float(run.parameters["speed"] or 0.0), EXACT[str(run.parameters["nose"])]
    residual = A * (speed**P - limit**P) ** (1.0 / P) if speed > limit else 0.0
    values = {"perforated": float(speed >= limit), "residual_velocity": residual}
    measured = {name: Measured(x, 1.0, {}, (), {"time": [1e-4], "value": [x]}, 1) for name, x in values.items()}
    return RunResult(run.id, "succeeded", measurements=measured, numbers={}, stop="end_time")


def test_report__states_limits_and_residual_velocities(tmp_path: Path) -> None:
    with undrawn():
        publish_sweep(SWEEP, fakes.searched(SWEEP, result_of), tmp_path)
    report = json.loads((tmp_path / "report.json").read_text())
    rows = {row["at"]["nose"]: row for row in report["search"]["rows"]}
    for nose, exact in EXACT.items():
        assert rows[nose]["lower"] < exact <= rows[nose]["upper"]
    [blunt, *_] = report["residual_velocity"]["curves"]
    # Exact data give exact constants.
    assert blunt["a"]["value"] == pytest.approx(A, rel=1e-4)
    assert blunt["p"]["value"] == pytest.approx(P, rel=1e-4)
    assert blunt["v_bl"]["value"] == pytest.approx(EXACT[blunt["at"]["nose"]], rel=1e-4)
    assert "Recht" in (tmp_path / "report.html").read_text()
