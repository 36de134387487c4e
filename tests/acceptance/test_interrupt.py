"""Ctrl-C on a sweep without a service: everything ends in order, and the next call finishes the sweep."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import yaml

from service.files.artifacts import Artifacts
from service.records.jobs import State
from tests.acceptance.support import inspection
from tests.acceptance.support.crash_test import Work
from tests.acceptance.support.serving import ROOT
from tests.service.support.cluster import family
from tests.service.support.fakes import is_gone, open_store, settings_in, wait_until
from tests.service.support.targets import RUN_GATE

WORK = Work(speeds=3, sweeps=1, thicknesses=1, targets="tests.service.support.targets", run_seconds=0.0)
# The last verification waits, however busy the machine is.
SWEEP = """
import sys
from functools import partial
from service.cli import local
from service.records.timings import Timings
local.start_engine = partial(local.start_engine, timings=Timings(last_verification_wait=60.0))
local.run_sweep(sys.argv[1], sys.argv[2])
"""
PATIENCE = 300.0  # s


def begin(out: Path, gate: Path) -> "subprocess.Popen[bytes]":
    """A sweep in a session of its own; no run of it ends before the gate is there."""
    environment = {**os.environ, **WORK.environment(), RUN_GATE: str(gate)}
    command = [sys.executable, "-c", SWEEP, str(out / "sweep.yaml"), str(out)]
    with (out / "stderr.log").open("wb") as log:
        return subprocess.Popen(command, cwd=ROOT, env=environment, stderr=log, start_new_session=True)


def test_interrupt__as_from_a_terminal_ends_all_in_order_and_can_be_resumed(tmp_path: Path) -> None:
    [document] = WORK.documents()
    (tmp_path / "sweep.yaml").write_text(yaml.safe_dump(document))
    settings, gate = settings_in(tmp_path / ".whipple"), tmp_path / "gate"
    settings.data.mkdir()
    store, artifacts = open_store(settings), Artifacts(settings.data)

    process = begin(tmp_path, gate)
    wait_until(lambda: [*settings.data.glob("runs/*/*/a*/pid")])
    everything = family(process.pid)
    os.killpg(process.pid, signal.SIGINT)  # Ctrl-C reaches every process of the terminal
    gate.touch()
    assert process.wait(PATIENCE) != 0
    wait_until(lambda: all(map(is_gone, everything)))
    [sweep] = store.sweeps().items
    runs = inspection.runs(store, [sweep.id]).values()
    assert {run.state for run in runs} <= {State.QUEUED, State.SUCCEEDED}
    log = (tmp_path / "stderr.log").read_text()
    assert log.count("Traceback") == 1, log  # of the sweep itself; workers say nothing

    assert begin(tmp_path, gate).wait(PATIENCE) == 0
    ids = [row.id for row in store.sweeps().items]
    assert len(inspection.registered_once(store, ids)) == WORK.runs
    assert not inspection.damaged(store, artifacts)
    assert not inspection.half_files(store, artifacts)
    assert {"cube.nc", "runs.csv", "report.html", "report.json"} <= {file.name for file in tmp_path.iterdir()}
    store.close()
