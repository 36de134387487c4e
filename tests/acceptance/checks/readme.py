"""README.md as a user meets it: its blocks run in order, as they stand, in a fresh clone."""

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import xarray

from service.files.artifacts import digest
from tests.acceptance.checks.blocks import Block, Reader, blocks_of, cloned, surroundings
from tests.acceptance.checks.refusing import refusing
from tests.acceptance.support.serving import ROOT
from tests.rows import Row
from tests.service.support.cluster import free_port

FOLDERS = ("over-rest", "from-service", "without-service")  # of the small sweep, a block each
SIZES = {"speed": 3, "plate_thickness": 2}  # of its cube
FULL_SECONDS, SHORT_SECONDS = 6 * 3600.0, 240.0  # that a block may take

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


def needs_hours(block: Block) -> bool:
    """Whether it sets up, computes the demo and runs every check, or shows what that leaves."""
    return "make demo" in block.text or "demo/holes/" in block.text


def rows_in_full(place: Path) -> Iterator[Row]:
    """Every block, in a clone with an environment of its own."""
    yield from rows_of_blocks(Reader(cloned(place), surroundings(), FULL_SECONDS))


def rows_in_short(place: Path) -> Iterator[Row]:
    """The same without the block that takes hours: this environment, and runs that cost nothing."""
    clone, port = cloned(place), free_port()
    (clone / ".venv").symlink_to(sys.prefix)
    chosen = {"PYTHONPATH": str(clone), "WHIPPLE_TARGETS_MODULE": "tests.acceptance.checks.published"}
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
            if not (short and needs_hours(block)):
                yield reader.row_of(block)
                now = {cube: digest(cube) for cube in reader.clone.glob("*/cube.nc")}
                changed |= {str(cube) for cube in left if now.get(cube) != left[cube]}
                left = now
    finally:
        reader.end()
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
    return Row(f"options of {len(calls)} calls that curl 7.68 lacks", [], odd, bool(calls) and not odd)


def blocks() -> list[Block]:
    """Those of the text, in order."""
    return blocks_of(ROOT / "README.md")


def sizes_of(cube: Path) -> dict[str, Any] | str:
    """Of the axes of a cube in which every run has a value; else what is wrong with it."""
    if not cube.is_file():
        return "no cube"
    with xarray.open_dataset(cube) as dataset:
        values = dataset.hole_diameter
        return dict(values.sizes) if values.notnull().all() else "runs without a value"
