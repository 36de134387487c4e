"""Children that are stopped or killed, and a sweep that is interrupted: nothing is lost, and cubes have equal bytes."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from service.files.artifacts import Artifacts
from service.records.jobs import State
from studies.quantities.files import SWEEP_FILES
from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.service.support import inspection
from tests.service.support.crash_test import KillMoment, Victim, Work, crash_test
from tests.service.support.fakes import is_gone, open_store, settings_in, wait_until
from tests.service.support.processes import ROOT, family
from tests.service.support.targets import RUN_GATE

SOLVER = "tests.service.support.solving"


@pytest.mark.claim("mend-again", "equal-cubes", minutes=1.0)
def test_cubes__of_two_services_have_equal_bytes(compared: Compared, tmp_path: Path) -> None:
    """Cubes of the same sweep by two services are equal byte for byte, also after kills and with other workers."""
    work = Work(speeds=2, sweeps=1, targets=SOLVER)
    cubes = []
    for number, (workers, threads) in enumerate([("1", "1"), ("2", "2")]):
        settings = {"WHIPPLE_WORKERS": workers, "WHIPPLE_THREADS": threads}
        place = tmp_path / str(number)
        place.mkdir()
        with crash_test(work, place, settings=settings) as here:
            ids = here.submit()
            if number:
                here.strike(Victim.RUN, moment=KillMoment.CHECKPOINTED)
            here.wait_for_the_end(ids)
            cubes.append(here.fetch(ids, tmp_path / f"cubes-{number}"))
            compared(equal("kills", expected=number, got=here.killed.total()))
    compared(*inspection.rows_of_cubes(*cubes))


WORK = Work(speeds=3, sweeps=1, thicknesses=1, targets="tests.service.support.targets", run_seconds=0.0)
# The last verification waits, however busy the machine is.
SWEEP = """
import sys
from functools import partial
from service.cli import local
from service.workers.timings import Timings
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


@pytest.mark.claim("queue", "interrupt", minutes=0.1)
def test_interrupt__as_from_a_terminal_ends_all_in_order_and_can_be_resumed(tmp_path: Path) -> None:
    """Ctrl-C on a sweep without a service ends every process in order, and the next start goes on."""
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
    [sweep] = store.sweeps.page().items
    runs = inspection.runs(store, [sweep.id]).values()
    assert {run.state for run in runs} <= {State.QUEUED, State.SUCCEEDED}
    log = (tmp_path / "stderr.log").read_text()
    assert log.count("Traceback") == 1, log  # of the sweep itself; workers say nothing

    assert begin(tmp_path, gate).wait(PATIENCE) == 0
    ids = [row.id for row in store.sweeps.page().items]
    assert all(row.passed is not False for row in inspection.rows_of_store(store, artifacts, ids, WORK.runs))
    assert {*SWEEP_FILES} <= {file.name for file in tmp_path.iterdir()}
    store.close()
