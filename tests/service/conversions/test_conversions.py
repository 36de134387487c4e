"""Files over HTTP that a child process makes within limits: partial cubes, and results for other programs."""

import io
import json
import os
import re
import zipfile
from collections.abc import Callable
from dataclasses import replace
from itertools import count
from pathlib import Path
from subprocess import CompletedProcess
from typing import Any, get_args
from unittest.mock import AsyncMock

import anyio
import numpy as np
import pytest
import xarray as xr

from service.api.errors import Busy, ConversionFailed
from service.api.turns import Places, Turn
from service.client.client import Client
from service.conversions.conversions import MOST_FILES, Conversions, FileInputs, MadeFile
from service.files.artifacts import Artifacts, describe
from service.films.routes import FilmField
from service.records.jobs import Kind, Lease, Stored
from studies.cubes import cube
from studies.cubes.opening import whole_cube
from studies.films.film import SCALARS
from studies.quantities.measured import Measured
from studies.runs.execution import execute
from studies.runs.results import RunResult
from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.service.support.api import SWEEP, Api, served, sweep_of
from tests.service.support.fakes import DEADLINE
from tests.studies.runs.solved import asked
from tests.studies.support import fakes

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
    return whole_cube(folder / "partial.nc")


def test_partial_cube__has_the_results_so_far_and_says_so(api: Api, tmp_path: Path) -> None:
    file = f"/v1/sweeps/{api.submit()}/cube.nc"
    partial = f"{file}?partial=true"
    refused = api.http.get(partial)
    assert refused.status_code == 409
    assert "none of its runs" in refused.json()["detail"]
    first, _ = api.store.leases.take(2, api.term())
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
    # The same results are the same file.
    assert api.http.get(partial).headers["ETag"] == response.headers["ETag"]


@pytest.mark.claim("pages", "partial-cube-of-others", minutes=0.1)
def test_partial_cube__of_other_or_damaged_results_is_another(api: Api, tmp_path: Path) -> None:
    """A partial cube is made anew after another result, or where one or the file is damaged, and says which."""
    partial = f"/v1/sweeps/{api.submit()}/cube.nc?partial=true"
    first, second = api.store.leases.take(2, api.term())
    finish(api, first)
    tag = api.http.get(partial).headers["ETag"]
    [made] = (api.settings.data / "cache").glob("*.nc")
    made.write_bytes(b"damaged")
    assert opened(api.http.get(partial).content, tmp_path).attrs["sweep_state"] == "running, 1 of 2 runs have a result"
    finish(api, second)
    (api.settings.data / api.store.runs.file(first.id, "result.json").path).write_bytes(b"damaged")
    response = api.http.get(partial)
    assert response.headers["ETag"] != tag
    assert any("damaged" in str(reason) for reason in opened(response.content, tmp_path).run_reason.values)


@pytest.mark.claim("pages", "report-so-far", minutes=0.2)
def test_report__of_the_results_so_far_says_that_it_is_not_complete(api: Api, compared: Compared) -> None:
    """The report of a sweep that has not ended is made on request, and its title says how far the sweep is."""
    report = f"/v1/sweeps/{api.submit()}/report.html"
    first, second = api.store.leases.take(2, api.term())
    compared(equal("status without a result", expected=409, got=api.http.get(f"{report}?partial=true").status_code))
    finish(api, first)
    response = api.http.get(f"{report}?partial=true")
    said = re.findall(r"<h1>.*?\((not complete: .*?)\)<", response.text)
    compared(equal("its title", expected=["not complete: running, 1 of 2 runs have a result"], got=said))
    policy = response.headers["Content-Security-Policy"]
    compared(equal("its scripts are in a sandbox", expected=True, got="sandbox allow-scripts" in policy))
    compared(equal("status as a whole", expected=409, got=api.http.get(report).status_code))
    finish(api, second)
    api.compute()
    compared(equal("at the end", expected=api.http.get(report).text, got=api.http.get(f"{report}?partial=true").text))


def test_partial_cube__that_cannot_be_made_is_a_500_with_the_request_id_and_at_the_end_is_the_cube(
    api: Api, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = f"/v1/sweeps/{api.submit()}/cube.nc"
    for lease in api.store.leases.take(2, api.term()):
        api.store.leases.finish(lease, api.result(lease.id))
    ended = CompletedProcess([], 1, b"", f"KeyError in {api.settings.data}".encode())  # how the child ends
    monkeypatch.setattr(anyio, "run_process", AsyncMock(return_value=ended))
    response = api.http.get(f"{file}?partial=true")
    assert response.status_code == 500
    assert "request_id" in response.json()["detail"]
    assert str(api.settings.data) not in response.text
    api.compute()
    assert api.http.get(f"{file}?partial=true").headers["ETag"] == api.http.get(file).headers["ETag"]


def turn(caller: str = "ann") -> Turn:
    """The turn of a request that waits for nobody else's."""
    return Turn(Places(8, 8), caller)


async def partial(files: Conversions, *, sweep: str = "1", caller: str = "ann", is_large: bool = False) -> MadeFile:
    """The results so far of a sweep of which they change with each request."""

    def gather() -> FileInputs:
        return {"document": SWEEP, "outcomes": [], "state": f"of {next(NUMBERS)}"}

    return await files.partial("partial.nc", sweep, gather, turn(caller), is_large=is_large)


NUMBERS = count()


@pytest.mark.parametrize(("limit", "message"), [({"seconds": 0}, "0 s"), ({"memory": 1 << 26}, "log")])
def test_partial_cube__beyond_a_limit_is_refused_and_leaves_no_file(
    tmp_path: Path, limit: dict[str, int], message: str
) -> None:
    cubes = Conversions(tmp_path / "cache", **limit)
    with pytest.raises(ConversionFailed, match=message):
        anyio.run(partial, cubes)
    assert not list((tmp_path / "cache").iterdir())


class EmptyFiles(Conversions):
    """Writes an empty file in place of each."""

    def __init__(self, folder: Path, **options: Any):
        super().__init__(folder, **options)
        self.made = 0

    async def _run_child(self, file: Path, inputs: str) -> None:
        self.made += 1
        file.touch()


def test_partial_cubes__that_were_used_last_are_kept(tmp_path: Path) -> None:
    folder = tmp_path / "cache"
    folder.mkdir()
    for number in range(MOST_FILES + 5):
        (folder / f"{number}.nc").touch()
        os.utime(folder / f"{number}.nc", (number, number))
    left = folder / ".0.zarr.zip.x1.part"  # by a child that was killed
    (left / "speed").mkdir(parents=True)
    os.utime(left, (0, 0))
    made = anyio.run(partial, EmptyFiles(folder)).path
    kept = {file.name for file in folder.iterdir()} - {f"{made.name}.sha256"}
    assert made.name in kept
    assert len(kept) == MOST_FILES
    assert not left.exists()
    assert f"{MOST_FILES + 4}.nc" in kept
    assert "0.nc" not in kept


def test_partial_cube__of_a_large_sweep_is_made_once_a_minute_and_says_its_age(tmp_path: Path) -> None:
    files = EmptyFiles(tmp_path)

    async def use() -> None:
        first = await partial(files, is_large=True)
        assert first.age is None
        again = await partial(files, is_large=True, caller="bob")
        assert (again.path, again.sha256) == (first.path, first.sha256)
        assert again.age is not None
        assert (await partial(files, is_large=True, sweep="2")).age is None
        assert files.made == 2
        later = EmptyFiles(tmp_path, part_seconds=0.0)
        for number in range(2):
            assert (await partial(later, is_large=True)).age is None
            assert later.made == 1 + number

    anyio.run(use)


class SlowFiles(EmptyFiles):
    """Writes an empty file once it may."""

    def __init__(self, folder: Path, **options: Any):
        super().__init__(folder, **options)
        self.may_end = anyio.Event()
        self.begun: list[str] = []

    async def _run_child(self, file: Path, inputs: str) -> None:
        self.begun.append(json.loads(inputs)["options"]["field"])
        await self.may_end.wait()
        await super()._run_child(file, inputs)


async def file(files: Conversions, caller: str, of: str) -> MadeFile:
    source = Stored("state.npz", "state.npz", 0, "")
    return await files.file("cloud.view", [source], Artifacts(Path("/nowhere")), turn(caller), field=of)


def test_files__are_made_for_each_caller_in_turn_and_the_same_one_once(tmp_path: Path) -> None:
    async def use() -> None:
        files = SlowFiles(tmp_path)
        async with anyio.create_task_group() as tasks:
            for caller, of in (*(("ann", f"film {n}") for n in range(4)), ("bob", "film 0"), ("cid", "cube")):
                tasks.start_soon(file, files, caller, of)
                await anyio.wait_all_tasks_blocked()
            await wait_for(lambda: len(files.begun) == 2)
            # Another film of ann waits for the first, the same film of bob for the file of ann.
            assert files.begun == ["film 0", "cube"]
            files.may_end.set()
        assert sorted(files.begun) == ["cube", *(f"film {n}" for n in range(4))]
        assert files.made == 5

    anyio.run(use)


def test_file__that_is_not_begun_in_time_is_refused(tmp_path: Path) -> None:
    async def use() -> None:
        files = SlowFiles(tmp_path, wait_seconds=0.05)
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(file, files, "ann", "film 0")
            await wait_for(lambda: files.begun)
            for caller, of in (("ann", "film 1"), ("bob", "film 0")):
                with pytest.raises(Busy):
                    await file(files, caller, of)
            files.may_end.set()
        assert files.made == 1

    anyio.run(use)


async def wait_for(condition: Callable[[], object]) -> None:
    with anyio.fail_after(DEADLINE):
        while not condition():
            await anyio.sleep(0.001)


def with_files(api: Api) -> tuple[str, str]:
    """A sweep and its run, with the files of a real run and of a real cube."""
    id = api.submit(**sweep_of(axes={"speed": ["5 km/s"]}))
    for lease in iter(lambda: next(iter(api.store.leases.take(1, api.term())), None), None):
        folder = api.settings.data / lease.id
        folder.mkdir(exist_ok=True)
        if lease.kind is Kind.RUN:
            run, ended = lease.id, api.result(lease.id)
            execute(asked("thin_plate"), folder, threads=1, film=True)
            files = [replace(describe(file), path=f"{run}/{file.name}") for file in sorted(folder.iterdir())]
            api.store.leases.finish(lease, replace(ended, files=tuple(files)))
        else:
            file = describe(cube.write(fakes.cube_of(fakes.holes()), folder / "cube.nc"))
            api.store.leases.publish(lease, [replace(file, path=f"{lease.id}/cube.nc")], seconds=0.1)
    return id, run


@pytest.mark.claim("pages", "conversions", minutes=0.5)
def test_conversions__of_a_run_and_a_cube_are_what_their_programs_open(
    api: Api, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Over REST a run is VTK and GIF, and a cube is Zarr; without an extra the service says what it lacks."""
    id, run = with_files(api)
    vtk = api.http.get(f"/v1/runs/{run}/vtk.zip")
    assert vtk.status_code == 200, vtk.text
    with zipfile.ZipFile(io.BytesIO(vtk.content)) as opened:
        assert {"film.pvd", "film-000.vtu", "state.vtu", "departed.vtu"} < set(opened.namelist())
        assert b"UNITS_LABEL" in opened.read("state.vtu")
    assert api.http.get(f"/v1/runs/{run}/vtk.zip").headers["ETag"] == vtk.headers["ETag"]
    speed, pressure = (
        api.http.get(f"/v1/runs/{run}/film.gif?field={field}").content for field in ("speed", "pressure")
    )
    assert speed[:6] == pressure[:6] == b"GIF89a"
    assert speed != pressure
    with served(api) as url, Client(url) as client:
        assert client.run(run).film("pressure").gif == pressure
        assert client.sweep(id).plot().names[0] == "hole_diameter_laws"
    (tmp_path / "cube.zarr.zip").write_bytes(api.http.get(f"/v1/sweeps/{id}/cube.zarr.zip").content)
    stored = api.settings.data / api.store.sweeps.get_with_file(id, "cube.nc")[1].path  # type: ignore[union-attr]
    with zipfile.ZipFile(tmp_path / "cube.zarr.zip") as opened, xr.open_datatree(stored) as written:
        opened.extractall(tmp_path / "cube.zarr")
        with xr.open_datatree(tmp_path / "cube.zarr", engine="zarr") as read:
            xr.testing.assert_identical(read.load(), written.load())
    (tmp_path / "zarr.py").write_text("raise ImportError('no zarr here')")
    monkeypatch.syspath_prepend(tmp_path)
    for file in (api.settings.data / "cache").iterdir():
        file.unlink()
    lacking = api.http.get(f"/v1/sweeps/{id}/cube.zarr.zip")
    assert lacking.status_code == 501
    assert "whipple[zarr]" in lacking.json()["detail"]


def test_conversions__of_what_was_not_kept_or_is_no_field_are_refused(api: Api) -> None:
    api.submit()
    api.compute()
    [point, _] = api.store.sweeps.points(api.http.get("/v1/sweeps").json()["items"][0]["id"]).items
    for name in ("vtk.zip", "film.gif"):
        assert api.http.get(f"/v1/runs/{point.run.id}/{name}").status_code == 404
    assert api.http.get(f"/v1/runs/{point.run.id}/film.gif?field=colour").status_code == 422
    assert api.http.get(f"/v1/runs/{point.run.id}/film.mp4").status_code == 404
    assert get_args(FilmField) == SCALARS
