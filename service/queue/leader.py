"""The turns of the service that leads: rows and engine are compared, ends registered, slots filled.

The row is the truth: what this object remembers is only which attempts it has given to the engine.
Whatever is lost on the way is found when the two are compared.
"""

import logging
import math
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Self

from service.execution.protocol import Engine
from service.files.artifacts import Artifacts
from service.files.disk_space import Space
from service.queue.garbage_collection import GarbageCollector
from service.queue.in_flight import Attempts
from service.queue.registration import Registrar
from service.queue.tickets import Tickets
from service.queue.verification import WAIT_SECONDS, Inspector, Looks
from service.records.attempt import Ending
from service.records.fault_points import point
from service.records.jobs import Claim, State, StoreUnavailable
from service.records.logs import about
from service.records.settings import Settings
from service.store import Store

log = logging.getLogger(__name__)

REFUSED_SECONDS = 5.0  # after an attempt that could not be given to the engine
STUMBLED_SECONDS = 5.0  # before an end that could not be brought into its row is looked at again
STUMBLES = 3  # of one end, until it is given up
LAST_LOOK_SECONDS = 2.0  # at what attempts left, when the service stops; our next life looks again
NO_WORKER = "there is no worker"
REFUSED = "the engine takes no work; see the log"
PROGRESS_SECONDS = 1.0  # between two writes of progress


@dataclass(frozen=True)
class _Stumbled:
    """An end that could not be brought into its row."""

    times: int
    not_before: float  # monotonic


@dataclass(frozen=True)
class Parts:
    """What every reign works with."""

    settings: Settings
    store: Store
    artifacts: Artifacts
    space: Space
    tickets: Tickets
    inspector: Inspector
    registrar: Registrar
    care: GarbageCollector

    @classmethod
    def of(cls, settings: Settings, store: Store) -> Self:
        """The parts for a store and its data directory."""
        artifacts = Artifacts(settings.data)
        space = Space(settings.data, settings.disk_reserve)
        return cls(
            settings=settings,
            store=store,
            artifacts=artifacts,
            space=space,
            tickets=Tickets(settings, store, artifacts),
            inspector=Inspector(artifacts),
            registrar=Registrar(store, artifacts, space),
            care=GarbageCollector(settings, store, artifacts, space),
        )


class Reign:
    """An epoch, while it lasts; claims of earlier ones, our own included, are foreign to it."""

    def __init__(self, epoch: int, parts: Parts, engine: Engine, attempts: Attempts, looks: Looks):
        self.epoch = epoch
        self._parts = parts
        self._store = parts.store
        self._engine = engine
        self._attempts = attempts
        self._looks = looks
        self._attempts.held.clear()
        parts.registrar.refused.clear()
        self._compared = self._written = self._refused = -math.inf  # monotonic
        self._stumbled: dict[str, _Stumbled] = {}  # ends that could not be settled
        self.slots = 0  # attempts that can be under way at once
        self.has_ended = False  # a younger one began: this one claims and adopts nothing any more
        self.hindrance: str | None = None  # why nothing is begun

    def turn(self) -> None:
        """Bring rows and engine together; what makes room is removed even if no row can be written."""
        claimed = self._store.claimed()
        self.slots = self._engine.slots()
        is_due = self._is_due()
        try:
            if is_due:
                self._compare(claimed)
            self._stop_unwanted(claimed)
            self._register_all(seconds=WAIT_SECONDS)
            self._fill()
            self._write_progress()
        finally:
            self.hindrance = self._why_not() or self._refusal()
            if is_due:
                self._parts.care.step()

    def settle(self, *, is_over: bool) -> None:
        """Register what ended while the engine closes; once that is over, queue the rest again."""
        if is_over:
            stopped = Ending.lost("Lost", "the service was stopped")
            for key in self._attempts.held:
                self._attempts.ended.setdefault(key, stopped)
            self._stumbled.clear()
        self._register_all(seconds=LAST_LOOK_SECONDS if is_over else WAIT_SECONDS)

    def _is_due(self) -> bool:
        """Whether it is time to compare: at the begin, every few seconds, when the engine is back."""
        late = time.monotonic() - self._compared >= self._parts.settings.reconcile_seconds
        return late or self._attempts.is_back

    # --- rows and engine compared ----------------------------------------------------------------

    def _compare(self, claimed: tuple[Claim, ...]) -> None:
        """Every running row is under way here, adopted, finished, or put back into the queue.

        While the engine is away, nobody knows what is under way there, so nothing is decided.
        """
        self.has_ended = self._store.queue().epoch > self.epoch
        known = self._known()
        for claim in claimed:
            if claim.key in self._attempts.held:
                continue
            if claim.key in self._attempts.given or claim.key in (known or ()):
                self._adopt(claim)
            elif known is not None:
                self._attempts.find_lost(claim, Ending.lost("Lost", "the service was gone"))
        self._follow_strangers((known or set()) - self._attempts.given, claimed)
        self._compared, self._attempts.is_back = time.monotonic(), False

    def _follow_strangers(self, known: set[str], claimed: tuple[Claim, ...]) -> None:
        """Attempts that the engine has from our earlier lives, and that no row counts on any more.

        They may hold a worker, so they are stopped and forgotten as others that no row wants.
        """
        counted = {claim.key for claim in claimed}
        for key in sorted(known - counted):
            if self._parts.artifacts.has_attempt(key):
                self._follow(key)

    def _known(self) -> set[str] | None:
        """What the engine has, also of earlier lives; None: it cannot be asked."""
        if self._attempts.away is None:
            with suppress(OSError):
                return self._engine.known()
        return None

    def _adopt(self, claim: Claim) -> None:
        """Go on with an attempt of an earlier reign that the engine still has."""
        if claim.key not in self._attempts.given and not self._follow(claim.key):
            return
        adopted = self._store.adopt(claim, self.epoch)
        if adopted is not None:  # else it is stopped, as one that no row wants
            log.info("%s is adopted", claim.key, extra=about(claim))
            self._attempts.hold(adopted)

    def _follow(self, key: str) -> bool:
        """Hear how an attempt of an earlier life ends; whether the engine could be asked."""
        try:
            self._engine.follow(key)
        except OSError:
            return False  # away again; looked at when it is back
        self._attempts.given.add(key)
        return True

    def _stop_unwanted(self, claimed: tuple[Claim, ...]) -> None:
        """Ask the engine to stop what no running row wants; asked at each turn until it ends."""
        wanted = {claim.key for claim in claimed if claim.state is State.RUNNING}
        unwanted = self._attempts.under_way() - wanted
        if unwanted:
            with suppress(OSError):  # away; asked again when it is back
                self._engine.stop(sorted(unwanted))

    # --- what came back --------------------------------------------------------------------------

    def _register_all(self, *, seconds: float) -> None:
        """Bring every ended attempt into its row; it is forgotten only when the row has it.

        What takes longer than so many seconds to look at is registered at a later turn.
        """
        due = self._due()
        self._looks.begin(due, seconds=seconds)
        settled: list[str] = []
        try:
            for key in list(self._attempts.ended):
                claim = self._attempts.held.get(key)
                if claim is None or (key in due and self._is_settled(claim)):
                    self._attempts.forget(key)  # its row has it, or no row waits for it
                    self._looks.forget(key)
                    self._stumbled.pop(key, None)
                    settled.append(key)
        finally:
            if settled:
                self._engine.forget(settled)

    def _due(self) -> dict[str, tuple[Claim, Ending]]:
        """Ends that should be brought into their rows now."""
        now, held = time.monotonic(), self._attempts.held
        return {
            key: (held[key], ending)
            for key, ending in self._attempts.ended.items()
            if key in held and (key not in self._stumbled or self._stumbled[key].not_before < now)
        }

    def _is_settled(self, claim: Claim) -> bool:
        """Bring an end into its row, if it is known; one for which that fails must not hold up the others."""
        try:
            found = self._looks.take(claim.key)
            if found is None:
                return False
            self._parts.registrar.settle(claim, found)
        except StoreUnavailable:
            raise  # nor could the others
        except Exception as error:
            return self._is_given_up(claim, error)
        return True

    def _is_given_up(self, claim: Claim, error: Exception) -> bool:
        """Note that an end could not be brought into its row; after some tries the job has failed."""
        log.exception("%s could not be settled", claim.key, extra=about(claim))
        times = self._stumbled.get(claim.key, _Stumbled(0, 0.0)).times + 1
        self._stumbled[claim.key] = _Stumbled(times, time.monotonic() + STUMBLED_SECONDS)
        if times < STUMBLES:
            return False
        with suppress(Exception):  # not even that; it is tried again
            self._parts.registrar.abandon(claim, error)
            return True
        return False

    def _write_progress(self) -> None:
        """At most so often: one transaction for all runs."""
        now, attempts = time.monotonic(), self._attempts
        if not attempts.told or now - self._written < PROGRESS_SECONDS:
            return
        self._written = now
        news = [
            (claim, words)
            for key, words in attempts.told.items()
            if (claim := attempts.held.get(key)) is not None
        ]
        attempts.told.clear()
        self._store.progress([_progress(claim, words) for claim, words in news])
        self._store.checkpointed(
            [(claim, words["checkpoint"]) for claim, words in news if "checkpoint" in words]
        )

    # --- what begins -----------------------------------------------------------------------------

    def _fill(self) -> None:
        """Give the engine as many attempts as it has free slots."""
        free = self.slots - len(self._attempts.under_way())
        if free <= 0 or self._why_not() is not None:
            return
        resting = self._parts.registrar.rests.resting()
        is_refused = self._refusal() is not None
        claims = self._store.claim(free, self.epoch, publications_only=is_refused, resting=resting)
        under_way = len(self._attempts.under_way()) + len(claims)
        threads = self._parts.settings.threads_of_a_run(workers=self.slots, runs=max(1, under_way))
        for claim in claims:
            point("claim-after-commit")
            self._attempts.hold(claim)
            self._submit(claim, threads)

    def _why_not(self) -> str | None:
        """Why nothing is begun, whatever there is in the queue."""
        if self._attempts.away is not None:
            return self._attempts.away
        if time.monotonic() - self._refused < REFUSED_SECONDS:
            return REFUSED
        return NO_WORKER if self.slots == 0 else self._parts.space.shortage()

    def _refusal(self) -> str | None:
        """Why no run is begun though publications are: too many results are lost."""
        return next(iter(self._parts.registrar.refused.values()), None)

    def _submit(self, claim: Claim, threads: int) -> None:
        try:
            self._engine.submit(self._parts.tickets.write(claim, threads=threads))
        except Exception as error:  # whatever it is, the attempt is not under way
            log.exception("%s could not be given to the engine", claim.key, extra=about(claim))
            self._attempts.ended[claim.key] = Ending.lost(
                "Lost", f"{type(error).__name__}: {error}"
            )
            self._refused = time.monotonic()
        point("claim-after-submit")


def _progress(
    claim: Claim, words: Mapping[str, Any]
) -> tuple[Claim, float, float, Mapping[str, Any]]:
    return claim, float(words.get("fraction") or 0.0), float(words["seconds"]), words
