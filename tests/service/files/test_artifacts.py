"""Where files live, their checksums, and copies of them."""

from pathlib import Path

import pytest

from service.files.artifacts import Artifacts, describe
from service.records.jobs import Claim, Keep, Kind, State, Stored
from tests.service.support.fakes import run_id


@pytest.fixture
def artifacts(tmp_path: Path) -> Artifacts:
    return Artifacts(tmp_path)


def claim(kind: Kind = Kind.RUN, *, id: str = run_id(7), sweep_id: str | None = None) -> Claim:
    return Claim(
        id=id,
        kind=kind,
        attempt=2,
        epoch=1,
        token="c0ffee00",
        crashes=0,
        crash_step=None,
        priority=0,
        keep=Keep.FINAL,
        state=State.RUNNING,
        spec={},
        sweep_id=sweep_id,
    )


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


def test_log__of_an_attempt_is_in_its_folder(artifacts: Artifacts) -> None:
    asked = claim()
    log = artifacts.log_of(asked.id, asked.attempt, asked.token)
    assert log == artifacts.attempt_directory(asked) / "log.txt"


def test_complete_files__none_without_an_answer(artifacts: Artifacts) -> None:
    folder = artifacts.attempt_directory(claim())
    assert artifacts.complete_files(claim()) == ()
    folder.mkdir(parents=True)
    for name in ("state.npz", "log.txt", "pid", ".result.json.x.part"):
        (folder / name).touch()
    assert artifacts.complete_files(claim()) == ()
    (folder / "result.json").touch()
    found = artifacts.complete_files(claim())
    assert [file.name for file in found] == ["result.json", "state.npz", "log.txt"]


def test_discard_checkpoint__takes_everything_of_it_and_nothing_else(artifacts: Artifacts) -> None:
    folder = artifacts.attempt_directory(claim())
    folder.mkdir(parents=True)
    for name in ("checkpoint.npz", "checkpoint.film.npz", ".checkpoint.npz.abc.part"):
        (folder.parent / name).touch()
    assert artifacts.checkpoint(run_id(7)).is_file()
    artifacts.discard_checkpoint(run_id(7))
    artifacts.discard_checkpoint(run_id(8))  # which has no folder
    assert [*folder.parent.iterdir()] == [folder]


def test_has_attempt__knows_the_keys_of_this_directory(artifacts: Artifacts) -> None:
    artifacts.attempt_directory(claim()).mkdir(parents=True)
    assert artifacts.has_attempt(claim().key)
    assert not artifacts.has_attempt(claim(id=run_id(8)).key)


def test_has_attempt__knows_publications_too(artifacts: Artifacts) -> None:
    publication = claim(id=run_id(1), kind=Kind.PUBLISH, sweep_id=run_id(2))
    assert not artifacts.has_attempt(publication.key)
    artifacts.attempt_directory(publication).mkdir(parents=True)
    assert artifacts.has_attempt(publication.key)


@pytest.mark.parametrize(
    "key", ["x", "", "a-b-c", f"{run_id(7)}-1-../../etc", f"../x-1-{run_id(7)}"]
)
def test_has_attempt__a_name_of_somebody_else_is_not_ours(artifacts: Artifacts, key: str) -> None:
    assert not artifacts.has_attempt(key)


def test_bring_to_disk__reaches_every_file_and_the_folders_above(
    artifacts: Artifacts, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = artifacts.attempt_directory(claim())
    folder.mkdir(parents=True)
    (folder / "log.txt").touch()
    reached: list[Path] = []

    def sync(descriptor: int) -> None:
        reached.append(Path(f"/proc/self/fd/{descriptor}").resolve())

    monkeypatch.setattr("os.fsync", sync)
    artifacts.bring_to_disk(folder)
    above = [place.resolve() for place in folder.parents if place.is_relative_to(artifacts.root)]
    assert reached == [folder.resolve() / "log.txt", folder.resolve(), *above]
