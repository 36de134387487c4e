"""The tutorial notebook: its cells run in order, in one interpreter and an empty folder, and say what the text says."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).parents[2] / "docs" / "tutorial.ipynb"
CHECKS = """
assert float(cube.hole_diameter.isel(speed=1)) > float(cube.hole_diameter.isel(speed=0)) > 8e-3
assert all("under_resolved" in flags for flags in whipple.flag_words(cube.run_flags))
assert len(laws[inside]) >= 1
"""


@pytest.mark.claim("docs", "tutorial", minutes=0.3)
def test_tutorial__runs_cell_by_cell_and_its_text_holds(tmp_path: Path) -> None:
    """The tutorial's cells run in order in an empty folder, and its text holds."""
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    program = "\n".join(["import matplotlib; matplotlib.use('Agg')", *code, CHECKS])
    done = subprocess.run(
        [sys.executable, "-W", "error::FutureWarning", "-c", program],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "tutorial" / "report.html").is_file()


def test_tutorial__is_stored_without_output() -> None:
    for cell in json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]:
        assert not cell.get("outputs"), "clear the outputs: they belong to one machine"
