"""Partial cubes over HTTP, made by a child process within limits."""

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from service.api.conversions import MOST_FILES, Conversions
from service.api.errors import ConversionFailed
from service.records.jobs import Lease
from studies.quantities.measured import Measured
from studies.runs.results import RunResult
from tests.service.support.api import SWEEP, Api

HOLE = 0.0148  # m


def finish(api: Api, lease: Lease) -> None:
    """Register the result of a run as a real one would be."""
    measured = Measured(HOLE, 1e-4, {"growth": 1e-4}, (), {"time": [0.0], "value": [HOLE]}, 1)
    result = RunResult(lease.id, "succeeded", measurements={"hole_diameter": measured}).as_json()
    plain = api.result(lease.id)
    stored = api._stored(f"{lease.id}/result.json", json.dumps(result).encode())
    api.store.leases.finish(lease, replace(plain, files=(stored,)))


def opened(content: bytes, folder: Path) -> xr.Dataset:
    (folder / "partial.nc").write_bytes(content)
    return xr.load_dataset(folder / "partial.nc")


def test_partial_cube__has_the_results_so_far_and_says_so(api: Api, tmp_path: Path) -> None:
    file = f"/v1/sweeps/{api.submit()}/cube.nc"
    partial = f"{file}?partial=true"
    refused = api.http.get(partial)
    assert refused.status_code == 409
    assert "none of its runs" in refused.json()["detail"]
    first, second = api.store.leases.take(2, api.term())
    finish(api, first)
    assert api.http.get(file).status_code == 409
    response = api.http.get(partial)
    assert response.status_code == 200, response.text
    assert "partial" in response.headers["Content-Disposition"]
    cube = opened(response.content, tmp_path)
    flags = cube.run_state.attrs["flag_meanings"].split()
    assert sorted(flags[int(state)] for state in cube.run_state) == ["running", "succeeded"]
    done = cube.run_state.values == flags.index("succeeded")
    assert np.isfinite(cube.hole_diameter.values).tolist() == done.tolist()
    assert cube.attrs["sweep_state"] == "running, 1 of 2 runs have a result"
    assert cube.attrs["comment"].startswith("Not complete")
    # The same results are the same file; others, or damaged ones, are another.
    tag = response.headers["ETag"]
    assert api.http.get(partial).headers["ETag"] == tag
    finish(api, second)
    path = api.store.runs.get(first.id).path
    assert path is not None
    (api.settings.data / path).write_bytes(b"damaged")
    response = api.http.get(partial)
    assert response.headers["ETag"] != tag
    assert any("damaged" in str(reason) for reason in opened(response.content, tmp_path).run_reason.values)


def test_partial_cube__that_cannot_be_made_is_a_500_with_the_request_id_and_at_the_end_is_the_cube(api: Api) -> None:
    file = f"/v1/sweeps/{api.submit()}/cube.nc"
    for lease in api.store.leases.take(2, api.term()):
        api.store.leases.finish(lease, api.result(lease.id))  # "{}"
    response = api.http.get(f"{file}?partial=true")
    assert response.status_code == 500
    assert "request_id" in response.json()["detail"]
    assert str(api.settings.data) not in response.text
    api.compute()
    assert api.http.get(f"{file}?partial=true").headers["ETag"] == api.http.get(file).headers["ETag"]


@pytest.mark.parametrize(("limit", "message"), [({"seconds": 0}, "0 s"), ({"memory": 1 << 26}, "log")])
def test_partial_cube__beyond_a_limit_is_refused_and_leaves_no_file(
    tmp_path: Path, limit: dict[str, int], message: str
) -> None:
    cubes = Conversions(tmp_path / "cache", **limit)
    with pytest.raises(ConversionFailed, match=message):
        cubes.partial_cube(SWEEP, [], tmp_path, "running")
    assert not list((tmp_path / "cache").iterdir())


class EmptyFiles(Conversions):
    """Writes an empty file in place of each cube."""

    def _run_child(self, file: Path, inputs: str) -> None:
        file.touch()


def test_partial_cubes__that_were_used_last_are_kept(tmp_path: Path) -> None:
    folder = tmp_path / "cache"
    folder.mkdir()
    for number in range(MOST_FILES + 5):
        (folder / f"{number}.nc").touch()
        os.utime(folder / f"{number}.nc", (number, number))
    made, _ = EmptyFiles(folder).partial_cube(SWEEP, [], tmp_path, "running")
    kept = {file.name for file in folder.iterdir()}
    assert made.name in kept
    assert len(kept) == MOST_FILES
    assert f"{MOST_FILES + 4}.nc" in kept
    assert "0.nc" not in kept
