"""Rooms, arrows, floors, circles, names and lines, as ``make map`` finds them; and how long a start takes."""

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from tests import house
from tests.acceptance.support.serving import serving
from tests.claims import Row, at_most, claim

ROOMS, ARROWS, FLOORS = 16, 60, 8  # of service and of studies
PRODUCT, TESTS = 25_000, 20_000  # lines, an aim
READY, CACHED = 2.0, 2.0  # s

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


@claim(
    "rooms", says="service and studies have few rooms, few imports between them, few floors and no circle", quick=True
)
def rooms() -> Iterator[Row]:
    for each in house.houses():
        circle = " -> ".join(each.circle)
        yield Row(f"{each.package}: circles", expected="none", got=circle or "none", passed=not circle)
        if each.package != "solver":
            yield at_most(f"{each.package}: rooms", limit=ROOMS, got=len(each.lines))
            yield at_most(f"{each.package}: arrows between rooms", limit=ARROWS, got=len(each.arrows))
            if not circle:
                yield at_most(f"{each.package}: floors", limit=FLOORS, got=len(each.floors))


@claim("class-names", says="no class name is defined twice in the project")
def class_names() -> Iterator[Row]:
    twice = house.classes_defined_twice()
    yield at_most("class names that are defined twice", limit=0, got=len(twice))
    for name, files in twice.items():
        yield Row(f"class {name}", expected="one file", got=", ".join(files), passed=None)


@claim("lines", says="there is a third less to read: 25 000 lines of product and 20 000 of tests (an aim)")
def lines() -> Iterator[Row]:
    product = sum(house.lines_under(house.ROOT / package) for package in house.PACKAGES)
    tests = house.lines_under(house.ROOT / "tests")
    yield Row("lines of solver, studies and service", expected=f"{PRODUCT}, an aim", got=product, passed=None)
    yield Row("lines of tests", expected=f"{TESTS}, an aim", got=tests, passed=None)


@claim("starts", says="the service is ready, and a sweep of a run that is there published, within two seconds")
def starts() -> Iterator[Row]:
    with tempfile.TemporaryDirectory(prefix="whipple-starts-") as name:
        begin = time.perf_counter()
        with serving(Path(name) / "data") as service:
            service.wait_until_ready()
            yield at_most("whipple serve until it is ready (s)", limit=READY, got=time.perf_counter() - begin)
        _swept(Path(name), "first")
        seconds = _swept(Path(name), "again", "--overwrite")
        yield at_most("whipple sweep of a run that is there (s)", limit=CACHED, got=seconds)


def _swept(folder: Path, name: str, *options: str) -> float:
    """Seconds of ``whipple sweep`` on a document of a name, whose one run is always the same."""
    document = folder / f"{name}.json"
    document.write_text(json.dumps({**SWEEP, "name": name}))
    begin = time.perf_counter()
    command = [sys.executable, "-m", "service", "sweep", str(document), "--out", str(folder / "out")]
    subprocess.run([*command, *options], cwd=house.ROOT, check=True, capture_output=True)
    return time.perf_counter() - begin
