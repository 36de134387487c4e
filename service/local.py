"""The whole engine on this machine: store, dispatcher and workers, without HTTP.

``whipple serve`` and ``whipple sweep`` both use it, so there is one path from a sweep to its cube.
"""

import fcntl
import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any

from service.artifacts import Artifacts
from service.jobs import SWEEP_TERMINAL, SweepRow, SweepState
from service.settings import Settings
from service.store import Store, digest_of
from solver.errors import WhippleError
from studies.sweep import Sweep, SweepLimits
from studies.sweep_document import read_sweep_file

if TYPE_CHECKING:
    from service.dispatcher import Dispatcher

LOCK = "whipple.lock"
SCRATCH = "scratch"  # of the workers
STORE_OF_FOLDER = ".whipple"  # inside the output folder of a sweep without a service
MOST_SWEEPS = 1000  # unfinished ones in such a folder; there is one or none
WATCH_SECONDS = 0.25  # how often a waiting person is told
WATCH_SHARE = 20.0  # and never more than one part in so many of the time is spent on counting


class DataInUse(WhippleError):
    """Another service, or sweep, works in this data directory."""


class PublicationFailed(WhippleError):
    """The runs are done, but cube and report could not be made."""


@dataclass(frozen=True)
class Finished:
    """A sweep that was computed on this machine; as a path it is its folder."""

    folder: Path
    sweep: SweepRow

    @property
    def counts(self) -> Mapping[str, int]:
        """Points per state."""
        return self.sweep.counts

    def __fspath__(self) -> str:
        return str(self.folder)


def run_sweep(
    document: Mapping[str, Any] | str | Path,
    out: str | Path,
    *,
    progress: Callable[[SweepRow], None] | None = None,
    settings: Settings | None = None,
) -> Finished:
    """Compute a sweep on this machine into the folder ``out``; called again, it resumes.

    ``document`` is a mapping or the path of a YAML or JSON file. ``progress`` is called with the
    sweep's row, again and again. Raises InvalidInput, DataInUse, PublicationFailed.
    """
    folder = Path(out)
    settings = settings or Settings(data=folder / STORE_OF_FOLDER)
    sweep = Sweep.parse(_read(document), SweepLimits(max_runs=settings.max_runs))
    settings.data.mkdir(parents=True, exist_ok=True)
    with closing(Store.open(settings.url)) as store, start_engine(settings, store) as engine:
        accepted = _accept(store, sweep)
        row = _watch(store, engine, accepted.id, progress or _nobody)
        if row.state is SweepState.FAILED:
            raise PublicationFailed(row.reason or "cube and report could not be made")
        artifacts = Artifacts(settings.data)
        for file in store.artifacts(row.id):
            artifacts.copy_out(file, folder)
    return Finished(folder, row)


@contextmanager
def start_engine(settings: Settings, store: Store) -> "Iterator[Dispatcher]":
    """Workers and dispatcher, at work on the store's queue until the end of the block.

    Nobody else may use the data directory meanwhile; raises DataInUse.
    """
    from service.dispatcher import Dispatcher
    from service.execution import Engine, Message

    with _locked(settings.data):
        inbox: SimpleQueue[Message | None] = SimpleQueue()
        engine = Engine(workers=settings.workers, scratch=settings.data / SCRATCH, inbox=inbox)
        dispatcher = Dispatcher(settings, store, engine=engine, inbox=inbox)
        dispatcher.start()
        try:
            yield dispatcher
        finally:
            dispatcher.close()


def _read(document: Mapping[str, Any] | str | Path) -> Mapping[str, Any]:
    return document if isinstance(document, Mapping) else read_sweep_file(Path(document))


def _accept(store: Store, sweep: Sweep) -> SweepRow:
    """The sweep in this folder's store: a new one, unless it is there and not done.

    The folder answers one question at a time: other sweeps that are not done are given up.
    """
    known = store.find_sweep(digest_of(sweep))
    if known is None or known.is_terminal:
        known = store.create_sweep(sweep)
    for other in _unfinished(store):
        if other.id != known.id:
            store.cancel_sweep(other.id)
    return known


def _unfinished(store: Store) -> list[SweepRow]:
    found: list[SweepRow] = []
    for state in set(SweepState) - SWEEP_TERMINAL:
        found.extend(store.sweeps(state=state, limit=MOST_SWEEPS).items)
    return found


def _watch(
    store: Store, engine: "Dispatcher", id: str, progress: Callable[[SweepRow], None]
) -> SweepRow:
    """Tell how far the sweep is until it has ended."""
    while True:
        begin = time.monotonic()
        row = store.sweep(id)
        progress(row)
        if row.is_terminal:
            return row
        if not engine.is_alive():
            raise PublicationFailed("the dispatcher has stopped; see the log")
        spent = time.monotonic() - begin
        time.sleep(max(WATCH_SECONDS, WATCH_SHARE * spent))


def _nobody(_row: SweepRow) -> None:
    """Nobody wants to know."""


@contextmanager
def _locked(directory: Path) -> Iterator[None]:
    """Hold a data directory; the kernel gives it back when the process ends, however it ends."""
    with (directory / LOCK).open("a+", encoding="utf-8") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            file.seek(0)
            owner = file.read().strip() or "unknown"
            cure = "stop it, or choose another directory"
            raise DataInUse(f"{directory} is used by process {owner}; {cure}") from None
        file.truncate(0)
        file.write(str(os.getpid()))
        file.flush()
        yield
