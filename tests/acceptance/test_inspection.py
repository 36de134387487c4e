"""What the drills look for afterwards is seen where it is."""

import json
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from service.api.app import CACHE
from service.files.artifacts import Artifacts, describe
from service.records.jobs import Lease, Stored, Submission
from service.store import Store
from studies.values.files import RESULT
from tests.acceptance.support.inspection import damaged, differences, half_files
from tests.service.support.fakes import sweep_of
from tests.service.support.rows import lease_runs, result

ANSWERED = json.dumps({"state": "succeeded"}).encode()


@dataclass(frozen=True)
class Site:
    """A run with a result, and one that is under way."""

    store: Store
    artifacts: Artifacts
    done: Lease
    running: Lease

    def folder(self, claim: Lease) -> Path:
        return self.artifacts.attempt_directory(claim)

    def registered(self, file: Path) -> Stored:
        return replace(describe(file), path=self.artifacts.relative(file))


@pytest.fixture
def site(tmp_path: Path) -> Iterator[Site]:
    url = f"sqlite:///{tmp_path / 'whipple.db'}"
    with closing(Store.open(url, cost=lambda run: 1.0)) as store:
        store.create_sweep(Submission(sweep_of(2)))
        found = Site(store, Artifacts(tmp_path), *lease_runs(store, 2))
        file = write(found.folder(found.done) / RESULT, ANSWERED)
        assert store.finish(found.done, replace(result(), files=(found.registered(file),)))
        yield found


def write(file: Path, content: bytes) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(content)
    return file


def arrays(folder: Path) -> bytes:
    """What a file of arrays holds."""
    file = folder / "arrays.npz"
    np.savez(file, density=np.arange(100.0))
    content = file.read_bytes()
    file.unlink()
    return content


def half(content: bytes) -> bytes:
    return content[: len(content) // 2]


def test_half_files__are_none_where_all_are_whole(site: Site, tmp_path: Path) -> None:
    write(site.artifacts.checkpoint(site.running.id), arrays(tmp_path))
    write(site.folder(site.running) / "state.npz", arrays(tmp_path))
    write(site.folder(site.running) / RESULT, ANSWERED)
    write(site.folder(site.running) / "log.txt", b"step 1\nst")
    write(site.artifacts.root / CACHE / "7.json", ANSWERED)
    assert half_files(site.store, site.artifacts) == []


def test_half_files__of_an_attempt_without_an_answer_are_its_own(
    site: Site, tmp_path: Path
) -> None:
    write(site.folder(site.running) / "state.npz", half(arrays(tmp_path)))
    write(site.folder(site.running) / ".result.json.x.part", half(ANSWERED))
    assert half_files(site.store, site.artifacts) == []


@pytest.mark.parametrize("share", [0, 10, 200])
def test_checkpoint__that_cannot_be_read_is_a_half_file(
    site: Site, tmp_path: Path, share: int
) -> None:
    file = write(site.artifacts.checkpoint(site.running.id), arrays(tmp_path)[:share])
    assert half_files(site.store, site.artifacts) == [str(file)]


def test_answer__of_an_attempt_under_way_that_cannot_be_read_is_a_half_file(site: Site) -> None:
    file = write(site.folder(site.running) / RESULT, half(ANSWERED))
    assert half_files(site.store, site.artifacts) == [str(file)]


def test_state__beside_a_complete_answer_that_cannot_be_read_is_a_half_file(
    site: Site, tmp_path: Path
) -> None:
    write(site.folder(site.running) / RESULT, ANSWERED)
    file = write(site.folder(site.running) / "state.npz", half(arrays(tmp_path)))
    assert half_files(site.store, site.artifacts) == [str(file)]


def test_file__beside_a_registered_one_that_cannot_be_read_is_a_half_file(
    site: Site, tmp_path: Path
) -> None:
    file = write(site.folder(site.done) / "film.npz", half(arrays(tmp_path)))
    assert half_files(site.store, site.artifacts) == [str(file)]


def test_file__that_was_registered_before_it_was_whole_is_a_half_file(site: Site) -> None:
    file = write(site.folder(site.running) / RESULT, half(ANSWERED))
    stored = site.registered(file)
    assert site.store.finish(site.running, replace(result(), files=(stored,)))
    assert damaged(site.store, site.artifacts) == []  # it is what its row says
    assert half_files(site.store, site.artifacts) == [str(file)]


@pytest.mark.parametrize("content", [b"\x89HDF and no more", b'{"a": [1,', b""])
def test_part_of_a_cube__that_cannot_be_read_is_a_half_file(site: Site, content: bytes) -> None:
    file = write(site.artifacts.root / CACHE / "7.nc", content)
    assert half_files(site.store, site.artifacts) == [str(file)]


# --- cubes ----------------------------------------------------------------------------------------


def cube(file: Path, *, masses: list[float], reasons: list[str]) -> Path:
    """A cube of two speeds."""
    variables = {"mass": ("speed", masses), "run_reason": ("speed", reasons)}
    xr.Dataset(variables, {"speed": [1.0, 2.0]}).to_netcdf(file)
    return file


def test_differences__of_a_part_are_those_of_all_its_variables_alone(tmp_path: Path) -> None:
    one = cube(tmp_path / "1.nc", masses=[1.0, 2.0], reasons=["", ""])
    other = cube(tmp_path / "2.nc", masses=[1.5, 2.0], reasons=["out of memory", ""])
    assert list(differences(one, other)) == ["mass", "run_reason"]
    assert list(differences(one, other, at={"speed": [1.0]})) == ["mass", "run_reason"]
    assert list(differences(one, other, at={"speed": [2.0]})) == []
