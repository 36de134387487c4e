"""The way of a sweep from its request to the bytes of its cube, in CONTRIBUTING.md and in a real sweep.

The files on the way are those on the call stack when an event of the sweep is stored, when a process is started, and
when a complete file gets its name. Rooms of values, records and files help everywhere, and are left out.
"""

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

import sqlalchemy as sa

from service.api.app import open_service
from service.cli.local import start_engine
from service.records.settings import Settings
from tests import house
from tests.claims import Row, at_most, claim
from tests.claims.house.plan import SWEEP
from tests.service.support.fakes import wait_until

MOST_FILES = 15  # of service and studies
LISTED = re.compile(r"^\d+\. `((?:service|studies)/[\w/]+\.py)`", re.MULTILINE)
# Rooms that help everywhere, what is around every request, what every command of the store uses, and what keeps
# pictures of a run: no cube has them.
HELPERS = re.compile(
    r"service/(records|files|cli)/.*|studies/(values|films)/.*"
    r"|service/api/(access|middleware)\.py|service/store/(connection|statements)\.py"
)
TRACE = "WHIPPLE_WAY"  # environment: file to which a child process adds the files on its stack
# Imported by the interpreter of each child process.
IN_CHILD = f"""
import os, sys
replace = os.replace
def traced(*names):
    frame, files = sys._getframe(1), []
    while frame is not None:
        files.append(frame.f_code.co_filename)
        frame = frame.f_back
    with open(os.environ["{TRACE}"], "a") as trace:
        print(*files, sep="\\n", file=trace)
    return replace(*names)
os.replace = traced
"""


@claim(
    "way",
    says="CONTRIBUTING.md lists the files from POST /v1/sweeps to cube.nc, at most 15, and a real sweep uses no other",
)
def way() -> Iterator[Row]:
    listed = LISTED.findall((house.ROOT / "CONTRIBUTING.md").read_text("utf-8"))
    yield at_most("files on the way from POST /v1/sweeps to cube.nc", limit=MOST_FILES, got=len(listed))
    missing = [name for name in listed if not (house.ROOT / name).is_file()]
    yield Row("listed files that do not exist", "none", ", ".join(missing) or "none", not missing)
    used = {name for name in _files_used() if not HELPERS.fullmatch(name)}
    others = sorted(used - set(listed))
    yield at_most("files of a real sweep", limit=len(listed), got=len(used))
    yield Row("files of a real sweep that are not listed", "none", ", ".join(others) or "none", not others)


def _files_used() -> set[str]:
    """The files of service and studies on the stacks of a sweep, by path below the root."""
    with tempfile.TemporaryDirectory(prefix="whipple-way-") as name:
        folder = Path(name)
        (folder / "sitecustomize.py").write_text(IN_CHILD)
        trace = folder / "trace"
        files: set[str] = set()
        with (
            patch.dict(os.environ, {TRACE: str(trace)}),
            patch.object(sys, "path", [name, *sys.path]),
            _recorded_stacks(files),
        ):
            _publish_a_sweep(folder / "data")
        files |= set(trace.read_text().splitlines())
    root = f"{house.ROOT}/"
    own = {file.removeprefix(root) for file in files if file.startswith(root)}
    return {name for name in own if name.startswith(("service/", "studies/"))}


@contextmanager
def _recorded_stacks(files: set[str]) -> Iterator[None]:
    """Add the files on the stack of this process whenever it stores an event or starts a process."""

    def record() -> None:
        frame: Any = sys._getframe(1)
        while frame is not None:
            files.add(frame.f_code.co_filename)
            frame = frame.f_back

    def on_statement(_connection: object, _cursor: object, statement: str, *_: object) -> None:
        if statement.startswith("INSERT INTO events"):
            record()

    start = subprocess.Popen.__init__

    def on_start(*arguments: Any, **options: Any) -> None:
        record()
        start(*arguments, **options)

    sa.event.listen(sa.Engine, "before_cursor_execute", on_statement)
    try:
        with patch.object(subprocess.Popen, "__init__", on_start):
            yield
    finally:
        sa.event.remove(sa.Engine, "before_cursor_execute", on_statement)


def _publish_a_sweep(data: Path) -> None:
    from fastapi.testclient import TestClient

    with open_service(Settings(data=data, workers=1), start_engine) as app:
        client = TestClient(app, base_url="http://127.0.0.1:8000")
        sweep = client.post("/v1/sweeps", json={**SWEEP, "name": "way"}).json()["links"]["self"]
        wait_until(lambda: client.get(sweep).json()["state"] == "succeeded", seconds=300)
        assert client.get(f"{sweep}/cube.nc").status_code == 200
