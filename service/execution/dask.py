"""The engine on a Dask scheduler, over TLS: the only file that imports ``distributed``.

Dask is muscle: it is never given more than it has free slots, never retries, and may lose anything
at any moment. A slot is a worker process with ``service.execution.dask_worker`` in it; there a
supervisor watches one child. The scheduler is somebody's, may go away and come back, and its attempts
go on when we die: they are found again by their keys. A scheduler that does not answer in time counts
as away: its connection is given up, and another one takes its place when it answers again.
"""

import asyncio
import logging
import socket
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import distributed

from service.execution import Cluster, dask_worker
from service.records.attempt import Attempt, Away, Back, Ended, Ending, Inbox, ProgressMessage
from service.workers.supervisor import LEAVE_SECONDS, STOP_SECONDS

if TYPE_CHECKING:
    from service.records.settings import Settings

log = logging.getLogger(__name__)

# Begin of the names under which a scheduler keeps attempts for our next life.
PUBLISHED = "whipple/"
CONNECT_SECONDS = 5.0  # for a scheduler to be reached
ANSWER_SECONDS = 5.0  # for it to answer, and for a worker to receive a message
CLOSE_SECONDS = 10.0  # for a connection to close
RETRY_SECONDS = 2.0  # between two tries to reach the scheduler
WATCH_SECONDS = 0.25  # between two looks whether the connection still holds
RESULT_SECONDS = 10.0  # for an answer to come from its worker
NO_SLOT_SECONDS = 30.0  # without any worker, until its attempts count as lost

Message = Callable[[list[str]], None]  # a function of ``dask_worker``, called with keys of attempts


class SchedulerConnection(distributed.Client):
    """A connection to a scheduler. One that broke is not mended: another one takes its place."""

    def __init__(self, place: Any, **options: Any):
        self.is_lost = threading.Event()
        self._unheard: set[tuple[str, Message]] = set()  # under way, by the worker's address
        super().__init__(place, set_as_default=False, **options)

    async def _reconnect(self) -> None:
        """Called in place of Dask's own, which gives every future up, and itself after a while."""
        self.is_lost.set()
        raise asyncio.CancelledError  # the loop that listens ends

    def keep(self, name: str, future: distributed.Future) -> None:
        """Let the scheduler keep an attempt, whoever dies; raises OSError, as all methods below."""
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
        return {
            address: dask_worker.differences(worker.get(dask_worker.SOFTWARE))
            for address, worker in said.items()
        }

    def tell(self, message: Message, keys: Sequence[str]) -> None:
        """Call a function of ``dask_worker`` in the workers that have these attempts.

        Nothing waits for them: one may be frozen, and the message must reach the others all the same.
        """
        for address, has in self._ask("processing").items():
            theirs = sorted(set(keys) & set(has))
            if theirs and (address, message) not in self._unheard:
                self._send(address, message, theirs)

    def hang_up(self) -> None:
        """Let it go; what it followed is not lost by that."""
        self.is_lost.set()
        with suppress(OSError):
            self.close(timeout=CLOSE_SECONDS)

    def _send(self, address: str, message: Message, keys: list[str]) -> None:
        assert self.loop is not None
        sent = self._run(
            dask_worker.call, message, keys, workers=[address], wait=False, on_error="ignore"
        )
        self._unheard.add((address, message))
        hearing = asyncio.run_coroutine_threadsafe(
            asyncio.wait_for(sent, ANSWER_SECONDS),
            self.loop.asyncio_loop,  # type: ignore[attr-defined]
        )
        hearing.add_done_callback(lambda _: self._unheard.discard((address, message)))

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


@dataclass(frozen=True)
class Remote:
    """A scheduler somewhere, and what proves that we may talk to it (files in PEM)."""

    address: str  # tls://host:port
    ca: Path
    certificate: Path
    key: Path

    @classmethod
    def of(cls, settings: "Settings") -> Self:
        """The scheduler of the settings, which were checked to have all of it."""
        files = (settings.tls_ca, settings.tls_cert, settings.tls_key)
        ca, certificate, key = (file or Path() for file in files)
        return cls(settings.engine or "", ca, certificate, key)

    def connect(self) -> SchedulerConnection:
        """A connection; raises OSError."""
        self.greet()
        return SchedulerConnection(self.address, security=self._security(), timeout=CONNECT_SECONDS)

    def greet(self) -> None:
        """Raises OSError where nobody is, or somebody else; a client of Dask leaves a thread behind."""
        host, _, port = self.address.removeprefix("tls://").rpartition(":")
        context = self._security().get_connection_args("client")["ssl_context"]
        with socket.create_connection((host.strip("[]"), int(port)), CONNECT_SECONDS) as plain:
            context.wrap_socket(plain).close()

    def _security(self) -> distributed.Security:
        return distributed.Security(
            require_encryption=True,
            tls_ca_file=str(self.ca),
            tls_client_cert=str(self.certificate),
            tls_client_key=str(self.key),
        )


class DaskEngine:
    """``protocol.Engine`` on the workers of a scheduler."""

    def __init__(self, remote: Remote, inbox: Inbox):
        self._remote = remote
        self._inbox = inbox
        self._followed: dict[str, distributed.Future | None] = {}  # None: scheduler is away
        self._changed = threading.Condition()  # guards what is followed
        self._client: SchedulerConnection | None = None
        self._refused: set[str] = set()  # addresses of workers that get no work
        self._last_slot = time.monotonic()
        self._closing = threading.Event()
        inbox.put(Away("the scheduler has not answered yet"))
        self._keeper = threading.Thread(target=self._stay_connected, name="engine", daemon=True)
        self._keeper.start()

    # --- what the dispatcher asks ----------------------------------------------------------------

    def slots(self) -> int:
        """Attempts that can be under way at once."""
        client = self._client
        if client is None or client.is_lost.is_set():
            return 0
        try:
            workers = client.workers()
        except OSError:  # it is going away
            return 0
        self._tell_of_refused(workers)
        count = sum(not why for why in workers.values())
        self._give_up_without_slots(count)
        return count

    def submit(self, ticket: Attempt) -> None:
        """Begin an attempt; ``Ended`` follows, whatever happens."""
        client, key = self._connected(), ticket.key
        with self._changed:
            self._followed[key] = None
        try:
            future = client.submit(
                dask_worker.compute,
                ticket,
                key=key,
                pure=False,
                retries=0,
                resources={dask_worker.OFFER: 1},
            )
            client.keep(PUBLISHED + key, future)
        except BaseException:
            with self._changed:
                self._followed.pop(key, None)
            raise
        self._attach(key, future)

    def stop(self, keys: list[str]) -> None:
        """Ask for the end of attempts; one that has not begun does not hear it, so ask again."""
        self._connected().tell(dask_worker.stop, keys)

    def known(self) -> set[str]:
        """Attempts that the scheduler has, also ended ones until they are forgotten; raises OSError."""
        names = self._connected().kept_names()
        return {name.removeprefix(PUBLISHED) for name in names if name.startswith(PUBLISHED)}

    def follow(self, key: str) -> None:
        """Care for an attempt of an earlier life; ``Ended`` follows. Raises OSError."""
        client = self._connected()
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
        """Their rows know how they ended: the scheduler need not keep it."""
        with suppress(OSError):  # away; it is forgotten after the next life has seen it
            self._connected().release([PUBLISHED + key for key in keys])

    def close(self, leave_seconds: float | None = LEAVE_SECONDS) -> None:
        """Let every attempt write a checkpoint and leave; one that does not is stopped.

        With None they go on where workers outlive us: another service, or our next life, finds them.
        """
        self._closing.set()
        self._keeper.join()
        if self._client is not None:
            if leave_seconds is not None:
                self._end_all(leave_seconds)
            self._client.hang_up()

    # --- attempts --------------------------------------------------------------------------------

    def _attach(self, key: str, future: distributed.Future) -> None:
        with self._changed:
            if future.client.is_lost.is_set():
                return  # it is looked for when the scheduler is back
            self._followed[key] = future
        future.add_done_callback(self._note_end)

    def _find(self, client: SchedulerConnection, key: str) -> None:
        """Follow an attempt that the scheduler has; else it is lost."""
        future = client.kept(PUBLISHED + key)
        if future is not None:
            self._attach(key, future)
        else:
            self._end(key, Ending.lost("Gone", "the scheduler no longer has it"))

    def _note_end(self, future: distributed.Future) -> None:
        """Called in a thread of the client when a future is done, failed, cancelled or lost."""
        try:
            ending = future.result(timeout=RESULT_SECONDS)
        except BaseException as error:  # cancellation is no Exception here
            if future.client.is_lost.is_set():
                return  # it is looked for when the scheduler is back
            ending = Ending.lost(type(error).__name__, f"the worker is lost: {error}")
        self._end(str(future.key), ending)
        future.release()

    def _end(self, key: str, ending: Ending) -> None:
        with self._changed:
            if key in self._followed:  # else it was told before
                self._inbox.put(Ended(key, ending))
                del self._followed[key]
            self._changed.notify_all()

    def _hear(self, event: tuple[float, Mapping[str, Any]]) -> None:
        """Called in the loop of the client."""
        progress = dict(event[1])
        key = progress.pop("key")
        if key in self._followed:  # a scheduler may serve other services too
            self._inbox.put(ProgressMessage(key, progress))

    def _end_all(self, leave_seconds: float) -> None:
        """Let all attempts leave, then stop the others; each step has its time."""
        steps = ((dask_worker.leave, leave_seconds), (dask_worker.stop, STOP_SECONDS))
        for message, seconds in steps:
            with self._changed:
                keys = list(self._followed)
            try:
                if keys:
                    self._connected().tell(message, keys)
            except OSError:
                return  # the scheduler is away, and with it the answers
            with self._changed:
                self._changed.wait_for(lambda: not self._followed, seconds)

    def _give_up_without_slots(self, slots: int) -> None:
        """What waits for a worker that does not come is under way nowhere."""
        now = time.monotonic()
        if slots:
            self._last_slot = now
        if now - self._last_slot < NO_SLOT_SECONDS:
            return
        with self._changed:
            waiting = {key: future for key, future in self._followed.items() if future is not None}
        if waiting:
            self.forget(list(waiting))
            self._connected().cancel(list(waiting.values()), force=True)  # ``Ended`` follows

    def _tell_of_refused(self, workers: Mapping[str, str]) -> None:
        """Say once of each worker why it gets no work."""
        for address, why in workers.items():
            if why and address not in self._refused:
                self._refused.add(address)
                log.warning("the worker %s gets no work: %s", address, why)

    # --- the connection --------------------------------------------------------------------------

    def _connected(self) -> SchedulerConnection:
        client = self._client
        if client is None or client.is_lost.is_set():
            raise ConnectionError("the scheduler is away")
        return client

    def _connect(self) -> None:
        client = self._remote.connect()
        try:
            client.subscribe_topic(dask_worker.PROGRESS, self._hear)
            with self._changed:
                orphans = list(self._followed)
            for key in orphans:
                self._find(client, key)
        except BaseException:
            client.hang_up()
            raise
        self._last_slot = time.monotonic()
        self._client = client

    def _stay_connected(self) -> None:
        """The thread that looks after the connection."""
        said: str | None = ""
        while not self._closing.wait(WATCH_SECONDS):
            if self._client is not None and self._client.is_lost.is_set():
                self._let_go("the connection to the scheduler broke")
            if self._client is not None:
                continue
            try:
                self._connect()
            except Exception as error:  # whatever it is, the scheduler may be well a little later
                if said != str(error):
                    said = str(error)
                    self._inbox.put(Away(f"the scheduler cannot be reached: {error}"))
                self._closing.wait(RETRY_SECONDS)
            else:
                said = None
                self._inbox.put(Back())

    def _let_go(self, reason: str) -> None:
        """Of a connection that broke."""
        client, self._client = self._client, None
        assert client is not None
        self._inbox.put(Away(reason))
        with self._changed:
            self._followed = dict.fromkeys(self._followed)
        client.hang_up()


def probe(settings: "Settings") -> Cluster:
    """Ask the scheduler of the settings who works for it; raises OSError."""
    remote = Remote.of(settings)
    client = remote.connect()
    try:
        return Cluster(remote.address, client.workers())
    finally:
        client.hang_up()
