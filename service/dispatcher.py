"""Between the rows and the engine: claims, registers, tries again, stops, and compares the two.

One thread. The row is the truth: what this object remembers is only which attempts it has given to
the engine. Whatever is lost on the way is found by ``_reconcile``.
"""

import logging
import math
import os
import socket
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, Protocol

from service.artifacts import LOG, Artifacts, describe
from service.execution import Ended, Message, Told
from service.jobs import (
    Cause,
    Claim,
    Kind,
    Outcome,
    Result,
    State,
    Stored,
    StoreUnavailable,
    may_try_again,
)
from service.settings import Settings
from service.store import Store
from service.worker import Ending, Ticket

log = logging.getLogger(__name__)

PROGRESS_SECONDS = 1.0  # between two writes of progress
STUCK_SECONDS = 60.0  # without a turn that succeeded, before it counts as dead


class Engine(Protocol):
    """What the dispatcher asks of an engine; ``execution.Engine`` is one."""

    def slots(self) -> int: ...
    def submit(self, ticket: Ticket) -> None: ...
    def stop(self, keys: list[str]) -> None: ...
    def close(self) -> None: ...


class Dispatcher:
    """Keeps the engine busy with the queue, and the rows true."""

    def __init__(
        self,
        settings: Settings,
        store: Store,
        *,
        engine: Engine,
        inbox: "SimpleQueue[Message | None]",
    ):
        self._settings = settings
        self._store = store
        self._artifacts = Artifacts(settings.data)
        self._engine = engine
        self._inbox = inbox
        self._held: dict[str, Claim] = {}  # attempts that the engine has, by key
        self._ended: dict[str, Ending] = {}  # of these, not yet registered
        self._told: dict[str, Mapping[str, Any]] = {}  # last progress, not yet written
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="dispatcher", daemon=True)
        self._epoch: int | None = None
        self._reconciled = self._written = -math.inf  # monotonic
        self._worked = time.monotonic()  # end of the last turn that succeeded

    def start(self) -> None:
        """Begin to work through the queue."""
        self._store.on_order(self.wake)
        self._thread.start()

    def is_alive(self) -> bool:
        """Whether somebody looks after the queue, and could do so lately."""
        works = time.monotonic() - self._worked < STUCK_SECONDS
        return works and self._thread.is_alive() and not self._closing.is_set()

    def wake(self) -> None:
        """Look at the queue now."""
        self._inbox.put(None)

    def close(self) -> None:
        """Stop what is under way, put it back into the queue, and leave."""
        self._closing.set()
        self.wake()
        self._thread.join()
        self._engine.close()
        self._listen(wait=0.0)
        with self._patience():
            self._register_all()
            for claim in self._held.values():
                self._store.requeue(claim, Cause.LOST, reason="the service was stopped")

    # --- the thread ------------------------------------------------------------------------------

    def _run(self) -> None:
        while not self._closing.is_set():
            with self._patience():
                self.turn()
            self._listen(wait=self._settings.poll_seconds)

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
        """Take what the engine said, and bring rows and engine together."""
        self._listen(wait=0.0)
        if self._epoch is None:
            self._epoch = self._store.begin_epoch(f"{socket.gethostname()}:{os.getpid()}")
        self._register_all()
        self._write_progress()
        claimed = self._store.claimed()
        self._reconcile(claimed)
        self._stop_unwanted(claimed)
        self._fill()
        self._worked = time.monotonic()

    def _listen(self, *, wait: float) -> None:
        """Take what the engine says, and wait for it at most so long."""
        try:
            message = self._inbox.get(timeout=wait)
            while True:
                self._take(message)
                message = self._inbox.get_nowait()
        except Empty:
            pass

    def _take(self, message: Message | None) -> None:
        if isinstance(message, Ended):
            self._ended[message.key] = message.ending
        elif isinstance(message, Told):
            self._told[message.key] = message.words

    # --- what came back --------------------------------------------------------------------------

    def _register_all(self) -> None:
        """Bring every ended attempt into its row; it is forgotten only when the row has it."""
        for key, ending in list(self._ended.items()):
            claim = self._held.get(key)
            if claim is not None:
                self._settle(claim, ending)
            for known in (self._ended, self._held, self._told):
                known.pop(key, None)

    def _settle(self, claim: Claim, ending: Ending) -> None:
        """One ended attempt: its result, another try, or its failure."""
        cause, failure, reason = ending.cause, ending.failure, ending.reason
        if cause is None:
            try:
                counts = self._register(claim, ending)
            except (OSError, ValueError, LookupError) as error:
                cause, failure = Cause.CRASH, type(error).__name__
                reason = f"its files cannot be registered: {error}"
        if cause is not None and may_try_again(cause, claim.crashes):
            counts = self._store.requeue(claim, cause, reason=reason)
        elif cause is not None:
            folder = self._artifacts.relative(self._artifacts.attempt_directory(claim))
            reason = f"{reason} (log: {folder}/{LOG})"
            counts = self._store.fail(claim, cause, failure=failure, reason=reason)
        log.log(
            logging.INFO if counts else logging.WARNING,
            "%s %s: %s",
            claim.kind,
            claim.key,
            (reason or "done") if counts else "too late, it no longer counts",
        )

    def _register(self, claim: Claim, ending: Ending) -> bool:
        """Registers complete files, after a look at their digests."""
        files = [_with_path(file, self._artifacts) for file in ending.files]
        damaged = [file.name for file in files if not self._artifacts.is_intact(file)]
        if damaged:
            raise ValueError(f"{', '.join(damaged)} does not match its checksum")
        self._artifacts.bring_to_disk(self._artifacts.attempt_directory(claim))
        if claim.kind is Kind.PUBLISH:
            return self._store.publish(claim, files, seconds=ending.seconds)
        [file] = files
        return self._store.finish(claim, _result(file, self._artifacts, ending.seconds))

    def _write_progress(self) -> None:
        """At most so often: one transaction for all runs."""
        now = time.monotonic()
        if not self._told or now - self._written < PROGRESS_SECONDS:
            return
        self._written = now
        news = [
            (claim, float(words.get("fraction", 0.0)), float(words["seconds"]), words)
            for key, words in self._told.items()
            if (claim := self._held.get(key)) is not None
        ]
        self._told.clear()
        self._store.progress(news)

    # --- rows and engine compared ----------------------------------------------------------------

    def _reconcile(self, claimed: tuple[Claim, ...]) -> None:
        """Every running row is under way here, finished, or put back into the queue."""
        now = time.monotonic()
        if now - self._reconciled < self._settings.reconcile_seconds:
            return
        for claim in claimed:
            if claim.key not in self._held:
                self._recover(claim)
        gone = self._store.forgotten(self._artifacts.sweep_ids())
        self._artifacts.discard_sweeps(gone)
        self._reconciled = now

    def _recover(self, claim: Claim) -> None:
        """An attempt of an earlier life: its result may be complete, else it is tried again."""
        directory = self._artifacts.attempt_directory(claim)
        answer = directory / "result.json"
        if claim.kind is Kind.RUN and answer.is_file():
            self._settle(claim, Ending(None, "", "", (describe(answer),), 0.0))
            return
        self._store.requeue(claim, Cause.LOST, reason="the service was gone")

    def _stop_unwanted(self, claimed: tuple[Claim, ...]) -> None:
        """Ask the engine to stop what nobody waits for; asked again at each turn until it ends."""
        keys = [claim.key for claim in claimed if claim.state is State.CANCELLING]
        unwanted = [key for key in keys if key in self._held]
        if unwanted:
            self._engine.stop(unwanted)

    def _fill(self) -> None:
        """Give the engine as many attempts as it has free slots."""
        assert self._epoch is not None
        free = self._engine.slots() - len(self._held)
        if free <= 0:
            return
        for claim in self._store.claim(free, self._epoch):
            self._held[claim.key] = claim
            try:
                self._engine.submit(self._ticket(claim))
            except Exception as error:  # whatever it is, the attempt is not under way
                log.exception("%s could not be given to the engine", claim.key)
                self._ended[claim.key] = Ending(
                    Cause.LOST, type(error).__name__, str(error), (), 0.0
                )

    def _ticket(self, claim: Claim) -> Ticket:
        return Ticket(
            key=claim.key,
            kind=claim.kind,
            directory=str(self._artifacts.attempt_directory(claim)),
            spec=self._spec(claim),
            seconds_limit=self._settings.run_seconds_limit,
            targets=self._settings.targets_module,
        )

    def _spec(self, claim: Claim) -> Mapping[str, Any]:
        if claim.kind is Kind.RUN:
            return claim.spec
        assert claim.sweep_id is not None
        document, outcomes = self._store.question(claim.sweep_id)
        return {
            "document": document,
            "outcomes": [_outcome(one, self._artifacts.root) for one in outcomes],
        }


def _outcome(outcome: Outcome, root: Path) -> dict[str, Any]:
    """How a run ended, for the process that publishes."""
    has_result = outcome.path is not None and outcome.state in (State.SUCCEEDED, State.FAILED)
    return {
        "run_id": outcome.run_id,
        "state": outcome.state,
        "reason": outcome.reason,
        "path": str(root / outcome.path) if has_result and outcome.path else None,
        "sha256": outcome.sha256,
    }


def _with_path(file: Stored, artifacts: Artifacts) -> Stored:
    """A file that a worker described, with its path as rows have it."""
    return Stored(file.name, artifacts.relative(Path(file.path)), file.size, file.sha256)


def _result(file: Stored, artifacts: Artifacts, seconds: float) -> Result:
    """What the row keeps of a result: everything but histories."""
    answer = artifacts.read_json(file)
    measured = {
        name: {key: one[key] for key in ("value", "uncertainty", "flags") if key in one}
        for name, one in answer["measurements"].items()
    }
    summary = {"measurements": measured}
    summary |= {key: answer[key] for key in ("flags", "numbers", "stop") if key in answer}
    return Result(
        file=file,
        succeeded=answer["state"] == "succeeded",
        reason=answer["reason"],
        failure=answer["failure"],
        summary=summary,
        seconds=seconds or float(answer["provenance"].get("seconds", 0.0)),
    )
