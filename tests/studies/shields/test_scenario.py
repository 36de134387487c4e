"""The scenario of a shield: its defaults, and a wall that debris has still to reach."""

from dataclasses import replace
from pathlib import Path

import pytest

from studies.runs import execution
from studies.runs.remeasure import remeasure
from studies.sweeps.search import outcome_in
from tests.contracts.test_scenarios import asked


def _never(*_: object, **__: object) -> None:
    raise AssertionError("a stored state is read, not computed")


def test_wall__that_debris_has_still_to_reach_stays_undecided(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    run = asked("whipple_shield", wall_thickness=16e-3, cells_per_diameter=6.0, end_time=40e-6)
    before = execution.execute(run, tmp_path, threads=1)
    assert outcome_in(before.as_json(), "wall_perforated") is None
    older = {name: replace(measured, version=0) for name, measured in before.measurements.items()}
    monkeypatch.setattr(execution, "simulate", _never)
    after = remeasure(run, replace(before, measurements=older), tmp_path / "state.npz", by="a test")
    assert outcome_in(after.as_json(), "wall_perforated") is None
    for name in ("wall_perforated", "wall_bulge"):
        assert "still_coming" in after.measurements[name].flags
    assert "still_growing" in after.measurements["wall_perforated"].flags
