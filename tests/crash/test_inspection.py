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
from service.records.jobs import Submission
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


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    """A run with a registered result in ``done``, and one under way in ``running``."""
    with closing(Store.open(f"sqlite:///{tmp_path / 'whipple.db'}")) as opened:
        opened.sweeps.create(Submission(sweep_of(2)))
        done, running = lease_runs(opened, 2)
        artifacts = Artifacts(tmp_path)
        for lease, link in ((done, "done"), (running, "running")):
            folder = artifacts.attempt_directory(lease)
            folder.mkdir(parents=True)
            (folder / RESULT).write_bytes(ANSWER)
            (tmp_path / link).symlink_to(folder)
        (tmp_path / CACHE).mkdir()
        answer = describe(artifacts.attempt_directory(done) / RESULT)
        registered = replace(answer, path=artifacts.relative(Path(answer.path)))
        assert opened.leases.finish(done, replace(result(), files=(registered,)))
        yield opened


def test_half_files__are_none_where_all_are_whole_or_of_an_attempt_without_answer(store: Store, tmp_path: Path) -> None:
    whole = {"running/state.npz": WHOLE, "running/log.txt": b"step 1\nst", "running/../checkpoint.npz": WHOLE}
    for name, content in {**whole, f"{CACHE}/7.json": ANSWER}.items():
        (tmp_path / name).write_bytes(content)
    assert half_files(store, Artifacts(tmp_path)) == []
    (tmp_path / "running" / RESULT).rename(tmp_path / "running" / f".{RESULT}.x.part")
    (tmp_path / "running" / "state.npz").write_bytes(HALF)
    assert half_files(store, Artifacts(tmp_path)) == []


@pytest.mark.parametrize(
    ("name", "content"),
    [
        *(("running/../checkpoint.npz", WHOLE[:size]) for size in (0, 10, 200)),
        (f"running/{RESULT}", HALF_ANSWER),
        ("running/state.npz", HALF),  # beside a complete answer
        ("done/film.npz", HALF),  # beside a registered file
        *((f"{CACHE}/7.nc", content) for content in (b"\x89HDF and no more", b'{"a": [1,', b"")),
    ],
)
def test_half_file__that_could_be_used_or_shown_is_listed(
    store: Store, tmp_path: Path, name: str, content: bytes
) -> None:
    (tmp_path / name).write_bytes(content)
    assert half_files(store, Artifacts(tmp_path)) == [str((tmp_path / name).resolve())]


def test_differences__of_a_part_are_those_of_all_its_variables_alone(tmp_path: Path) -> None:
    files = tmp_path / "1.nc", tmp_path / "2.nc"
    for file, mass, reason in zip(files, (1.0, 1.5), ("", "out of memory"), strict=True):
        variables = {"mass": ("speed", [mass, 2.0]), "run_reason": ("speed", [reason, ""])}
        xr.Dataset(variables, {"speed": [1.0, 2.0]}).to_netcdf(file)
    assert list(differences(*files)) == list(differences(*files, at={"speed": [1.0]})) == ["mass", "run_reason"]
    assert list(differences(*files, at={"speed": [2.0]})) == []
