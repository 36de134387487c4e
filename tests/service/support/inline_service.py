"""A service without API and engine, for a fork that dies: a real store and dispatcher, and runs computed at once."""

import os
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path

from service.files.artifacts import OF_A_RUN, describe
from service.files.data_directory import holding
from service.queue.dispatcher import Dispatcher
from service.records.jobs import Kind, Submission
from service.settings import Settings
from service.store import Store
from service.workers.attempt import Attempt, Ended, Ending, Inbox
from service.workers.warm_process import perform
from studies.quantities.files import SWEEP_FILES
from tests.service.support import fault_points
from tests.service.support.fakes import RecordingEngine, open_store, settings_in, sweep_of
from tests.service.support.targets import Run

KEY = ("the-only-one", "11" * 32)


class Inline(RecordingEngine):
    """An engine that computes at once."""

    def __init__(self, inbox: Inbox):
        super().__init__(free=1)
        self._inbox = inbox

    def submit(self, attempt: Attempt) -> None:
        folder = Path(attempt.directory)
        folder.mkdir(parents=True)
        perform(attempt, lambda _message: None, lambda: False)
        names = OF_A_RUN if attempt.kind is Kind.RUN else SWEEP_FILES
        files = tuple(describe(folder / name) for name in names if (folder / name).is_file())
        self._inbox.put(Ended(attempt.key, Ending(None, "", "", files, 0.1)))


def live(data: Path, runs_asked: int, environment: Mapping[str, str]) -> None:
    """Submit a sweep, with the same key each time, and work until it is done, or until this process dies."""
    os.environ |= {**environment, "NUMBA_NUM_THREADS": "1"}
    fault_points.arm()
    settings = settings_in(data, disk_reserve=0)
    runs = [Run(f"{number:032x}", {"seconds": 0.01}) for number in range(runs_asked)]
    with closing(open_store(settings)) as store:
        accepted = store.sweeps.create(Submission(sweep_of(runs), idempotency=KEY))
        compute_here(settings, store, accepted.id)


def compute_here(settings: Settings, store: Store, *sweeps: str) -> None:
    """Work in this process until sweeps have ended."""
    with holding(settings):
        dispatcher = Dispatcher(settings, store, open_engine=Inline)
        while not all(store.sweeps.get(id).is_terminal for id in sweeps):
            dispatcher.tick()
