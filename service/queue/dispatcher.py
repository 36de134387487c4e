"""The dispatcher: the thread that works through the queue, where its service leads.

While another service leads, this one stands by without an engine and tries again every few seconds. A leader that
loses its lead leaves its attempts running: it adopts them if it leads again, and leaves them to
another leader. A leader that still holds the lead and finds a later term logs a warning and begins a new term.
"""

import logging
import math
import os
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from queue import Empty, SimpleQueue

from service.execution.protocol import Engine, OpenEngine
from service.queue import data_identity as identity
from service.queue.leader import Leader
from service.queue.renewal import Expand
from service.records.expansion import expand_again
from service.records.jobs import StoreUnavailable
from service.settings import Settings
from service.store import DatabaseFileLost, Leadership, Store
from service.workers.attempt import Inbox
from service.workers.timings import DEFAULT, Timings

log = logging.getLogger(__name__)

OTHER_LEADER = (
    "another program has started to process this queue in spite of the lock for one leader; "
    "this service continues and takes over the claimed jobs: make sure that the other program has ended"
)


class Dispatcher:
    """Keeps the engine busy with the queue, and the rows true."""

    def __init__(
        self,
        settings: Settings,
        store: Store,
        *,
        open_engine: OpenEngine,
        timings: Timings = DEFAULT,
        expand: Expand = expand_again,
    ):
        self._settings = settings
        self._store = store
        self._open_engine = open_engine
        self._timings = timings
        self._owner = f"{socket.gethostname()}:{os.getpid()}"
        self._inbox: Inbox = SimpleQueue()
        self._leader = Leader(settings, store, wake=self.wake, timings=timings, expand=expand)
        self._leadership: Leadership | None = None
        self._engine: Engine | None = None
        self._closing = False
        self._first_tick: SimpleQueue[Exception | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="dispatcher", daemon=True)
        # Monotonic: setting the clock of the machine changes nothing here.
        self._tried = -math.inf
        self._ticked = time.monotonic()  # end of the last tick that succeeded
        self._refusal: str | None = None  # by the database, of the last tick
        self._is_away = False  # whether data directory or database were, at the last tick

    # --- for others ------------------------------------------------------------------------------

    def start(self) -> None:
        """Begin to work through the queue; raises what keeps the engine from starting."""
        self._store.on_command(self.wake)
        self._thread.start()
        error = self._first_tick.get()
        if error is not None:
            self.close()
            raise error

    def is_alive(self) -> bool:
        """Whether this service works through the queue or stands by, and its last tick was not long ago."""
        ticks = time.monotonic() - self._ticked < self._timings.stuck
        return ticks and self._thread.is_alive() and not self._closing

    def leads(self) -> bool:
        return self._leader.term is not None and self._refusal is None

    def blocked_reason(self) -> str | None:
        return self._refusal or self._leader.blocked_reason

    def is_refused(self) -> bool:
        return self._refusal is not None

    def workers(self) -> int | None:
        return self._leader.slots if self.leads() else None

    def wake(self) -> None:
        """Ask for a tick now."""
        self._inbox.put(None)

    def leave(self) -> None:
        """Ask the thread to end: nothing more is claimed, and attempts write a checkpoint and leave.

        Returns at once, so that a signal handler may call it.
        """
        self._closing = True
        self.wake()

    def close(self) -> None:
        """Stop what is under way, queue it again, and end the thread."""
        self.leave()
        self._thread.join()

    # --- the thread ------------------------------------------------------------------------------

    def _run(self) -> None:
        self._first_tick.put(self._try_first_tick())
        while not self._closing:
            self._receive(wait=self._settings.poll_seconds)
            if not self._closing:
                with self._logged():
                    self.tick()
        self._end()

    def _try_first_tick(self) -> Exception | None:
        """The error that keeps this dispatcher from working; a store that is away may come back."""
        try:
            self.tick()
        except StoreUnavailable as error:
            log.warning("%s", error)
        except Exception as error:
            return error
        return None

    @contextmanager
    def _logged(self) -> Iterator[None]:
        """Log errors: the thread goes on, and the next tick tries again."""
        try:
            yield
        except StoreUnavailable as error:
            log.warning("%s", error)
        except Exception:
            log.exception("the dispatcher could not finish its tick")

    def tick(self) -> None:
        """Receive the engine's messages and, as the leader, reconcile rows and engine."""
        self._receive(wait=0.0)
        try:
            if self._lead():
                self._leader.reconcile()
        except StoreUnavailable as error:
            self._refusal = str(error)
            raise
        self._refusal = None
        self._ticked = time.monotonic()

    def _receive(self, *, wait: float) -> None:
        """Receive messages; return ``wait`` seconds later, or after one that needs a tick."""
        end = time.monotonic() + wait
        while True:
            try:
                message = self._inbox.get(timeout=max(0.0, end - time.monotonic()))
            except Empty:
                return
            if self._leader.in_flight.receive(message):
                end = 0.0  # receive the messages that are there, then return

    def _end(self) -> None:
        """Close the engine; meanwhile register what ends, and afterwards queue the rest again."""
        closing = threading.Thread(target=self._close_engine, args=(self._settings.leave_seconds,), name="closing")
        closing.start()
        while closing.is_alive():
            self._receive(wait=self._timings.closing_poll)
            with self._logged():
                self._leader.register_last(is_over=False)
        self._receive(wait=0.0)
        with self._logged():
            self._leader.register_last(is_over=True)
        self._leader.verification.close()
        self._leader.renewer.close()
        if self._leadership is not None:
            self._leadership.close()

    def _close_engine(self, leave_seconds: float | None) -> None:
        """Close the engine; abandon it if it does not close in order."""
        engine, self._engine = self._engine, None
        if engine is None:
            return
        try:
            engine.close(leave_seconds)
        except Exception:
            log.exception("the engine could not be closed in order")

    # --- who leads -------------------------------------------------------------------------------

    def _lead(self) -> bool:
        """Whether this service leads, with a data directory, an engine and a term."""
        if not self._has_directory():
            return False
        if self._leadership is None or not self._leadership.holds():
            self._resign()
            if not self._may_retry():
                return False
            self._leadership = self._store.terms.lead(self._owner)
            if self._leadership is None:
                self._stand_by()
                return False
            self._tried = -math.inf
        if self._engine is None:
            if not self._may_retry():
                return False
            self._engine = self._open_engine(self._inbox)
            self._receive(wait=0.0)  # a scheduler that has not answered yet is away
        if self._leader.term is None or self._leader.is_superseded:
            if not self._leadership.holds():  # the engine took long to start
                return False
            if self._leader.is_superseded:
                log.error(OTHER_LEADER)
            term = self._store.terms.begin(self._owner)
            self._leader.begin_term(term, self._engine)
            log.info("%s leads, term %s", self._owner, term)
        return True

    def _has_directory(self) -> bool:
        """Whether data directory and database are there and belong together; otherwise this service cannot lead."""
        was_away = self._is_away
        try:
            identity.check(self._settings, self._store)
            self._is_away = False
        except (identity.WrongDirectory, DatabaseFileLost) as error:
            self._is_away = True
            if not was_away:
                log.error("%s", error)
            self._resign()
            self._leader.verification.clear()
            self._leader.blocked_reason = error.what
        if self._is_away or was_away:
            self._leader.in_flight.excuse_failures()
        return not self._is_away

    def _may_retry(self) -> bool:
        now = time.monotonic()
        if now - self._tried < self._timings.leadership_retry:
            return False
        self._tried = now
        return True

    def _resign(self) -> None:
        """End the term. Its attempts go on until it is known whether another service leads."""
        if self._leadership is not None:
            log.warning("this service is no longer the leader")
            self._leadership.close()
        self._leadership = None
        self._leader.end_term()

    def _stand_by(self) -> None:
        """Close the engine: the other leader adopts what is under way, or begins it again."""
        if self._engine is not None:
            log.warning("another service leads; this service stands by")
        self._leader.in_flight.clear()
        self._leader.verification.clear()
        self._leader.blocked_reason = None
        self._close_engine(None)
