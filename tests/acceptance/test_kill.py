"""Kill -9, with real processes: what was accepted is finished, registered once, and nothing is left."""

import os
import random
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import yaml

from service.artifacts import LOG, Artifacts
from service.jobs import RunRow, State, Stored, SweepRow, SweepState
from service.settings import Settings
from service.store import Store
from tests.service.cluster import family
from tests.service.doubles import is_gone, open_store, settings_in, wait_until
from tests.service.targets import GATES, RUN_GATE

ROOT = Path(__file__).parents[2]
# A turn, and the last one above all, looks at everything that ended, however busy the machine is.
SWEEP = """
import sys
from service import local, reign
reign.WAIT_SECONDS = reign.LAST_LOOK_SECONDS = 60.0
local.run_sweep(sys.argv[1], sys.argv[2])
"""
RUNS = 6
SEED = 20_261_121


@dataclass
class Drill:
    """A sweep without a service, in a process that can be killed, and its store seen from outside."""

    out: Path
    settings: Settings
    process: "subprocess.Popen[bytes] | None" = None

    @property
    def document(self) -> Path:
        return self.out / "sweep.yaml"

    @property
    def said(self) -> Path:
        return self.out / "stderr.log"

    @property
    def gates(self) -> dict[str, Path]:
        """Without these files no run and no sweep ends: they are still there when they are struck."""
        return {gate: self.out / gate for gate in GATES}

    def open(self, gate: str) -> None:
        """Let what waits there end, now and in every life to come."""
        self.gates[gate].touch()

    def begin(self) -> None:
        """Start the sweep, or go on with it."""
        environment = {
            **os.environ,
            "WHIPPLE_TARGETS_MODULE": "tests.service.targets",
            "WHIPPLE_WORKERS": "2",
            **{gate: str(file) for gate, file in self.gates.items()},
        }
        command = [sys.executable, "-c", SWEEP, str(self.document), str(self.out)]
        with self.said.open("wb") as log:
            self.process = subprocess.Popen(
                command, cwd=ROOT, env=environment, stderr=log, start_new_session=True
            )

    def end(self) -> int:
        """Open all gates and wait for the end of the sweep; its exit status."""
        assert self.process is not None
        for gate in GATES:
            self.open(gate)
        return self.process.wait(300)

    def kill(self) -> None:
        """Kill -9 the process that has store, dispatcher and scheduler."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()

    def running(self) -> list[tuple[RunRow, int]]:
        """Runs under way now, with the processes that compute them."""
        found = []
        for run in self.runs():
            pids = list(self.folder(run).glob(f"a{run.attempt}-*/pid"))
            text = pids[0].read_text() if run.state is State.RUNNING and pids else ""
            if text and not is_gone(int(text)):
                found.append((run, int(text)))
        return found

    def mortal(self, killed: Mapping[str, int]) -> list[tuple[RunRow, int]]:
        """Of these, the ones killed less than twice: the third death is a run's failure."""
        return [(run, pid) for run, pid in self.running() if killed.get(run.id, 0) < 2]

    def process_of(self, id: str, attempt: int) -> int | None:
        """The process that computes an attempt of a run now."""
        found = [pid for run, pid in self.running() if (run.id, run.attempt) == (id, attempt)]
        return found[0] if found else None

    def processes(self) -> list[int]:
        """The process of the sweep, and everything that it started."""
        return family(self.process.pid) if self.process is not None else []

    def runs(self) -> list[RunRow]:
        with self.store() as store:
            rows = store.sweeps().items
            return [point.run for point in store.sweep_runs(rows[0].id).items] if rows else []

    def sweep(self) -> SweepRow:
        with self.store() as store:
            [row] = store.sweeps().items
            return row

    def folder(self, run: RunRow) -> Path:
        return self.settings.data / "runs" / run.id[:2] / run.id

    def store(self) -> "closing[Store]":
        return closing(open_store(self.settings))

    def check(self) -> None:
        """Every run has one result, registered and whole; the copies outside are whole too."""
        assert self.sweep().state is SweepState.SUCCEEDED
        runs = self.runs()
        assert [run.state for run in runs] == [State.SUCCEEDED] * RUNS
        artifacts = Artifacts(self.settings.data)
        for run in runs:
            assert run.path is not None
            assert run.size is not None
            assert run.sha256 is not None
            assert artifacts.is_intact(Stored("result.json", run.path, run.size, run.sha256))
        with self.store() as store:
            events = store.events(self.sweep().id)
            files = store.artifacts(self.sweep().id)
        succeeded = [event.job_id for event in events if event.kind == "succeeded"]
        assert sorted(map(str, succeeded)) == sorted(run.id for run in runs)
        copies = [
            Stored(file.name, file.name, file.size, file.sha256)
            for file in files
            if file.name != LOG
        ]
        assert len(copies) == 3
        assert all(Artifacts(self.out).is_intact(copy) for copy in copies)
        assert not [*self.settings.data.rglob("*.part")]


@pytest.fixture
def drill(tmp_path: Path) -> Iterator[Drill]:
    made = Drill(tmp_path, settings_in(tmp_path / ".whipple"))
    made.document.write_text(yaml.safe_dump(sweep()))
    made.settings.data.mkdir()
    open_store(made.settings).close()  # whoever opens it while it is made finds it locked
    yield made
    left = made.processes()
    made.kill()
    wait_until(partial(all_gone, left))


def sweep(runs: int = RUNS) -> dict[str, Any]:
    return {
        "name": "drill",
        "scenario": "thin_plate",
        "fixed": {
            "projectile": "copper-ofhc",
            "target": "copper-ofhc",
            "projectile_diameter": "8 mm",
            "plate_thickness": "2 mm",
        },
        "axes": {"speed": [f"{2 + number} km/s" for number in range(runs)]},
        "resolution": 8,
    }


def all_gone(pids: list[int]) -> bool:
    return all(is_gone(pid) for pid in pids)


def test_run_killed__is_tried_again_and_its_neighbours_are_untouched(drill: Drill) -> None:
    chance = random.Random(SEED)
    print(f"seed {SEED}")
    drill.begin()
    killed: dict[str, int] = {}
    for _ in range(4):
        run, pid = chance.choice(wait_until(partial(drill.mortal, killed)))
        os.kill(pid, signal.SIGKILL)
        killed[run.id] = killed.get(run.id, 0) + 1
        wait_until(partial(is_gone, pid))
    assert drill.end() == 0
    drill.check()
    crashes = {run.id: run.crashes for run in drill.runs() if run.crashes}
    assert crashes == killed
    assert all(run.attempt == 1 + run.crashes for run in drill.runs())


def test_run_killed_three_times__is_failed_with_a_reason(drill: Drill) -> None:
    # No more runs than slots: a third one would wait at its gate in the slot of the victim.
    drill.document.write_text(yaml.safe_dump(sweep(2)))
    drill.begin()
    victim = wait_until(drill.running)[0][0]
    for attempt in (1, 2, 3):
        pid = wait_until(partial(drill.process_of, victim.id, attempt))
        os.kill(pid, signal.SIGKILL)
    assert drill.end() == 0
    with drill.store() as store:
        run = store.run(victim.id)
    assert (run.state, run.failure, run.crashes) == (State.FAILED, "SIGKILL", 3)
    assert drill.sweep().counts == {**drill.sweep().counts, "succeeded": 1, "failed": 1}


def test_service_killed__leaves_no_process_and_the_next_one_finishes(drill: Drill) -> None:
    for _ in range(2):
        drill.begin()
        under_way = wait_until(drill.running)
        everything = drill.processes()
        assert {pid for _, pid in under_way} <= set(everything)
        drill.kill()
        wait_until(partial(all_gone, everything))
        assert any(run.state is State.RUNNING for run in drill.runs())  # as the crash left it
    drill.begin()
    assert drill.end() == 0
    drill.check()
    assert {run.crashes for run in drill.runs()} == {0}


def test_service_killed_while_it_publishes__no_half_file_is_seen(drill: Drill) -> None:
    drill.begin()
    drill.open(RUN_GATE)
    wait_until(lambda: drill.runs() and drill.sweep().state is SweepState.PUBLISHING, seconds=240.0)
    drill.kill()
    with drill.store() as store:
        assert store.artifacts(drill.sweep().id) == ()
    assert not (drill.out / "cube.nc").exists()
    drill.begin()
    assert drill.end() == 0
    drill.check()


def test_interrupt__as_from_a_terminal_ends_all_in_order_and_can_be_resumed(drill: Drill) -> None:
    drill.begin()
    wait_until(drill.running)
    everything = drill.processes()
    os.killpg(everything[0], signal.SIGINT)  # Ctrl-C reaches every process of the terminal
    assert drill.end() != 0
    wait_until(partial(all_gone, everything))
    assert {run.state for run in drill.runs()} <= {State.QUEUED, State.SUCCEEDED}
    said = drill.said.read_text()
    assert said.count("Traceback") == 1, said  # of the sweep itself; workers say nothing
    drill.begin()
    assert drill.end() == 0
    drill.check()
