"""``whipple continue``: what was still growing at its latest end gets a later one, and nothing else is computed."""

import json
from pathlib import Path

import pytest

from service.cli.local import STORE_OF_FOLDER
from studies.cubes import cube
from studies.cubes.opening import whole_cube
from studies.quantities.files import CUBE
from studies.quantities.findings import InvalidInput
from studies.sweeps.sweep import Sweep
from tests.cases.cubes import computed
from tests.service.support.command import run

SOLVING = "tests.service.support.solving"  # the solver, and reports without figures

SLOW, FAST = "1 km/s", "3 km/s"  # the crater of the slow projectile settles after 16 us, that of the fast after 21 us
DOCUMENT = {
    "name": "craters",
    "scenario": "thick_plate",
    "fixed": {
        **{"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": "5 mm"},
        **{"target_depth": "30 mm", "target_radius": "25 mm", "end_time": "18 us"},
    },
    "axes": {"speed": [SLOW, FAST]},
    "resolution": 4,
}


@pytest.mark.claim("cube", "continue", minutes=0.3)
def test_continue__computes_what_was_growing_with_twice_its_latest_end(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """`whipple continue` gives a later end to the runs that were still growing, and to no others."""
    out = tmp_path / "out"
    (out / STORE_OF_FOLDER).mkdir(parents=True)
    before = computed(DOCUMENT, tmp_path)
    cube.write(before, out / CUBE)
    monkeypatch.setenv("WHIPPLE_TARGETS_MODULE", SOLVING)
    assert before.stop_reason.values.tolist() == ["settled", "end_time"]
    assert run("continue", out, "-o", tmp_path / "later.json") == 0
    later = json.loads((tmp_path / "later.json").read_text())
    assert later["ends"] == [{"speed": FAST, "end_time": "36 us"}]
    assert run("continue", out) == 0
    after = whole_cube(out)
    assert json.loads(after.attrs["sweep"]) == later
    assert after.stop_reason.values.tolist() == ["settled", "settled"]
    assert after.end_time.values.tolist() == pytest.approx([18e-6, 36e-6])
    assert after.run_id[0] == before.run_id[0]
    # The other is the run of any sweep that ends then.
    ordinary = {**DOCUMENT, "fixed": {**DOCUMENT["fixed"], "end_time": "36 us"}}  # type: ignore[dict-item]
    assert after.run_id[1].item() == Sweep.parse(ordinary).runs()[1].run.id
    capsys.readouterr()
    assert run("continue", out) == 0
    assert "no run was still growing" in capsys.readouterr().out


def test_continue__wants_the_folder_of_a_sweep(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("continue", tmp_path) == 2
    assert "whipple sweep --out" in capsys.readouterr().err


def test_ends__are_read_as_they_are_written() -> None:
    sweep = Sweep.parse({**DOCUMENT, "ends": [{"speed": "3000 m/s", "end_time": "0.036 ms"}]})
    assert sweep.document()["ends"] == [{"speed": "3 km/s", "end_time": "36 us"}]
    assert Sweep.parse(sweep.document()) == sweep
    assert [point.run.parameters["end_time"] for point in sweep.runs()] == [18e-6, 36e-6]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ends": [{"speed": "4 km/s", "end_time": "36 us"}]}, "stand on the axes"),
        ({"ends": [{"end_time": "36 us"}]}, "give speed, end_time"),
        ({"ends": [{"speed": FAST, "end_time": "36 mm"}]}, "mm"),
        ({"fixed": {}, "axes": {"end_time": ["18 us"]}, "ends": [{"end_time": "36 us"}]}, "a parameter and no axis"),
    ],
)
def test_ends__are_refused_where_they_are_of_no_point(changes: dict[str, object], message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        Sweep.parse({**DOCUMENT, **changes})
