"""Named points where the service dies: what the store and the files say then, and that all goes on."""

import functools
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from contextlib import closing, suppress
from dataclasses import dataclass, field, replace
from multiprocessing import get_context
from pathlib import Path
from signal import SIGKILL

import httpx
import pytest
import yaml

from service.files.artifacts import Artifacts, digest
from service.records.jobs import Kind, State, SweepState, SweepStatus
from service.store import Store
from studies.quantities.files import RESULT, SWEEP_FILES
from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.service.support import inline_service, inspection
from tests.service.support.crash_test import CrashTest, Work, crash_test
from tests.service.support.fault_points import POINTS, VARIABLE
from tests.service.support.processes import ROOT, process_tree
from tests.service.support.serving import START_SECONDS

WORK = Work(speeds=3, sweeps=1, thicknesses=1, run_seconds=0.1)
KEY = {"Idempotency-Key": "the-only-one"}
COPY = "copy-halfway"
SWEEP = """
import sys
from service.cli.local import run_sweep
from tests.service.support.fault_points import arm
arm()
run_sweep(sys.argv[1], sys.argv[2])
"""


@dataclass
class FaultSite:
    """Where something dies, and what was there when the last life ended."""

    store: Store
    artifacts: Artifacts
    sweeps: list[str] = field(default_factory=list)
    succeeded: int = 0

    def sweep(self) -> SweepStatus:
        [row] = self.store.sweeps.page().items
        return row

    def count(self, state: State) -> int:
        return sum(row.counts[state] for row in self.store.sweeps.page().items)

    def die_at_every_point(self, live_until: Callable[[str], int], compared: Compared) -> None:
        """Lives that end at one point after the other, and what is there after each."""
        for point in POINTS[: POINTS.index(COPY)]:
            compared(equal(f"exit status at {point}", expected=-SIGKILL, got=live_until(point)))
            says, is_there = EXPECTED[point]
            compared(equal(f"died at {point}: {says}", expected=True, got=is_there(self)))
            compared(equal(f"died at {point}: wrong in store and files", expected=[], got=self.wrong()))
            self.sweeps = [row.id for row in self.store.sweeps.page().items]
            self.succeeded = self.count(State.SUCCEEDED)

    def wrong(self) -> list[str]:
        """What is wrong with the store in itself, and with every file that it names."""
        wrong = [*inspection.contradictions(self.store), *inspection.damaged(self.store, self.artifacts)]
        return [*wrong, *inspection.half_files(self.store, self.artifacts)]


def _is_accepted(here: FaultSite) -> bool:
    row = here.sweep()
    return row.state is SweepState.QUEUED and row.counts[State.QUEUED] == WORK.runs


def _has_unregistered_answer(here: FaultSite) -> bool:
    leases = [lease for lease in here.store.leases.held() if lease.kind is Kind.RUN]
    answers = [here.artifacts.attempt_directory(lease) / RESULT for lease in leases]
    return any(map(Path.is_file, answers)) and here.count(State.SUCCEEDED) == here.succeeded


def _has_another(here: FaultSite) -> bool:
    done = [run for run in inspection.runs(here.store, here.sweeps).values() if run.sha256]
    kept = [run for run in done if here.artifacts.checkpoint(run.id).is_file()]
    return len(done) > here.succeeded and len(kept) > 0


def _is_unpublished(here: FaultSite) -> bool:
    row, files = here.sweep(), here.store.publications.files
    written = {file.name for file in here.artifacts.sweep_folder(row.id).glob("a*/*")}
    return row.state is SweepState.PUBLISHING and written >= {*SWEEP_FILES} and not files(row.id)


def _is_published(here: FaultSite) -> bool:
    row = here.sweep()
    names = {file.name for file in here.store.publications.files(row.id)}
    return row.state is SweepState.SUCCEEDED and names >= {*SWEEP_FILES}


CLAIMED = "a row says running", lambda here: len(here.store.leases.held()) > 0
UNREGISTERED = "an answer is complete, and no row names it", _has_unregistered_answer
UNPUBLISHED = "cube and report are complete, and no row names them", _is_unpublished
EXPECTED: Mapping[str, tuple[str, Callable[[FaultSite], bool]]] = {
    "submission-before-commit": ("no sweep is there", lambda here: not here.store.sweeps.page().items),
    "submission-after-commit": ("it is accepted whole", _is_accepted),
    "claim-after-commit": CLAIMED,
    "claim-after-submit": CLAIMED,
    "result-before-registration": UNREGISTERED,
    "result-before-commit": UNREGISTERED,
    "result-after-commit": ("one more has its row, and still a checkpoint", _has_another),
    "publication-before-registration": UNPUBLISHED,
    "publication-before-commit": UNPUBLISHED,
    "publication-after-commit": ("the sweep is published", _is_published),
}


@pytest.mark.claim("queue", "fault-points", minutes=2.0)
@pytest.mark.parametrize("database", ["sqlite", "postgresql"])
def test_service__that_dies_at_a_point_goes_on(
    database: str, tmp_path: Path, request: pytest.FixtureRequest, compared: Compared
) -> None:
    """A service that dies at a named point leaves a consistent store and no half file, and the next one goes on."""
    url = request.getfixturevalue("postgresql_url") if database == "postgresql" else None
    with crash_test(WORK, tmp_path, database_url=url) as here:
        here.service.kill()
        FaultSite(here.store, here.artifacts).die_at_every_point(functools.partial(_live_until, here), compared)
        here.service.start()
        here.service.wait_until_listening()
        ids = [row.id for row in here.store.sweeps.page().items]
        compared(equal("sweeps in the end", expected=ids, got=[_submit(here)]))
        compared(*here.rows_of_the_end(ids, tmp_path / "cubes"))


def _live_until(here: CrashTest, point: str) -> int:
    """A life that ends at a point, and how; the sweep is given to it again and again, with one key."""
    here.service.start(fault=point)
    if point.startswith("submission"):
        here.service.wait_until_listening()
        with suppress(httpx.TransportError):
            _submit(here)
    return here.service.die()


def _submit(here: CrashTest) -> str:
    [document] = here.work.documents()
    answer = httpx.post(f"{here.service.url}/v1/sweeps", json=document, headers=KEY, timeout=60)
    assert answer.status_code == 202, answer.text
    return str(answer.json()["id"])


@pytest.mark.claim("queue", "fault-points")
def test_fork_of_a_service__that_dies_at_a_point_goes_on(tmp_path: Path, compared: Compared) -> None:
    """The same of a service without interface and engine, which is the fork of a process that has loaded it."""

    def live(**more: str) -> int:
        forks = get_context("forkserver")
        forks.set_forkserver_preload([inline_service.__name__])
        life = forks.Process(target=inline_service.live, args=(tmp_path, WORK.runs, more))
        life.start()
        life.join(START_SECONDS)
        assert life.exitcode is not None
        return life.exitcode

    with closing(Store.open(f"sqlite:///{tmp_path / 'whipple.db'}")) as store:
        here = FaultSite(store, Artifacts(tmp_path))
        here.die_at_every_point(lambda point: live(**{VARIABLE: point}), compared)
        compared(equal("exit status of the next one", expected=0, got=live()))
        once = inspection.registered_once(store, [here.sweep().id])
        compared(equal("runs with one result", expected=WORK.runs, got=len(once)))
        compared(equal("wrong in store and files", expected=[], got=here.wrong()))


@pytest.mark.claim("queue", "fault-points", minutes=0.1)
def test_copy__that_dies_after_the_first_file_is_completed(tmp_path: Path, compared: Compared) -> None:
    """A sweep without a service that is killed while it copies files out copies the others when it starts again."""
    work = replace(WORK, targets="tests.service.support.targets", run_seconds=0.0)
    [document] = work.documents()
    file, published = tmp_path / "sweep.yaml", {*SWEEP_FILES}
    file.write_text(yaml.safe_dump(document))

    def run(**more: str) -> int:
        return subprocess.run(
            [sys.executable, "-c", SWEEP, str(file), str(tmp_path)],
            cwd=ROOT,
            env={**os.environ, **work.environment(), **more},
            capture_output=True,
            timeout=START_SECONDS,
            check=False,
        ).returncode

    with process_tree() as tree:
        compared(equal(f"died at {COPY}", expected=-SIGKILL, got=run(**{VARIABLE: COPY})))
        there = {each.name for each in tmp_path.iterdir()} & published
        compared(equal("files copied out", expected=1, got=len(there)))
        compared(equal("half files", expected=[], got=[each.name for each in tmp_path.glob(".*.part")]))
        compared(equal("the next one ends well", expected=0, got=run()))
        with closing(Store.open(f"sqlite:///{tmp_path / '.whipple' / 'whipple.db'}", migrate=False)) as store:
            row, *_ = store.sweeps.page().items  # the youngest; the one before had ended already
            begun = sum(run.attempt for run in inspection.runs(store, [row.id]).values())
            wanted = {each.name: each.sha256 for each in store.publications.files(row.id) if each.name in published}
        compared(equal("runs computed again", expected=0, got=begun - work.runs))
        compared(equal("files registered", expected=published, got=set(wanted)))
        compared(equal("files copied out", expected=wanted, got={name: digest(tmp_path / name) for name in wanted}))
        compared(equal("processes left", expected=0, got=len(tree.pids())))
