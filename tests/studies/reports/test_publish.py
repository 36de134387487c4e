"""Publishing: one call makes the three files, from a document and plain outcomes, and the cube redoes the report."""

import json
from pathlib import Path

import numpy as np
import pytest

from studies.cubes.opening import whole_cube
from studies.quantities.files import ALL_RUNS_CSV, APPENDIX_HTML, COVER, SWEEP_FILES
from studies.quantities.measured import Measured
from studies.quantities.parameters import Plain
from studies.reports import report
from studies.reports.page import appendix
from studies.reports.publish import publish
from studies.runs.results import RunResult
from studies.sweeps.sweep import Sweep
from tests.studies.support.printed import undrawn

PUBLISHED = (*SWEEP_FILES, APPENDIX_HTML, ALL_RUNS_CSV, COVER)
HOLES: dict[str, Plain] = {
    "name": "holes",
    "scenario": "thin_plate",
    "fixed": {"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": "8 mm"},
    "axes": {"speed": ["3 km/s", "6 km/s"], "plate_thickness": ["2 mm", "3 mm"]},
    "resolution": 16,
    "observations": [
        {
            "speed": "6 km/s",
            "plate_thickness": "2 mm",
            "quantity": "hole_diameter",
            "value": "19 mm",
            "source": "Somebody (2001)",
        }
    ],
}


def outcomes(document: dict) -> dict[str, dict]:
    """A result for each run but the first, which crashed."""
    first, *others = Sweep.parse(document).runs()
    hole = Measured(0.018, 0.0004, {"resolution": 0.0004}, (), {"time": [0.0, 1e-5], "value": [None, 0.018]}, 1)
    return {
        first.run.id: {"state": "crashed", "reason": "killed by signal 9"},
        **{
            point.run.id: RunResult(
                point.run.id,
                "succeeded",
                measurements={"hole_diameter": hole},
                numbers={"energy_drift": 0.002},
                stop="settled",
                provenance={"whipple": "0.1.0", "physics_version": "1", "seconds": 2.0},
            ).as_json()
            for point in others
        },
    }


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("out")
    with undrawn():
        files = publish(HOLES, json.loads(json.dumps(outcomes(HOLES))), folder / "holes")
    assert files == {name: str(folder / "holes" / name) for name in PUBLISHED}
    return folder / "holes"


def test_cube_alone__redoes_the_report(folder: Path) -> None:
    """But for the date and what the computation took."""
    document = report.report_of(whole_cube(folder)).as_json()
    published = json.loads((folder / "report.json").read_text())
    assert published["provenance"]["cube"].pop("date_created")
    for run in published["runs"]["runs"]:
        del run["values"]["solver_seconds"], run["values"]["solver_threads"]
    assert json.loads(report.as_json(document)) == published
    with undrawn():
        assert "time (s)" not in appendix(document)


def test_cube__has_the_same_bytes_whoever_computes_the_sweep(folder: Path, tmp_path: Path) -> None:
    """The report and the table of runs say what the computation took."""
    answers = outcomes(HOLES)
    for answer in answers.values():
        answer.get("provenance", {}).update(seconds=6.5, threads=2, checkpoint="on from step 2")
    with undrawn():
        publish(HOLES, answers, tmp_path)
    assert (folder / "cube.nc").read_bytes() == (tmp_path / "cube.nc").read_bytes()
    assert "6.5,2.0" in (tmp_path / ALL_RUNS_CSV).read_text()
    assert "6.5,2.0" not in (folder / ALL_RUNS_CSV).read_text()
    assert "time (s)" in (tmp_path / APPENDIX_HTML).read_text()


def test_cube__has_laws_materials_and_shots_that_ship_or_that_the_sweep_brings(folder: Path) -> None:
    dataset = whole_cube(folder)
    crashed = dataset.sel(speed=3e3, plate_thickness=2e-3)
    assert crashed.run_reason.item() == "killed by signal 9"
    laws = dataset.hole_diameter_by_law
    answer = laws.sel(speed=6e3, plate_thickness=2e-3, hole_diameter_law="maiden_al")
    assert float(answer) / 8e-3 == pytest.approx(1.971, abs=5e-4)  # Ma (2005), Eq. 1-3
    # The shot takes from the sweep what it does not state.
    assert float(dataset.observation_equivalent_diameter[0]) == 8e-3
    assert np.isfinite(dataset.hole_diameter_by_law_at_observation).any()
    materials = json.loads(dataset.attrs["materials"])
    assert materials["copper-ofhc"]["numbers"]["strength.A"]["source"]
