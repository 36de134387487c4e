"""The process that opens cubes: it may take so long and so much, and leaves with the service."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from service import slices
from service.errors import Busy, SliceFailed
from service.slices import Part, Slices
from tests.service.doubles import is_gone, wait_until


def make(tmp_path: Path, **limits: Any) -> Slices:
    return Slices(tmp_path / "cache", **limits)


ANY = Part((), {}, "json")


def stand_in(monkeypatch: pytest.MonkeyPatch, code: str) -> None:
    """Let the child be another program."""
    plain = slices.subprocess.Popen

    def popen(command: list[str], **given: Any) -> Any:
        return plain([sys.executable, "-c", code], **given)

    monkeypatch.setattr(slices.subprocess, "Popen", popen)


def test_child__that_is_late_is_killed_and_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stand_in(monkeypatch, "import time; time.sleep(600)")
    cutter = make(tmp_path, seconds=0.5)
    with pytest.raises(SliceFailed, match=r"more than 0\.5 s"):
        cutter.part(tmp_path / "cube.nc", "00", ANY)
    assert cutter._child is None
    assert not list((tmp_path / "cache").iterdir())


def test_child__that_dies_is_no_end_of_the_service(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stand_in(monkeypatch, "import os; os.abort()")
    cutter = make(tmp_path)
    with pytest.raises(SliceFailed):
        cutter.part(tmp_path / "cube.nc", "00", ANY)
    cutter.close()


def test_child__without_memory_says_so(tmp_path: Path) -> None:
    cutter = make(tmp_path, memory=64 << 20)
    try:
        with pytest.raises(SliceFailed):
            cutter.part(tmp_path / "cube.nc", "00", ANY)
    finally:
        cutter.close()


def test_child__leaves_with_the_service(tmp_path: Path) -> None:
    cutter = make(tmp_path)
    with pytest.raises(SliceFailed, match="log"):
        cutter.part(tmp_path / "cube.nc", "00", ANY)  # there is no such file
    child = cutter._child
    assert child is not None
    assert child.poll() is None
    cutter.close()
    assert child.poll() is not None
    with pytest.raises(Busy):
        cutter.part(tmp_path / "cube.nc", "00", ANY)


ORPHAN = """
import os, signal, sys
from pathlib import Path
from service.slices import Part, Slices
cutter = Slices(Path(sys.argv[1]))
try:
    cutter.part(Path("/nowhere"), "00", Part((), {}, "json"))
except Exception as error:
    pass
print(cutter._child.pid, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_child__leaves_with_a_service_that_is_killed(tmp_path: Path) -> None:
    said = subprocess.run(
        [sys.executable, "-c", ORPHAN, tmp_path],
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
        check=False,
    )
    pid = int(said.stdout)
    wait_until(lambda: is_gone(pid))


def test_orders__that_wait_are_few(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in(monkeypatch, "import time; time.sleep(600)")
    cutter = make(tmp_path, seconds=0.1)

    def ask(number: int) -> type[Exception]:
        try:
            cutter.part(tmp_path / "cube.nc", str(number), ANY)
        except (SliceFailed, Busy) as error:
            return type(error)
        raise AssertionError("it cannot be made")

    most = slices.MOST_WAITING
    with ThreadPoolExecutor(2 * most) as pool:
        with cutter._turn:  # until all have asked
            asked = [pool.submit(ask, number) for number in range(2 * most)]
            wait_until(lambda: sum(one.done() for one in asked) == most - 1)
        got = [one.result() for one in asked]
    assert got.count(Busy) == most - 1
    assert got.count(SliceFailed) == most + 1
