"""The inspection after a crash test finds what is wrong, and nothing else."""

import io
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
class InspectedStore:
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
def site(tmp_path: Path) -> Iterator[InspectedStore]:
    url = f"sqlite:///{tmp_path / 'whipple.db'}"
    with closing(Store.open(url, cost=lambda run: 1.0)) as store:
        store.create_sweep(Submission(sweep_of(2)))
        site = InspectedStore(store, Artifacts(tmp_path), *lease_runs(store, 2))
        file = write(site.folder(site.done) / RESULT, ANSWERED)
        assert store.finish(site.done, replace(result(), files=(site.registered(file),)))
        yield site


def write(file: Path, content: bytes) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(content)
    return file


def whole_arrays() -> bytes:
    """The content of a file of arrays."""
    content = io.BytesIO()
    np.savez(content, density=np.arange(100.0))
    return content.getvalue()


ARRAYS = whole_arrays()
HALF_ARRAYS, HALF_ANSWER = ARRAYS[: len(ARRAYS) // 2], ANSWERED[: len(ANSWERED) // 2]


def test_half_files__are_none_where_all_are_whole_or_of_an_attempt_without_answer(site: InspectedStore) -> None:
    write(site.folder(site.running) / "state.npz", HALF_ARRAYS)
    write(site.folder(site.running) / ".result.json.x.part", HALF_ANSWER)
    assert half_files(site.store, site.artifacts) == []
    (site.folder(site.running) / ".result.json.x.part").unlink()
    write(site.artifacts.checkpoint(site.running.id), ARRAYS)
    write(site.folder(site.running) / "state.npz", ARRAYS)
    write(site.folder(site.running) / RESULT, ANSWERED)
    write(site.folder(site.running) / "log.txt", b"step 1\nst")
    write(site.artifacts.root / CACHE / "7.json", ANSWERED)
    assert half_files(site.store, site.artifacts) == []


@pytest.mark.parametrize(
    ("place", "content"),
    [
        *(("{run}/checkpoint.npz", ARRAYS[:size]) for size in (0, 10, 200)),
        ("{running}/result.json", HALF_ANSWER),
        ("{answered}/state.npz", HALF_ARRAYS),  # beside a complete answer
        ("{done}/film.npz", HALF_ARRAYS),  # beside a registered file
        *((CACHE + "/7.nc", content) for content in (b"\x89HDF and no more", b'{"a": [1,', b"")),
    ],
)
def test_half_file__that_could_be_used_or_shown_is_listed(site: InspectedStore, place: str, content: bytes) -> None:
    running, done = site.folder(site.running), site.folder(site.done)
    if "{answered}" in place:
        write(running / RESULT, ANSWERED)
    path = place.format(run=running.parent, running=running, answered=running, done=done)
    file = write(site.artifacts.root / path, content)
    assert half_files(site.store, site.artifacts) == [str(file)]


def test_file__that_was_registered_before_it_was_whole_is_a_half_file(site: InspectedStore) -> None:
    file = write(site.folder(site.running) / RESULT, HALF_ANSWER)
    stored = site.registered(file)
    assert site.store.finish(site.running, replace(result(), files=(stored,)))
    assert damaged(site.store, site.artifacts) == []  # it is what its row says
    assert half_files(site.store, site.artifacts) == [str(file)]


# --- cubes ----------------------------------------------------------------------------------------


def cube(file: Path, *, masses: list[float], reasons: list[str]) -> Path:
    """A cube of two speeds."""
    variables = {"mass": ("speed", masses), "run_reason": ("speed", reasons)}
    xr.Dataset(variables, {"speed": [1.0, 2.0]}).to_netcdf(file)
    return file


def test_differences__of_a_part_are_those_of_all_its_variables_alone(tmp_path: Path) -> None:
    first = cube(tmp_path / "1.nc", masses=[1.0, 2.0], reasons=["", ""])
    second = cube(tmp_path / "2.nc", masses=[1.5, 2.0], reasons=["out of memory", ""])
    assert list(differences(first, second)) == ["mass", "run_reason"]
    assert list(differences(first, second, at={"speed": [1.0]})) == ["mass", "run_reason"]
    assert list(differences(first, second, at={"speed": [2.0]})) == []
