"""Which engine the settings ask for, and what is particular to the one of this machine."""

import sys
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import pytest

from service import execution
from service.execution import engine_of, local, probe
from service.execution.local import LocalEngine
from service.records.attempt import Inbox
from service.records.jobs import Cause
from service.records.settings import Settings
from service.workers.supervisor import Supervisor
from studies.values.errors import MissingExtra
from tests.service.support.cluster import Service, pid_of, ticket
from tests.service.support.fakes import is_gone


def test_engine__is_of_this_machine_unless_an_address_is_given() -> None:
    engine = engine_of(Settings(workers=3))(SimpleQueue())
    assert isinstance(engine, LocalEngine)
    assert engine.slots() == 3
    engine.close(0.0)


def test_engine__of_a_cluster_without_its_libraries_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pem = tmp_path / "any.pem"
    pem.touch()
    files = dict.fromkeys(("tls_ca", "tls_cert", "tls_key"), pem)
    settings = Settings(engine="tls://127.0.0.1:8786", memory_limit=1 << 30, **files)  # type: ignore[arg-type]
    monkeypatch.delitem(sys.modules, "service.execution.dask", raising=False)
    monkeypatch.delattr(execution, "dask", raising=False)
    monkeypatch.setitem(sys.modules, "distributed", None)
    for ask in (engine_of, probe):
        with pytest.raises(MissingExtra, match=r"tls://127.*distributed.*'whipple\[cluster\]'"):
            ask(settings)


def test_slot__whose_supervisor_fails_serves_the_next_attempt(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_arguments: Any) -> None:
        raise ZeroDivisionError("nobody foresaw this")

    inbox: Inbox = SimpleQueue()
    service = Service(LocalEngine(1, inbox), inbox)
    try:
        one, other = ticket(tmp_path, 1), ticket(tmp_path, 2)
        with monkeypatch.context() as patch:
            patch.setattr(Supervisor, "run", fail)
            service.engine.submit(one)
            ending = service.end_of(one)
        assert (ending.cause, ending.failure) == (Cause.LOST, "ZeroDivisionError")
        service.engine.submit(other)
        assert service.end_of(other).cause is None
    finally:
        service.engine.close(0.0)


def test_close__an_attempt_that_waits_for_a_slot_does_not_begin(tmp_path: Path) -> None:
    inbox: Inbox = SimpleQueue()
    service = Service(LocalEngine(1, inbox), inbox)
    first, waiting = ticket(tmp_path, 1, "hang"), ticket(tmp_path, 2)
    for order in (first, waiting):
        service.engine.submit(order)
    pid_of(first)
    service.engine.close(0.0)
    assert {service.end_of(order).failure for order in (first, waiting)} == {"Stopped"}
    assert not Path(waiting.directory, "pid").exists()


def test_close__says_that_a_slot_is_still_busy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    inbox: Inbox = SimpleQueue()
    service = Service(LocalEngine(1, inbox), inbox)
    deaf = ticket(tmp_path, 1, "deaf")
    service.engine.submit(deaf)
    pid = pid_of(deaf)
    with monkeypatch.context() as patch:
        patch.setattr(local, "STOP_SECONDS", -1.0)
        with pytest.raises(TimeoutError, match="1 of 1 slots"):
            service.engine.close(0.0)
    service.engine.close(60.0)
    assert is_gone(pid)
