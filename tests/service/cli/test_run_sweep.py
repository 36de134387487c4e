"""A sweep without a service: its files, its progress, and what a folder held before."""

import json
import os
import subprocess
import sys
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from service.cli.local import Finished, PublicationFailed, run_sweep
from service.files.artifacts import Artifacts
from service.records.jobs import State, Submission, SweepState, SweepStatus
from service.settings import Settings
from studies.quantities.files import SWEEP_FILES
from studies.quantities.findings import InvalidInput
from tests.service.support.api import SWEEP
from tests.service.support.fakes import open_store, run_id, runs_of, settings_in, sweep_of

ROOT = Path(__file__).parents[3]


def settings_of(out: Path) -> Settings:
    return settings_in(out / ".whipple", workers=1)  # each takes half a second of computing to start


@dataclass
class Answered:
    """A sweep that was computed once, and what was told meanwhile."""

    finished: Finished
    progress: list[SweepStatus]


@pytest.fixture(scope="module")
def answered(tmp_path_factory: pytest.TempPathFactory) -> Answered:
    out, progress = tmp_path_factory.mktemp("sweep") / "out", list[SweepStatus]()
    finished = run_sweep(SWEEP, out, progress=progress.append, settings=settings_of(out), keep="film")
    return Answered(finished, progress)


def test_run_sweep__leaves_the_published_files_with_the_registered_digests(answered: Answered) -> None:
    out = Path(answered.finished)
    assert {file.name for file in out.iterdir()} == {".whipple", "runs", *SWEEP_FILES}
    with closing(open_store(settings_of(out))) as store:
        files = store.publications.files(answered.finished.sweep.id)
    copies = [replace(file, path=file.name) for file in files if file.name in SWEEP_FILES]
    assert len(copies) == len(SWEEP_FILES)
    assert all(Artifacts(out).is_intact(copy) for copy in copies)
    assert len(list((out / "runs").glob("*/film.npz"))) == 2


def test_run_sweep__again_from_a_file_computes_nothing_new(answered: Answered) -> None:
    out = Path(answered.finished)
    file = out.parent / "holes.json"
    file.write_text(json.dumps(SWEEP))
    (out / "cube.nc").unlink()
    rule = {"retention_days": 1e-9}  # of a service, in the environment
    again = run_sweep(str(file), out, settings=settings_of(out).model_copy(update=rule))
    assert (again.counts["succeeded"], again.sweep.reused, again.sweep.new) == (2, 2, 0)
    assert (out / "cube.nc").is_file()
    with closing(open_store(settings_of(out))) as store:
        assert answered.finished.sweep.id in [sweep.id for sweep in store.sweeps.page().items]


def test_run_sweep__says_when_nothing_can_be_published(tmp_path: Path) -> None:
    with pytest.raises(PublicationFailed, match="this sweep cannot be published"):
        run_sweep({**SWEEP, "name": "unpublishable"}, tmp_path, settings=settings_of(tmp_path))


def test_run_sweep__refuses_a_bad_document_before_it_makes_anything(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with pytest.raises(InvalidInput, match="thin_plat"):
        run_sweep({**SWEEP, "scenario": "thin_plat"}, out, settings=settings_of(out))
    assert not out.exists()


def test_run_sweep__gives_up_what_the_folder_was_asked_before(tmp_path: Path) -> None:
    settings = settings_of(tmp_path)
    settings.data.mkdir()
    with closing(open_store(settings)) as store:
        old = store.sweeps.create(Submission(sweep_of(runs_of("hang", "hang", "hang"))))
    run_sweep(SWEEP, tmp_path, settings=settings, overwrite=True)
    with closing(open_store(settings)) as store:
        assert store.sweeps.get(old.id).state is SweepState.CANCELLED
        assert store.runs.get(run_id(0)).state is State.CANCELLED


def test_run_sweep__from_a_script_without_a_guard_runs_it_once(tmp_path: Path) -> None:
    out, script = tmp_path / "out", tmp_path / "script.py"
    call = f"run_sweep({SWEEP!r}, {str(out)!r})"
    script.write_text(f"from service.cli.local import run_sweep\nprint({call}.counts['succeeded'])\n")
    environment = {"WHIPPLE_TARGETS_MODULE": "tests.service.support.targets", "PYTHONPATH": str(ROOT)}
    answer = subprocess.run(
        [sys.executable, script], env={**os.environ, **environment}, check=True, capture_output=True, text=True
    )
    assert answer.stdout == "2\n"
