"""Where files live, their checksums, and copies of them."""

from pathlib import Path

import pytest

from service.artifacts import Artifacts, describe
from service.jobs import Claim, Kind, State, Stored
from tests.service.doubles import run_id


@pytest.fixture
def artifacts(tmp_path: Path) -> Artifacts:
    return Artifacts(tmp_path)


def claim(kind: Kind = Kind.RUN, *, id: str = run_id(7), sweep_id: str | None = None) -> Claim:
    return Claim(id, kind, 2, 1, "c0ffee00", 0, State.RUNNING, {}, sweep_id)


def registered(artifacts: Artifacts, text: str = "{}") -> Stored:
    file = artifacts.root / "runs" / "result.json"
    file.parent.mkdir(exist_ok=True)
    file.write_text(text)
    found = describe(file)
    return Stored(found.name, artifacts.relative(file), found.size, found.sha256)


def test_directory__is_the_attempts_own(artifacts: Artifacts) -> None:
    folder = artifacts.attempt_directory(claim(id="ab" * 16))
    assert artifacts.relative(folder) == f"runs/ab/{'ab' * 16}/a2-c0ffee00"
    folder = artifacts.attempt_directory(claim(Kind.PUBLISH, sweep_id="cd" * 16))
    assert artifacts.relative(folder) == f"sweeps/{'cd' * 16}/a2-c0ffee00"


@pytest.mark.parametrize("id", ["", "..", "../../etc", "AB" * 16, "ab" * 17, f"{'ab' * 16}\n"])
def test_directory__only_for_ids_of_the_service(artifacts: Artifacts, id: str) -> None:
    with pytest.raises(ValueError, match="not an id"):
        artifacts.attempt_directory(claim(id=id))


@pytest.mark.parametrize("path", ["../secret", "/etc/passwd", "runs/../../secret"])
def test_path__never_leaves_the_data_directory(artifacts: Artifacts, path: str) -> None:
    with pytest.raises(ValueError, match="leaves"):
        artifacts.path(Stored("x", path, 0, ""))


def test_path__a_link_out_of_the_data_directory_is_refused(artifacts: Artifacts) -> None:
    (artifacts.root / "out").symlink_to("/etc")
    with pytest.raises(ValueError, match="leaves"):
        artifacts.path(Stored("x", "out/passwd", 0, ""))


def test_describe__size_and_digest(tmp_path: Path) -> None:
    file = tmp_path / "empty"
    file.touch()
    found = describe(file)
    # The SHA-256 of nothing: FIPS 180-4, and everybody's first test.
    assert found.sha256 == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"
    assert (found.name, found.size) == ("empty", 0)


@pytest.mark.parametrize("damage", ["[]", "{} ", None])
def test_intact__sees_other_bytes_other_sizes_and_absence(
    artifacts: Artifacts, damage: str | None
) -> None:
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


def test_copy_out__leaves_the_old_file_when_it_fails(artifacts: Artifacts, tmp_path: Path) -> None:
    file, folder = registered(artifacts), tmp_path / "out"
    folder.mkdir()
    artifacts.copy_out(file, folder)
    artifacts.path(file).unlink()
    with pytest.raises(FileNotFoundError):
        artifacts.copy_out(file, folder)
    assert [entry.name for entry in folder.iterdir()] == ["result.json"]
    assert (folder / "result.json").read_text() == "{}"


def test_discard__deletes_the_files_of_those_sweeps_alone(artifacts: Artifacts) -> None:
    for number in (1, 2):
        (artifacts.root / "sweeps" / run_id(number) / "a1-x").mkdir(parents=True)
    (artifacts.root / "sweeps" / "not-an-id").mkdir()
    assert sorted(artifacts.sweep_ids()) == [run_id(1), run_id(2)]
    artifacts.discard_sweeps([run_id(1)])
    assert artifacts.sweep_ids() == [run_id(2)]
