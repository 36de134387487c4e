"""A release: version, changelog and citation state the same number."""

import re
import shutil
from pathlib import Path

import pytest

from docs.release import ROOT, UNRELEASED, state_version, versions

FILES = ("pyproject.toml", "CITATION.cff", "CHANGELOG.md")


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    for name in FILES:
        shutil.copy(ROOT / name, tmp_path)
    return tmp_path


def test_version__is_the_same_in_every_file() -> None:
    """The changelog says which was released last; before the first release it says none."""
    assert len(set(versions(ROOT).values())) == 1, versions(ROOT)
    assert UNRELEASED in (ROOT / "CHANGELOG.md").read_text()


def test_release__brings_every_file_to_its_version_and_leaves_the_rest(copied: Path) -> None:
    before = {name: (copied / name).read_text() for name in FILES}
    for version, day in (("98.0.1", "2026-12-01"), ("98.1.0", "2026-12-24")):
        state_version(copied, version, day)
        assert versions(copied) == dict.fromkeys(FILES, version)
        assert f"date-released: {day}" in (copied / "CITATION.cff").read_text()
    changelog = (copied / "CHANGELOG.md").read_text()
    assert re.findall(r"^## (.*)$", changelog, re.MULTILINE)[:3] == [
        "Unreleased",
        "98.1.0 (2026-12-24)",
        "98.0.1 (2026-12-01)",
    ]
    assert (
        changelog.replace("\n## 98.1.0 (2026-12-24)\n", "").replace("\n## 98.0.1 (2026-12-01)\n", "")
        == before["CHANGELOG.md"]
    )
    lines = [text.splitlines() for text in (before["pyproject.toml"], (copied / "pyproject.toml").read_text())]
    assert sum(a != b for a, b in zip(*lines, strict=True)) == 1


@pytest.mark.parametrize(
    ("version", "message"), [("98", "three numbers"), ("97.9.9", "not newer"), ("98.0.0", "not newer")]
)
def test_release__of_a_version_that_is_none_or_not_newer_is_refused(copied: Path, version: str, message: str) -> None:
    state_version(copied, "98.0.0", "2026-12-01")
    with pytest.raises(ValueError, match=message):
        state_version(copied, version, "2026-12-02")
