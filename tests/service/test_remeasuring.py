"""Remeasure: values follow a changed definition, nothing is solved, and whatever dies loses nothing."""

import json
import os
import shutil
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from service.artifacts import Artifacts
from service.attempt import Ended, Ticket
from service.directory import holding
from service.jobs import Cause, Conflict, Kind, NotFound, State, SweepState
from service.remeasuring import Plan, order, plan_of
from service.store import Store
from studies import measurements
from studies.files import STATE
from studies.sweep import Sweep
from tests.service.api import SWEEP
from tests.service.attempts import SLOT, nobody, supervise
from tests.service.bench import Bench
from tests.service.by_hand import statements
from tests.service.command import run
from tests.service.doubles import DEADLINE, settings_in, wait_until
from tests.service.raised import FAULT, MEASUREMENT, TODAY, VALUE, VERSION, raise_the_version

TINY = {
    **SWEEP,
    "fixed": {**SWEEP["fixed"], "plate_radius": "16 mm", "end_time": "2 us", "stop": "end_time"},
    "resolution": 4,
}
RAISED = "tests.service.raised_targets"
OTHER = {**TINY, "name": "other", "axes": {"speed": ["3 km/s"]}}  # one of the runs of the first
APART = {**TINY, "name": "apart", "axes": {"speed": ["5 km/s"]}}


class Solved:
    """A data directory with sweeps that were solved, and a dispatcher on it."""

    def __init__(self, bench: Bench):
        self.bench = bench
        self.store = bench.store
        self.artifacts = Artifacts(bench.settings.data)

    def id(self, document: dict[str, Any]) -> str:
        """The id of one of the sweeps."""
        names = {row.name: row.id for row in self.store.sweeps().items}
        return names[document["name"]]

    def compute_all(self, *, targets: str | None = None) -> list[Ticket]:
        """Turns until nothing is under way, each attempt in the real warm process; the orders."""
        done: list[Ticket] = []
        while tickets := self.bench.turn():
            for ticket in tickets:
                ending = supervise(replace(ticket, targets=targets), nobody)
                self.bench.say(Ended(ticket.key, ending))
                done.append(ticket)
        return done

    def result(self, run_id: str) -> dict[str, Any]:
        """What the registered result of a run says."""
        answer: dict[str, Any] = self.artifacts.read_json(
            self.store.run_file(run_id, "result.json")
        )
        return answer

    def cube(self, sweep_id: str) -> xr.Dataset:
        with xr.open_dataset(self.artifacts.path(self.store.artifacts(sweep_id)[0])) as cube:
            return cube.load()

    def run_ids(self, sweep_id: str) -> list[str]:
        return [point.run.id for point in self.store.sweep_runs(sweep_id).items]

    def is_intact(self) -> bool:
        """Whether every row points to a whole file."""
        return all(self.artifacts.is_intact(file) for _, file in self.store.files())


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data directory with three sweeps that were solved and published; tests work on copies."""
    folder = tmp_path_factory.mktemp("original")
    with opened(folder) as solved:
        for document in (TINY, OTHER, APART):
            solved.store.create_sweep(Sweep.parse(document))
        solved.compute_all()
        assert {row.state for row in solved.store.sweeps().items} == {SweepState.SUCCEEDED}
    SLOT.close()  # the next process is one that knows the new definition
    return folder


@pytest.fixture
def solved(original: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Solved]:
    monkeypatch.setattr(measurements, "load", measurements.load)  # put back whatever a test raises
    shutil.copytree(original, tmp_path, dirs_exist_ok=True)
    with opened(tmp_path) as copied:
        yield copied


@pytest.fixture(scope="module", autouse=True)
def _processes() -> Iterator[None]:
    yield
    SLOT.close()


@contextmanager
def opened(folder: Path) -> Iterator[Solved]:
    settings = settings_in(folder, reconcile_seconds=1e-9, disk_reserve=0)
    with closing(Store.open(settings.url, cost=lambda run: 1.0)) as store:
        yield Solved(Bench(settings, store))


def test_remeasure__gives_the_values_of_the_new_definition_and_solves_nothing(
    solved: Solved,
) -> None:
    id = solved.id(TINY)
    before, old = solved.cube(id), {one: solved.result(one) for one in solved.run_ids(id)}
    raise_the_version()
    plan = order(solved.store, id)
    assert (len(plan.read), plan.not_kept, plan.up_to_date) == (2, (), 0)
    assert solved.store.sweep(id).state is SweepState.PUBLISHING
    done = solved.compute_all(targets=RAISED)
    assert {ticket.kind for ticket in done} == {Kind.PUBLISH}
    row, cube = solved.store.sweep(id), solved.cube(id)
    assert (row.state, row.counts["succeeded"]) == (SweepState.SUCCEEDED, 2)
    assert (cube[MEASUREMENT] == VALUE).all()
    for run_id in solved.run_ids(id):
        result, run = solved.result(run_id), solved.store.run(run_id)
        assert result["measurements"][MEASUREMENT]["version"] == VERSION
        assert run.summary is not None
        assert run.summary["measurements"][MEASUREMENT]["value"] == VALUE
        assert (run.attempt, run.state) == (1, State.SUCCEEDED)
        assert run.sha256 == solved.store.run_file(run_id, "result.json").sha256
        rest = {name: one for name, one in result["measurements"].items() if name != MEASUREMENT}
        assert rest.items() <= old[run_id]["measurements"].items()
    unchanged = [name for name in before.data_vars if MEASUREMENT not in str(name)]
    assert all(cube[name].identical(before[name]) for name in unchanged if before[name].size)
    assert solved.is_intact()
    assert plan_of(solved.store, id) == Plan({}, (), 2, 0)


def test_cube__says_by_which_definition_it_was_measured(solved: Solved) -> None:
    id = solved.id(TINY)
    versions = json.loads(solved.cube(id).attrs["measurement_versions"])
    assert versions[MEASUREMENT] == [TODAY]
    raise_the_version()
    order(solved.store, id)
    solved.compute_all(targets=RAISED)
    attrs = solved.cube(id).attrs
    assert json.loads(attrs["measurement_versions"]) == {**versions, MEASUREMENT: [VERSION]}
    assert f"{MEASUREMENT} {TODAY} to {VERSION}" in json.loads(attrs["software"])["remeasured"][0]


def test_sweeps__that_use_the_runs_are_published_again(solved: Solved) -> None:
    id, other, apart = map(solved.id, (TINY, OTHER, APART))
    raise_the_version()
    order(solved.store, id)
    done = solved.compute_all(targets=RAISED)
    assert [ticket.kind for ticket in done] == [Kind.PUBLISH] * 2
    assert (solved.cube(other)[MEASUREMENT] == VALUE).all()
    assert (solved.cube(apart)[MEASUREMENT] != VALUE).all()
    assert {solved.store.sweep(one).state for one in (id, other, apart)} == {SweepState.SUCCEEDED}


def test_runs__whose_state_was_not_kept_stay_as_they_are_and_are_named(solved: Solved) -> None:
    id = solved.id(TINY)
    runs = solved.run_ids(id)
    for run_id in runs:
        solved.artifacts.path(solved.store.run_file(run_id, STATE)).unlink()
        solved.store.forget_files(run_id, [STATE])
    results = {one: solved.result(one) for one in runs}
    raise_the_version()
    plan = order(solved.store, id)
    assert plan == Plan({}, tuple(sorted(runs)), 0, 0)
    assert solved.store.sweep(id).state is SweepState.SUCCEEDED
    assert solved.compute_all(targets=RAISED) == []
    assert {one: solved.result(one) for one in runs} == results
    assert len(order(solved.store, solved.id(APART)).read) == 1


def test_state__that_is_damaged_leaves_its_run_as_it_is_and_renews_the_others(
    solved: Solved,
) -> None:
    id = solved.id(TINY)
    damaged, fine = solved.run_ids(id)
    before = solved.result(damaged)
    file = solved.artifacts.path(solved.store.run_file(damaged, "state.npz"))
    file.write_bytes(b"x" * file.stat().st_size)
    raise_the_version()
    order(solved.store, id)
    solved.compute_all(targets=RAISED)
    assert solved.result(damaged) == before
    assert solved.result(fine)["measurements"][MEASUREMENT]["value"] == VALUE
    [told] = [
        event for event in solved.store.events(id) if event.kind == "remeasured" and event.sweep_id
    ]
    assert told.body["runs"] == 1
    assert "does not match its checksum" in told.body["unreadable"][damaged]
    assert json.loads(solved.cube(id).attrs["measurement_versions"])[MEASUREMENT] == [
        TODAY,
        VERSION,
    ]


def test_death__between_reading_and_publishing_loses_nothing(
    solved: Solved, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    id = solved.id(TINY)
    SLOT.close()  # the next process sees the environment
    monkeypatch.setenv(FAULT, str(tmp_path / "died"))
    old = {one: solved.store.run(one).sha256 for one in solved.run_ids(id)}
    raise_the_version()
    order(solved.store, id)
    [ticket] = solved.bench.turn()
    ending = supervise(replace(ticket, targets=RAISED), nobody)
    assert ending.failure == "SIGABRT"
    written = sorted(solved.bench.settings.data.glob("runs/*/*/a1-*/result-*.json"))
    assert len(written) == 2
    stamps = [file.stat().st_mtime_ns for file in written]
    assert {one: solved.store.run(one).sha256 for one in old} == old
    solved.bench.say(Ended(ticket.key, ending))
    again, _other = solved.compute_all(targets=RAISED)
    monkeypatch.delenv(FAULT)
    SLOT.close()
    assert again.spec["again"] == ticket.spec["again"]
    assert [file.stat().st_mtime_ns for file in written] == stamps  # read once
    assert (solved.cube(id)[MEASUREMENT] == VALUE).all()
    assert solved.is_intact()


def test_service__that_was_killed_while_it_read_does_it_again(solved: Solved) -> None:
    id = solved.id(TINY)
    raise_the_version()
    order(solved.store, id)
    [lost] = solved.bench.turn()  # and then nobody is there any more
    bench = solved.bench = Bench(solved.bench.settings, solved.store)
    again, _other = solved.compute_all(targets=RAISED)
    assert again.spec["again"] == lost.spec["again"]
    assert again.key != lost.key
    bench.say(Ended(lost.key, supervise(replace(lost, targets=RAISED), nobody)))
    bench.turn()  # too late, it no longer counts
    assert (solved.cube(id)[MEASUREMENT] == VALUE).all()
    assert [one.kind for one in solved.store.events(id)].count("published") == 2
    assert solved.is_intact()


def test_publication__that_was_given_the_old_results_begins_again(solved: Solved) -> None:
    id, other = solved.id(TINY), solved.id(OTHER)
    solved.store.retry_sweep(other)
    [stale] = solved.bench.turn()  # a publication by the old definition is under way
    raise_the_version()
    order(solved.store, id)
    [reading] = solved.bench.turn()
    for ticket, targets in ((reading, RAISED), (stale, None)):
        ending = supervise(replace(ticket, targets=targets), nobody)
        solved.bench.say(Ended(ticket.key, ending))
        if ticket is reading:
            solved.bench.engine.free = 0
            solved.bench.turn()
            solved.bench.turn()
            assert solved.bench.engine.stopped[-1] == stale.key
            solved.bench.engine.free = 2
    [again] = solved.compute_all(targets=RAISED)
    assert again.kind is Kind.PUBLISH
    assert (solved.cube(other)[MEASUREMENT] == VALUE).all()


def test_order__given_twice_is_done_once(solved: Solved) -> None:
    id = solved.id(TINY)
    raise_the_version()
    for _ in range(2):
        order(solved.store, id)
    [ticket] = solved.bench.turn()
    order(solved.store, id)  # while it is done
    solved.bench.say(Ended(ticket.key, supervise(replace(ticket, targets=RAISED), nobody)))
    [of_other] = solved.compute_all(targets=RAISED)
    assert not of_other.spec["again"]
    kinds = [event.kind for event in solved.store.events(id) if event.sweep_id]
    assert kinds.count("remeasuring") == 1


def test_order__while_the_sweep_is_computed_is_refused(solved: Solved) -> None:
    axes = {"speed": ["3 km/s", "7 km/s"]}  # one of the two is there
    id = solved.store.create_sweep(Sweep.parse({**TINY, "axes": axes})).id
    raise_the_version()
    with pytest.raises(Conflict, match="remeasure it when that is done"):
        order(solved.store, id)
    with pytest.raises(NotFound):
        order(solved.store, "0" * 32)


def test_retry__after_reading_has_failed_publishes_what_there_is(solved: Solved) -> None:
    id = solved.id(TINY)
    raise_the_version()
    order(solved.store, id)
    [ticket] = solved.bench.turn()
    claim = solved.store.claimed()[0]
    assert solved.store.fail(claim, Cause.ERROR, failure="X", reason="because")
    assert solved.store.sweep(id).state is SweepState.FAILED
    solved.store.retry_sweep(id)
    solved.bench.engine.submitted.clear()
    [again] = solved.bench.turn()
    assert ticket.spec["again"]
    assert not again.spec["again"]


def test_plan__asks_a_few_statements_whatever_the_size(solved: Solved) -> None:
    id = solved.id(OTHER)
    with statements(solved.store) as sent:
        plan_of(solved.store, id)
    assert len([one for one in sent if one.startswith("SELECT")]) == 2


def test_nothing__of_it_is_left_behind(solved: Solved) -> None:
    id = solved.id(TINY)
    raise_the_version()
    order(solved.store, id)
    solved.compute_all(targets=RAISED)
    data = solved.bench.settings.data
    assert not [name for _, _, names in os.walk(data) for name in names if name.endswith(".part")]


# --- the command ------------------------------------------------------------------------------------


@pytest.fixture
def _commanded(solved: Solved, monkeypatch: pytest.MonkeyPatch) -> None:
    """The command means this data directory, and its processes know the new definition."""
    monkeypatch.setenv("WHIPPLE_DATA", str(solved.bench.settings.data))
    monkeypatch.setenv("WHIPPLE_TARGETS_MODULE", RAISED)
    raise_the_version()


@pytest.mark.usefixtures("_commanded")
def test_command__reads_every_sweep_again_without_a_service(
    solved: Solved, capsys: pytest.CaptureFixture[str]
) -> None:
    queued = solved.store.create_sweep(Sweep.parse({**APART, "axes": {"speed": ["8 km/s"]}})).id
    old = {row.id: solved.store.artifacts(row.id) for row in solved.store.sweeps().items}
    assert run("remeasure", "--dry-run") == 0
    assert capsys.readouterr().out.count(" to read again") == 3
    assert {id: solved.store.artifacts(id) for id in old} == old
    assert run("remeasure") == 0
    said = capsys.readouterr().out
    assert said.count("succeeded (") == 3
    for document in (TINY, OTHER, APART):
        assert (solved.cube(solved.id(document))[MEASUREMENT] == VALUE).all()
    assert solved.store.sweep(queued).state is SweepState.QUEUED  # no run was begun
    assert solved.is_intact()
    assert run("remeasure") == 0
    assert capsys.readouterr().out == "nothing is to be read again\n"


@pytest.mark.usefixtures("_commanded")
def test_command__beside_a_service_leaves_the_work_to_it(
    solved: Solved, capsys: pytest.CaptureFixture[str]
) -> None:
    id = solved.id(APART)
    ended: list[int] = []
    with holding(solved.bench.settings):
        command = threading.Thread(target=lambda: ended.append(run("remeasure", id)))
        command.start()
        wait_until(lambda: solved.store.sweep(id).state is SweepState.PUBLISHING)
        solved.compute_all(targets=RAISED)
        command.join(60)
    assert ended == [0]
    assert "a service works here" in capsys.readouterr().out
    assert (solved.cube(id)[MEASUREMENT] == VALUE).all()


@pytest.mark.usefixtures("_commanded")
def test_command__beside_a_service_that_dies_does_the_work_itself(solved: Solved) -> None:
    id = solved.id(APART)
    ended: list[int] = []
    with holding(solved.bench.settings):
        command = threading.Thread(target=lambda: ended.append(run("remeasure", id)), daemon=True)
        command.start()
        wait_until(lambda: solved.store.sweep(id).state is SweepState.PUBLISHING)
        solved.bench.turn()  # it is claimed
    command.join(4 * DEADLINE)
    assert ended == [0]
    assert (solved.cube(id)[MEASUREMENT] == VALUE).all()


@pytest.mark.usefixtures("_commanded")
def test_command__after_one_that_was_killed_goes_on(solved: Solved) -> None:
    id = solved.id(APART)
    order(solved.store, id)
    solved.bench.turn()  # the publication is claimed, and nobody is there any more
    assert run("remeasure", id) == 0
    assert (solved.cube(id)[MEASUREMENT] == VALUE).all()
    assert solved.store.sweep(id).state is SweepState.SUCCEEDED


@pytest.mark.usefixtures("_commanded")
def test_command__leaves_a_sweep_that_is_computed_and_says_so(
    solved: Solved, capsys: pytest.CaptureFixture[str]
) -> None:
    axes = {"speed": ["3 km/s", "7 km/s"]}  # one of the two is there
    id = solved.store.create_sweep(Sweep.parse({**TINY, "axes": axes})).id
    assert run("remeasure", id) == 3
    assert "remeasure it when that is done" in capsys.readouterr().out


@pytest.mark.usefixtures("_commanded")
def test_command__ends_with_3_and_names_what_cannot_be_read(
    solved: Solved, capsys: pytest.CaptureFixture[str]
) -> None:
    [damaged] = solved.run_ids(solved.id(APART))
    solved.artifacts.path(solved.store.run_file(damaged, STATE)).write_bytes(b"x")
    assert run("remeasure", solved.id(APART)) == 3
    assert f"{damaged} stays as it was" in capsys.readouterr().out
    assert solved.store.sweep(solved.id(APART)).state is SweepState.SUCCEEDED
