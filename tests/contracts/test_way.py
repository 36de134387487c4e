"""The files on the way of a sweep from its request to the bytes of its cube are those that CONTRIBUTING.md lists.

They are those on the call stack when an event of the sweep is stored, when a process is started, and when a complete
file gets its name. Rooms of values, records and files help everywhere, and are left out.
"""

import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from unittest.mock import patch

import pytest
import sqlalchemy as sa
from fastapi.testclient import TestClient

from service.api.app import open_service
from service.cli.local import start_engine
from service.settings import Settings
from tests.claims.rows import at_most, equal
from tests.contracts.features import ROOT
from tests.service.support.fakes import wait_until

SWEEP = {
    "scenario": "thin_plate",
    "fixed": {
        "projectile": "copper-ofhc",
        "target": "copper-ofhc",
        "projectile_diameter": "8 mm",
        "plate_thickness": "2 mm",
        "end_time": "1 us",
        "stop": "end_time",
    },
    "axes": {"speed": ["3 km/s"]},
    "resolution": 4,
}
MOST_FILES = 15  # of service and studies
LISTED = re.compile(r"^\d+\. `((?:service|studies)/[\w/]+\.py)`", re.MULTILINE)
# Rooms that help everywhere, what is around every request, what commands of the store are made of, and what keeps
# pictures of a run: no cube has them.
HELPERS = re.compile(
    r"service/(records|files|cli|maintenance|monitoring)/.*|studies/(films|quantities|sections)/.*"
    r"|service/api/(access|middleware|turns)\.py|service/store/(connection|events|statements|submission)\.py"
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


@pytest.mark.claim("house", "way", minutes=0.5)
def test_way__of_a_sweep_is_that_of_contributing(tmp_path: Path, compared: Callable[..., None]) -> None:
    """CONTRIBUTING.md lists the files from POST /v1/sweeps to cube.nc, at most 15, and a real sweep uses no other."""
    listed = LISTED.findall((ROOT / "CONTRIBUTING.md").read_text("utf-8"))
    compared(at_most("files on the way from POST /v1/sweeps to cube.nc", limit=MOST_FILES, got=len(listed)))
    missing = [name for name in listed if not (ROOT / name).is_file()]
    compared(equal("listed files that do not exist", expected=[], got=missing))
    used = {name for name in _files_used(tmp_path) if not HELPERS.fullmatch(name)}
    compared(at_most("files of a real sweep", limit=len(listed), got=len(used)))
    compared(equal("files of a real sweep that are not listed", expected=[], got=sorted(used - set(listed))))


def _files_used(folder: Path) -> set[str]:
    """The files of service and studies on the stacks of a sweep, by path below the root."""
    (folder / "sitecustomize.py").write_text(IN_CHILD)
    trace = folder / "trace"
    files: set[str] = set()
    with (
        patch.dict(os.environ, {TRACE: str(trace)}),
        patch.object(sys, "path", [str(folder), *sys.path]),
        _recorded_stacks(files),
    ):
        _publish_a_sweep(folder / "data")
    files |= set(trace.read_text().splitlines())
    root = f"{ROOT}/"
    own = {file.removeprefix(root) for file in files if file.startswith(root)}
    return {name for name in own if name.startswith(("service/", "studies/"))}


@contextmanager
def _recorded_stacks(files: set[str]) -> Iterator[None]:
    """Add the files on the stack of this process whenever it stores an event or starts a process."""

    def record() -> None:
        frame: FrameType | None = sys._getframe(1)
        while frame is not None:
            files.add(frame.f_code.co_filename)
            frame = frame.f_back

    def on_statement(_connection: object, _cursor: object, statement: str, *_: object) -> None:
        if statement.startswith("INSERT INTO events"):
            record()

    start = subprocess.Popen.__init__

    def on_start(*arguments: object, **options: object) -> None:
        record()
        start(*arguments, **options)  # type: ignore[call-overload]

    sa.event.listen(sa.Engine, "before_cursor_execute", on_statement)
    try:
        with patch.object(subprocess.Popen, "__init__", on_start):
            yield
    finally:
        sa.event.remove(sa.Engine, "before_cursor_execute", on_statement)


def _publish_a_sweep(data: Path) -> None:
    with open_service(Settings(data=data, workers=1), start_engine) as app:
        client = TestClient(app, base_url="http://127.0.0.1:8000")
        sweep = client.post("/v1/sweeps", json={**SWEEP, "name": "way"}).json()["links"]["self"]
        wait_until(lambda: client.get(sweep).json()["state"] == "succeeded", seconds=300)
        assert client.get(f"{sweep}/cube.nc").status_code == 200
