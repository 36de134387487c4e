"""The engine: workers of Dask over TLS. The only file that imports ``distributed``.

Dask is muscle: it is never given more than it has free slots, never retries, and may lose anything
at any moment. A slot is a worker process with ``service.slot`` in it; there a supervisor watches one
child. The scheduler and its workers are our own (``Embedded``), or somebody's (``Remote``) who may go
away and come back, and whose attempts go on when we die: they are found again by their keys.
"""

import asyncio
import logging
import socket
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import dask
import distributed

from service import slot, supervisor
from service.attempt import Away, Back, Ended, Ending, Inbox, Ticket, Told
from service.jobs import Cause

if TYPE_CHECKING:
    from service.settings import Settings

log = logging.getLogger(__name__)

PUBLISHED = (
    "whipple/"  # begin of the names under which a scheduler keeps attempts for our next life
)
CONNECT_SECONDS = 5.0  # for a scheduler to answer
RETRY_SECONDS = 2.0  # between two tries to reach it
WATCH_SECONDS = 0.25  # between two looks whether the connection still holds
RESULT_SECONDS = 10.0  # for an answer to come from its worker
STOP_SECONDS = 1.5  # for those that could not leave: half of it is the supervisor's patience
CLOSE_SECONDS = 10.0  # for a worker to go
NO_SLOT_SECONDS = 30.0  # without any worker, until its attempts count as lost

CONFIGURATION = {
    "distributed.scheduler.allowed-failures": 0,  # the row owns retries
    "distributed.scheduler.work-stealing": True,  # a task on a busy worker moves to a free one
    "distributed.scheduler.http.routes": [],  # no page without a login
    "distributed.worker.http.routes": [],
    "distributed.worker.profile.enabled": False,
    "distributed.admin.low-level-log-length": 100,
}


class _Client(distributed.Client):
    """A connection to a scheduler. One that broke is not mended: another one takes its place."""

    def __init__(self, place: Any, **options: Any):
        self.is_lost = threading.Event()
        super().__init__(place, set_as_default=False, **options)

    async def _reconnect(self) -> None:
        """Called in place of Dask's own, which gives every future up, and itself after a while."""
        self.is_lost.set()
        raise asyncio.CancelledError  # the loop that listens ends


class Embedded:
    """Scheduler and workers of our own, on this machine; they end with us."""

    def __init__(self, workers: int, scratch: Path):
        slot.spare_the_main_module()
        with dask.config.set(CONFIGURATION):
            self.cluster = distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                protocol="tls://",
                security=distributed.Security.temporary(),
                scheduler_kwargs={"dashboard": False, "dashboard_address": "127.0.0.1:0"},
                memory_limit=None,  # the supervisor is small, and Dask does not see its child
                local_directory=str(scratch),
                silence_logs=logging.CRITICAL,
                preload=["service.slot"],
            )

    def connect(self) -> _Client:
        """A connection."""
        return _Client(self.cluster)

    def close(self) -> None:
        """End the workers."""
        self.cluster.close(timeout=CLOSE_SECONDS)


@dataclass(frozen=True)
class Remote:
    """A scheduler somewhere, and what proves that we may talk to it (files in PEM)."""

    address: str  # tls://host:port
    ca: Path
    certificate: Path
    key: Path

    def connect(self) -> _Client:
        """A connection; raises OSError."""
        self.greet()
        return _Client(self.address, security=self._security(), timeout=CONNECT_SECONDS)

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


class Engine:
    """Slots for attempts; what happens in them is put into ``inbox``."""

    def __init__(self, place: Embedded | Remote, inbox: Inbox):
        self._place = place
        self._inbox = inbox
        self._followed: dict[str, distributed.Future | None] = {}  # None: scheduler is away
        self._changed = threading.Condition()  # guards what is followed
        self._client: _Client | None = None
        self._refused: set[str] = set()  # addresses of workers that get no work
        self._last_slot = time.monotonic()
        self._closing = threading.Event()
        if isinstance(place, Embedded):
            self._connect()
        else:
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
            workers = _workers(client)
        except (OSError, TimeoutError):  # it is going away
            return 0
        self._tell_of_refused(workers)
        count = len(_ours(workers))
        self._give_up_without_slots(count)
        return count

    def submit(self, ticket: Ticket) -> None:
        """Begin an attempt; ``Ended`` follows, whatever happens."""
        client, key = self._connected(), ticket.key
        with self._changed:
            self._followed[key] = None
        try:
            future = client.submit(
                slot.compute, ticket, key=key, pure=False, retries=0, resources={slot.OFFER: 1}
            )
            client.publish_dataset(future, name=PUBLISHED + key)
        except BaseException:
            with self._changed:
                self._followed.pop(key, None)
            raise
        self._attach(key, future)

    def stop(self, keys: list[str]) -> None:
        """Ask for the end of attempts; one that has not begun does not hear it, so ask again."""
        self._say(supervisor.stop, keys)

    def known(self) -> set[str]:
        """Attempts that the scheduler has, also ended ones until they are forgotten; raises OSError."""
        names = self._connected().list_datasets()
        return {name.removeprefix(PUBLISHED) for name in names if name.startswith(PUBLISHED)}

    def follow(self, key: str) -> None:
        """Care for an attempt of an earlier life; ``Ended`` follows. Raises OSError."""
        client = self._connected()
        with self._changed:
            if key in self._followed:
                return
            self._followed[key] = None
        self._find(client, key)

    def forget(self, keys: list[str]) -> None:
        """Their rows know how they ended: the scheduler need not keep it."""
        with suppress(OSError):  # away; it is forgotten after the next life has seen it
            self._connected().unpublish_dataset([PUBLISHED + key for key in keys])

    def close(self, leave_seconds: float | None = supervisor.LEAVE_SECONDS) -> None:
        """Let every attempt write a checkpoint and leave; one that does not is stopped.

        With None they go on where workers outlive us: another service, or our next life, finds them.
        """
        self._closing.set()
        self._keeper.join()
        if self._client is not None:
            if leave_seconds is not None:
                self._end_all(leave_seconds)
            _hang_up(self._client)
        self._place.close()

    # --- attempts --------------------------------------------------------------------------------

    def _attach(self, key: str, future: distributed.Future) -> None:
        with self._changed:
            if future.client.is_lost.is_set():
                return  # it is looked for when the scheduler is back
            self._followed[key] = future
        future.add_done_callback(self._note_end)

    def _find(self, client: _Client, key: str) -> None:
        """Follow an attempt that the scheduler has; else it is lost."""
        future = client.get_dataset(PUBLISHED + key, default=None)
        if future is not None:
            self._attach(key, future)
        else:
            self._end(key, _lost("Gone", "the scheduler no longer has it"))

    def _note_end(self, future: distributed.Future) -> None:
        """Called in a thread of the client when a future is done, failed, cancelled or lost."""
        try:
            ending = future.result(timeout=RESULT_SECONDS)
        except BaseException as error:  # cancellation is no Exception here
            if future.client.is_lost.is_set():
                return  # it is looked for when the scheduler is back
            ending = _lost(type(error).__name__, f"the worker is lost: {error}")
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
        words = dict(event[1])
        key = words.pop("key")
        if key in self._followed:  # a scheduler may serve other services too
            self._inbox.put(Told(key, words))

    def _end_all(self, leave_seconds: float) -> None:
        """Two words to all attempts, and the time that each leaves them."""
        words = ((supervisor.leave, leave_seconds), (supervisor.stop, STOP_SECONDS))
        for word, seconds in words:
            with self._changed:
                keys = list(self._followed)
            try:
                if keys:
                    self._say(word, keys)
            except OSError:
                return  # the scheduler is away, and with it the answers
            with self._changed:
                self._changed.wait_for(lambda: not self._followed, seconds)

    def _say(self, word: Any, keys: list[str]) -> None:
        """Call a function of the supervisor in every worker of ours."""
        client = self._connected()
        workers = _ours(_workers(client))
        if workers:
            client.run(slot.call, word, keys, workers=workers, wait=False, on_error="ignore")

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

    def _connected(self) -> _Client:
        client = self._client
        if client is None or client.is_lost.is_set():
            raise ConnectionError("the scheduler is away")
        return client

    def _connect(self) -> None:
        client = self._place.connect()
        try:
            client.subscribe_topic(slot.PROGRESS, self._hear)
            with self._changed:
                orphans = list(self._followed)
            for key in orphans:
                self._find(client, key)
        except BaseException:
            _hang_up(client)
            raise
        self._last_slot = time.monotonic()
        self._client = client

    def _stay_connected(self) -> None:
        """The thread that looks after the connection."""
        said = None if self._client is not None else ""
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
        _hang_up(client)


def open_engine(settings: "Settings", *, scratch: Path, inbox: Inbox) -> Engine:
    """The engine that the settings ask for."""
    if settings.engine is None:
        return Engine(Embedded(settings.workers, scratch), inbox)
    return Engine(_remote(settings), inbox)


@dataclass(frozen=True)
class Cluster:
    """What answers at an address."""

    address: str
    workers: Mapping[str, str]  # by address: why it gets no work; empty if it gets some


def probe(settings: "Settings") -> Cluster:
    """Ask the scheduler of the settings who works for it; raises OSError."""
    place = _remote(settings)
    client = place.connect()
    try:
        return Cluster(place.address, _workers(client))
    finally:
        _hang_up(client)


def _remote(settings: "Settings") -> Remote:
    files = (settings.tls_ca, settings.tls_cert, settings.tls_key)
    ca, certificate, key = (file or Path() for file in files)  # the settings have seen to them
    return Remote(settings.engine or "", ca, certificate, key)


def _hang_up(client: _Client) -> None:
    """Let a connection go; what it followed is not lost by that."""
    client.is_lost.set()
    with suppress(OSError, TimeoutError):
        client.close(timeout=CLOSE_SECONDS)


def _workers(client: _Client) -> Mapping[str, str]:
    """Why each worker gets no work, by address; empty for those that get some."""
    said: Mapping[str, Any] = client.scheduler_info(n_workers=-1).get("workers", {})
    return {address: slot.differences(one.get(slot.SOFTWARE)) for address, one in said.items()}


def _ours(workers: Mapping[str, str]) -> list[str]:
    """Addresses of those that compute what we would, one attempt each."""
    return [address for address, why in workers.items() if not why]


def _lost(failure: str, reason: str) -> Ending:
    return Ending(Cause.LOST, failure, reason, (), 0.0)
