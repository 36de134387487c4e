"""Parts of a cube over HTTP: made in a process of their own, within limits, and kept a while."""

import itertools
import json
import os
import signal
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import psutil
import pytest
import xarray as xr

from service import slices
from service.jobs import Claim, Result
from studies import cube
from studies.publish import outcome_from_json
from studies.results import Measured, RunResult
from studies.sweep import Sweep
from tests.service.api import FILES, SWEEP, Api, open_api, served
from tests.service.doubles import is_gone, wait_until

FRESH = itertools.count(4000)  # m/s, speeds that no run has yet


def answer_of(run_id: str, hole: float) -> dict[str, Any]:
    """What a run that measured this hole leaves."""
    measured = Measured(hole, 1e-4, {"growth": 1e-4}, (), {"time": [0.0], "value": [hole]}, 1)
    return RunResult(run_id, "succeeded", measurements={"hole_diameter": measured}).as_json()


def hole_at(speed: Any) -> float:
    """What the runs of these tests measure."""
    return 2.5e-6 * float(speed)


def finish(api: Api, claim: Claim) -> None:
    """Register the result of a run as a real one would be."""
    content = json.dumps(answer_of(claim.id, hole_at(claim.spec["parameters"]["speed"]))).encode()
    plain = vars(api.result(claim.id))
    stored = api._stored(f"{claim.id}/result.json", content)
    api.store.finish(claim, Result(**{**plain, "files": (stored,)}))


@pytest.fixture(scope="module")
def api(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Api]:
    with open_api(tmp_path_factory.mktemp("slices")) as opened:
        opened.http.app.state.slices._seconds = 600.0  # type: ignore[attr-defined]
        yield opened


@pytest.fixture(scope="module")
def published(api: Api, tmp_path_factory: pytest.TempPathFactory) -> str:
    """The address of a sweep with a real cube."""
    id = api.submit()
    folder = tmp_path_factory.mktemp("published")
    epoch = api.epoch()
    for claim in api.store.claim(10, epoch):
        finish(api, claim)
    [claim] = api.store.claim(10, epoch)
    sweep = Sweep.parse(SWEEP)
    answers = {
        point.run.id: outcome_from_json(
            answer_of(point.run.id, hole_at(point.coordinates["speed"]))
        )
        for point in sweep.runs()
    }
    file = cube.write(cube.build(sweep, answers), folder / "cube.nc")
    contents = {**FILES, "cube.nc": file.read_bytes()}
    stored = [api._stored(f"{id}/{name}", content) for name, content in contents.items()]
    api.store.publish(claim, stored, seconds=0.1)
    return f"/v1/sweeps/{id}"


@dataclass(frozen=True)
class Half:
    """A sweep of which one run has ended, and the other is running."""

    api: Api
    id: str
    running: Claim

    @property
    def address(self) -> str:
        return f"/v1/sweeps/{self.id}"


@pytest.fixture
def half(api: Api, published: str) -> Half:
    api.compute()  # what other tests left in the queue
    id = api.submit(axes={"speed": [f"{next(FRESH)} m/s", f"{next(FRESH)} m/s"]})
    first, second = api.store.claim(2, api.epoch())
    finish(api, first)
    return Half(api, id, second)


def child_of(api: Api) -> psutil.Process | None:
    child = api.http.app.state.slices._child  # type: ignore[attr-defined]
    return None if child is None else psutil.Process(child.pid)


# --- slices -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("speed", ["6 km/s", "6000"])
def test_slice__is_the_value_at_a_point(api: Api, published: str, speed: str) -> None:
    response = api.http.get(f"{published}/slice", params={"speed": speed})
    assert response.status_code == 200, response.text
    assert response.headers["Content-Type"] == "application/json"
    part = response.json()
    assert part["coords"]["speed"] == {**part["coords"]["speed"], "unit": "m s-1", "values": 6e3}
    hole = part["variables"]["hole_diameter"]
    assert (hole["dims"], hole["unit"], hole["values"]) == ([], "m", hole_at(6000))
    assert part["variables"]["hole_diameter_uncertainty"]["values"] == 1e-4


def test_slice__is_netcdf_on_request(api: Api, published: str, tmp_path: Path) -> None:
    query = {"variable": "hole_diameter", "speed": "..5 km/s", "format": "nc"}
    response = api.http.get(f"{published}/slice", params=query)
    assert response.headers["Content-Type"] == "application/x-netcdf"
    assert response.headers["Content-Disposition"].startswith("attachment")
    (tmp_path / "part.nc").write_bytes(response.content)
    with xr.open_dataset(tmp_path / "part.nc") as part:
        assert part.hole_diameter.values.tolist() == [hole_at(3000)]


def test_slice__is_made_once_and_not_sent_twice(
    api: Api, published: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = api.http.get(f"{published}/slice?variable=hole_diameter&speed=3000")

    def fail(*_: Any) -> None:
        raise AssertionError("it is made already")

    monkeypatch.setattr(slices, "_line_from", fail)
    again = api.http.get(f"{published}/slice?speed=3000&variable=hole_diameter")
    assert again.content == first.content
    tag = {"If-None-Match": first.headers["ETag"]}
    unchanged = api.http.get(f"{published}/slice?variable=hole_diameter&speed=3000", headers=tag)
    assert unchanged.status_code == 304


@pytest.mark.parametrize(
    ("query", "field", "cure"),
    [
        ("variable=hole_diametr", "variable", "hole_diameter"),
        ("sped=3000", "sped", "speed"),
        ("speed=3100", "speed", ".."),
        ("speed=2 kg", "speed", "km/s"),
        ("format=xml", "query.format", ""),
        ("partial=perhaps", "query.partial", ""),
        ("speed=" + "1" * 300, "query", "range"),
        ("&".join(["speed=3000"] * 300), "query", "range"),
    ],
)
def test_slice__of_what_is_not_there_is_refused_with_a_cure(
    api: Api, published: str, query: str, field: str, cure: str
) -> None:
    response = api.http.get(f"{published}/slice?{query}")
    assert response.status_code == 422, response.text
    [error] = response.json()["errors"]
    assert error["field"] == field
    assert cure in error["cure"]


def test_slice__before_the_end_is_a_409_unless_partial(half: Half) -> None:
    api, here = half.api, half.address
    assert api.http.get(f"{here}/slice").status_code == 409
    part = api.http.get(f"{here}/slice?partial=true").json()
    assert part["sweep_state"] == "running, 1 of 2 runs have a result"
    values = part["variables"]["hole_diameter"]["values"]
    assert sorted(value is None for value in values) == [False, True]


def test_slice__of_a_damaged_cube_says_so(half: Half) -> None:
    api, here = half.api, half.address
    finish(api, half.running)
    api.compute()  # publishes a cube that is none
    response = api.http.get(f"{here}/slice")
    assert response.status_code == 500
    assert "request_id" in response.json()["detail"]
    assert str(api.settings.data) not in response.text
    stored = api.store.artifact(half.id, "cube.nc")
    (api.settings.data / stored.path).write_bytes(b"changed by hand")
    assert "damaged" in api.http.get(f"{here}/slice").json()["detail"]


# --- partial cubes ----------------------------------------------------------------------------------


def test_partial_cube__has_what_there_is_and_says_so(half: Half, tmp_path: Path) -> None:
    api, here = half.api, half.address
    assert api.http.get(f"{here}/cube.nc").status_code == 409
    response = api.http.get(f"{here}/cube.nc?partial=true")
    assert response.status_code == 200, response.text
    assert "partial" in response.headers["Content-Disposition"]
    (tmp_path / "partial.nc").write_bytes(response.content)
    with xr.open_dataset(tmp_path / "partial.nc") as opened:
        words = opened.run_state.attrs["flag_meanings"].split()
        states = [words[int(state)] for state in opened.run_state]
        assert sorted(states) == ["running", "succeeded"]
        done = opened.run_state.values == words.index("succeeded")
        assert np.isfinite(opened.hole_diameter.values).tolist() == done.tolist()
        assert opened.attrs["sweep_state"] == "running, 1 of 2 runs have a result"
        assert opened.attrs["comment"].startswith("Not complete")


def test_partial_cube__changes_with_what_there_is_and_not_before(half: Half) -> None:
    api, here = half.api, half.address
    first = api.http.get(f"{here}/cube.nc?partial=true").headers["ETag"]
    assert api.http.get(f"{here}/cube.nc?partial=true").headers["ETag"] == first
    finish(api, half.running)
    assert api.http.get(f"{here}/cube.nc?partial=true").headers["ETag"] != first


def test_partial_cube__of_a_sweep_that_has_ended_is_the_cube(api: Api, published: str) -> None:
    whole = api.http.get(f"{published}/cube.nc")
    partial = api.http.get(f"{published}/cube.nc?partial=true")
    assert partial.headers["ETag"] == whole.headers["ETag"]


def test_partial_cube__without_a_result_is_a_409(tmp_path: Path) -> None:
    with open_api(tmp_path) as api:
        response = api.http.get(f"/v1/sweeps/{api.submit()}/cube.nc?partial=true")
        assert response.status_code == 409
        assert "none of its runs" in response.json()["detail"]


def test_partial_cube__without_the_files_of_a_run_says_that(half: Half, tmp_path: Path) -> None:
    api, here = half.api, half.address
    for point in api.store.sweep_runs(half.id).items:
        if point.run.path is not None:
            (api.settings.data / point.run.path).write_bytes(b"damaged")
    response = api.http.get(f"{here}/cube.nc?partial=true")
    (tmp_path / "partial.nc").write_bytes(response.content)
    with xr.open_dataset(tmp_path / "partial.nc") as opened:
        assert any("damaged" in str(reason) for reason in opened.run_reason.values)


# --- the process ------------------------------------------------------------------------------------


def test_child__is_one_and_opens_the_datasets_of_all_requests(api: Api, published: str) -> None:
    with ThreadPoolExecutor(4) as pool:
        speeds = ["3000..", "..3000", "6000..", "..6000"]
        got = list(pool.map(lambda one: api.http.get(f"{published}/slice?speed={one}"), speeds))
    assert {response.status_code for response in got} == {200}
    child = child_of(api)
    assert child is not None
    libraries = Path(f"/proc/{child.pid}/maps").read_text().lower()
    assert "_netcdf4" in libraries


def test_child__that_was_killed_is_replaced(api: Api, published: str) -> None:
    api.http.get(f"{published}/slice?speed=3000..3001")
    child = child_of(api)
    assert child is not None
    os.kill(child.pid, signal.SIGKILL)
    wait_until(lambda: is_gone(child.pid))
    assert api.http.get(f"{published}/slice?speed=3000..3002").status_code == 200


def test_cache__makes_room_for_what_is_asked_for(
    api: Api, published: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(slices, "MOST_FILES", 3)
    for end in range(7000, 7006):
        assert api.http.get(f"{published}/slice?speed=..{end}").status_code == 200
    kept = list((api.settings.data / "cache").iterdir())
    assert len(kept) <= 3
    assert all(len(file.stem) == 64 for file in kept)


# --- from afar --------------------------------------------------------------------------------------


def test_remote_cube__is_opened_over_range_without_a_download(api: Api, published: str) -> None:
    import fsspec

    with served(api) as url:
        address = f"{url}{published}/cube.nc"
        size = int(httpx.head(address).headers["Content-Length"])
        with (
            fsspec.open(address, cache_type="blockcache", block_size=2**15) as file,
            xr.open_dataset(file, engine="h5netcdf") as opened,
        ):
            assert opened.hole_diameter.sel(speed=6e3).item() == hole_at(6000)
            assert file.size == size


def test_remote_cube__is_opened_with_a_key(api: Api, published: str) -> None:
    import fsspec

    from service.jobs import Scope

    _, secret = api.store.create_key("anna", [Scope.READ])
    headers = {"Authorization": f"Bearer {secret}"}
    with (
        served(api) as url,
        fsspec.open(f"{url}{published}/cube.nc", headers=headers) as file,
        xr.open_dataset(file, engine="h5netcdf") as opened,
    ):
        assert set(opened.hole_diameter.values) == {hole_at(3000), hole_at(6000)}
