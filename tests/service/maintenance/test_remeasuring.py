"""``whipple doctor --remeasure``: values follow a changed definition; an interruption loses nothing."""

import json
import shutil
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any
from unittest.mock import MagicMock

import pytest

from service.files.artifacts import Artifacts
from service.files.data_directory import DataInUse, holding
from service.maintenance import remeasuring
from service.maintenance.offline import without_services
from service.maintenance.remeasuring import plan_of, remeasure_runs
from service.records.jobs import State, Submission, SweepState
from service.settings import Settings
from service.store import Store
from studies import measurements
from studies.cubes.opening import whole_cube
from studies.quantities.files import RESULT, STATE
from studies.runs import execution
from studies.sweeps.sweep import Sweep
from tests.service.support.api import SWEEP
from tests.service.support.changed_measurement import MEASUREMENT, TODAY, VALUE, VERSION, raise_the_version
from tests.service.support.command import run
from tests.service.support.inline_service import compute_here

Capsys = pytest.CaptureFixture[str]

TINY = {
    **SWEEP,
    "fixed": {**SWEEP["fixed"], "plate_radius": "16 mm", "end_time": "2 us", "stop": "end_time"},
    "resolution": 4,
}
OTHER = {**TINY, "name": "other", "axes": {"speed": ["3 km/s"]}}  # one of the two runs of the first
SOLVING = "tests.service.support.solving"  # the solver, and reports without figures
RAISED = "tests.service.support.changed_targets"


@dataclass(frozen=True)
class Solved:
    """A data directory with sweeps that were solved, and its store."""

    settings: Settings
    store: Store

    @property
    def artifacts(self) -> Artifacts:
        return Artifacts(self.settings.data)

    def runs(self) -> list[str]:
        """The ids of both runs."""
        [sweep] = [row for row in self.store.sweeps.page().items if row.name == TINY["name"]]
        return [point.run.id for point in self.store.sweeps.points(sweep.id).items]

    def result(self, run_id: str) -> dict[str, Any]:
        """What the registered result of a run says."""
        answer: dict[str, Any] = json.loads(self.artifacts.path(self.store.runs.file(run_id, RESULT)).read_bytes())
        return answer

    def states(self) -> set[SweepState]:
        """Where the sweeps stand."""
        return {row.state for row in self.store.sweeps.page().items}

    def is_intact(self) -> bool:
        """Whether every row points to a whole file."""
        return all(self.artifacts.is_intact(file) for _, file in self.store.retention.files())


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data directory with two sweeps that were solved and published; tests work on copies."""
    settings = Settings(data=tmp_path_factory.mktemp("original"), workers=1, targets_module=SOLVING)
    with closing(Store.open(settings.url)) as store, pytest.MonkeyPatch.context() as patch:
        patch.setattr(execution, "Checkpointing", execution.Checkpointing)  # put back what the targets replace
        sweeps = [store.sweeps.create(Submission(Sweep.parse(document))).id for document in (TINY, OTHER)]
        compute_here(settings, store, *sweeps)
    return settings.data


@pytest.fixture
def solved(original: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Solved]:
    """A copy, and a definition that has changed since, here and in every process to come."""
    monkeypatch.setattr(measurements, "load", measurements.load)  # put back what is raised
    raise_the_version()
    shutil.copytree(original, tmp_path, dirs_exist_ok=True)
    settings = {"data": tmp_path, "workers": 1, "targets_module": RAISED}
    for name, value in settings.items():
        monkeypatch.setenv(f"WHIPPLE_{name.upper()}", str(value))
    with closing(Store.open(Settings().url)) as store:
        yield Solved(Settings(), store)


@pytest.fixture
def _here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Measure in this process, not in a pool of others."""
    monkeypatch.setattr(remeasuring, "ProcessPoolExecutor", MagicMock(return_value=MagicMock(map=map)))


@pytest.mark.usefixtures("_here")
def test_results__follow_the_new_definition_and_their_sweeps_are_marked(
    solved: Solved, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TTY_COMPATIBLE", "1")  # a terminal, for rich
    old = {id: solved.result(id) for id in solved.runs()}
    earlier = [solved.store.runs.file(id, RESULT) for id in old]
    assert run("doctor", "--remeasure") == 0
    output, shown = capsys.readouterr()
    assert "100%" in shown
    assert "changed: 2 results; unreadable: 0" in output
    assert "published again at the next start of the service: 2 sweeps" in output
    assert all(f"{row.id}  {row.name}" in output for row in solved.store.sweeps.page().items)
    assert solved.states() == {SweepState.PUBLISHING}
    for id in solved.runs():
        result, row = solved.result(id), solved.store.runs.get(id)
        assert row.summary is not None
        assert result["measurements"][MEASUREMENT]["version"] == VERSION
        assert row.summary["measurements"][MEASUREMENT]["value"] == VALUE
        assert (row.attempt, row.state) == (1, State.SUCCEEDED)
        assert row.sha256 == solved.store.runs.file(id, RESULT).sha256
        others = {name: item for name, item in result["measurements"].items() if name != MEASUREMENT}
        assert others.items() <= old[id]["measurements"].items()
    assert solved.is_intact()
    assert all(solved.artifacts.is_intact(file) for file in earlier)  # nothing is written in place
    assert not [*solved.settings.data.glob("runs/**/*.part")]


@pytest.mark.claim("cube", "remeasured-cube", minutes=0.2)
def test_cube__follows_at_the_next_start_and_nothing_is_solved(
    original: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    document, out = tmp_path / "tiny.json", tmp_path / "out"
    document.write_text(json.dumps(OTHER))
    monkeypatch.setenv("WHIPPLE_WORKERS", "1")
    monkeypatch.setattr(measurements, "load", measurements.load)  # put back what is raised
    shutil.copytree(original, out / ".whipple")
    with closing(Store.open(Settings(data=original).url)) as store:
        [sweep] = [row.id for row in store.sweeps.page().items if row.name == OTHER["name"]]
    [published] = Artifacts(original).sweep_folder(sweep).rglob("cube.nc")
    before = whole_cube(published)
    assert json.loads(before.attrs["measurement_versions"])[MEASUREMENT] == [TODAY]
    raise_the_version()
    monkeypatch.setenv("WHIPPLE_TARGETS_MODULE", RAISED)
    assert run("doctor", "--remeasure", "--data", out / ".whipple") == 0
    assert run("sweep", document, "--out", out) == 0
    cube = whole_cube(out / "cube.nc")
    assert (cube[MEASUREMENT] == VALUE).all()
    assert json.loads(cube.attrs["measurement_versions"])[MEASUREMENT] == [VERSION]
    messages = json.loads(cube.attrs["software"])["remeasured"][0]
    assert f"{MEASUREMENT} {TODAY} to {VERSION}" in messages
    rest = [name for name in before.data_vars if MEASUREMENT not in str(name)]
    assert all(cube[name].identical(before[name]) for name in rest if before[name].size)


@pytest.mark.usefixtures("_here")
def test_result__that_cannot_be_read_stays_as_it_is_and_is_named(solved: Solved, capsys: Capsys) -> None:
    other = solved.store.sweeps.create(Submission(Sweep.parse({**OTHER, "axes": {"speed": ["8 km/s"]}})))
    damaged, fine = solved.runs()
    before = solved.result(damaged)
    file = solved.artifacts.path(solved.store.runs.file(damaged, STATE))
    file.write_bytes(b"x" * file.stat().st_size)
    assert run("doctor", "--remeasure") == 3
    output = capsys.readouterr().out
    assert "without a stored final state: 0" in output
    assert "changed: 1 results; unreadable: 1" in output
    assert f"{damaged} is unchanged: Damaged: state.npz does not match its checksum" in output
    assert solved.result(damaged) == before
    assert solved.result(fine)["measurements"][MEASUREMENT]["value"] == VALUE
    assert solved.store.sweeps.get(other.id).state is SweepState.QUEUED  # no run was begun


def test_result__whose_state_was_not_kept_is_named(solved: Solved, capsys: Capsys) -> None:
    for id in solved.runs():
        solved.store.retention.forget_files(id, [STATE])
    assert run("doctor", "--remeasure") == 0
    output = capsys.readouterr().out
    assert "to measure again: 0 results of 0 sweeps; without a stored final state: 2" in output
    assert all(f"{id} is unchanged: its final state was not kept" in output for id in solved.runs())


@pytest.mark.usefixtures("_here")
def test_interruption__leaves_what_is_done_and_the_next_time_goes_on(solved: Solved, capsys: Capsys) -> None:
    plan = plan_of(solved.store)
    assert len(plan.measurable) == 2
    [first] = islice(remeasure_runs(solved.settings, solved.store, plan.measurable), 1)
    assert first.marked
    file = solved.store.runs.file(first.run_id, RESULT)
    assert solved.is_intact()
    assert run("doctor", "--remeasure") == 0
    assert capsys.readouterr().out.startswith("to measure again: 1 results")
    assert solved.store.runs.file(first.run_id, RESULT) == file
    assert run("doctor", "--remeasure") == 0
    assert capsys.readouterr().out == "to measure again: 0 results of 0 sweeps; without a stored final state: 0\n"


def test_command__refuses_where_a_service_works(solved: Solved, capsys: Capsys) -> None:
    files = solved.store.retention.files()
    with holding(solved.settings):
        assert run("doctor", "--remeasure") == 1
        assert "is used by process" in capsys.readouterr().err
        assert run("doctor", "--remeasure", "--dry-run") == 0
    assert "to measure again: 2 results of 2 sweeps" in capsys.readouterr().out
    assert solved.store.retention.files() == files


def test_command__refuses_where_a_service_leads_on_postgresql(tmp_path: Path, postgresql_url: str) -> None:
    settings = Settings(data=tmp_path, database_url=postgresql_url)
    with closing(Store.open(postgresql_url)) as store:
        leadership = store.terms.lead("host:7")
        assert leadership is not None
        with (
            closing(leadership),
            pytest.raises(DataInUse, match="host:7 uses this database"),
            without_services(settings, store),
        ):
            pass
        with without_services(settings, store):
            assert store.terms.lead("host:8") is None
