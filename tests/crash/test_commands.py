"""Commands of the Makefile and of CONTRIBUTING.md, in a clone whose environment they set up from nothing."""

import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.docs.test_makefile import TARGETS
from tests.service.support.blocks import Reader, blocks_of, cloned, surroundings
from tests.service.support.processes import ROOT

SECONDS = 1800.0  # that a command may take, or until it computes
BEGIN = "begin"  # of every command: the tag of what is here
# Values of targets that need some.
VALUES = {"release": " VERSION=98.0.1"}
GUIDE = [command for block in blocks_of(ROOT / "CONTRIBUTING.md") for command in block.commands]
# The demo comes first, as the README has it, and what removes all last.
MIDDLE = [target for target in TARGETS if target not in ("demo", "clean")]
COMMANDS = list(
    dict.fromkeys(["make demo", *(f"make {each}{VALUES.get(each, '')}" for each in MIDDLE), *GUIDE, "make clean"])
)
PERSON = {f"GIT_{role}_{what}": "nobody@example.org" for role in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")}


def git(clone: Path, *arguments: str) -> str:
    """What git prints in a clone."""
    done = subprocess.run(
        ["git", *arguments], cwd=clone, env={**os.environ, **PERSON}, check=True, capture_output=True, text=True
    )
    return done.stdout


@pytest.fixture(scope="module")
def reader(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Reader]:
    """A person with a clone; a release is without its image, which takes a docker and the packages of its system."""
    clone = cloned(tmp_path_factory.mktemp("commands"))
    git(clone, "commit", "--quiet", "--all", "--allow-empty", "--message", "What is changed here")
    git(clone, "tag", BEGIN)
    reader = Reader(clone, surroundings() | PERSON | {"IMAGE": "no"}, SECONDS)
    yield reader
    reader.end()


@pytest.mark.claim("mend", "every-command", minutes=20.0)
@pytest.mark.parametrize("command", COMMANDS)
def test_command__does_what_it_says(command: str, reader: Reader, compared: Compared) -> None:
    """Every target of the Makefile and every command of CONTRIBUTING.md runs in a fresh clone and environment."""
    git(reader.clone, "reset", "--quiet", "--hard", BEGIN)
    git(reader.clone, "clean", "--quiet", "--force", "-d")
    compared(reader.command(command))
    if command == "make clean":
        left = git(reader.clone, "status", "--porcelain", "--ignored").splitlines()
        left = [each for each in left if "__pycache__" not in each]
        compared(equal("what make clean leaves: the release", expected=["!! dist/"], got=left))
