"""README.md as a user meets it: its blocks run in order, as they stand, in a fresh clone."""

import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import psutil
import xarray
import yaml

from service.files.artifacts import digest
from tests.acceptance.checks.refusing import refusing
from tests.acceptance.support.serving import ROOT
from tests.rows import Row
from tests.service.support.cluster import free_port
from tests.service.support.fakes import is_gone, wait_until

FENCED = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"[\w-]+\.(?:nc|html|json)\b")
FOLDERS = ("over-rest", "from-service", "without-service")  # of the small sweep, a block each
SIZES = {"speed": 3, "plate_thickness": 2}  # of its cube
PORT = 8000  # of the text
FULL_SECONDS, SHORT_SECONDS = 6 * 3600.0, 240.0  # that a block may take
LAST = 600  # characters of what a block said, for whoever reads why it failed

# Answers of a service, and what the block over REST must show before it ends with an error.
FAILURES = {
    "a refused sweep": ({"sweeps": (422, "no scenario 'thin_plat'")}, "no scenario 'thin_plat'"),
    "a sweep without cube": ({"sweeps": (202, ""), "cube.nc": (404, "")}, "404"),
}

# Options of the curl of Ubuntu 20.04, 7.68, by the version that brought them; 7.75 brought
# -w '%header{}', 7.76 --fail-with-body and 7.82 --json, and the first of these ended the block there.
CURL = {
    **dict.fromkeys(("-s", "-S", "-f", "-o", "-D", "-H", "--data-binary"), "7.2"),
    **{"-w": "6.5", "--retry": "7.12.3", "--retry-delay": "7.12.3", "--retry-connrefused": "7.52"},
    "%{http_code}": "7.1",
}


@dataclass(frozen=True)
class Block:
    """A fenced block of the text."""

    language: str
    text: str
    line: int

    @property
    def needs_hours(self) -> bool:
        """Whether it sets up, computes the demo and runs every check, or shows what that leaves."""
        return "make demo" in self.text or "demo/holes/" in self.text


@dataclass(frozen=True)
class Reader:
    """Somebody who follows the text in a clone."""

    clone: Path
    environment: Mapping[str, str]
    seconds: float  # that a block may take
    sessions: list[int] = field(default_factory=list)  # of its programs

    def row_of(self, block: Block) -> Row:
        """What a block does, as its language has it."""
        does = {"sh": self._shell, "python": self._python, "csv": self._table, "yaml": self._lines}
        return does.get(block.language, self._listing)(block)

    def run(self, block: Block, *command: str | Path) -> Row:
        """A program, which must end well; what it leaves in the background is not waited for."""
        log = self.clone.with_name(f"line-{block.line}.log")
        with log.open("wb") as file:
            process = subprocess.Popen(
                command,
                cwd=self.clone,
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=file,
                start_new_session=True,
            )
        self.sessions.append(process.pid)
        ended = process.wait(self.seconds)
        output = "" if ended == 0 else f": {log.read_text(errors='replace')[-LAST:]}"
        return Row(f"line {block.line}, exit status", 0, f"{ended}{output}", ended == 0)

    def _shell(self, block: Block) -> Row:
        return self.run(block, "sh", "-e", "-c", block.text)

    def _python(self, block: Block) -> Row:
        return self.run(block, ".venv/bin/python", "-c", block.text)

    def _table(self, block: Block) -> Row:
        (self.clone / "shots.csv").write_text(block.text)
        return Row(f"line {block.line}, a table to be named", "", "shots.csv", None)

    def _lines(self, block: Block) -> Row:
        """Lines of a sweep document, in place of those that the small sweep has."""
        file = self.clone / f"line-{block.line}.yaml"
        small = yaml.safe_load((self.clone / "holes.yaml").read_text())
        file.write_text(yaml.safe_dump({**small, **yaml.safe_load(block.text)}))
        return self.run(block, ".venv/bin/whipple", "estimate", file)

    def _listing(self, block: Block) -> Row:
        """Folders at the begin of each line, and the files that it names in them."""
        missing = []
        for line in block.text.splitlines():
            folder = self.clone / line.split()[0]
            names = [folder, *(folder / name for name in FILE.findall(line))]
            missing += [str(name.relative_to(self.clone)) for name in names if not name.exists()]
        return Row(f"line {block.line}, listed and missing", [], missing, not missing)


def rows_in_full(place: Path) -> Iterator[Row]:
    """Every block, in a clone with an environment of its own."""
    yield from rows_of_blocks(Reader(cloned(place), surroundings(), FULL_SECONDS))


def rows_in_short(place: Path) -> Iterator[Row]:
    """The same without the block that takes hours: this environment, and runs that cost nothing."""
    clone, port = cloned(place), free_port()
    (clone / ".venv").symlink_to(sys.prefix)
    chosen = {
        "PYTHONPATH": str(clone),
        "WHIPPLE_TARGETS_MODULE": "tests.acceptance.checks.published",
    }
    yield from rows_of_blocks(Reader(clone, surroundings(port) | chosen, SHORT_SECONDS), short=True)


def rows_of_failures(place: Path) -> Iterator[Row]:
    """The block over REST ends with an error, and says which, where something fails."""
    block = next(item for item in blocks() if "curl " in item.text)
    program = place / ".venv" / "bin" / "whipple"  # a service runs already
    program.parent.mkdir(parents=True)
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    for name, (answers, options) in FAILURES.items():
        with refusing(answers) as url:
            ended = subprocess.run(
                ["sh", "-c", block.text],
                cwd=place,
                env={**surroundings(), "WHIPPLE_SERVICE": url},
                capture_output=True,
                text=True,
                timeout=SHORT_SECONDS,
                check=False,
            )
        output = f"{ended.returncode}: {ended.stdout}{ended.stderr}"
        is_reported = ended.returncode != 0 and options in output
        yield Row(f"{name} ends the block", f"an error with {options!r}", output, is_reported)
    left = [file.name for file in place.glob("*/*") if file.name in ("cube.nc", "report.html")]
    yield Row("files that are no results", [], left, not left)


def rows_of_blocks(reader: Reader, *, short: bool = False) -> Iterator[Row]:
    """Each block after the other, and what they leave."""
    left: dict[Path, str] = {}
    changed: set[str] = set()
    try:
        for block in blocks():
            if not (short and block.needs_hours):
                yield reader.row_of(block)
                now = {cube: digest(cube) for cube in reader.clone.glob("*/cube.nc")}
                changed |= {str(cube) for cube in left if now.get(cube) != left[cube]}
                left = now
    finally:
        end_programs(reader.sessions)
    yield Row("cubes of a block that a later one changed", set(), changed, not changed)
    for folder in FOLDERS:
        result = sizes_of(reader.clone / folder / "cube.nc")
        yield Row(f"{folder}, sizes of the cube", SIZES, result, result == SIZES)


def row_of_curl() -> Row:
    """The text asks for nothing that curl 7.68 does not have."""
    lines = "\n".join(item.text for item in blocks()).replace("\\\n", " ").splitlines()
    calls = [line.partition("curl ")[2] for line in lines if "curl " in line]
    options = [word for call in calls for word in re.findall(r"(?:^|\s)(--?[A-Za-z][\w-]*)", call)]
    long = {word for word in options if word.startswith("--")}
    short = {f"-{letter}" for word in options if word not in long for letter in word[1:]}
    formats = {word for call in calls for word in re.findall(r"%(?:\w+)?\{.*?\}", call)}
    odd = sorted((long | short | formats) - CURL.keys())
    return Row(
        f"options of {len(calls)} calls that curl 7.68 lacks", [], odd, bool(calls) and not odd
    )


def blocks() -> list[Block]:
    """Those of the text, in order."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    return [
        Block(result[1], result[2], text.count("\n", 0, result.start()) + 1)
        for result in FENCED.finditer(text)
    ]


def cloned(place: Path) -> Path:
    """A clone of this checkout in a new folder, with what is changed here and not committed yet."""
    clone = place / "whipple"
    subprocess.run(["git", "clone", "--quiet", ROOT, clone], check=True)
    change = ["git", "diff", "--binary", "HEAD"]
    changed = subprocess.run(change, cwd=ROOT, check=True, capture_output=True).stdout
    if changed:
        subprocess.run(["git", "apply"], cwd=clone, input=changed, check=True)
    return clone


def surroundings(port: int | None = None) -> dict[str, str]:
    """The environment without ours; with another port where that of the text is taken."""
    ours = re.compile(r"WHIPPLE_|PYTHON|VIRTUAL_ENV|MAKE|MFLAGS|PYTEST")
    plain = {name: value for name, value in os.environ.items() if not ours.match(name)}
    port = port or (free_port() if is_taken(PORT) else None)
    if port is None:
        return plain
    return {**plain, "WHIPPLE_PORT": str(port), "WHIPPLE_SERVICE": f"http://127.0.0.1:{port}"}


def is_taken(port: int) -> bool:
    """Whether something listens there."""
    with socket.socket() as item:
        return item.connect_ex(("127.0.0.1", port)) == 0


def end_programs(sessions: Sequence[int]) -> None:
    """Tell what still runs in these sessions to leave, and wait until it has."""
    for pid in members(sessions):
        os.kill(pid, signal.SIGTERM)
    wait_until(lambda: not members(sessions))


def members(sessions: Sequence[int]) -> list[int]:
    """The processes of these sessions."""
    result = []
    for pid in psutil.pids():
        with suppress(ProcessLookupError):
            if os.getsid(pid) in sessions and not is_gone(pid):
                result.append(pid)
    return result


def sizes_of(cube: Path) -> dict[str, Any] | str:
    """Of the axes of a cube in which every run has a value; else what is wrong with it."""
    if not cube.is_file():
        return "no cube"
    with xarray.open_dataset(cube) as dataset:
        values = dataset.hole_diameter
        return dict(values.sizes) if values.notnull().all() else "runs without a value"
