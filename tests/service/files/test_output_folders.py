"""What an output folder holds stays, unless the same sweep is asked again or it is to be replaced."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from service.cli.local import run_sweep
from service.client.client import Client
from service.files.output_folders import check_same, held_in
from studies.quantities.files import SWEEP_FILES
from studies.quantities.findings import InvalidInput
from studies.sweeps.sweep import Sweep
from tests.service.support.api import ALL_RUNS, FILES, SWEEP, Api, open_api, served, sweep_of
from tests.service.support.command import run
from tests.service.support.fakes import settings_in

FIXED: dict[str, Any] = SWEEP["fixed"]
SAME: dict[str, dict[str, Any]] = {
    "points added": {"axes": {"speed": ["3 km/s", "6 km/s", "7 km/s"]}},
    "points removed": {"axes": {"speed": ["6 km/s"]}},
    "another unit": {"fixed": {**FIXED, "plate_thickness": "0.002 m"}},
    "another name": {"name": "renamed", "title": "Renamed"},
}
ANOTHER: dict[str, tuple[dict[str, Any], str]] = {
    "scenario": ({"scenario": "thick_plate"}, "scenario: thick_plate"),
    "material": ({"fixed": {**FIXED, "target": "al-2024-t3"}}, "fixed.target: al-2024-t3"),
    "one more fixed": ({"fixed": {**FIXED, "friction": 0.1}}, "fixed.friction: 0.1"),
    "resolution": ({"resolution": 16}, "resolution: 16"),
    "resolutions": ({"resolution": [8, 16]}, "axes: resolution, speed"),
    "axis": ({"axes": {**SWEEP["axes"], "friction": [0, 0.1]}}, "axes: friction, speed"),
}


def document(**changes: Any) -> dict[str, Any]:
    """The canonical document of the sweep of the tests, changed."""
    given = sweep_of(**changes)
    if given["scenario"] == "thick_plate":
        given["fixed"] = {k: v for k, v in given["fixed"].items() if k != "plate_thickness"}
    return Sweep.parse(given).document()


@pytest.mark.parametrize("changes", SAME.values(), ids=list(SAME))
def test_same_sweep__may_go_on_in_its_folder(changes: dict[str, Any]) -> None:
    check_same(Path("out"), document(), document(**changes))


@pytest.mark.parametrize(("changes", "words"), ANOTHER.values(), ids=list(ANOTHER))
def test_another_sweep__is_refused_and_both_are_named(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(InvalidInput) as refused:
        check_same(Path("out"), document(), document(name="other", **changes))
    [finding] = refused.value.findings
    assert "out, which holds 'two-speeds'" in finding.value
    assert "'other'" in finding.limit
    assert words in finding.limit
    assert "--overwrite" in finding.cure


def test_held__is_what_the_report_says(tmp_path: Path) -> None:
    assert held_in(tmp_path) is None
    for unknown in ("", "[]", '{"provenance": 1}'):
        (tmp_path / "report.json").write_text(unknown)
        assert held_in(tmp_path) is None
    leave_report(tmp_path, document())
    assert held_in(tmp_path) == document()


def leave_report(folder: Path, held: dict[str, Any]) -> None:
    """The report of a sweep, as far as it says which one it is of."""
    folder.mkdir(exist_ok=True)
    (folder / "report.json").write_text(json.dumps({"provenance": {"sweep": held}}))


def test_run_sweep__into_the_folder_of_another_goes_by_its_store_and_replaces_on_request(tmp_path: Path) -> None:
    settings = settings_in(tmp_path / ".whipple", workers=1)
    asked = {**SWEEP, "axes": {"speed": ["3 km/s"]}}
    run_sweep(asked, tmp_path, settings=settings)
    first = (tmp_path / "cube.nc").read_bytes()
    other = {**asked, "name": "other", "resolution": 9}
    with pytest.raises(InvalidInput, match="'two-speeds'"):
        run_sweep(other, tmp_path, settings=settings)
    assert (tmp_path / "cube.nc").read_bytes() == first
    run_sweep(other, tmp_path, settings=settings, overwrite=True)
    assert (tmp_path / "cube.nc").read_bytes() != first
    with pytest.raises(InvalidInput, match="'other'"):
        run_sweep(asked, tmp_path, settings=settings)


@pytest.fixture
def api(tmp_path: Path) -> Iterator[Api]:
    with open_api(tmp_path / "data") as opened:
        yield opened


def test_fetch__refuses_the_folder_of_another_sweep_and_replaces_on_request(api: Api, tmp_path: Path) -> None:
    id, out = api.submit(), tmp_path / "out"
    api.compute()
    leave_report(out, document(name="first", resolution=16))
    with served(api) as url, Client(url) as client:
        with pytest.raises(InvalidInput, match="'first'"):
            client.sweep(id).fetch(out)
        assert [one.name for one in out.iterdir()] == ["report.json"]
        assert run("fetch", id, "--out", out, "--url", url) == 2
        assert run("fetch", id, "--out", out, "--url", url, "--overwrite") == 0
        leave_report(out, document(name="first"))
        client.sweep(id).fetch(out)  # the same sweep
        assert (out / "runs.csv").read_bytes() == FILES["runs.csv"]
        assert run("fetch", id, "--out", out, "--url", url, "--all") == 0
        assert (out / "runs.csv").read_bytes() == ALL_RUNS["runs-all.csv"]
    assert {file.name for file in out.iterdir()} == set(SWEEP_FILES)
