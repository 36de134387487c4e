"""Store, dispatcher and workers on this machine, without HTTP.

``whipple serve`` and ``whipple sweep`` share it, so that there is one way from a sweep to its cube.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from service.cli.progress import Show
from service.cli.signals import EndRequest, handling_end_signals
from service.execution import engine_of
from service.files.artifacts import PART, Artifacts
from service.files.data_directory import DataInUse, check_names, holding
from service.files.output_folders import check_same, held_in
from service.queue import data_identity as identity
from service.queue.dispatcher import Dispatcher
from service.records.jobs import SWEEP_TERMINAL, Keep, NotFound, StoreUnavailable, Submission, SweepState, SweepStatus
from service.settings import Settings
from service.store import Store, digest_of
from service.workers.timings import DEFAULT, Timings
from solver.errors import WhippleError
from studies.quantities.files import ALL_RUNS_CSV, FILM, RUNS_CSV, SWEEP_FILES
from studies.quantities.findings import refusal
from studies.quantities.parameters import Plain
from studies.sweeps.document import document_of
from studies.sweeps.reading import SweepLimits
from studies.sweeps.sweep import Sweep

if TYPE_CHECKING:
    from service.records.expansion import ExpandedSweep
    from service.workers.warm import WarmProcess

__all__ = ["DataInUse", "Finished", "PublicationFailed", "run_sweep", "start_engine"]

ShowProgress = Callable[[str], AbstractContextManager[Show]]

STORE_OF_FOLDER = ".whipple"  # inside the output folder of a sweep without a service
KEEPING_ALL = {"retention_days": 0.0, "artifacts": None}  # a rule in the environment is that of a service, a bucket too
MOST_SWEEPS = 1000  # unfinished ones in such a folder; usually there is at most one
PROGRESS_SECONDS = 0.1  # interval between two progress reports
MOST_SILENT = 50  # looks in a row that find no life in the dispatcher, until it counts as dead
PROGRESS_PAUSE = 20.0  # the pause between reports, at least, as a multiple of the time that one takes


class PublicationFailed(WhippleError):
    """The runs are computed, but cube and report could not be made."""


@dataclass(frozen=True)
class Finished:
    """A sweep that was computed on this machine; as a path it is its folder."""

    folder: Path
    sweep: SweepStatus

    @property
    def counts(self) -> Mapping[str, int]:
        return self.sweep.counts

    def __fspath__(self) -> str:
        return str(self.folder)


def run_sweep(
    document: Mapping[str, Any] | str | Path,
    out: str | Path,
    *,
    progress: Callable[[SweepStatus], None] = lambda status: None,
    settings: Settings | None = None,
    overwrite: bool = False,
    keep: str = Keep.FINAL,
    every_column: bool = False,
    ready: "list[WarmProcess] | None" = None,
) -> Finished:
    """Compute a sweep on this machine into the folder ``out``; repeated, it resumes.

    ``document`` is a mapping, whose paths of files begin here, or the path of a YAML or JSON file. ``progress`` is
    called repeatedly with the status of the sweep. A folder that holds another sweep is refused, unless ``overwrite``
    is set. ``keep`` selects the files kept for each run: ``numbers``, also the ``final`` state, or also the ``film``,
    which is copied to ``out/runs/RUN/film.npz``. With ``every_column`` ``runs.csv`` has every column. ``ready`` are
    processes that were started before, for the first runs or the publication. Raises InvalidInput, DataInUse,
    PublicationFailed. Ctrl-C and SIGTERM end it in order, as KeyboardInterrupt and SystemExit; interrupted runs
    continue from their checkpoints next time.
    """
    folder = Path(out)
    settings = (settings or Settings(data=folder / STORE_OF_FOLDER)).model_copy(update=KEEPING_ALL)
    sweep = Sweep.parse(document_of(document), SweepLimits(max_runs=settings.max_runs))
    if keep not in set(Keep):
        raise refusal("keep", keep, f"one of {', '.join(Keep)}", "write one of these")
    retention = Keep(keep)
    held = held_in(folder)
    if held is not None and not overwrite:
        check_same(folder, held, sweep.document())
    with _store_of(settings) as (store, leaving):
        if held is None and not overwrite:
            # The last sweep in a folder without a report must be this one.
            for last in store.sweeps.page(limit=1).items:
                check_same(folder, store.sweeps.document(last.id), sweep.document())
        id = _accept(store, {sweep.name: sweep}, retention)[sweep.name]
        leaving.raise_if_requested()
        with start_engine(settings, store, ready=ready) as dispatcher:
            status = _wait(store, dispatcher, id, progress, leaving)
        artifacts = Artifacts(settings.data)
        _copy_out(store, artifacts, id, folder, every_column=every_column)
        for run in store.runs.measured(id) if retention is Keep.FILM else ():
            with suppress(NotFound):  # one that failed
                film, place = store.runs.file(run.id, FILM), folder / "runs" / run.id
                place.mkdir(parents=True, exist_ok=True)
                artifacts.copy_out(film, place)
    return Finished(folder, status)


def run_sweeps(
    documents: Mapping[str, Mapping[str, Plain]], out: Path, *, showing: ShowProgress, settings: Settings
) -> Iterator[tuple[str, Finished]]:
    """Compute sweeps into folders of their names in ``out``, from one store beside them, and yield each as it ends.

    They share their runs, slots and warm processes. Repeated, it resumes: a computed run is not computed again. Other
    unfinished sweeps of the store are cancelled. ``showing`` shows the progress of the sweep of a name while it is
    awaited. Raises as ``run_sweep`` does.
    """
    settings = settings.model_copy(update=KEEPING_ALL)
    limits = SweepLimits(max_runs=settings.max_runs)
    sweeps = {name: Sweep.parse(document, limits) for name, document in documents.items()}
    with _store_of(settings) as (store, leaving):
        ids = _accept(store, sweeps, Keep.NUMBERS)
        with start_engine(settings, store) as dispatcher:
            for name, id in ids.items():
                with showing(name) as show:
                    status = _wait(store, dispatcher, id, show, leaving)
                folder = out / name
                folder.mkdir(parents=True, exist_ok=True)
                _copy_out(store, Artifacts(settings.data), id, folder)
                yield name, Finished(folder, status)


@contextmanager
def _store_of(settings: Settings) -> Iterator[tuple[Store, EndRequest]]:
    """The store of a folder, which nobody else uses for the duration of a block, and the requests to end."""
    check_names(settings)
    Store.check_origin(settings.url)
    with handling_end_signals() as leaving:
        with holding(settings), closing(Store.open(settings.url)) as store:
            identity.settle(settings, store)
            yield store, leaving
        leaving.raise_if_requested()


@contextmanager
def start_engine(
    settings: Settings, store: Store, timings: Timings = DEFAULT, ready: "list[WarmProcess] | None" = None
) -> Iterator[Dispatcher]:
    """Dispatcher and engine, working through the store's queue for the duration of a block; raises InvalidInput.

    With SQLite the caller holds the data directory (``data_directory.holding``).
    """
    engine = engine_of(settings, ready)
    dispatcher = Dispatcher(settings, store, open_engine=engine, timings=timings, expand=_expanded_in_child)
    dispatcher.start()
    try:
        yield dispatcher
    finally:
        dispatcher.close()


def _expanded_in_child(document: Mapping[str, Plain]) -> "ExpandedSweep":
    """An accepted sweep, expanded by a child process."""
    from service.api.readers import expand_accepted  # the web framework, which few sweeps need

    return expand_accepted(document)


def _accept(store: Store, sweeps: Mapping[str, Sweep], keep: Keep) -> dict[str, str]:
    """Ids of sweeps in a store of a folder: new ones, unless they are there and unfinished; cancels all others."""
    ids = {}
    for name, sweep in sweeps.items():
        known = store.sweeps.find(digest_of(sweep))
        if known is None or known.is_terminal or known.keep is not keep:
            known = store.sweeps.create(Submission(sweep, keep=keep))
        ids[name] = known.id
    for state in set(SweepState) - SWEEP_TERMINAL:
        for other in store.sweeps.page(state=state, limit=MOST_SWEEPS).items:
            if other.id not in ids.values():
                store.sweeps.cancel(other.id)
    return ids


def _wait(
    store: Store, dispatcher: Dispatcher, id: str, progress: Callable[[SweepStatus], None], leaving: EndRequest
) -> SweepStatus:
    """Report progress until the sweep has ended, or until a signal asks to leave; raises PublicationFailed."""
    silent = 0  # such looks: a process that was suspended has a few
    while True:
        begin = time.monotonic()
        # It may pass; the dispatcher waits too.
        with suppress(StoreUnavailable):
            status = store.sweeps.get(id)
            progress(status)
            if status.state is SweepState.FAILED:
                raise PublicationFailed(status.reason or "cube and report could not be made")
            if status.is_terminal:
                return status
        silent = 0 if dispatcher.is_alive() else silent + 1
        if silent > MOST_SILENT:
            raise PublicationFailed("the dispatcher has stopped; see the log")
        seconds = time.monotonic() - begin
        leaving.raise_if_requested(wait=max(PROGRESS_SECONDS, PROGRESS_PAUSE * seconds))


def _copy_out(store: Store, artifacts: Artifacts, id: str, folder: Path, *, every_column: bool = False) -> None:
    """Copy cube and report to the output folder, replacing those of an earlier sweep."""
    sources = {file.name: file for file in store.publications.files(id)}
    for name in SWEEP_FILES:
        # Parts of a copy that was killed.
        for part in folder.glob(f".{name}.{PART}"):
            part.unlink(missing_ok=True)
        source = sources[ALL_RUNS_CSV if every_column and name == RUNS_CSV else name]
        artifacts.copy_out(source, folder, name)
