"""Where files live, their checksums, and copies of them."""

from dataclasses import replace
from pathlib import Path

import pytest

from service.files.artifacts import Artifacts, describe
from service.records.jobs import Kind, Stored
from tests.service.support.fakes import run_id
from tests.service.support.rows import lease_of


@pytest.fixture
def artifacts(tmp_path: Path) -> Artifacts:
    return Artifacts(tmp_path)


def registered(artifacts: Artifacts, text: str = "{}") -> Stored:
    file = artifacts.root / "runs" / "result.json"
    file.parent.mkdir(exist_ok=True)
    file.write_text(text)
    return replace(describe(file), path=artifacts.relative(file))


def test_directory__is_the_attempts_own(artifacts: Artifacts) -> None:
    folder = artifacts.attempt_directory(lease_of(id="ab" * 16))
    assert artifacts.relative(folder) == f"runs/ab/{'ab' * 16}/a1-c0ffee00"
    folder = artifacts.attempt_directory(lease_of(kind=Kind.PUBLISH, sweep_id="cd" * 16))
    assert artifacts.relative(folder) == f"sweeps/{'cd' * 16}/a1-c0ffee00"


@pytest.mark.parametrize("id", ["", "..", "../../etc", "AB" * 16, "ab" * 17, f"{'ab' * 16}\n"])
def test_directory__only_for_ids_of_the_service(artifacts: Artifacts, id: str) -> None:
    with pytest.raises(ValueError, match="not an id"):
        artifacts.attempt_directory(lease_of(id=id))


@pytest.mark.parametrize("path", ["../secret", "/etc/passwd", "runs/../../secret", "out/passwd"])
def test_path__never_leaves_the_data_directory(artifacts: Artifacts, path: str) -> None:
    (artifacts.root / "out").symlink_to("/etc")
    with pytest.raises(ValueError, match="leaves"):
        artifacts.path(Stored("x", path, 0, ""))


def test_describe__size_and_digest(tmp_path: Path) -> None:
    file = tmp_path / "empty"
    file.touch()
    described = describe(file)
    # The SHA-256 of no bytes, FIPS 180-4.
    assert described.sha256 == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"
    assert (described.name, described.size) == ("empty", 0)


@pytest.mark.parametrize("damage", ["[]", "{} ", None])
def test_intact__sees_other_bytes_other_sizes_and_absence(artifacts: Artifacts, damage: str | None) -> None:
    file = registered(artifacts)
    assert artifacts.is_intact(file)
    if damage is None:
        artifacts.path(file).unlink()
    else:
        artifacts.path(file).write_text(damage)
    assert not artifacts.is_intact(file)


def test_copy_out__is_a_copy_under_its_own_name(artifacts: Artifacts, tmp_path: Path) -> None:
    file, folder = registered(artifacts, "[1]"), tmp_path / "out"
    folder.mkdir()
    copy = artifacts.copy_out(file, folder)
    assert (copy.name, copy.read_text()) == ("result.json", "[1]")
    copy.write_text("edited")
    assert artifacts.is_intact(file)


def test_complete_files__none_without_an_answer(artifacts: Artifacts) -> None:
    folder = artifacts.attempt_directory(lease_of())
    assert artifacts.complete_files(lease_of()) == ()
    folder.mkdir(parents=True)
    for name in ("state.npz", "log.txt", "pid", ".result.json.x.part"):
        (folder / name).touch()
    assert artifacts.complete_files(lease_of()) == ()
    (folder / "result.json").touch()
    files = artifacts.complete_files(lease_of())
    assert [file.name for file in files] == ["result.json", "state.npz", "log.txt"]


def test_discard_checkpoint__takes_everything_of_it_and_nothing_else(artifacts: Artifacts) -> None:
    folder = artifacts.attempt_directory(lease_of())
    folder.mkdir(parents=True)
    for name in ("checkpoint.npz", "checkpoint.film.npz", ".checkpoint.npz.abc.part"):
        (folder.parent / name).touch()
    assert artifacts.checkpoint(run_id(7)).is_file()
    artifacts.discard_checkpoint(run_id(7))
    artifacts.discard_checkpoint(run_id(8))  # which has no folder
    assert [*folder.parent.iterdir()] == [folder]


def test_bring_to_disk__reaches_every_file_and_the_folders_above(
    artifacts: Artifacts, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = artifacts.attempt_directory(lease_of())
    folder.mkdir(parents=True)
    (folder / "log.txt").touch()
    reached: list[Path] = []

    def sync(descriptor: int) -> None:
        reached.append(Path(f"/proc/self/fd/{descriptor}").resolve())

    monkeypatch.setattr("os.fsync", sync)
    artifacts.bring_to_disk(folder)
    above = [place.resolve() for place in folder.parents if place.is_relative_to(artifacts.root)]
    assert reached == [folder.resolve() / "log.txt", folder.resolve(), *above]


def test_has_attempt__knows_the_keys_of_this_directory(artifacts: Artifacts) -> None:
    publication = lease_of(id=run_id(1), kind=Kind.PUBLISH, sweep_id=run_id(2))
    for lease in (lease_of(), publication):
        assert not artifacts.has_attempt(lease.key)
        artifacts.attempt_directory(lease).mkdir(parents=True)
        assert artifacts.has_attempt(lease.key)
    for key in ("", "a-b-c", f"{run_id(7)}-1-../../etc", f"../x-1-{run_id(7)}"):
        assert not artifacts.has_attempt(key)
