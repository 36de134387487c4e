"""A release: version, changelog and citation state the same number."""

import re
import shutil
from pathlib import Path

import pytest

from docs.release import ROOT, UNRELEASED, state_version, versions

FILES = ("pyproject.toml", "CITATION.cff", "CHANGELOG.md")


def test_version__is_the_same_in_every_file() -> None:
    """The changelog says which was released last; before the first release it says none."""
    assert len(set(versions(ROOT).values())) == 1, versions(ROOT)
    assert UNRELEASED in (ROOT / "CHANGELOG.md").read_text()


def test_release__brings_every_file_to_its_version_and_leaves_the_rest(tmp_path: Path) -> None:
    for name in FILES:
        shutil.copy(ROOT / name, tmp_path)
    before = (tmp_path / "CHANGELOG.md").read_text()
    for version, day in (("98.0.1", "2026-12-01"), ("98.1.0", "2026-12-24")):
        state_version(tmp_path, version, day)
        assert versions(tmp_path) == dict.fromkeys(FILES, version)
        assert f"date-released: {day}" in (tmp_path / "CITATION.cff").read_text()
    after = (tmp_path / "CHANGELOG.md").read_text()
    headings = ["98.1.0 (2026-12-24)", "98.0.1 (2026-12-01)"]
    assert re.findall(r"^## (.*)$", after, re.MULTILINE)[:3] == ["Unreleased", *headings]
    assert after.replace(f"\n## {headings[0]}\n", "").replace(f"\n## {headings[1]}\n", "") == before
    for version, message in (("98", "three numbers"), ("97.9.9", "not newer"), ("98.1.0", "not newer")):
        with pytest.raises(ValueError, match=message):
            state_version(tmp_path, version, "2026-12-25")
