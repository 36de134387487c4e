"""The engine: workers of Dask over TLS. With ``service.scheduler`` all that imports ``distributed``.

Dask is muscle: it is never given more than it has free slots, never retries, and may lose anything
at any moment. A slot is a worker process with ``service.slot`` in it; there a supervisor watches one
child. The scheduler and its workers are our own (``Embedded``), or somebody's (``Remote``) who may go
away and come back, and whose attempts go on when we die: they are found again by their keys.
"""

import logging
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import distributed

from service import slot, supervisor
from service.attempt import Away, Back, Ended, Ending, Inbox, Ticket, Told
from service.jobs import Cause
from service.scheduler import Connection, Embedded, Remote, ours

if TYPE_CHECKING:
    from service.settings import Settings

log = logging.getLogger(__name__)

PUBLISHED = (
    "whipple/"  # begin of the names under which a scheduler keeps attempts for our next life
)
RETRY_SECONDS = 2.0  # between two tries to reach it
WATCH_SECONDS = 0.25  # between two looks whether the connection still holds
RESULT_SECONDS = 10.0  # for an answer to come from its worker
STOP_SECONDS = 1.5  # for those that could not leave: half of it is the supervisor's patience
NO_SLOT_SECONDS = 30.0  # without any worker, until its attempts count as lost


class Engine:
    """Slots for attempts; what happens in them is put into ``inbox``."""

    def __init__(self, place: Embedded | Remote, inbox: Inbox):
        self._place = place
        self._inbox = inbox
        self._followed: dict[str, distributed.Future | None] = {}  # None: scheduler is away
        self._changed = threading.Condition()  # guards what is followed
        self._client: Connection | None = None
        self._refused: set[str] = set()  # addresses of workers that get no work
        self._last_slot = time.monotonic()
        self._closing = threading.Event()
        if isinstance(place, Embedded):
            self._connect_or_close()
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
            workers = client.workers()
        except OSError:  # it is going away
            return 0
        self._tell_of_refused(workers)
        count = len(ours(workers))
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
            client.keep(PUBLISHED + key, future)
        except BaseException:
            with self._changed:
                self._followed.pop(key, None)
            raise
        self._attach(key, future)

    def stop(self, keys: list[str]) -> None:
        """Ask for the end of attempts; one that has not begun does not hear it, so ask again."""
        self._connected().tell(supervisor.stop, keys)

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

    def close(self, leave_seconds: float | None = supervisor.LEAVE_SECONDS) -> None:
        """Let every attempt write a checkpoint and leave; one that does not is stopped.

        With None they go on where workers outlive us: another service, or our next life, finds them.
        """
        self._closing.set()
        self._keeper.join()
        if self._client is not None:
            if leave_seconds is not None:
                self._end_all(leave_seconds)
            self._client.hang_up()
        self._place.close()

    # --- attempts --------------------------------------------------------------------------------

    def _attach(self, key: str, future: distributed.Future) -> None:
        with self._changed:
            if future.client.is_lost.is_set():
                return  # it is looked for when the scheduler is back
            self._followed[key] = future
        future.add_done_callback(self._note_end)

    def _find(self, client: Connection, key: str) -> None:
        """Follow an attempt that the scheduler has; else it is lost."""
        future = client.kept(PUBLISHED + key)
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
                    self._connected().tell(word, keys)
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

    def _connected(self) -> Connection:
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
            client.hang_up()
            raise
        self._last_slot = time.monotonic()
        self._client = client

    def _connect_or_close(self) -> None:
        """The first connection to workers of our own, which end where there is none."""
        try:
            self._connect()
        except BaseException:
            self._place.close()
            raise

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
        client.hang_up()


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
        return Cluster(place.address, client.workers())
    finally:
        client.hang_up()


def _remote(settings: "Settings") -> Remote:
    files = (settings.tls_ca, settings.tls_cert, settings.tls_key)
    ca, certificate, key = (file or Path() for file in files)  # the settings have seen to them
    return Remote(settings.engine or "", ca, certificate, key)


def _lost(failure: str, reason: str) -> Ending:
    return Ending(Cause.LOST, failure, reason, (), 0.0)
