"""The engine on a Dask scheduler: what dies, goes away and comes back, and which workers get no work."""

import json
import logging
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path

import pytest
from pydantic import ByteSize

from service.dask import engine as dask
from service.dask import worker as dask_worker
from service.execution import probe
from service.records.jobs import Cause
from service.settings import Settings
from service.workers.attempt import Attempt, Away, Back, Ended
from service.workers.timings import DEFAULT
from solver import PHYSICS_VERSION
from tests.claims.marked import Compared
from tests.claims.rows import at_most
from tests.service.dask.cluster import PRELOAD, DaskCluster, running, serving
from tests.service.support.attempts import EngineUser, attempt_in, checkpoint_step, pid_of
from tests.service.support.fakes import is_gone
from tests.service.support.processes import ROOT, environment, patiently

# A cluster takes four seconds of computing; the contract of engines (test_engine.py) has another in each make test.
pytestmark = pytest.mark.claim("queue", "dask", minutes=0.3)
WORKERS = 2
MEMORY_LIMIT = ByteSize(4 << 30)

# A service in a process of its own: gives these attempts to the scheduler, reports it, and stays.
SERVICE = """
import json, sys, time
from pathlib import Path
from queue import SimpleQueue
from service.workers.attempt import Attempt
from service.dask.engine import DaskEngine, Remote
job = json.loads(sys.argv[1])
address, *files = job["remote"]
engine = DaskEngine(Remote(address, *map(Path, files)), SimpleQueue())
while not engine.slots():
    time.sleep(0.05)
for attempt in job["attempts"]:
    engine.submit(Attempt(**attempt))
print("submitted", flush=True)
time.sleep(600)
"""

# The same, killed between the submission of its attempt and the order to keep it.
UNKEPT = (
    """
import os, signal
from service.dask.engine import SchedulerConnection
from service.workers.attempt import Attempt
def die(*_, **__):
    directory = Path(job["attempts"][0]["directory"])
    while not (directory / "pid").exists():  # a worker computes it
        time.sleep(0.02)
    os.kill(os.getpid(), signal.SIGKILL)
SchedulerConnection.publish_dataset = die
"""
    + SERVICE
)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[DaskCluster]:
    with running(tmp_path_factory.mktemp("cluster"), WORKERS) as started:
        yield started


@pytest.fixture
def user(cluster: DaskCluster) -> Iterator[EngineUser]:
    with serving(cluster.remote()) as opened:
        opened.wait_for_slots(WORKERS)
        yield opened


def settings_of(cluster: DaskCluster, folder: Path) -> Settings:
    remote = cluster.remote()
    return Settings(
        data=folder,
        engine=remote.address,
        tls_ca=remote.ca,
        tls_cert=remote.certificate,
        tls_key=remote.key,
        memory_limit=MEMORY_LIMIT,
    )


# --- workers that go -----------------------------------------------------------------------------


def test_worker_told_to_end__only_its_own_run_is_lost_and_has_a_checkpoint(
    cluster: DaskCluster, user: EngineUser, tmp_path: Path
) -> None:
    """SIGTERM, as Slurm sends it when the time of a job is over."""
    *before, last = [type(message) for message in user.receive()]
    assert set(before) == {Away}  # one more for each connection that a busy scheduler refuses
    assert last is Back
    extra = cluster.start_workers(1)
    user.wait_for_slots(WORKERS + 1)
    attempts = [attempt_in(tmp_path, number, seconds=3.0) for number in range(WORKERS + 1)]
    user.begin(*attempts)
    extra.look()
    extra.process.send_signal(signal.SIGTERM)
    ends = [user.end_of(attempt) for attempt in attempts]
    patiently(extra.is_gone)
    pairs = zip(attempts, ends, strict=True)
    [left] = [attempt for attempt, end in pairs if end.cause is Cause.LOST]
    assert checkpoint_step(left) > 0
    assert is_gone(pid_of(left))
    user.wait_for_slots(WORKERS)


# --- the service dies ----------------------------------------------------------------------------


def start_service(cluster: DaskCluster, attempts: list[Attempt], program: str = SERVICE) -> "subprocess.Popen[bytes]":
    remote = cluster.remote()
    files = [str(file) for file in (remote.ca, remote.certificate, remote.key)]
    job = {"remote": [remote.address, *files], "attempts": [asdict(message) for message in attempts]}
    return subprocess.Popen(
        [sys.executable, "-c", program, json.dumps(job)], cwd=ROOT, env=environment(), stdout=subprocess.PIPE
    )


def test_service_killed__the_next_one_follows_its_attempts(cluster: DaskCluster, tmp_path: Path) -> None:
    short, long = attempt_in(tmp_path, 1), attempt_in(tmp_path, 2, seconds=3.0)
    with start_service(cluster, [short, long]) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == b"submitted\n"
            pid = pid_of(long)
        finally:
            process.kill()
    with serving(cluster.remote()) as user:
        user.wait_for_slots(WORKERS)
        assert {short.key, long.key} <= user.engine.attempts()
        for attempt in (short, long, long):  # the second time has no effect
            user.engine.follow(attempt.key)
        assert {user.end_of(attempt).cause for attempt in (short, long)} == {None}
        assert pid_of(long) == pid
        assert user.progress_of(long)
        ended = [message.key for message in user.receive() if isinstance(message, Ended)]
        assert sorted(ended) == sorted([short.key, long.key])
        assert not {short.key, long.key} & user.engine.attempts()


@pytest.mark.claim("doors", "orphan", minutes=1.5)
def test_service_killed_before_its_attempt_is_kept__the_attempt_ends(
    cluster: DaskCluster, tmp_path: Path, compared: Compared
) -> None:
    """An attempt that no service can find again is over before a next service has begun: 20 kills."""
    for number in range(20):
        attempt = attempt_in(tmp_path, number, seconds=30.0)
        start_service(cluster, [attempt], UNKEPT).wait(60)
        begin = time.monotonic()
        patiently(partial(is_gone, pid_of(attempt)))
        # Another service takes over when the lock of the first is free, and connects for 2 s and more.
        compared(at_most(f"kill {number}: s until its process is gone", limit=2.0, got=time.monotonic() - begin))


# --- the scheduler goes away ---------------------------------------------------------------------


def test_scheduler_frozen__is_away_and_its_attempts_are_found_again(cluster: DaskCluster, tmp_path: Path) -> None:
    with serving(cluster.remote(), replace(DEFAULT, answer=2.0)) as user:
        frozen = cluster.processes[0].process.pid
        user.wait_for_slots(WORKERS)
        attempt = attempt_in(tmp_path, seconds=3.0)
        [pid] = user.begin(attempt)
        os.killpg(frozen, signal.SIGSTOP)
        try:
            assert user.engine.slots() == 0
            with pytest.raises(OSError, match="away"):
                user.engine.stop([attempt.key])
            user.wait_for(Away)
        finally:
            os.killpg(frozen, signal.SIGCONT)
        assert user.end_of(attempt).cause is None
        assert pid_of(attempt) == pid
        user.wait_for_slots(WORKERS)


def test_no_worker_comes__attempts_that_wait_for_one_are_lost(
    cluster: DaskCluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dask_worker, "OFFER", "whipple of tomorrow")
    monkeypatch.setattr(dask_worker, "software", lambda: {"whipple": "tomorrow"})
    with serving(cluster.remote(), replace(DEFAULT, no_slot=1.0)) as user:
        attempt = attempt_in(tmp_path)
        user.wait_for(Back)
        user.engine.submit(attempt)
        patiently(lambda: user.engine.slots() == 0 and isinstance(user.receive()[-1], Ended))
        assert user.end_of(attempt).cause is Cause.LOST
        assert not user.engine.attempts()


# --- which workers get no work -------------------------------------------------------------------

OLDER = "import solver\n\nsolver.PHYSICS_VERSION = 0\n"


@pytest.mark.parametrize(
    ("preload", "difference"),
    [
        (f"--preload older --preload {PRELOAD}", f"physics 0, on the service {PHYSICS_VERSION}"),
        ("--preload json", f"the worker was started without --preload {PRELOAD}"),
    ],
)
def test_worker_of_another_kind__gets_no_work_and_is_named(
    cluster: DaskCluster,
    user: EngineUser,
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
    preload: str,
    difference: str,
) -> None:
    def workers() -> dict[str, str]:
        return dict(probe(settings_of(cluster, tmp_path)))

    (tmp_path / "older.py").write_text(OLDER)
    before = workers()
    assert list(before.values()) == [""] * WORKERS
    path = os.pathsep.join([str(ROOT), str(tmp_path)])
    other = cluster.start_workers(1, preload=preload, PYTHONPATH=path)
    patiently(lambda: workers().keys() - before.keys())
    [address] = workers().keys() - before.keys()
    assert difference in workers()[address]
    with caplog.at_level(logging.WARNING, logger=dask.__name__):
        assert user.engine.slots() == user.engine.slots() == WORKERS
    warnings = [message for message in caplog.messages if address in message]
    assert warnings == [f"the worker {address} receives no work: {difference}"]
    attempts = [attempt_in(tmp_path, number, seconds=0.5) for number in range(4)]
    assert {ending.cause for ending in user.compute(*attempts)} == {None}
    other.look()
    assert not {pid_of(attempt) for attempt in attempts} & other.descendants
    other.kill()
    patiently(lambda: workers() == before)


# --- trust ---------------------------------------------------------------------------------------


def test_other_authority__the_scheduler_is_not_trusted(cluster: DaskCluster, tmp_path: Path) -> None:
    other = DaskCluster(tmp_path, cluster.port)
    other.certify()
    with serving(other.remote()) as user:
        patiently(lambda: len(user.receive()) == 2)
        [_, away] = user.receive()
        assert isinstance(away, Away)
        assert "certificate verify failed" in away.reason
    with pytest.raises(OSError, match="certificate verify failed"):
        probe(settings_of(other, tmp_path))
