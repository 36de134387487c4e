"""A dispatcher whose ticks a test takes by hand, between a real store and an engine that only records."""

from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from service.files.artifacts import OF_A_RUN, Artifacts, describe
from service.queue.clock_watch import ClockWatch
from service.queue.dispatcher import Dispatcher
from service.queue.renewal import Expand
from service.records.expansion import expand_again
from service.records.jobs import Cause, Keep, Kind, RunRow, State, Submission
from service.scrubbing.scrubber import Scrubber
from service.settings import Settings
from service.store import Store
from service.workers.attempt import Attempt, Ended, Ending, Inbox, Message
from service.workers.timings import Timings
from studies.quantities.files import SWEEP_FILES
from tests.service.support.attempts import computed, published
from tests.service.support.fakes import (
    DEADLINE,
    LosableTerms,
    RecordingEngine,
    open_store,
    run_id,
    settings_in,
    sweep_of,
)
from tests.service.support.targets import FakeRun, execute, publish

# A tick waits for every verification and looks at all orphans, however busy the machine is; nothing is put off.
AT_ONCE = Timings(
    leadership_retry=0.0,
    collection_step=DEADLINE,
    verification_wait=DEADLINE,
    last_verification_wait=DEADLINE,
    verification_retry=0.0,
    registration_retry=0.0,
    scrub_step=DEADLINE,
    scrub_note=0.0,
)


@dataclass
class Harness:
    """A dispatcher, its store and its engine."""

    settings: Settings
    store: Store
    timings: Timings = AT_ONCE
    engine: RecordingEngine = field(default_factory=RecordingEngine)
    inbox: Inbox | None = None  # of the dispatcher that was the last to open its engine

    def __post_init__(self) -> None:
        self.artifacts = Artifacts(self.settings.data)
        self.store.terms = self.terms = LosableTerms(self.store.database)
        self.dispatcher = self.successor(self.engine)

    def successor(
        self, engine: RecordingEngine, *, first: Message | None = None, expand: Expand = expand_again
    ) -> Dispatcher:
        """Another dispatcher on the same store; its engine sends ``first``."""

        def open_engine(inbox: Inbox) -> RecordingEngine:
            self.inbox = inbox
            inbox.put(first)
            return engine

        return Dispatcher(self.settings, self.store, open_engine=open_engine, timings=self.timings, expand=expand)

    def submit(self, *sweep: Any, **options: Any) -> str:
        """Submit the sweep of these runs, or of so many; its id."""
        return self.store.sweeps.create(Submission(sweep_of(*sweep), **options)).id

    def tick(self) -> list[Attempt]:
        """One tick; the attempts that the engine was given in it."""
        before = len(self.engine.submitted)
        self.dispatcher.tick()
        return self.engine.submitted[before:]

    def begin(self, *sweep: Any, **options: Any) -> list[Attempt]:
        """Submit a sweep and take a tick; the attempts that begin."""
        self.submit(*sweep, **options)
        return self.tick()

    def compute(self, attempt: Attempt) -> Ending:
        """Compute an attempt here, as a worker does."""
        directory = Path(attempt.directory)
        directory.mkdir(parents=True)
        (directory / "log.txt").write_text("computed\n")
        if attempt.kind is Kind.RUN:
            execute(FakeRun.from_json(computed(attempt)), directory, film=attempt.keep is Keep.FILM)
        else:
            answers = {outcome["run_id"]: outcome for outcome in published(attempt)["outcomes"]}
            publish(published(attempt)["document"], answers, directory)
        names = OF_A_RUN if attempt.kind is Kind.RUN else (*SWEEP_FILES, "log.txt")
        files = [directory / name for name in names]
        return Ending(None, "", "", tuple(describe(file) for file in files if file.is_file()), 1.5)

    def send(self, message: Message) -> None:
        assert self.inbox is not None
        self.inbox.put(message)

    def end(self, attempt: Attempt, ending: Ending) -> None:
        self.send(Ended(attempt.key, ending))

    def end_well(self, attempt: Attempt) -> None:
        """End an attempt with a result."""
        self.end(attempt, self.compute(attempt))

    def end_badly(self, attempt: Attempt, cause: Cause, **more: Any) -> None:
        """End an attempt without a result."""
        ending = Ending(cause, cause.value, f"because of {cause}", (), 1.0)
        self.end(attempt, replace(ending, **more))

    def publish(self) -> Attempt:
        """Take a tick, in which a publication begins, and end it well."""
        [publication] = self.tick()
        assert publication.kind is Kind.PUBLISH
        self.end_well(publication)
        self.tick()
        return publication

    def compute_all(self) -> None:
        """Take ticks, and end well what begins, until nothing does."""
        while attempts := self.tick():
            for attempt in attempts:
                self.end_well(attempt)

    def run(self, number: int = 0) -> RunRow:
        return self.store.runs.get(run_id(number))

    def is_first_success(self) -> bool:
        """Whether the first run has the result of its first attempt."""
        row = self.run()
        return (row.state, row.attempt, row.crashes) == (State.SUCCEEDED, 1, 0)

    def scrubber(self, *, rate: int = 1 << 60, interval: float = 0.0) -> Scrubber:
        """A scrubber at its start, which reads everything in a step and begins again at the next one."""
        settings = self.settings.model_copy(update={"scrub_rate": rate})
        clock = ClockWatch(settings, self.store)
        return Scrubber(settings, self.store, self.artifacts, clock, replace(AT_ONCE, scrub_interval=interval))


@contextmanager
def open_harness(folder: Path, timings: Timings = AT_ONCE, **settings: Any) -> Iterator[Harness]:
    """A harness in a folder; rows and engine are compared at every tick."""
    chosen = settings_in(folder, **{"reconcile_seconds": 1e-9, "disk_reserve": 0, **settings})
    with closing(open_store(chosen)) as store:
        yield Harness(chosen, store, timings)
