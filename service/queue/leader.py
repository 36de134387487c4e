"""The leader's work: it reconciles rows with the engine, registers what ended and fills free slots.

The row is the truth: this object remembers only which attempts it has given to the engine. What is lost on the way is
found when rows and engine are compared.
"""

import logging
import math
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

from service.execution.protocol import Engine
from service.files.artifacts import Artifacts
from service.files.disk_space import Space
from service.logs import about
from service.queue import searching
from service.queue.clock_watch import ClockWatch
from service.queue.garbage_collection import GarbageCollector
from service.queue.in_flight import AttemptsInFlight
from service.queue.keepers import keepers_of
from service.queue.registration import Registrar
from service.queue.renewal import Expand, Renewer
from service.queue.verification import Verification
from service.records.jobs import Kind, Lease, State, StoreUnavailable
from service.settings import Settings
from service.store import Store
from service.workers.attempt import Attempt, Ending, Publication
from service.workers.timings import Timings
from solver import PHYSICS_VERSION
from studies.runs.results import OTHER_PHYSICS

log = logging.getLogger(__name__)

MOST_REGISTRATIONS = 3  # tries to register one ending, until its job fails
NO_WORKER = "there is no worker"
REFUSED = "the engine accepts no work; see the log"
UNKNOWN = "unknown"  # the store may have the reason of another leader


@dataclass(frozen=True)
class _Failure:
    """An ending that could not be registered."""

    times: int
    not_before: float  # monotonic: of the next try


class Leader:
    """Reconciles rows and engine during its terms; leases of earlier terms are foreign until adopted."""

    def __init__(self, settings: Settings, store: Store, *, wake: Callable[[], None], timings: Timings, expand: Expand):
        self._settings = settings
        self._store = store
        self._timings = timings
        self._artifacts = Artifacts.of(settings)
        self._space = Space(settings.data, settings.disk_reserve)
        self._registrar = Registrar(store, self._artifacts, self._space, timings)
        clock = ClockWatch(settings, store)
        self._collector = GarbageCollector(settings, store, self._artifacts, self._space, clock, timings)
        self._keepers = keepers_of(settings, store, self._artifacts, clock, timings)
        self.verification = Verification(self._artifacts, wake, timings, store.runs.files)
        self.renewer = Renewer(store, expand, wake)
        self.in_flight = AttemptsInFlight()
        self.term: int | None = None
        self.is_superseded = False  # a younger term began: this one claims and adopts nothing more
        self.slots = 0  # attempts that can be under way at once
        self.blocked_reason: str | None = None  # why no job begins
        self._stored_reason: str | None = UNKNOWN
        self._engine: Engine
        self._reset()

    def _reset(self) -> None:
        self._compared = self._written = self._submission_failed = -math.inf  # monotonic
        self._failures: dict[str, _Failure] = {}  # by key

    def begin_term(self, term: int, engine: Engine) -> None:
        """Begin a term of leadership with an engine that is open."""
        self._reset()
        self.in_flight.leases.clear()
        self._registrar.blocking.clear()
        self.renewer.look_again()
        self._engine, self.term, self.is_superseded, self.slots = engine, term, False, 0

    def end_term(self) -> None:
        """End the term; attempts go on."""
        self.term, self.is_superseded, self._stored_reason = None, False, UNKNOWN

    def reconcile(self) -> None:
        """Bring rows and engine together; garbage is collected even if no row can be written."""
        assert self.term is not None
        try:
            leases = self._store.leases.held()
            self.slots = self._engine.slots()
            late = time.monotonic() - self._compared >= self._settings.reconcile_seconds
            is_due = late or self.in_flight.is_back
            try:
                if is_due:
                    self._compare(leases, self.term)
                self._stop_unwanted(leases)
                self.renewer.step()
                # An ending without a result may say that no run is to begin: it is registered first.
                ended_well = all(ending.cause is None for ending in self.in_flight.ended.values())
                if ended_well:
                    self._fill(self.term)
                if self._register(wait=self._timings.verification_wait) or not ended_well:
                    self._fill(self.term)
                self._write_progress()
            finally:
                self.blocked_reason = self._why_nothing_begins() or self._why_no_run_begins()
                if is_due:
                    self._collector.step()
                    for keeper in self._keepers:
                        keeper.step()
        finally:
            self._store_blocked_reason()

    def register_last(self, *, is_over: bool) -> None:
        """Register what ends while the engine closes; once it ``is_over``, queue the rest again."""
        if self.term is None:
            return
        if is_over:
            stopped = Ending.lost("Lost", "the service was stopped")
            for key in self.in_flight.leases:
                self.in_flight.ended.setdefault(key, stopped)
            self._failures.clear()
        timings = self._timings
        self._register(wait=timings.last_verification_wait if is_over else timings.verification_wait)
        if is_over:
            self.blocked_reason = None
            self._store_blocked_reason()

    # --- rows and engine compared ----------------------------------------------------------------

    def _compare(self, leases: tuple[Lease, ...], term: int) -> None:
        """Adopt, or mark as lost, each running row that is not under way here.

        While the engine is away its attempts are unknown, so none is marked as lost.
        """
        self.is_superseded = self._store.terms.latest() > term
        keys = self._engine_keys()
        for lease in leases:
            if lease.key in self.in_flight.leases:
                continue
            if lease.key in self.in_flight.submitted or lease.key in (keys or ()):
                self._adopt(lease, term)
            elif keys is not None:
                with suppress(OSError):  # a worker may have it still: its service froze before the engine kept it
                    self._engine.stop([lease.key])
                self.in_flight.add_lost(lease, "the service ended during the attempt")
        # Attempts of earlier processes without a row may occupy a worker: follow them, so that they are stopped.
        wanted = self.in_flight.submitted | {lease.key for lease in leases}
        for key in sorted((keys or set()) - wanted):
            if self._artifacts.has_attempt(key):
                self._follow(key)
        self._compared, self.in_flight.is_back = time.monotonic(), False

    def _engine_keys(self) -> set[str] | None:
        """Attempts that the engine has, also of earlier processes; None: the engine is unreachable."""
        if self.in_flight.away is None:
            with suppress(OSError):
                return self._engine.attempts()
        return None

    def _adopt(self, lease: Lease, term: int) -> None:
        """Go on with an attempt of an earlier term that the engine still has."""
        if lease.key not in self.in_flight.submitted and not self._follow(lease.key):
            return
        adopted = self._store.leases.adopt(lease, term)
        if adopted is not None:  # else it is stopped, as one that no row wants
            log.info("%s is adopted", lease.key, extra=about(lease))
            self.in_flight.add(adopted)

    def _follow(self, key: str) -> bool:
        """Ask the engine for the end of an attempt of an earlier process; False: it is unreachable."""
        try:
            self._engine.follow(key)
        except OSError:
            return False
        self.in_flight.submitted.add(key)
        return True

    def _stop_unwanted(self, leases: tuple[Lease, ...]) -> None:
        """Ask the engine to stop what no running row wants, at each tick until it has ended."""
        wanted = {lease.key for lease in leases if lease.state is State.RUNNING}
        unwanted = self.in_flight.under_way() - wanted
        if unwanted:
            with suppress(OSError):  # away; asked again when it is back
                self._engine.stop(sorted(unwanted))

    # --- what ended ------------------------------------------------------------------------------

    def _register(self, *, wait: float) -> bool:
        """Whether an ending was registered: each that is verified within ``wait`` seconds; others at a later tick."""
        now, flight = time.monotonic(), self.in_flight
        due = {
            key: (flight.leases[key], ending)
            for key, ending in flight.ended.items()
            if key in flight.leases and (key not in self._failures or self._failures[key].not_before < now)
        }
        self.verification.begin(due, seconds=wait)
        done: list[str] = []
        try:
            for key in list(flight.ended):
                lease = flight.leases.get(key)
                if lease is None or (key in due and self._is_registered(lease)):
                    flight.forget(key)
                    self.verification.forget(key)
                    self._failures.pop(key, None)
                    done.append(key)
        finally:
            if done:
                self._engine.forget(done)
        return bool(done)

    def _is_registered(self, lease: Lease) -> bool:
        """Register an ending that is verified; a failure must not hold up the others."""
        try:
            verified = self.verification.take(lease.key)
            if verified is None:
                return False
            self._registrar.register(lease, verified)
            if verified.result is not None and verified.result.failure == OTHER_PHYSICS:
                self.renewer.look_again()
        except StoreUnavailable:
            raise  # the others would fail too
        except Exception as error:
            return self._is_given_up(lease, error)
        return True

    def _is_given_up(self, lease: Lease, error: Exception) -> bool:
        """Note that an ending could not be registered; after some tries its job fails."""
        log.exception("the ending of %s could not be registered", lease.key, extra=about(lease))
        times = self._failures.get(lease.key, _Failure(0, 0.0)).times + 1
        retry = time.monotonic() + self._timings.registration_retry
        self._failures[lease.key] = _Failure(times, retry)
        if times < MOST_REGISTRATIONS:
            return False
        with suppress(Exception):  # tried again later
            self._registrar.abandon(lease, error)
            return True
        return False

    def _write_progress(self) -> None:
        """Write the progress of all runs in one transaction, and not at every tick."""
        now, flight = time.monotonic(), self.in_flight
        if not flight.progress or now - self._written < self._timings.progress_interval:
            return
        self._written = now
        news = [(flight.leases[key], progress) for key, progress in flight.progress.items() if key in flight.leases]
        flight.progress.clear()
        self._store.leases.record_progress(news)

    # --- what begins -----------------------------------------------------------------------------

    def _fill(self, term: int) -> None:
        """Give the engine as many attempts as it has free slots."""
        free = self.slots - len(self.in_flight.under_way())
        if free <= 0 or self._why_nothing_begins() is not None:
            return
        leases = self._store.leases.take(
            free,
            term,
            publications_only=self._why_no_run_begins() is not None,
            backed_off=self._registrar.backoff.delayed(),
        )
        runs = len(self.in_flight.under_way()) + len(leases)
        threads = self._settings.threads_of_a_run(workers=self.slots, runs=max(1, runs))
        for lease in leases:
            self.in_flight.add(lease)
        for lease in leases:
            self._begin(lease, threads)

    def _why_nothing_begins(self) -> str | None:
        if self.in_flight.away is not None:
            return self.in_flight.away
        if time.monotonic() - self._submission_failed < self._timings.engine_retry:
            return REFUSED
        if self.renewer.reason is not None:
            return self.renewer.reason
        bucket = self._artifacts.bucket
        away = None if bucket is None else bucket.blocked_reason()
        return NO_WORKER if self.slots == 0 else self._space.blocked_reason() or away

    def _why_no_run_begins(self) -> str | None:
        """The reason why only publications start: one, which waits for no run, found too many results lost."""
        blocking = self._registrar.blocking
        last = self._store.retention.last_attempts(blocking) if blocking else {}
        return next((blocking[id] for id in last if last[id].state in (State.QUEUED, State.RUNNING)), None)

    def _store_blocked_reason(self) -> None:
        """Tell every service that shares the store why nothing begins, when that changes."""
        if self.blocked_reason != self._stored_reason:
            self._store.queue.set_blocked_reason(self.blocked_reason, self.term)
            self._stored_reason = self.blocked_reason

    def _begin(self, lease: Lease, threads: int) -> None:
        """Give an attempt to the engine, or further runs to the sweep of a publication that searches for a limit."""
        attempt = None
        try:
            if lease.kind is Kind.PUBLISH and searching.goes_on(self._store, lease):
                self.in_flight.forget(lease.key)
                return
            attempt = self._attempt(lease, threads)
            self._engine.submit(attempt)
        except Exception as error:  # whatever it is, the attempt is not under way
            log.exception("%s could not be given to the engine", lease.key, extra=about(lease))
            self.in_flight.ended[lease.key] = Ending.lost("Lost", f"{type(error).__name__}: {error}")
            if attempt is not None:
                self._submission_failed = time.monotonic()

    def _attempt(self, lease: Lease, threads: int) -> Attempt:
        """The attempt of a lease; the folder above its own exists, so a worker that misses it lacks the disk."""
        directory = self._artifacts.attempt_directory(lease)
        self._artifacts.make_folder(directory.parent)
        is_run = lease.kind is Kind.RUN
        return Attempt(
            key=lease.key,
            kind=lease.kind,
            directory=str(directory),
            spec=lease.spec or self._publication(lease),
            seconds_limit=self._settings.run_seconds_limit,
            targets=self._settings.targets_module,
            run=lease.id if is_run else None,
            keep=lease.keep,
            checkpoint=str(self._artifacts.checkpoint(lease.id)) if is_run else None,
            memory_limit=self._settings.memory_of_a_run,
            threads=threads,
            stall_seconds=self._settings.stall_seconds,
        )

    def _publication(self, lease: Lease) -> Publication:
        """The sweep document and the outcomes of its runs, from which cube and report are made."""
        assert lease.sweep_id is not None
        document, outcomes = self._store.publications.inputs(lease.sweep_id, self._artifacts.root)
        publication: Publication = {"document": document, "outcomes": outcomes}
        renewals = self._store.renewals
        if renewals.physics_of(lease.sweep_id) != PHYSICS_VERSION:  # this version gives its runs other ids
            publication["places"] = renewals.coordinates(lease.sweep_id)
        return publication
