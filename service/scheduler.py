"""The connection to a Dask scheduler, ours or somebody's, that never keeps anybody waiting for long.

A scheduler that does not answer in time counts as away: its connection is given up, and another one
takes its place when it answers again. Workers are told things, and not waited for at all.
"""

import asyncio
import logging
import socket
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from multiprocessing import active_children
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

import dask
import distributed

from service import slot, steady

CONNECT_SECONDS = 5.0  # for a scheduler to be reached
ANSWER_SECONDS = 5.0  # for it to answer, and for a worker to hear a word
CLOSE_SECONDS = 10.0  # for a worker to go
NO_CHECK_TIME = 0x200000  # X509_V_FLAG_NO_CHECK_TIME of OpenSSL, which Python has no name for

CONFIGURATION = {
    "distributed.scheduler.allowed-failures": 0,  # the row owns retries
    "distributed.scheduler.work-stealing": True,  # a task on a busy worker moves to a free one
    "distributed.scheduler.http.routes": [],  # no page without a login
    "distributed.worker.http.routes": [],
    "distributed.worker.profile.enabled": False,
    "distributed.admin.low-level-log-length": 100,
}

Word = Callable[[list[str]], None]  # a function of the supervisor


class Connection(distributed.Client):
    """A connection to a scheduler. One that broke is not mended: another one takes its place."""

    def __init__(self, place: Any, **options: Any):
        self.is_lost = threading.Event()
        self._unheard: set[tuple[str, Word]] = set()  # words on their way, by the worker's address
        super().__init__(place, set_as_default=False, **options)

    async def _reconnect(self) -> None:
        """Called in place of Dask's own, which gives every future up, and itself after a while."""
        self.is_lost.set()
        raise asyncio.CancelledError  # the loop that listens ends

    def keep(self, name: str, future: distributed.Future) -> None:
        """Let the scheduler keep an attempt, whoever dies; raises OSError, as all that follow."""
        self._answer(self.publish_dataset, future, name=name)

    def kept(self, name: str) -> distributed.Future | None:
        """An attempt that it keeps."""
        return self._answer(self.get_dataset, name, default=None)

    def kept_names(self) -> list[str]:
        """Of all that it keeps, for us or for others."""
        return [name for name in self._answer(self.list_datasets) if isinstance(name, str)]

    def release(self, names: list[str]) -> None:
        """Let it forget what it keeps."""
        self._answer(self.unpublish_dataset, names)

    def workers(self) -> Mapping[str, str]:
        """Why each worker gets no work, by address; empty for those that get some."""
        said = self._ask("identity", n_workers=-1).get("workers", {})
        return {address: slot.differences(one.get(slot.SOFTWARE)) for address, one in said.items()}

    def tell(self, word: Word, keys: Sequence[str]) -> None:
        """Call a function of the supervisor in the workers that have these attempts.

        Nobody waits for them: one may be frozen, and the others must hear it all the same.
        """
        for address, has in self._ask("processing").items():
            theirs = sorted(set(keys) & set(has))
            if theirs and (address, word) not in self._unheard:
                self._send(address, word, theirs)

    def hang_up(self) -> None:
        """Let it go; what it followed is not lost by that."""
        self.is_lost.set()
        with suppress(OSError):
            self.close(timeout=CLOSE_SECONDS)

    def _send(self, address: str, word: Word, keys: list[str]) -> None:
        assert self.loop is not None
        sent = self._run(slot.call, word, keys, workers=[address], wait=False, on_error="ignore")
        self._unheard.add((address, word))
        hearing = asyncio.run_coroutine_threadsafe(
            asyncio.wait_for(sent, ANSWER_SECONDS),
            self.loop.asyncio_loop,  # type: ignore[attr-defined]
        )
        hearing.add_done_callback(lambda _: self._unheard.discard((address, word)))

    def _ask(self, question: str, **words: Any) -> Any:
        """What the scheduler says."""
        if self.scheduler is None:
            raise ConnectionError("the scheduler is away")
        return self._answer(partial(self.sync, getattr(self.scheduler, question)), **words)

    def _answer(self, ask: Callable[..., Any], *about: Any, **words: Any) -> Any:
        """What comes back of a question, in time; raises OSError."""
        try:
            return ask(*about, callback_timeout=ANSWER_SECONDS, **words)
        except TimeoutError:
            self.is_lost.set()
            silence = f"the scheduler has not answered within {ANSWER_SECONDS:g} s"
            raise ConnectionError(silence) from None


class Ageless(distributed.Security):
    """Certificates that live in the memory of our processes only, so that their dates protect nobody.

    Dask's own would be refused by every worker that starts after the clock was set back, or after a year.
    """

    def get_connection_args(self, role: str) -> dict[str, Any]:
        return _at_any_time(super().get_connection_args(role))

    def get_listen_args(self, role: str) -> dict[str, Any]:
        return _at_any_time(super().get_listen_args(role))


def _at_any_time(arguments: dict[str, Any]) -> dict[str, Any]:
    arguments["ssl_context"].verify_flags |= NO_CHECK_TIME
    return arguments


class Embedded:
    """Scheduler and workers of our own, on this machine; they end with us."""

    def __init__(self, workers: int, scratch: Path):
        slot.spare_the_main_module()
        steady.keep_time()
        with dask.config.set(CONFIGURATION):
            self.cluster = distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                protocol="tls://",
                security=Ageless.temporary(),
                scheduler_kwargs={"dashboard": False, "dashboard_address": "127.0.0.1:0"},
                memory_limit=None,  # the supervisor is small, and Dask does not see its child
                local_directory=str(scratch),
                silence_logs=logging.CRITICAL,
                preload=["service.slot"],
            )

    def connect(self) -> Connection:
        """A connection."""
        return Connection(self.cluster)

    def close(self) -> None:
        """End the workers; raises TimeoutError for those that do not go, after they were killed."""
        own = {nanny.pid for nanny in list(self.cluster.workers.values())}
        try:
            self.cluster.close(timeout=CLOSE_SECONDS)
        finally:
            for process in _processes():
                if process.pid in own:
                    process.kill()


@dataclass(frozen=True)
class Remote:
    """A scheduler somewhere, and what proves that we may talk to it (files in PEM)."""

    address: str  # tls://host:port
    ca: Path
    certificate: Path
    key: Path

    def connect(self) -> Connection:
        """A connection; raises OSError."""
        steady.keep_time()
        self.greet()
        return Connection(self.address, security=self._security(), timeout=CONNECT_SECONDS)

    def greet(self) -> None:
        """Raises OSError where nobody is, or somebody else; a client of Dask leaves a thread behind."""
        host, _, port = self.address.removeprefix("tls://").rpartition(":")
        context = self._security().get_connection_args("client")["ssl_context"]
        with socket.create_connection((host.strip("[]"), int(port)), CONNECT_SECONDS) as plain:
            context.wrap_socket(plain).close()

    def close(self) -> None:
        """They are not ours to end."""

    def _security(self) -> distributed.Security:
        return distributed.Security(
            require_encryption=True,
            tls_ca_file=str(self.ca),
            tls_client_cert=str(self.certificate),
            tls_client_key=str(self.key),
        )


def has_processes() -> bool:
    """Whether workers of our own live; nobody is asked, so it is known of starved ones too."""
    return bool(_processes())


def _processes() -> list[BaseProcess]:
    return [one for one in active_children() if one.name.startswith(slot.WORKER_PROCESS)]


def ours(workers: Mapping[str, str]) -> list[str]:
    """Addresses of those that compute what we would, one attempt each."""
    return [address for address, why in workers.items() if not why]
