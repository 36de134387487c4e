"""The Makefile: each target is told of, and each of its lines is shell that can be read."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
TARGETS = re.search(r"^TARGETS := (.*)$", MAKEFILE, re.MULTILINE)[1].split()  # type: ignore[index]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with what the targets depend on and nothing that they could harm."""
    for name in ("Makefile", "pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, tmp_path)
    return tmp_path


def made(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """What make did in the folder."""
    return subprocess.run(["make", *arguments], cwd=folder, capture_output=True, text=True, check=False)


def test_help__names_every_target(folder: Path) -> None:
    named = re.findall(r"^make ([\w-]+)", made(folder, "help").stdout, re.MULTILINE)
    assert sorted([*named, "help"]) == sorted(TARGETS)


@pytest.mark.parametrize("target", TARGETS)
def test_target__is_shell_that_can_be_read(target: str, folder: Path) -> None:
    """Every line of a target and of all that it depends on is parsed by bash (``-n``), and none is run."""
    read = made(folder, "--always-make", target, ".SHELLFLAGS=-n -c")
    assert (read.returncode, read.stderr) == (0, "")
    assert not list(folder.glob(".venv*"))
