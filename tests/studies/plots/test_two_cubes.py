"""Two cubes beside each other: the points and panels that both have, whatever each sweep varies."""

from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from studies.cubes import cube
from tests.service.support.command import run
from tests.studies.support.sized import CRATERS, HOLES, sized_cube

THREE_PLATES = {**HOLES, "name": "three plates"}
SOME_SPEEDS = {"speed": ["3 km/s", "4 km/s", "9 km/s"]}


def one_plate(thickness: str, **fixed: Any) -> dict[str, Any]:
    fixed = {**HOLES["fixed"], "plate_thickness": thickness, **fixed}
    return {**HOLES, "name": "one plate", "fixed": fixed, "axes": SOME_SPEEDS}


def written(folder: Path, document: dict[str, Any], quantity: str = "hole_diameter", times: float = 2.0) -> Path:
    folder.mkdir()
    dataset = sized_cube(document, lambda shot: times * shot.projectile_diameter, quantity)
    cube.write(dataset, folder / "cube.nc")
    return folder


def test_two_cubes__are_drawn_together_and_compared_where_they_overlap(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One varies the thickness of the plate, and the other fixes it."""
    first = written(tmp_path / "first", THREE_PLATES)
    second = written(tmp_path / "second", one_plate("2 mm", courant=0.2), times=2.5)
    assert run("plot", first, second, "--out", tmp_path / "out", "--format", "svg") == 0
    printed = capsys.readouterr().out
    assert "courant 0.3 / courant 0.2" in printed
    assert "+25.0%" in printed
    table = pd.read_csv(tmp_path / "out" / "differences.csv")
    assert table[["speed", "plate_thickness"]].to_numpy().tolist() == [[3e3, 2e-3], [4e3, 2e-3]]
    assert table["three plates"].tolist() == pytest.approx([0.01, 0.01])
    assert table["one plate"].tolist() == pytest.approx([0.0125, 0.0125])
    drawn = (tmp_path / "out" / "hole_diameter_two_cubes.svg").read_text()
    assert "<!-- three plates -->" in drawn
    assert "<!-- one plate -->" in drawn
    assert "3 mm" not in drawn


@pytest.mark.parametrize(
    ("document", "quantity", "limit"),
    [
        (CRATERS, "crater_depth", "a quantity that both cubes have"),
        (
            {**one_plate("2 mm", speed="3 km/s"), "axes": {"courant": [0.2, 0.3]}},
            "hole_diameter",
            "an axis that both cubes have",
        ),
        (one_plate("1.5 mm"), "hole_diameter", "points or series that both cubes have"),
    ],
)
def test_two_cubes__without_anything_in_common_are_refused(
    document: dict[str, Any], quantity: str, limit: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first = written(tmp_path / "first", THREE_PLATES)
    second = written(tmp_path / "second", {**document, "name": "others"}, quantity)
    assert run("plot", first, second, "--out", tmp_path / "out") == 2
    printed = capsys.readouterr().err
    assert limit in printed
    assert "'three plates and others'" in printed
