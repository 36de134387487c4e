"""A dispatcher whose turns a test takes by hand, between a real store and an engine that stands still."""

from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from service.files.artifacts import OF_A_RUN, describe
from service.queue.dispatcher import Dispatcher
from service.records.attempt import Attempt, Ended, Ending, Inbox, Message
from service.records.jobs import Cause, Kind, RunRow
from service.records.settings import Settings
from service.store import Store
from tests.service.support.fakes import RecordingEngine, open_store, run_id, settings_in
from tests.service.support.targets import Run, execute, publish

PUBLISHED = ("cube.nc", "report.html", "report.json")


@dataclass
class Harness:
    """A dispatcher, its store and its engine."""

    settings: Settings
    store: Store
    engine: RecordingEngine = field(default_factory=RecordingEngine)
    inbox: Inbox | None = None  # of the dispatcher that was the last to start its engine

    def __post_init__(self) -> None:
        self.dispatcher = self.successor(self.engine)

    def successor(self, engine: RecordingEngine, *, first: Message | None = None) -> Dispatcher:
        """Another dispatcher on the same store; what its engine says ``first``."""

        def open_engine(inbox: Inbox) -> RecordingEngine:
            self.inbox = inbox
            inbox.put(first)
            return engine

        return Dispatcher(self.settings, self.store, open_engine=open_engine)

    def turn(self) -> list[Attempt]:
        """One turn; what the engine was given in it."""
        before = len(self.engine.submitted)
        self.dispatcher.turn()
        return self.engine.submitted[before:]

    def compute(self, ticket: Attempt) -> Ending:
        """What a worker does with a ticket, here."""
        directory = Path(ticket.directory)
        directory.mkdir(parents=True)
        (directory / "log.txt").write_text("computed\n")
        if ticket.kind is Kind.RUN:
            execute(Run.from_json(ticket.spec), directory)
        else:
            answers = {one["run_id"]: one for one in ticket.spec["outcomes"]}
            publish(ticket.spec["document"], answers, directory)
        names = OF_A_RUN if ticket.kind is Kind.RUN else (*PUBLISHED, "log.txt")
        found = [directory / name for name in names]
        files = tuple(describe(file) for file in found if file.is_file())
        return Ending(None, "", "", files, 1.5)

    def say(self, message: Message) -> None:
        """The engine says something."""
        assert self.inbox is not None
        self.inbox.put(message)

    def end(self, ticket: Attempt, ending: Ending) -> None:
        """The engine says how an attempt ended."""
        self.say(Ended(ticket.key, ending))

    def end_well(self, ticket: Attempt) -> None:
        """An attempt ended with a result."""
        self.end(ticket, self.compute(ticket))

    def end_badly(self, ticket: Attempt, cause: Cause, **more: Any) -> None:
        """An attempt ended without a result."""
        ending = Ending(cause, cause.value, f"because of {cause}", (), 1.0)
        self.end(ticket, replace(ending, **more))

    def run(self, number: int = 0) -> RunRow:
        """The row of a run."""
        return self.store.run(run_id(number))


@contextmanager
def open_harness(folder: Path, **settings: Any) -> Iterator[Harness]:
    """A harness in a folder; rows and engine are compared at every turn."""
    chosen = settings_in(folder, **{"reconcile_seconds": 1e-9, "disk_reserve": 0, **settings})
    with closing(open_store(chosen)) as store:
        yield Harness(chosen, store)
