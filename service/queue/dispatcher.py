"""The thread that works through the queue, and who of several services does.

The leader holds an epoch and an engine, and takes turns (``service.queue.leader``). While another service
leads, this one stands by without an engine and asks again every few seconds. A leader whose right is
gone lets what is under way go on until it knows: if it leads again, it adopts that; if another one
does, it lets go of it. A leader that has the right, and meets a younger epoch all the same, says so
and begins another one.
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
from service.queue.in_flight import Attempts
from service.queue.leader import Parts, Reign
from service.queue.verification import Looks
from service.records.attempt import Inbox
from service.records.jobs import StoreUnavailable
from service.records.settings import Settings
from service.store import Leadership, Store

log = logging.getLogger(__name__)

TRY_SECONDS = 2.0  # between two attempts to become the leader, or to start the engine
STUCK_SECONDS = 60.0  # without a turn that succeeded, before it counts as dead
END_SECONDS = 0.1  # between two looks whether the engine is closed
UNSAID = "nothing yet"
OTHER_LEADER = (
    "another program has begun to work through this queue, past the lock that keeps it to one; "
    "this one goes on, and takes over what is claimed: see to it that the other has ended"
)


class Dispatcher:
    """Keeps the engine busy with the queue, and the rows true."""

    def __init__(self, settings: Settings, store: Store, *, open_engine: OpenEngine):
        self._settings = settings
        self._store = store
        self._open_engine = open_engine
        self._parts = Parts.of(settings, store)
        self._looks = Looks(self._parts.inspector, self.wake)
        self._owner = f"{socket.gethostname()}:{os.getpid()}"
        self._inbox: Inbox = SimpleQueue()
        self._attempts = Attempts()
        self._leadership: Leadership | None = None
        self._engine: Engine | None = None
        self._reign: Reign | None = None
        self._closing = False
        self._first_turn: SimpleQueue[Exception | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="dispatcher", daemon=True)
        # Of the monotonic clock: setting the other one changes nothing here.
        self._tried = -math.inf
        self._worked = time.monotonic()  # end of the last turn that succeeded
        self._hindrance: str | None = None
        self._said: str | None = UNSAID  # what the store knows of it
        self._is_away = False  # whether the data directory was at the last turn

    # --- for others ------------------------------------------------------------------------------

    def start(self) -> None:
        """Begin to work through the queue; raises what keeps the engine from starting."""
        self._store.on_order(self.wake)
        self._thread.start()
        error = self._first_turn.get()
        if error is not None:
            self.close()
            raise error

    def is_alive(self) -> bool:
        """Whether this service works through the queue, or stands by, and could do so lately."""
        works = time.monotonic() - self._worked < STUCK_SECONDS
        return works and self._thread.is_alive() and not self._closing

    def leads(self) -> bool:
        """Whether it is this service that gives the work out."""
        return self._reign is not None

    def trouble(self) -> str | None:
        """Why nothing is begun although there may be work; told by a leader."""
        return self._hindrance

    def workers(self) -> int | None:
        """Attempts that can be under way at once; None while another service leads."""
        reign = self._reign
        return None if reign is None else reign.slots

    def wake(self) -> None:
        """Look at the queue now."""
        self._inbox.put(None)

    def leave(self) -> None:
        """Begin to stop: nothing more is claimed, what runs writes a checkpoint and goes.

        Does not wait; a signal handler may call it.
        """
        self._closing = True
        self.wake()

    def close(self) -> None:
        """Stop what is under way, put it back into the queue, and leave."""
        self.leave()
        self._thread.join()

    # --- the thread ------------------------------------------------------------------------------

    def _run(self) -> None:
        self._first_turn.put(self._try_first_turn())
        while not self._closing:
            self._listen(wait=self._settings.poll_seconds)
            if not self._closing:
                with self._patience():
                    self.turn()
        self._end()

    def _try_first_turn(self) -> Exception | None:
        """What cannot work is told at once to whoever starts us; what may pass is waited for."""
        try:
            self.turn()
        except StoreUnavailable as error:
            log.warning("%s", error)
        except Exception as error:
            return error
        return None

    @contextmanager
    def _patience(self) -> Iterator[None]:
        """Nothing ends this thread: what could not be done now is tried again at the next turn."""
        try:
            yield
        except StoreUnavailable as error:
            log.warning("%s", error)
        except Exception:
            log.exception("the dispatcher could not finish its turn")

    def turn(self) -> None:
        """Take what the engine said and, as the leader, bring rows and engine together."""
        self._listen(wait=0.0)
        if self._leads():
            assert self._reign is not None
            try:
                self._reign.turn()
            finally:
                self._hinder(self._reign.hindrance)
        self._worked = time.monotonic()

    def _listen(self, *, wait: float) -> None:
        """Take what the engine says; wait at most so long for something that needs a turn."""
        end = time.monotonic() + wait
        while True:
            try:
                message = self._inbox.get(timeout=max(0.0, end - time.monotonic()))
            except Empty:
                return
            if self._attempts.take(message):
                end = 0.0  # the rest of what is there, then go

    def _end(self) -> None:
        """The last turns: what ended is registered, what left on request is queued again."""
        closing = threading.Thread(target=self._close_engine, name="closing")
        closing.start()
        while closing.is_alive():
            self._listen(wait=END_SECONDS)
            self._settle(is_over=False)
        self._listen(wait=0.0)
        self._settle(is_over=True)
        self._looks.close()
        if self._leadership is not None:
            self._leadership.close()

    def _close_engine(self) -> None:
        if self._engine is not None:
            _close(self._engine, self._settings.leave_seconds)

    def _settle(self, *, is_over: bool) -> None:
        if self._reign is not None:
            with self._patience():
                self._reign.settle(is_over=is_over)
                if is_over:
                    self._hinder(None)

    # --- who leads -------------------------------------------------------------------------------

    def _leads(self) -> bool:
        """Whether this service leads, and has what it needs for that."""
        if not self._has_directory():
            return False
        if self._leadership is None or not self._leadership.holds():
            self._resign()
            if not self._is_time_to_try():
                return False
            self._leadership = self._store.lead(self._owner)
            if self._leadership is None:
                self._stand_by()
                return False
            self._tried = -math.inf
        if self._engine is None:
            if not self._is_time_to_try():
                return False
            self._engine = self._open_engine(self._inbox)
            self._listen(wait=0.0)  # a scheduler that has not answered yet is away
        if self._reign is None or self._reign.has_ended:
            if not self._leadership.holds():  # the engine took long to start
                return False
            self._begin_reign()
        return True

    def _has_directory(self) -> bool:
        """Whether the data directory is the one of the database; without it this service cannot lead.

        What is under way goes on as after any loss of the right to lead.
        """
        was_away = self._is_away
        try:
            identity.check(self._settings, self._store)
            self._is_away = False
        except identity.WrongDirectory as error:
            self._is_away = True
            if not was_away:
                log.error("%s", error)
            self._resign()
            self._looks.clear()
            self._hindrance = error.what
        if self._is_away or was_away:
            self._attempts.excuse()
        return not self._is_away

    def _is_time_to_try(self) -> bool:
        now = time.monotonic()
        if now - self._tried < TRY_SECONDS:
            return False
        self._tried = now
        return True

    def _resign(self) -> None:
        """The right to lead is gone. What is under way goes on until we know whether another leads."""
        if self._leadership is not None:
            log.warning("the right to lead is lost")
            self._leadership.close()
        self._leadership = self._reign = None
        self._said = UNSAID

    def _stand_by(self) -> None:
        """Another service leads: what is under way here is for it to adopt, or to begin again."""
        engine, self._engine = self._engine, None
        self._attempts.clear()
        self._hindrance = None
        if engine is not None:
            log.warning("another service leads; this one stands by")
            _close(engine, None)

    def _begin_reign(self) -> None:
        assert self._engine is not None
        if self._reign is not None:
            log.error(OTHER_LEADER)
        epoch = self._store.begin_epoch(self._owner)
        self._reign = Reign(epoch, self._parts, self._engine, self._attempts, self._looks)
        log.info("%s leads, epoch %s", self._owner, epoch)

    def _hinder(self, reason: str | None) -> None:
        """Let every service that shares the store know why nothing is begun, when that changes."""
        self._hindrance = reason
        if reason != self._said:
            epoch = None if self._reign is None else self._reign.epoch
            self._store.hinder(reason, epoch)
            self._said = reason


def _close(engine: Engine, leave_seconds: float | None) -> None:
    """End an engine; one that does not end in order is left to itself."""
    try:
        engine.close(leave_seconds)
    except Exception:
        log.exception("the engine could not be closed in order")
