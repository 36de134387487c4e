"""The notebooks: cells run in order, in one interpreter and an empty folder, and say what the text says."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
TUTORIAL = """
assert float(cube.hole_diameter.isel(speed=1)) > float(cube.hole_diameter.isel(speed=0)) > 8e-3
assert (cube.hole_diameter_uncertainty < 0.06 * cube.hole_diameter).all()
assert not any(whipple.flag_words(cube.run_flags))
assert len(laws[inside]) >= 1
"""
CUBE = """
assert set(cube.children) == {"laws", "quantities", "runs", "inputs"}
assert both.hole_diameter.dims == ("speed", "plate_thickness") and both.hole_diameter.notnull().all()
assert merged.measured.count() == 1 and flags.under_resolved.all()
"""


@pytest.mark.parametrize(
    ("name", "checks"),
    [
        pytest.param("tutorial", TUTORIAL, marks=pytest.mark.claim("docs", "tutorial", minutes=0.3)),
        pytest.param("cube", CUBE, marks=pytest.mark.claim("contract", "ten-things", minutes=0.7)),
    ],
)
def test_notebook__runs_cell_by_cell_and_its_text_holds(name: str, checks: str, tmp_path: Path) -> None:
    """The cells of a notebook (tutorial; a cube in xarray) run in order in an empty folder, and its text holds."""
    cells = json.loads((DOCS / f"{name}.ipynb").read_text(encoding="utf-8"))["cells"]
    assert not any(cell.get("outputs") for cell in cells), "clear the outputs: they belong to one machine"
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    program = "\n".join(["import matplotlib; matplotlib.use('Agg')", *code, checks])
    done = subprocess.run(
        [sys.executable, "-W", "error::FutureWarning", "-c", program],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert [*tmp_path.glob("*/report.html")]
