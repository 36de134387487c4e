"""The engine of this machine: real workers, real processes, runs that behave as a test says."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from service.cli.local import Finished, PublicationFailed, run_sweep, start_engine
from service.files.artifacts import Artifacts
from service.files.data_directory import holding
from service.queue.dispatcher import Dispatcher
from service.records.jobs import Cause, RunRow, State, Submission, SweepState, SweepStatus
from service.records.settings import Settings
from service.store import Store
from studies.values.errors import InvalidInput
from tests.service.support.cluster import patiently
from tests.service.support.fakes import is_gone, open_store, run_id, runs_of, settings_in, sweep_of, wait_until
from tests.service.support.targets import FakeRun

ROOT = Path(__file__).parents[3]
PUBLISHED = ("cube.nc", "runs.csv", "report.html", "report.json")


@dataclass
class Local:
    """A running service without HTTP."""

    settings: Settings
    store: Store
    dispatcher: Dispatcher

    def ask(self, runs: Sequence[FakeRun]) -> SweepStatus:
        return self.store.create_sweep(Submission(sweep_of(runs)))

    def end_of(self, row: SweepStatus) -> SweepStatus:
        return patiently(lambda: (now := self.store.sweep(row.id)).is_terminal and now)

    def runs(self, row: SweepStatus) -> list[RunRow]:
        return [point.run for point in self.store.sweep_runs(row.id).items]

    def pid(self, run: FakeRun, attempt: int = 1) -> int:
        """The process of an attempt, as soon as there is one."""
        folder = self.settings.data / "runs" / run.id[:2] / run.id
        files = wait_until(lambda: [*folder.glob(f"a{attempt}-*/pid")])
        return int(wait_until(files[0].read_text))


@pytest.fixture(scope="module")
def local(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Local]:
    settings = settings_in(tmp_path_factory.mktemp("data"), workers=2)
    with holding(settings), closing(open_store(settings)) as store, start_engine(settings, store) as dispatcher:
        yield Local(settings, store, dispatcher)


# --- one engine, many sweeps ---------------------------------------------------------------------


def test_whole_path__files_are_there_and_whole(local: Local) -> None:
    row = local.end_of(local.ask(runs_of("fine", "verdict", "raise", first=100)))
    assert row.state is SweepState.SUCCEEDED
    assert (row.counts["succeeded"], row.counts["failed"]) == (1, 2)
    artifacts, files = Artifacts(local.settings.data), local.store.artifacts(row.id)
    assert {file.name for file in files} == {"cube.nc", "runs.csv", "report.html", "report.json", "log.txt"}
    assert all(artifacts.is_intact(file) for file in files)
    causes = [run.cause for run in local.runs(row)]
    assert causes == [None, Cause.VERDICT, Cause.ERROR]


def test_crash__touches_that_run_alone_and_is_tried_again(local: Local) -> None:
    [flaky] = runs_of("abort", first=200, crashes=2)
    [broken] = runs_of("abort", first=201)
    fine = runs_of(*["fine"] * 4, first=202)
    row = local.end_of(local.ask([flaky, broken, *fine]))
    flaky_row, broken_row, *fine_rows = local.runs(row)
    assert (flaky_row.state, flaky_row.attempt, flaky_row.crashes) == (State.SUCCEEDED, 3, 2)
    assert (broken_row.state, broken_row.failure) == (State.FAILED, "SIGABRT")
    assert broken_row.crashes == 3
    assert {(run.state, run.attempt) for run in fine_rows} == {(State.SUCCEEDED, 1)}


def test_cancel__ends_processes_and_queue(local: Local) -> None:
    runs = [*runs_of("hang", "deaf", first=300), *runs_of("fine", first=302)]
    row = local.ask(runs)
    pids = [local.pid(run) for run in runs[:2]]
    local.store.cancel_sweep(row.id)
    assert local.end_of(row).state is SweepState.CANCELLED
    wait_until(lambda: all(is_gone(pid) for pid in pids))
    wait_until(lambda: {run.state for run in local.runs(row)} == {State.CANCELLED})
    assert local.runs(row)[2].attempt == 0


def test_progress__is_stored_while_a_run_is_under_way(local: Local) -> None:
    [run] = runs_of("fine", first=400, seconds=20.0)
    row = local.ask([run])
    wait_until(lambda: local.store.run(run.id).fraction)
    under_way = local.store.run(run.id)
    assert under_way.progress is not None
    assert "hole_diameter" in under_way.progress["measured"]
    assert local.store.sweep(row.id).eta_seconds is not None
    local.store.cancel_sweep(row.id)
    local.end_of(row)
    wait_until(lambda: local.store.run(run.id).state is State.CANCELLED)


# --- a sweep without a service -------------------------------------------------------------------


def document(**more: Any) -> dict[str, Any]:
    """A real sweep of two runs."""
    return {
        "name": "holes",
        "scenario": "thin_plate",
        "fixed": {
            "projectile": "copper-ofhc",
            "target": "copper-ofhc",
            "projectile_diameter": "8 mm",
            "plate_thickness": "2 mm",
        },
        "axes": {"speed": ["2 km/s", "3 km/s"]},
        "resolution": 8,
        **more,
    }


def settings_of(out: Path) -> Settings:
    return settings_in(out / ".whipple", workers=2)


@dataclass
class Answered:
    """A sweep that was computed once, and what was told meanwhile."""

    finished: Finished
    progress: list[SweepStatus]


@pytest.fixture(scope="module")
def answered(tmp_path_factory: pytest.TempPathFactory) -> Answered:
    out, progress = tmp_path_factory.mktemp("sweep") / "out", list[SweepStatus]()
    finished = run_sweep(document(), out, progress=progress.append, settings=settings_of(out), keep="film")
    return Answered(finished, progress)


def test_run_sweep__leaves_the_published_files_with_the_registered_digests(answered: Answered) -> None:
    out = Path(answered.finished)
    assert {file.name for file in out.iterdir()} == {".whipple", "runs", *PUBLISHED}
    with closing(open_store(settings_of(out))) as store:
        files = store.artifacts(answered.finished.sweep.id)
    copies = [replace(file, path=file.name) for file in files if file.name in PUBLISHED]
    assert len(copies) == len(PUBLISHED)
    assert all(Artifacts(out).is_intact(copy) for copy in copies)


def test_run_sweep__keeps_the_films_of_its_runs(answered: Answered) -> None:
    assert len(list((Path(answered.finished) / "runs").glob("*/film.npz"))) == 2


def test_run_sweep__refuses_an_unknown_retention(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="keep"):
        run_sweep(document(), tmp_path, keep="everything")


def test_run_sweep__tells_how_far_it_is_until_the_end(answered: Answered) -> None:
    assert answered.progress[-1] == answered.finished.sweep
    assert answered.finished.counts["succeeded"] == 2
    assert [row.progress for row in answered.progress] == sorted(row.progress for row in answered.progress)


def test_run_sweep__again_from_a_file_computes_nothing_new(answered: Answered) -> None:
    out = Path(answered.finished)
    file = out.parent / "holes.json"
    file.write_text(json.dumps(document()))
    (out / "cube.nc").unlink()
    again = run_sweep(str(file), out, settings=settings_of(out))
    assert (again.counts["succeeded"], again.sweep.reused, again.sweep.new) == (2, 2, 0)
    assert (out / "cube.nc").is_file()


def test_run_sweep__says_when_nothing_can_be_published(tmp_path: Path) -> None:
    with pytest.raises(PublicationFailed, match="this sweep cannot be published"):
        run_sweep(document(name="unpublishable"), tmp_path, settings=settings_of(tmp_path))


def test_run_sweep__refuses_a_bad_document_before_it_makes_anything(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with pytest.raises(InvalidInput, match="thin_plat"):
        run_sweep(document(scenario="thin_plat"), out, settings=settings_of(out))
    assert not out.exists()


def test_run_sweep__gives_up_what_the_folder_was_asked_before(tmp_path: Path) -> None:
    settings = settings_of(tmp_path)
    settings.data.mkdir()
    with closing(open_store(settings)) as store:
        old = store.create_sweep(Submission(sweep_of(runs_of("hang", "hang", "hang"))))
    run_sweep(document(), tmp_path, settings=settings, overwrite=True)
    with closing(open_store(settings)) as store:
        assert store.sweep(old.id).state is SweepState.CANCELLED
        assert store.run(run_id(0)).state is State.CANCELLED


def test_run_sweep__from_a_script_without_a_guard_runs_it_once(tmp_path: Path) -> None:
    out, script = tmp_path / "out", tmp_path / "script.py"
    call = f"run_sweep({document()!r}, {str(out)!r})"
    script.write_text(f"from service.cli.local import run_sweep\nprint({call}.counts['succeeded'])\n")
    environment = {"WHIPPLE_TARGETS_MODULE": "tests.service.support.targets", "PYTHONPATH": str(ROOT)}
    answer = subprocess.run(
        [sys.executable, script], env={**os.environ, **environment}, check=True, capture_output=True, text=True
    )
    assert answer.stdout == "2\n"
