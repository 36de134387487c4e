"""The engine on somebody's scheduler: what dies, goes away and comes back, and who gets no work."""

import json
import logging
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, replace
from pathlib import Path
from queue import SimpleQueue

import pytest
from pydantic import ByteSize, ValidationError

from service.execution import dask
from service.execution.dask import DaskEngine, SchedulerConnection, probe
from service.records.attempt import Attempt, Away, Back, Ended, Inbox
from service.records.jobs import Cause
from service.records.settings import Settings
from solver import PHYSICS_VERSION
from tests.service.support.cluster import (
    PRELOAD,
    ROOT,
    Cluster,
    Line,
    Service,
    environment,
    free_port,
    parent_of,
    patiently,
    pid_of,
    pids_of,
    running,
    serving,
    ticket,
)
from tests.service.support.fakes import is_gone

WORKERS = 2
MEMORY_LIMIT = ByteSize(4 << 30)

# A service in a process of its own: gives these orders to the scheduler, says so, and stays.
SERVICE = """
import json, sys, time
from pathlib import Path
from queue import SimpleQueue
from service.records.attempt import Ticket
from service.execution.dask import DaskEngine, Remote
said = json.loads(sys.argv[1])
address, *files = said["remote"]
engine = DaskEngine(Remote(address, *map(Path, files)), SimpleQueue())
while not engine.slots():
    time.sleep(0.05)
for order in said["orders"]:
    engine.submit(Ticket(**order))
print("given", flush=True)
time.sleep(600)
"""


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    with running(tmp_path_factory.mktemp("cluster"), WORKERS) as one:
        yield one


@pytest.fixture
def service(cluster: Cluster) -> Iterator[Service]:
    with serving(cluster.remote()) as one:
        one.wait_for_slots(WORKERS)
        yield one


def settings_of(cluster: Cluster, folder: Path) -> Settings:
    remote = cluster.remote()
    return Settings(
        data=folder,
        engine=remote.address,
        tls_ca=remote.ca,
        tls_cert=remote.certificate,
        tls_key=remote.key,
        memory_limit=MEMORY_LIMIT,
    )


# --- a scheduler that stays ----------------------------------------------------------------------


def test_attempts__are_computed_in_warm_processes_and_tell_of_it(
    service: Service, tmp_path: Path
) -> None:
    orders = [ticket(tmp_path, number, seconds=1.5) for number in range(4)]
    for pair in (orders[:2], orders[2:]):
        for order in pair:
            service.engine.submit(order)
        assert {service.end_of(order).cause for order in pair} == {None}
    assert len({pid_of(order) for order in orders}) == WORKERS
    assert service.told(orders[0])[-1]["checkpoint"]


def test_scheduler__is_said_to_be_away_until_it_answers(service: Service) -> None:
    assert [type(message) for message in service.listen()] == [Away, Back]


def test_worker_told_to_end__only_its_own_run_is_lost_and_has_a_checkpoint(
    cluster: Cluster, service: Service, tmp_path: Path
) -> None:
    """SIGTERM, as Slurm sends it when the time of a job is over."""
    extra = cluster.start_workers(1)
    service.wait_for_slots(WORKERS + 1)
    orders = [ticket(tmp_path, number, seconds=5.0) for number in range(WORKERS + 1)]
    for order in orders:
        service.engine.submit(order)
    # At once: until the others have begun, this one may have ended.
    patiently(lambda: pids_of(orders) & set(extra.look()))
    extra.process.send_signal(signal.SIGTERM)
    ends = [service.end_of(order) for order in orders]
    patiently(extra.is_gone)
    [left] = [order for order, end in zip(orders, ends, strict=True) if end.cause is Cause.LOST]
    assert int(Path(str(left.checkpoint)).read_text()) > 0
    assert is_gone(pid_of(left))
    service.wait_for_slots(WORKERS)


def test_nanny_killed__nothing_of_it_is_left(
    cluster: Cluster, service: Service, tmp_path: Path
) -> None:
    extra = cluster.start_workers(1)
    service.wait_for_slots(WORKERS + 1)
    orders = [ticket(tmp_path, number, "deaf") for number in range(WORKERS + 1)]
    for order in orders:
        service.engine.submit(order)
    pids = {pid_of(order) for order in orders}
    extra.kill_alone()
    assert len(pids & extra.seen) == 1
    patiently(extra.is_gone)
    service.engine.stop([order.key for order in orders])
    assert {service.end_of(order).cause for order in orders} == {Cause.LOST}
    service.wait_for_slots(WORKERS)


def test_worker_frozen__stop_reaches_the_others(service: Service, tmp_path: Path) -> None:
    stopped, other = ticket(tmp_path, 1, "hang"), ticket(tmp_path, 2, seconds=1.0)
    for order in (stopped, other):
        service.engine.submit(order)
    pid_of(stopped)
    frozen = parent_of(pid_of(other))
    os.kill(frozen, signal.SIGSTOP)
    try:
        begin = time.monotonic()
        for _ in range(3):
            service.engine.stop([stopped.key, other.key])
        assert time.monotonic() - begin < dask.ANSWER_SECONDS
        assert service.end_of(stopped).failure == "Stopped"
    finally:
        os.kill(frozen, signal.SIGCONT)
    service.end_of(other)
    service.wait_for_slots(WORKERS)


# --- the service dies ----------------------------------------------------------------------------


def start_service(cluster: Cluster, orders: list[Attempt]) -> "subprocess.Popen[bytes]":
    remote = cluster.remote()
    files = [str(file) for file in (remote.ca, remote.certificate, remote.key)]
    said = {"remote": [remote.address, *files], "orders": [asdict(order) for order in orders]}
    return subprocess.Popen(
        [sys.executable, "-c", SERVICE, json.dumps(said)],
        cwd=ROOT,
        env=environment(),
        stdout=subprocess.PIPE,
    )


def test_service_killed__the_next_one_adopts_its_attempts(cluster: Cluster, tmp_path: Path) -> None:
    short, long = ticket(tmp_path, 1), ticket(tmp_path, 2, seconds=6.0)
    with start_service(cluster, [short, long]) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == b"given\n"
            pid = pid_of(long)
        finally:
            process.kill()
    with serving(cluster.remote()) as service:
        service.wait_for_slots(WORKERS)
        assert {short.key, long.key} <= service.engine.known()
        for order in (short, long, long):  # of what it follows it is asked again in vain
            service.engine.follow(order.key)
        assert service.end_of(short).cause is None
        assert service.end_of(long).cause is None
        assert pid_of(long) == pid  # the process of then
        assert service.told(long)
        ends = [one.key for one in service.listen() if isinstance(one, Ended)]
        assert sorted(ends) == sorted([short.key, long.key])
        assert not {short.key, long.key} & service.engine.known()


def test_service_that_goes_without_a_word__its_attempts_go_on(
    cluster: Cluster, tmp_path: Path
) -> None:
    order = ticket(tmp_path, seconds=3.0)
    with serving(cluster.remote(), leave_seconds=None) as service:
        service.wait_for_slots(WORKERS)
        service.engine.submit(order)
        pid_of(order)
    with serving(cluster.remote()) as service:
        service.wait_for_slots(WORKERS)
        service.engine.follow(order.key)
        assert service.end_of(order).cause is None


# --- the connection breaks -----------------------------------------------------------------------


def test_connection_cut__attempts_go_on_and_are_found_again(
    cluster: Cluster, tmp_path: Path
) -> None:
    line = Line(cluster.port)
    long, short = ticket(tmp_path, 1, seconds=5.0), ticket(tmp_path, 2, seconds=0.5)
    try:
        with serving(cluster.remote(line.port)) as service:
            service.wait_for_slots(WORKERS)
            for order in (long, short):
                service.engine.submit(order)
            pid_of(long)
            line.cut()
            patiently(lambda: isinstance(service.listen()[-1], Away))
            assert service.engine.slots() == 0
            with pytest.raises(OSError, match="away"):
                service.engine.known()
            done = Path(short.directory) / "result.json"
            patiently(done.is_file)  # meanwhile
            line.mend()
            patiently(lambda: any(isinstance(one, Back) for one in service.listen()[2:]))
            assert service.end_of(short).cause is None
            assert service.end_of(long).cause is None
    finally:
        line.close()


# --- the scheduler dies --------------------------------------------------------------------------


def test_scheduler_killed__runs_leave_their_checkpoint_and_the_service_waits(
    tmp_path: Path,
) -> None:
    with running(tmp_path / "cluster", 0) as cluster, serving(cluster.remote()) as service:
        [scheduler] = cluster.processes
        workers = cluster.start_workers(1)
        service.wait_for_slots(1)
        order = ticket(tmp_path, seconds=20.0)
        service.engine.submit(order)
        pid = pid_of(order)
        patiently(lambda: service.told(order))
        workers.look()
        scheduler.kill()
        patiently(workers.is_gone)
        assert is_gone(pid)
        assert int(Path(str(order.checkpoint)).read_text()) > 0
        patiently(lambda: isinstance(service.listen()[-1], Away))
        assert service.engine.slots() == 0
        cluster.start_scheduler()
        cluster.start_workers(1)
        service.wait_for_slots(1)
        assert service.end_of(order).cause is Cause.LOST
        again = replace(ticket(tmp_path, 1, seconds=1.0))
        service.engine.submit(again)
        assert service.end_of(again).cause is None


def test_scheduler_frozen__is_away_and_its_attempts_are_found_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with running(tmp_path / "cluster", 0) as cluster, serving(cluster.remote()) as service:
        [frozen] = cluster.processes
        cluster.start_workers(1)
        service.wait_for_slots(1)
        order = ticket(tmp_path, seconds=3.0)
        service.engine.submit(order)
        pid = pid_of(order)
        monkeypatch.setattr(dask, "ANSWER_SECONDS", 1.0)
        os.killpg(frozen.process.pid, signal.SIGSTOP)
        try:
            with ThreadPoolExecutor(1) as thread:
                assert thread.submit(service.engine.slots).result(60) == 0
            with pytest.raises(OSError, match="away"):
                service.engine.stop([order.key])
            patiently(lambda: isinstance(service.listen()[-1], Away))
            with pytest.raises(OSError, match="away"):
                service.engine.follow("another")
        finally:
            os.killpg(frozen.process.pid, signal.SIGCONT)
        assert service.end_of(order).cause is None
        assert pid_of(order) == pid
        service.wait_for_slots(1)


def test_follow__that_failed_can_be_asked_for_again(
    service: Service, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_arguments: object) -> None:
        raise ConnectionError("it went away just now")

    order = ticket(tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(SchedulerConnection, "kept", refuse)
        with pytest.raises(ConnectionError, match="just now"):
            service.engine.follow(order.key)
    service.engine.follow(order.key)
    assert service.end_of(order).failure == "Gone"


def test_no_worker_comes__attempts_that_wait_for_one_are_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dask, "NO_SLOT_SECONDS", 1.0)
    with running(tmp_path / "cluster", 0) as cluster, serving(cluster.remote()) as service:
        order = ticket(tmp_path)
        service.wait_until_back()
        service.engine.submit(order)
        patiently(lambda: service.engine.slots() == 0 and isinstance(service.listen()[-1], Ended))
        assert service.end_of(order).cause is Cause.LOST
        assert not service.engine.known()


# --- who gets no work ----------------------------------------------------------------------------

OLDER = "import solver\n\nsolver.PHYSICS_VERSION = 0\n"


@pytest.mark.parametrize(
    ("preload", "difference"),
    [
        (f"--preload older --preload {PRELOAD}", f"physics 0, here {PHYSICS_VERSION}"),
        ("--preload json", f"it was started without --preload {PRELOAD}"),
    ],
)
def test_worker_of_another_kind__gets_no_work_and_is_named(
    cluster: Cluster,
    service: Service,
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
    preload: str,
    difference: str,
) -> None:
    (tmp_path / "older.py").write_text(OLDER)
    path = os.pathsep.join([str(ROOT), str(tmp_path)])
    before = set(probe(settings_of(cluster, tmp_path)).workers)
    other = cluster.start_workers(1, preload=preload, PYTHONPATH=path)
    patiently(lambda: set(probe(settings_of(cluster, tmp_path)).workers) - before)
    [address] = set(probe(settings_of(cluster, tmp_path)).workers) - before
    assert difference in probe(settings_of(cluster, tmp_path)).workers[address]
    with caplog.at_level(logging.WARNING, logger=dask.__name__):
        assert service.engine.slots() == service.engine.slots() == WORKERS
    said = [one.getMessage() for one in caplog.records if address in one.getMessage()]
    assert said == [f"the worker {address} gets no work: {difference}"]
    orders = [ticket(tmp_path, number, seconds=0.5) for number in range(4)]
    for order in orders:
        service.engine.submit(order)
    assert {service.end_of(order).cause for order in orders} == {None}
    other.look()
    assert not {pid_of(order) for order in orders} & other.seen
    other.kill()
    patiently(lambda: set(probe(settings_of(cluster, tmp_path)).workers) == before)


# --- who may talk to whom ------------------------------------------------------------------------


def test_tcp__is_refused(cluster: Cluster, tmp_path: Path) -> None:
    remote = cluster.remote()
    with pytest.raises(ValidationError, match="tls://"):
        Settings(data=tmp_path, engine=remote.address.replace("tls://", "tcp://"))


def test_other_authority__the_scheduler_is_not_trusted(cluster: Cluster, tmp_path: Path) -> None:
    other = Cluster(tmp_path, cluster.port)
    other.certify()
    with serving(other.remote()) as service:
        patiently(lambda: len(service.listen()) == 2)
        [_, away] = service.listen()
        assert isinstance(away, Away)
        assert "certificate verify failed" in away.reason
    with pytest.raises(OSError, match="certificate verify failed"):
        probe(settings_of(other, tmp_path))


def test_nobody_there__is_said_once_and_tried_again(tmp_path: Path) -> None:
    cluster = Cluster(tmp_path, free_port())
    cluster.certify()
    inbox: Inbox = SimpleQueue()
    engine = DaskEngine(cluster.remote(), inbox)
    try:
        service = Service(engine, inbox)
        patiently(lambda: len(service.listen()) == 2)
        [_, away] = service.listen()
        assert isinstance(away, Away)
        assert "refused" in away.reason
    finally:
        engine.close()


def test_probe__says_who_works(cluster: Cluster, tmp_path: Path) -> None:
    found = probe(settings_of(cluster, tmp_path))
    assert found.address == cluster.remote().address
    assert list(found.workers.values()) == [""] * WORKERS
