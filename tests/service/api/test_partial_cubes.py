"""Partial cubes over HTTP, made by a child process within limits; cubes opened over HTTP."""

import itertools
import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from service.api.errors import PartialCubeFailed
from service.api.partial_cubes import MOST_FILES, PartialCubes
from service.records.jobs import Lease, Result
from studies.cubes import cube
from studies.reports.publish import outcome_from_json
from studies.sweeps.sweep import Sweep
from studies.values.results import Measured, RunResult
from tests.service.support.api import FILES, SWEEP, Api, open_api

FRESH = itertools.count(4000)  # m/s, speeds that no run has yet


def answer_of(run_id: str, hole: float) -> dict[str, Any]:
    """What a run that measured this hole leaves."""
    measured = Measured(hole, 1e-4, {"growth": 1e-4}, (), {"time": [0.0], "value": [hole]}, 1)
    return RunResult(run_id, "succeeded", measurements={"hole_diameter": measured}).as_json()


def hole_at(speed: Any) -> float:
    """What the runs of these tests measure."""
    return 2.5e-6 * float(speed)


def finish(api: Api, claim: Lease) -> None:
    """Register the result of a run as a real one would be."""
    content = json.dumps(answer_of(claim.id, hole_at(claim.spec["parameters"]["speed"]))).encode()
    plain = vars(api.result(claim.id))
    stored = api._stored(f"{claim.id}/result.json", content)
    api.store.finish(claim, Result(**{**plain, "files": (stored,)}))


@pytest.fixture(scope="module")
def api(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Api]:
    with open_api(tmp_path_factory.mktemp("cubes")) as opened:
        yield opened


@pytest.fixture(scope="module")
def published(api: Api, tmp_path_factory: pytest.TempPathFactory) -> str:
    """The address of a sweep with a real cube."""
    id = api.submit()
    folder = tmp_path_factory.mktemp("published")
    term = api.term()
    for claim in api.store.lease(10, term):
        finish(api, claim)
    [claim] = api.store.lease(10, term)
    sweep = Sweep.parse(SWEEP)
    answers = {
        point.run.id: outcome_from_json(answer_of(point.run.id, hole_at(point.coordinates["speed"])))
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
    running: Lease

    @property
    def address(self) -> str:
        return f"/v1/sweeps/{self.id}"


@pytest.fixture
def half(api: Api, published: str) -> Half:
    api.compute()  # what other tests left in the queue
    id = api.submit(axes={"speed": [f"{next(FRESH)} m/s", f"{next(FRESH)} m/s"]})
    first, second = api.store.lease(2, api.term())
    finish(api, first)
    return Half(api, id, second)


def test_partial_cube__has_what_there_is_and_says_so(half: Half, tmp_path: Path) -> None:
    api, here = half.api, half.address
    assert api.http.get(f"{here}/cube.nc").status_code == 409
    response = api.http.get(f"{here}/cube.nc?partial=true")
    assert response.status_code == 200, response.text
    assert "partial" in response.headers["Content-Disposition"]
    (tmp_path / "partial.nc").write_bytes(response.content)
    with xr.open_dataset(tmp_path / "partial.nc") as opened:
        flags = opened.run_state.attrs["flag_meanings"].split()
        states = [flags[int(state)] for state in opened.run_state]
        assert sorted(states) == ["running", "succeeded"]
        done = opened.run_state.values == flags.index("succeeded")
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


def test_partial_cube__that_cannot_be_made_is_a_500_with_the_request_id(half: Half) -> None:
    api, here = half.api, half.address
    api.store.finish(half.running, api.result(half.running.id))  # its result is "{}"
    response = api.http.get(f"{here}/cube.nc?partial=true")
    assert response.status_code == 500
    assert "request_id" in response.json()["detail"]
    assert str(api.settings.data) not in response.text


@pytest.mark.parametrize(("limit", "message"), [({"seconds": 0}, "0 s"), ({"memory": 1 << 26}, "log")])
def test_partial_cube__beyond_a_limit_is_refused_and_leaves_no_file(
    tmp_path: Path, limit: dict[str, int], message: str
) -> None:
    cubes = PartialCubes(tmp_path / "cache", **limit)
    with pytest.raises(PartialCubeFailed, match=message):
        cubes.file(SWEEP, [], tmp_path, "running")
    assert not list((tmp_path / "cache").iterdir())


class EmptyPartialCubes(PartialCubes):
    """Writes an empty file in place of each cube."""

    def _run_child(self, file: Path, inputs: str) -> None:
        file.touch()


def test_partial_cubes__that_were_used_last_are_kept(tmp_path: Path) -> None:
    folder = tmp_path / "cache"
    folder.mkdir()
    for number in range(MOST_FILES + 5):
        (folder / f"{number}.nc").touch()
        os.utime(folder / f"{number}.nc", (number, number))
    made, _ = EmptyPartialCubes(folder).file(SWEEP, [], tmp_path, "running")
    kept = {file.name for file in folder.iterdir()}
    assert made.name in kept
    assert len(kept) == MOST_FILES
    assert f"{MOST_FILES + 4}.nc" in kept
    assert "0.nc" not in kept


# --- from afar --------------------------------------------------------------------------------------
