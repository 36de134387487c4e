"""The Makefile: each target is told of, and each of its lines is shell that can be read."""

import os
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
    """What make did in the folder; the environment has a name, as that of a make that was given one has."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS"))}
    environment["NAME"] = "of-the-machine"
    return subprocess.run(
        ["make", *arguments], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


def test_help__names_every_target(folder: Path) -> None:
    named = re.findall(r"^make ([\w-]+)", made(folder, "help").stdout, re.MULTILINE)
    assert sorted([*named, "help"]) == sorted(TARGETS)


@pytest.mark.parametrize("target", TARGETS)
def test_target__is_shell_that_can_be_read(target: str, folder: Path) -> None:
    """Every line of a target and of all that it depends on is parsed by bash (``-n``), and none is run."""
    read = made(folder, "--always-make", target, ".SHELLFLAGS=-n -c")
    assert (read.returncode, read.stderr) == (0, "")
    assert not list(folder.glob(".venv*"))


@pytest.mark.parametrize(
    ("arguments", "names"),
    [([], ""), (["house", "taylor-bar"], "house taylor-bar"), (["docs"], "docs"), (["NAME=house"], "house")],
)
def test_claims__are_those_that_the_command_names(arguments: list[str], names: str, folder: Path) -> None:
    printed = made(folder, "--dry-run", "claims", *arguments).stdout
    assert re.findall(r"-m tests.claims ?(.*)", printed) == [names]
