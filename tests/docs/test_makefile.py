"""The Makefile: help tells of each target, and claims are those that the command names."""

import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
TARGETS = re.search(r"^TARGETS := (.*)$", MAKEFILE, re.MULTILINE)[1].split()  # type: ignore[index]


def made(*arguments: str) -> str:
    """What make says; the environment has a name, as that of a make that was given one has."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS"))}
    environment["NAME"] = "of-the-machine"
    return subprocess.run(
        ["make", *arguments], cwd=ROOT, env=environment, capture_output=True, text=True, check=True
    ).stdout


def test_help__names_every_target() -> None:
    assert sorted([*re.findall(r"^make ([\w-]+)", made("help"), re.MULTILINE), "help"]) == sorted(TARGETS)


@pytest.mark.parametrize(
    ("arguments", "names"),
    [([], ""), (["house", "taylor-bar"], "house taylor-bar"), (["docs"], "docs"), (["NAME=house"], "house")],
)
def test_claims__are_those_that_the_command_names(arguments: list[str], names: str) -> None:
    assert re.findall(r"-m tests.claims ?(.*)", made("--dry-run", "claims", *arguments)) == [names]
