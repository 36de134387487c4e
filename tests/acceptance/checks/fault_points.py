"""Named points where the service dies: what the store and the files say then, and that all goes on."""

import functools
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, suppress
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path
from signal import SIGKILL
from typing import Protocol

import httpx
import yaml

from service.files.artifacts import Artifacts, digest
from service.records.fault_points import POINTS, VARIABLE
from service.records.jobs import Kind, State, SweepState, SweepStatus
from service.store import Store
from studies.values.files import RESULT
from tests.acceptance.checks.common import fetch, folder, rows_of_cubes, rows_of_store, undisturbed
from tests.acceptance.support import inline_service, inspection
from tests.acceptance.support.crash_test import CrashTest, Work, crash_test
from tests.acceptance.support.process_tree import process_tree
from tests.acceptance.support.serving import ROOT, START_SECONDS
from tests.rows import Row

WORK = Work(speeds=3, sweeps=1, thicknesses=1, run_seconds=0.1)
KEY = {"Idempotency-Key": "the-only-one"}
COPY = "copy-halfway"
OF_A_SERVICE = POINTS[: POINTS.index(COPY)]
SWEEP = "import sys; from service.cli.local import run_sweep; run_sweep(sys.argv[1], sys.argv[2])"
PUBLISHED = {"cube.nc", "runs.csv", "report.html", "report.json"}


@dataclass
class Observed:
    """What was there when the last life ended."""

    sweeps: list[str] = field(default_factory=list)
    succeeded: int = 0


class FaultSite(Protocol):
    """Where something dies."""

    store: Store
    artifacts: Artifacts


def of_a_service(name: str, database_url: str | None) -> Iterator[Row]:
    """A service that dies at every point in turn, and one that finishes."""
    expected = undisturbed(WORK)
    with folder() as place, crash_test(WORK, place, database_url=database_url) as here:
        here.service.kill()
        yield from lives(name, here, functools.partial(_live_until, here))
        here.service.start()
        here.service.wait_until_listening()
        ids = [row.id for row in here.store.sweeps().items]
        again = _submit(here)
        yield Row(f"{name}: sweeps in the end", ids, [again], ids == [again])
        here.wait_for_the_end([again])
        yield from rows_of_store(here, [again])
        yield from rows_of_cubes(expected, fetch(here, [again], place / "cubes"))
        left = here.leave()
        yield Row(f"{name}: processes left", 0, len(left), not left)


def in_short() -> Iterator[Row]:
    """The same with a service that has no interface and no Dask."""
    with folder() as place, closing(Store.open(f"sqlite:///{place / 'whipple.db'}")) as store:
        here = Small(store, Artifacts(place))
        yield from lives("small", here, here.live_until)
        status = here.live()
        yield Row("small: the next one ends well", 0, status, status == 0)
        [row] = store.sweeps().items
        once = inspection.registered_once(store, [row.id])
        yield Row("small: runs with one result", WORK.runs, len(once), len(once) == WORK.runs)
        yield from _sound(here, "small: in the end")


def lives(name: str, here: FaultSite, live_until: Callable[[str], None]) -> Iterator[Row]:
    """Lives that end at one point after the other, and what is there after each."""
    before = Observed()
    for point in OF_A_SERVICE:
        live_until(point)
        state = EXPECTED[point]
        got = state.look(here, before)
        yield Row(f"{name}, died at {point}: {state.says}", "yes", "yes" if got else "no", got)
        yield from _sound(here, f"{name}, died at {point}")
        before = _observed(here)


def _live_until(here: CrashTest, point: str) -> None:
    """A life that ends at a point; the sweep is given to it again and again, with one key."""
    here.service.start(fault=point)
    if point.startswith("submission"):
        here.service.wait_until_listening()
        with suppress(httpx.TransportError):
            _submit(here)
    status = here.service.die()
    assert status == -SIGKILL, here.service.log_tail()


@dataclass
class Small:
    """A service that is a fork of a process which has loaded it; see ``tests.acceptance.support.inline_service``."""

    store: Store
    artifacts: Artifacts

    def live_until(self, point: str) -> None:
        assert self.live(**{VARIABLE: point}) == -SIGKILL

    def live(self, **more: str) -> int | None:
        forks = get_context("forkserver")
        forks.set_forkserver_preload([inline_service.__name__])
        life = forks.Process(target=inline_service.live, args=(self.artifacts.root, WORK.runs, more))
        life.start()
        life.join(START_SECONDS)
        return life.exitcode


def _submit(here: CrashTest) -> str:
    [document] = here.work.documents()
    url = f"{here.service.url}/v1/sweeps"
    answer = httpx.post(url, json=document, headers=KEY, timeout=60)
    assert answer.status_code == 202, answer.text
    return str(answer.json()["id"])


def _observed(here: FaultSite) -> Observed:
    sweeps = [row.id for row in here.store.sweeps().items]
    return Observed(sweeps, _count(here, State.SUCCEEDED))


# --- what is expected at each point -----------------------------------------------------------------


@dataclass(frozen=True)
class Expected:
    """What must be seen in store and files."""

    says: str
    look: Callable[[FaultSite, Observed], bool]


def _sweep(here: FaultSite) -> SweepStatus:
    [row] = here.store.sweeps().items
    return row


def _count(here: FaultSite, state: State) -> int:
    return sum(_sweep(here).counts[state] for _ in here.store.sweeps().items)


def _is_accepted(here: FaultSite, _observed: Observed) -> bool:
    row = _sweep(here)
    return row.state is SweepState.QUEUED and row.counts[State.QUEUED] == WORK.runs


def _is_claimed(here: FaultSite, _observed: Observed) -> bool:
    return len(here.store.leases()) > 0


def _has_unregistered_answer(here: FaultSite, before: Observed) -> bool:
    answers = [
        here.artifacts.attempt_directory(claim) / RESULT for claim in here.store.leases() if claim.kind is Kind.RUN
    ]
    return any(map(Path.is_file, answers)) and _count(here, State.SUCCEEDED) == before.succeeded


def _has_another(here: FaultSite, before: Observed) -> bool:
    done = [run for run in inspection.runs(here.store, before.sweeps).values() if run.path]
    kept = [run for run in done if here.artifacts.checkpoint(run.id).is_file()]
    return len(done) > before.succeeded and len(kept) > 0


def _is_unpublished(here: FaultSite, _observed: Observed) -> bool:
    row = _sweep(here)
    written = {file.name for file in here.artifacts.sweep_folder(row.id).glob("a*/*")}
    is_publishing = row.state is SweepState.PUBLISHING
    return is_publishing and written >= PUBLISHED and not here.store.artifacts(row.id)


def _is_published(here: FaultSite, _observed: Observed) -> bool:
    row = _sweep(here)
    names = {file.name for file in here.store.artifacts(row.id)}
    return row.state is SweepState.SUCCEEDED and names >= PUBLISHED


CLAIMED = Expected("a row says running", _is_claimed)
UNREGISTERED = Expected("an answer is complete, and no row names it", _has_unregistered_answer)
UNPUBLISHED = Expected("cube and report are complete, and no row names them", _is_unpublished)
EXPECTED: Mapping[str, Expected] = {
    "submission-before-commit": Expected("no sweep is there", lambda here, _: not here.store.queue().states),
    "submission-after-commit": Expected("it is accepted whole", _is_accepted),
    "claim-after-commit": CLAIMED,
    "claim-after-submit": CLAIMED,
    "result-before-registration": UNREGISTERED,
    "result-before-commit": UNREGISTERED,
    "result-after-commit": Expected("one more has its row, and still a checkpoint", _has_another),
    "publication-before-registration": UNPUBLISHED,
    "publication-before-commit": UNPUBLISHED,
    "publication-after-commit": Expected("the sweep is published", _is_published),
}


def _sound(here: FaultSite, where: str) -> Iterator[Row]:
    """The store in itself, and every file that it names."""
    wrong = [*inspection.contradictions(here.store), *inspection.damaged(here.store, here.artifacts)]
    wrong += inspection.half_files(here.store, here.artifacts)
    yield Row(f"{where}: what is wrong in store and files", "nothing", wrong or "nothing", not wrong)


# --- a sweep without a service -----------------------------------------------------------------------


def of_a_copy() -> Iterator[Row]:
    """Killed after the first of three files was copied out; started again, it copies the others."""
    [document] = WORK.documents()
    with folder() as out, process_tree() as tree:
        file = out / "sweep.yaml"
        file.write_text(yaml.safe_dump(document))
        arguments = ["-c", SWEEP, str(file), str(out)]
        status = _run(arguments, **{VARIABLE: COPY})
        yield Row(f"died at {COPY}", -SIGKILL, status, status == -SIGKILL)
        there = {file.name for file in out.iterdir()} & PUBLISHED
        parts = [file.name for file in out.glob(".*.part")]
        yield Row("files copied out, half ones", "1, 0", f"{len(there)}, {len(parts)}", len(there) == 1 and not parts)
        status = _run(arguments)
        yield Row("the next one ends well", 0, status, status == 0)
        with closing(Store.open(f"sqlite:///{out / '.whipple' / 'whipple.db'}", migrate=False)) as store:
            row, *_ = store.sweeps().items  # the youngest; the one before had ended already
            begun = sum(run.attempt for run in inspection.runs(store, [row.id]).values())
            wanted = {file.name: file.sha256 for file in store.artifacts(row.id) if file.name in PUBLISHED}
        yield Row("runs computed again", 0, begun - WORK.runs, begun == WORK.runs)
        got = {name: digest(out / name) for name in wanted}
        whole = wanted == got and len(got) == len(PUBLISHED)
        yield Row("files copied out as registered", len(PUBLISHED), len(got), whole)
        left = tree.pids()
        yield Row("processes left", 0, len(left), not left)


def _run(arguments: list[str], **more: str) -> int:
    """Let Python do something; the status of the process."""
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=ROOT,
        env={**os.environ, **WORK.environment(), **more},
        capture_output=True,
        timeout=START_SECONDS,
        check=False,
    ).returncode
