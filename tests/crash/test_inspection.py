"""The inspection after a crash test finds what is wrong, and nothing else."""

import io
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from service.conversions.routes import CACHE
from service.files.artifacts import Artifacts, describe
from service.records.jobs import Lease, Submission
from service.store import Store
from studies.quantities.files import RESULT
from tests.service.support.fakes import sweep_of
from tests.service.support.inspection import differences, half_files
from tests.service.support.rows import lease_runs, result

ANSWER = b'{"state": "succeeded"}'
ARRAYS = io.BytesIO()
np.savez(ARRAYS, density=np.arange(100.0))
WHOLE = ARRAYS.getvalue()
HALF, HALF_ANSWER = WHOLE[: len(WHOLE) // 2], ANSWER[: len(ANSWER) // 2]


class InspectedStore:
    """A run with a registered result, and one that is under way."""

    def __init__(self, store: Store, folder: Path):
        self.store, self.artifacts = store, Artifacts(folder)
        store.sweeps.create(Submission(sweep_of(2)))
        done, self.running = lease_runs(store, 2)
        self.folders = {"done": self.artifacts.attempt_directory(done)}
        self.folders["running"] = self.artifacts.attempt_directory(self.running)
        self.folders |= {"run": self.folders["running"].parent, "cache": folder / CACHE}
        self.register(done, ANSWER)

    def register(self, lease: Lease, answer: bytes) -> Path:
        """End a run with an answer."""
        file = write(self.artifacts.attempt_directory(lease) / RESULT, answer)
        registered = replace(describe(file), path=self.artifacts.relative(file))
        assert self.store.leases.finish(lease, replace(result(), files=(registered,)))
        return file

    def half_files(self) -> list[str]:
        return half_files(self.store, self.artifacts)


@pytest.fixture
def site(tmp_path: Path) -> Iterator[InspectedStore]:
    with closing(Store.open(f"sqlite:///{tmp_path / 'whipple.db'}")) as store:
        yield InspectedStore(store, tmp_path)


def write(file: Path, content: bytes) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(content)
    return file


def test_half_files__are_none_where_all_are_whole_or_of_an_attempt_without_answer(site: InspectedStore) -> None:
    running = site.folders["running"]
    write(running / "state.npz", HALF)
    part = write(running / ".result.json.x.part", HALF_ANSWER)
    assert site.half_files() == []
    part.unlink()
    whole = {"state.npz": WHOLE, RESULT: ANSWER, "log.txt": b"step 1\nst", "../checkpoint.npz": WHOLE}
    for name, content in whole.items():
        write(running / name, content)
    write(site.folders["cache"] / "7.json", ANSWER)
    assert site.half_files() == []


@pytest.mark.parametrize(
    ("place", "name", "content"),
    [
        *(("run", "checkpoint.npz", WHOLE[:size]) for size in (0, 10, 200)),
        ("running", RESULT, HALF_ANSWER),
        ("running", "state.npz", HALF),  # beside a complete answer
        ("done", "film.npz", HALF),  # beside a registered file
        *(("cache", "7.nc", content) for content in (b"\x89HDF and no more", b'{"a": [1,', b"")),
    ],
)
def test_half_file__that_could_be_used_or_shown_is_listed(
    site: InspectedStore, place: str, name: str, content: bytes
) -> None:
    write(site.folders["running"] / RESULT, ANSWER)
    file = write(site.folders[place] / name, content)
    assert site.half_files() == [str(file)]


def test_differences__of_a_part_are_those_of_all_its_variables_alone(tmp_path: Path) -> None:
    files = tmp_path / "1.nc", tmp_path / "2.nc"
    for file, mass, reason in zip(files, (1.0, 1.5), ("", "out of memory"), strict=True):
        variables = {"mass": ("speed", [mass, 2.0]), "run_reason": ("speed", [reason, ""])}
        xr.Dataset(variables, {"speed": [1.0, 2.0]}).to_netcdf(file)
    assert list(differences(*files)) == ["mass", "run_reason"]
    assert list(differences(*files, at={"speed": [1.0]})) == ["mass", "run_reason"]
    assert list(differences(*files, at={"speed": [2.0]})) == []
