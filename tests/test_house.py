"""The house keeps its limits, its picture is current, a start is quick, and a sweep goes the way that is written down.

The files on the way are those on the call stack when an event of the sweep is stored, when a process is started, and
when a complete file gets its name. Rooms of values, records and files help everywhere, and are left out.
"""

import json
import os
import re
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest
import sqlalchemy as sa

from studies.answers import EXAMPLE
from tests import house
from tests.claims.rows import at_most, equal
from tests.crash.support.serving import serving
from tests.service.support.fakes import wait_until

READY, CACHED = 1.0, 2.0  # s
ANSWER, SHEET = 1.0, 3.0  # s of processor time


# --- the plan ---------------------------------------------------------------------------------------


def test_picture_and_page__are_what_make_map_writes() -> None:
    whole = house.house()
    packages = [whole.folder(name) for name in house.PACKAGES]
    assert house.PICTURE.read_text(encoding="utf-8") == house.drawing(packages), "make map"
    assert house.PAGE.read_text(encoding="utf-8") == house.page(packages), "make map"


@pytest.mark.claim("house", "circles", minutes=0.1)
def test_folders__are_without_circles(compared: Callable[..., None]) -> None:
    """No rooms of a folder and no files import one another in a circle."""
    whole = house.house()
    for folder in whole.folders():
        compared(equal(f"{folder.name}: rooms in a circle", expected=[], got=folder.circle))
    compared(equal("circles of files", expected=[], got=whole.circles()))


@pytest.mark.claim("house", "class-names", minutes=0.1)
def test_names__of_classes_and_types_are_defined_once(compared: Callable[..., None]) -> None:
    """No class and no type has a name that is defined twice in the project."""
    twice = house.names_defined_twice()
    compared(equal("names that are defined twice", expected=0, got=len(twice)))
    compared(*(equal(f"files that define {name}", expected=1, got=files) for name, files in twice.items()))


@pytest.mark.claim("house", "types", minutes=0.8)
def test_types__hold_in_tests_and_documentation_too(compared: Callable[..., None]) -> None:
    """mypy finds nothing in the product, the tests and what makes the documentation."""
    ended = subprocess.run([sys.executable, "-m", "mypy"], cwd=house.ROOT, capture_output=True, text=True, check=False)
    errors = ended.stdout.count(": error:")
    compared(equal("exit status of mypy, and errors that it finds", expected=(0, 0), got=(ended.returncode, errors)))


# --- how long a start takes -------------------------------------------------------------------------

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


@pytest.mark.claim("house", "starts", minutes=0.5)
def test_start__is_quick(tmp_path: Path, compared: Callable[..., None]) -> None:
    """The service is ready within a second, and a sweep of a run that is there published within two."""

    def swept(name: str, *options: str) -> float:
        """Seconds of ``whipple sweep`` on a document of a name, whose one run is always the same."""
        document = tmp_path / f"{name}.json"
        document.write_text(json.dumps({**SWEEP, "name": name}))
        begin = time.perf_counter()
        command = [sys.executable, "-m", "service", "sweep", str(document), "--out", str(tmp_path / "out")]
        subprocess.run([*command, *options], cwd=house.ROOT, check=True, capture_output=True)
        return time.perf_counter() - begin

    begin = time.perf_counter()
    with serving(tmp_path / "data") as service:
        service.wait_until_ready()
        compared(at_most("whipple serve until it is ready (s)", limit=READY, got=time.perf_counter() - begin))
    swept("first")
    compared(at_most("whipple sweep of a run that is there (s)", limit=CACHED, got=swept("again", "--overwrite")))


@pytest.mark.claim("house", "starts", minutes=0.2)
def test_answer__about_a_shield_is_quick(tmp_path: Path, compared: Callable[..., None]) -> None:
    """What equations and shots say of a shield takes a second of processor time, and its sheet of one page three."""

    def spent() -> float:
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    for options, limit in (((), ANSWER), (("--out", str(tmp_path / "shield.html")), SHEET)):
        before = spent()
        command = [sys.executable, "-m", "service", "laws", "--at", str(EXAMPLE), *options]
        subprocess.run(command, cwd=house.ROOT, check=True, capture_output=True)
        compared(at_most(f"whipple laws --at shield.yaml {' '.join(options[:1])}", limit=limit, got=spent() - before))


# --- the way of a sweep from its request to the bytes of its cube ------------------------------------

MOST_FILES = 15  # of service and studies
LISTED = re.compile(r"^\d+\. `((?:service|studies)/[\w/]+\.py)`", re.MULTILINE)
# Rooms that help everywhere, what is around every request, what commands of the store are made of, and what keeps
# pictures of a run: no cube has them.
HELPERS = re.compile(
    r"service/(records|files|cli)/.*|studies/(films|quantities)/.*"
    r"|service/api/(access|middleware)\.py|service/store/(connection|events|statements|submission)\.py"
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
    listed = LISTED.findall((house.ROOT / "CONTRIBUTING.md").read_text("utf-8"))
    compared(at_most("files on the way from POST /v1/sweeps to cube.nc", limit=MOST_FILES, got=len(listed)))
    missing = [name for name in listed if not (house.ROOT / name).is_file()]
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

    from service.api.app import open_service
    from service.cli.local import start_engine
    from service.settings import Settings

    with open_service(Settings(data=data, workers=1), start_engine) as app:
        client = TestClient(app, base_url="http://127.0.0.1:8000")
        sweep = client.post("/v1/sweeps", json={**SWEEP, "name": "way"}).json()["links"]["self"]
        wait_until(lambda: client.get(sweep).json()["state"] == "succeeded", seconds=300)
        assert client.get(f"{sweep}/cube.nc").status_code == 200
