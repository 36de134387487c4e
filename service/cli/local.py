"""The whole engine on this machine: store, dispatcher and workers, without HTTP.

``whipple serve`` and ``whipple sweep`` both use it, so there is one path from a sweep to its cube.
"""

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from service.files.artifacts import LOG, PART, Artifacts
from service.files.data_directory import DataInUse, check_names, holding
from service.files.output_folders import check_same, held_in
from service.queue import data_identity as identity
from service.records.fault_points import fault_point
from service.records.jobs import (
    SWEEP_TERMINAL,
    Stored,
    StoreUnavailable,
    Submission,
    SweepState,
    SweepStatus,
)
from service.records.settings import Settings
from service.records.signals import Leaving, heeding
from service.records.timings import DEFAULT, Timings
from service.store import Store, digest_of
from solver.errors import WhippleError
from studies.sweeps.document import read_sweep_file
from studies.sweeps.sweep import Sweep, SweepLimits

if TYPE_CHECKING:
    from service.queue.dispatcher import Dispatcher

__all__ = ["DataInUse", "Finished", "PublicationFailed", "run_sweep", "start_engine"]

STORE_OF_FOLDER = ".whipple"  # inside the output folder of a sweep without a service
MOST_SWEEPS = 1000  # unfinished ones in such a folder; there is one or none
WATCH_SECONDS = 0.1  # how often a waiting person is told
WATCH_SHARE = 20.0  # and never more than one part in so many of the time is spent on counting


class PublicationFailed(WhippleError):
    """The runs are done, but cube and report could not be made."""


@dataclass(frozen=True)
class Finished:
    """A sweep that was computed on this machine; as a path it is its folder."""

    folder: Path
    sweep: SweepStatus

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
    progress: Callable[[SweepStatus], None] | None = None,
    settings: Settings | None = None,
    overwrite: bool = False,
) -> Finished:
    """Compute a sweep on this machine into the folder ``out``; called again, it resumes.

    ``document`` is a mapping or the path of a YAML or JSON file. ``progress`` is called with the
    sweep's row, again and again. A folder that holds another sweep (``folders``) is refused, unless
    that is to be replaced (``overwrite``). Raises InvalidInput, DataInUse, PublicationFailed. Ctrl-C and
    SIGTERM end it in order, as KeyboardInterrupt and SystemExit; what ran goes on from its
    checkpoint next time.
    """
    folder = Path(out)
    settings = settings or Settings(data=folder / STORE_OF_FOLDER)
    sweep = Sweep.parse(_read(document), SweepLimits(max_runs=settings.max_runs))
    check_names(settings)
    held = held_in(folder)
    if held is not None and not overwrite:
        check_same(folder, held, sweep.document())
    with heeding() as leaving:
        with holding(settings), closing(Store.open(settings.url)) as store:
            identity.settle(settings, store)
            if held is None and not overwrite:
                _check_begun(store, folder, sweep)
            row = _compute(store, settings, sweep, progress or _nobody, leaving)
            if row.state is SweepState.FAILED:
                raise PublicationFailed(row.reason or "cube and report could not be made")
            _copy_out(store.artifacts(row.id), Artifacts(settings.data), folder)
        leaving.obey()
    return Finished(folder, row)


@contextmanager
def start_engine(
    settings: Settings, store: Store, timings: Timings = DEFAULT
) -> "Iterator[Dispatcher]":
    """Dispatcher and engine, at work on the store's queue until the end of the block; raises InvalidInput.

    With SQLite the data directory must be ours (``directory.holding``).
    """
    from service.execution import engine_of
    from service.queue.dispatcher import Dispatcher

    dispatcher = Dispatcher(settings, store, open_engine=engine_of(settings), timings=timings)
    dispatcher.start()
    try:
        yield dispatcher
    finally:
        dispatcher.close()


def _compute(
    store: Store,
    settings: Settings,
    sweep: Sweep,
    progress: Callable[[SweepStatus], None],
    leaving: Leaving,
) -> SweepStatus:
    """The row of a sweep that has ended."""
    accepted = _accept(store, sweep)
    leaving.obey()
    with start_engine(settings, store) as dispatcher:
        return _watch(store, dispatcher, accepted.id, progress, leaving)


def _check_begun(store: Store, folder: Path, sweep: Sweep) -> None:
    """The sweep that was begun last in a folder without a report is this one; raises InvalidInput."""
    for last in store.sweeps(limit=1).items:
        check_same(folder, store.sweep_document(last.id), sweep.document())


def _copy_out(files: Iterable[Stored], artifacts: Artifacts, folder: Path) -> None:
    """Cube and report in the person's own folder, in place of what an earlier sweep left."""
    for file in files:
        if file.name != LOG:
            for part in folder.glob(f".{file.name}.{PART}"):  # of a copy that was killed
                part.unlink(missing_ok=True)
            artifacts.copy_out(file, folder)
            fault_point("copy-halfway")


def _read(document: Mapping[str, Any] | str | Path) -> Mapping[str, Any]:
    return document if isinstance(document, Mapping) else read_sweep_file(Path(document))


def _accept(store: Store, sweep: Sweep) -> SweepStatus:
    """The sweep in this folder's store: a new one, unless it is there and not done.

    The folder answers one question at a time: other sweeps that are not done are given up.
    """
    known = store.find_sweep(digest_of(sweep))
    if known is None or known.is_terminal:
        known = store.create_sweep(Submission(sweep))
    for other in _unfinished(store):
        if other.id != known.id:
            store.cancel_sweep(other.id)
    return known


def _unfinished(store: Store) -> list[SweepStatus]:
    found: list[SweepStatus] = []
    for state in set(SweepState) - SWEEP_TERMINAL:
        found.extend(store.sweeps(state=state, limit=MOST_SWEEPS).items)
    return found


def _watch(
    store: Store,
    dispatcher: "Dispatcher",
    id: str,
    progress: Callable[[SweepStatus], None],
    leaving: Leaving,
) -> SweepStatus:
    """Tell how far the sweep is until it has ended, or until somebody asks us to leave."""
    while True:
        begin = time.monotonic()
        with suppress(StoreUnavailable):  # it may pass; the dispatcher is as patient
            row = store.sweep(id)
            progress(row)
            if row.is_terminal:
                return row
        if not dispatcher.is_alive():
            raise PublicationFailed("the dispatcher has stopped; see the log")
        spent = time.monotonic() - begin
        leaving.obey(wait=max(WATCH_SECONDS, WATCH_SHARE * spent))


def _nobody(_row: SweepStatus) -> None:
    """Nobody wants to know."""
