"""The engine on a Dask scheduler, over TLS.

Dask is never given more attempts than it has free slots, never retries, and may lose anything at any moment. A slot is
a worker process with ``service.dask.worker`` in it, where a supervisor watches one child. The scheduler
may serve other programs, stop and return. Its attempts continue when this process dies, and are found again
by their keys. A scheduler that does not answer in time counts as away: its connection is closed, and opened anew when
it answers again.
"""

import asyncio
import logging
import socket
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Self, TypeVar

from service.dask import worker
from service.execution.protocol import OpenEngine
from service.settings import Settings
from service.workers.attempt import Attempt, Away, Back, Ended, Ending, Inbox, ProgressMessage
from service.workers.timings import DEFAULT, Timings
from studies.quantities.findings import MissingExtra

try:
    import distributed
except ModuleNotFoundError as error:
    cure = "pip install 'whipple[cluster]', or remove the engine setting to compute runs on this machine"
    raise MissingExtra(f"an engine at tls:// needs {error.name}, which is not installed: {cure}") from None

log = logging.getLogger(__name__)

PUBLISHED = "whipple/"  # begin of the names under which a scheduler keeps attempts for our next life

Answer = TypeVar("Answer")
Function = Callable[[list[str]], None]  # function of ``worker``, called with keys of attempts


class SchedulerConnection(distributed.Client):
    """A connection to a scheduler; a broken one is replaced, not mended. All methods raise OSError."""

    def __init__(self, address: str, timings: Timings, security: distributed.Security):
        self.is_lost = threading.Event()
        self._timings = timings
        self._undelivered: set[tuple[str, Function]] = set()  # messages, by the worker's address
        super().__init__(address, set_as_default=False, timeout=timings.connect, security=security)

    async def _reconnect(self) -> None:
        """Replaces Dask's own method, which gives up every future, and the connection after a while."""
        self.is_lost.set()
        raise asyncio.CancelledError  # the loop that listens ends

    def workers(self) -> Mapping[str, str]:
        """The reason why each worker receives no work, by address; empty if it receives work."""
        workers = self.answer(partial(self.sync, self._scheduler().identity, n_workers=-1)).get("workers", {})
        return {address: worker.differences(described.get(worker.SOFTWARE)) for address, described in workers.items()}

    def call(self, function: Function, keys: list[str]) -> None:
        """Call a function of ``worker`` in the workers that have these attempts.

        Returns at once: a frozen worker must not keep the message from the others.
        """
        for address, processing in self.answer(partial(self.sync, self._scheduler().processing)).items():
            theirs = sorted(set(keys) & set(processing))
            if theirs and (address, function) not in self._undelivered:
                self._send(address, function, theirs)

    def hang_up(self) -> None:
        """Close the connection; attempts go on."""
        self.is_lost.set()
        with suppress(OSError):
            self.close(timeout=self._timings.hang_up)

    def _send(self, address: str, function: Function, keys: list[str]) -> None:
        assert self.loop is not None
        sent = self._run(worker.call, function, keys, workers=[address], wait=False, on_error="ignore")
        self._undelivered.add((address, function))
        delivery = asyncio.run_coroutine_threadsafe(
            asyncio.wait_for(sent, self._timings.answer),
            self.loop.asyncio_loop,  # type: ignore[attr-defined]
        )
        delivery.add_done_callback(lambda _: self._undelivered.discard((address, function)))

    def _scheduler(self) -> distributed.core.rpc | distributed.core.PooledRPCCall:
        if self.scheduler is None:
            raise ConnectionError("the scheduler is away")
        return self.scheduler

    def answer(self, ask: Callable[..., Answer]) -> Answer:
        """The answer of the scheduler, in time."""
        try:
            return ask(callback_timeout=self._timings.answer)
        except TimeoutError:
            self.is_lost.set()
            silence = f"the scheduler has not answered within {self._timings.answer:g} s"
            raise ConnectionError(silence) from None


@dataclass(frozen=True)
class Remote:
    """The address of a scheduler, and the certificates for it (files in PEM)."""

    address: str  # tls://host:port
    ca: Path
    certificate: Path
    key: Path

    @classmethod
    def of(cls, settings: Settings) -> Self:
        """The scheduler of the settings, which were checked to be complete."""
        files = (settings.tls_ca, settings.tls_cert, settings.tls_key)
        ca, certificate, key = (file or Path() for file in files)
        return cls(settings.engine or "", ca, certificate, key)

    def connect(self, timings: Timings = DEFAULT) -> SchedulerConnection:
        """A connection; raises OSError."""
        security = distributed.Security(
            require_encryption=True,
            tls_ca_file=str(self.ca),
            tls_client_cert=str(self.certificate),
            tls_client_key=str(self.key),
        )
        # A client of Dask that meets nobody, or somebody else, leaves a thread behind: ask first.
        host, _, port = self.address.removeprefix("tls://").rpartition(":")
        context = security.get_connection_args("client")["ssl_context"]
        with socket.create_connection((host.strip("[]"), int(port)), timings.connect) as plain:
            context.wrap_socket(plain).close()
        return SchedulerConnection(self.address, timings, security=security)


class DaskEngine:
    """``protocol.Engine`` on the workers of a scheduler."""

    def __init__(self, remote: Remote, inbox: Inbox, timings: Timings = DEFAULT):
        self._remote = remote
        self._inbox = inbox
        self._timings = timings
        self._followed: dict[str, distributed.Future | None] = {}  # None: the scheduler is away
        self._changed = threading.Condition()  # guards what is followed
        self._client: SchedulerConnection | None = None
        self._refused: set[str] = set()  # addresses of workers that get no work
        self._last_slot = time.monotonic()
        self._closing = threading.Event()
        inbox.put(Away("the scheduler has not answered yet"))
        self._connector = threading.Thread(target=self._stay_connected, name="engine", daemon=True)
        self._connector.start()

    @classmethod
    def opener(cls, settings: Settings) -> OpenEngine:
        return partial(cls, Remote.of(settings))

    @classmethod
    def probe(cls, settings: Settings) -> Mapping[str, str]:
        client = Remote.of(settings).connect()
        try:
            return client.workers()
        finally:
            client.hang_up()

    # --- for the dispatcher ----------------------------------------------------------------------

    def slots(self) -> int:
        try:
            workers = self._connection().workers()
        except OSError:
            return 0
        for address, why in workers.items():
            if why and address not in self._refused:
                self._refused.add(address)
                log.warning("the worker %s receives no work: %s", address, why)
        slots = sum(not why for why in workers.values())
        self._cancel_without_slots(slots)
        return slots

    def submit(self, attempt: Attempt) -> None:
        client, key = self._connection(), attempt.key
        with self._changed:
            self._followed[key] = None
        try:
            future = client.submit(worker.compute, attempt, key=key, pure=False, retries=0, resources={worker.OFFER: 1})
            client.answer(partial(client.publish_dataset, future, name=PUBLISHED + key))
        except BaseException:
            with self._changed:
                self._followed.pop(key, None)
            raise
        self._attach(key, future)

    def stop(self, keys: list[str]) -> None:
        """Ask for the end of attempts; one that has not begun misses it, so ask again."""
        self._connection().call(worker.stop, keys)

    def attempts(self) -> set[str]:
        """Attempts that the scheduler has, also ended ones until they are forgotten; raises OSError."""
        names = map(str, self._connection().answer(self._connection().list_datasets))
        return {name.removeprefix(PUBLISHED) for name in names if name.startswith(PUBLISHED)}

    def follow(self, key: str) -> None:
        """Follow an attempt of an earlier life; ``Ended`` follows. Raises OSError."""
        client = self._connection()
        with self._changed:
            if key in self._followed:
                return
            self._followed[key] = None
        try:
            self._find(client, key)
        except BaseException:  # it is asked for again
            with self._changed:
                self._followed.pop(key, None)
            raise

    def forget(self, keys: list[str]) -> None:
        with suppress(OSError):  # away; the next life follows and forgets them
            client = self._connection()
            client.answer(partial(client.unpublish_dataset, [PUBLISHED + key for key in keys]))

    def close(self, leave_seconds: float | None) -> None:
        """Let every attempt write a checkpoint and leave, and stop the others; with None they go on."""
        self._closing.set()
        self._connector.join()
        if self._client is not None:
            if leave_seconds is not None:
                self._end_all(leave_seconds)
            self._client.hang_up()

    # --- attempts --------------------------------------------------------------------------------

    def _attach(self, key: str, future: distributed.Future) -> None:
        with self._changed:
            if future.client.is_lost.is_set():
                return  # found again when the scheduler is back
            self._followed[key] = future
        future.add_done_callback(self._note_end)

    def _find(self, client: SchedulerConnection, key: str) -> None:
        """Follow an attempt that the scheduler has; else it is lost."""
        future = client.answer(partial(client.get_dataset, PUBLISHED + key, default=None))
        if future is not None:
            self._attach(key, future)
        else:
            self._end(key, Ending.lost("Gone", "the scheduler no longer has the attempt"))

    def _note_end(self, future: distributed.Future) -> None:
        """Note that a future is done, failed, cancelled or lost; called in a thread of the client."""
        try:
            ending = future.result(timeout=self._timings.result)
        except BaseException as error:  # a cancellation is no Exception here
            if future.client.is_lost.is_set():
                return  # found again when the scheduler is back
            ending = Ending.lost(type(error).__name__, f"the worker is lost: {error}")
        self._end(str(future.key), ending)
        future.release()

    def _end(self, key: str, ending: Ending) -> None:
        with self._changed:
            if key in self._followed:  # else it was reported before
                self._inbox.put(Ended(key, ending))
                del self._followed[key]
            self._changed.notify_all()

    def _receive(self, event: tuple[float, worker.ProgressEvent]) -> None:
        """Pass progress on; called in the loop of the client."""
        message = event[1]
        if message["key"] in self._followed:  # a scheduler may serve other services too
            self._inbox.put(ProgressMessage(message["key"], message["progress"]))

    def _end_all(self, leave_seconds: float) -> None:
        """Let all attempts leave, then stop the others; each step has its time."""
        steps = ((worker.leave, leave_seconds), (worker.stop, self._timings.stop))
        for function, seconds in steps:
            with self._changed:
                keys = list(self._followed)
            try:
                if keys:
                    self._connection().call(function, keys)
            except OSError:
                return  # the scheduler is away, and with it the endings
            with self._changed:
                self._changed.wait_for(lambda: not self._followed, seconds)

    def _cancel_without_slots(self, slots: int) -> None:
        """Cancel attempts that wait for a worker which does not come."""
        now = time.monotonic()
        if slots:
            self._last_slot = now
        if now - self._last_slot < self._timings.no_slot:
            return
        with self._changed:
            waiting = {key: future for key, future in self._followed.items() if future is not None}
        if waiting:
            self.forget(list(waiting))
            self._connection().cancel(list(waiting.values()), force=True)  # ``Ended`` follows

    # --- the connection --------------------------------------------------------------------------

    def _connection(self) -> SchedulerConnection:
        client = self._client
        if client is None or client.is_lost.is_set():
            raise ConnectionError("the scheduler is away")
        return client

    def _connect(self) -> None:
        client = self._remote.connect(self._timings)
        try:
            client.subscribe_topic(worker.PROGRESS, self._receive)
            with self._changed:
                keys = list(self._followed)
            for key in keys:
                self._find(client, key)
        except BaseException:
            client.hang_up()
            raise
        self._last_slot = time.monotonic()
        self._client = client

    def _stay_connected(self) -> None:
        """Connect, and connect again after a loss; the thread of the connection."""
        reported: str | None = ""
        while not self._closing.wait(self._timings.connection_poll):
            if self._client is not None and self._client.is_lost.is_set():
                self._disconnect()
            if self._client is not None:
                continue
            try:
                self._connect()
            except Exception as error:  # whatever it is, the scheduler may be well a little later
                if reported != str(error):
                    reported = str(error)
                    self._inbox.put(Away(f"the scheduler cannot be reached: {error}"))
                self._closing.wait(self._timings.reconnect)
            else:
                reported = None
                self._inbox.put(Back())

    def _disconnect(self) -> None:
        """Let a broken connection go; its attempts are found again by their keys."""
        client, self._client = self._client, None
        assert client is not None
        self._inbox.put(Away("the connection to the scheduler broke"))
        with self._changed:
            self._followed = dict.fromkeys(self._followed)
        client.hang_up()
