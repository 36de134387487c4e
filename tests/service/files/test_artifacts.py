"""Where files live, their checksums, and that they reach the disk."""

from pathlib import Path

import pytest

from service.files.artifacts import Artifacts
from service.records.jobs import Stored
from tests.service.support.rows import lease_of


@pytest.fixture
def artifacts(tmp_path: Path) -> Artifacts:
    return Artifacts(tmp_path)


@pytest.mark.parametrize("id", ["", "..", "../../etc", "AB" * 16, "ab" * 17, f"{'ab' * 16}\n"])
def test_directory__only_for_ids_of_the_service(artifacts: Artifacts, id: str) -> None:
    with pytest.raises(ValueError, match="not an id"):
        artifacts.attempt_directory(lease_of(id=id))


@pytest.mark.parametrize("path", ["../secret", "/etc/passwd", "runs/../../secret", "out/passwd"])
def test_path__never_leaves_the_data_directory(artifacts: Artifacts, path: str) -> None:
    (artifacts.root / "out").symlink_to("/etc")
    with pytest.raises(ValueError, match="leaves"):
        artifacts.path(Stored("x", path, 0, ""))


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
    assert sorted(reached) == sorted([folder.resolve() / "log.txt", folder.resolve(), *above])
