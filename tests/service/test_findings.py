"""What attempts left is looked at: whether it is a result, in words that rows take, beside the turns."""

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from service import reign
from service.artifacts import Artifacts, describe
from service.attempt import Ending
from service.jobs import Cause, State, Stored
from tests.service.bench import Bench, open_bench
from tests.service.doubles import DEADLINE, run_id, runs_of, sweep_of


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    with open_bench(tmp_path) as opened:
        yield opened


NO_RESULTS: tuple[object, ...] = (
    {"state": "succeeded"},
    [],
    {"state": "succeeded", "measurements": []},
    None,
)


@pytest.mark.parametrize("answer", NO_RESULTS)
def test_result_that_is_none__is_no_result(bench: Bench, answer: object) -> None:
    bench.store.create_sweep(sweep_of(1))
    for _ in range(3):
        [ticket] = bench.turn()
        bench.compute(ticket)
        file = Path(ticket.directory) / "result.json"
        file.write_text(json.dumps(answer))
        bench.end(ticket, Ending(None, "", "", (describe(file),), 1.0))
    bench.turn()
    run = bench.run()
    assert (run.state, run.cause) == (State.FAILED, Cause.CRASH)
    assert "cannot be registered" in str(run.reason)


def test_reason__that_no_database_takes_is_made_legible(
    tmp_path: Path, database_url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    with open_bench(tmp_path, database_url=database_url) as bench:
        bench.store.create_sweep(sweep_of(2))
        crashed, failed = bench.turn()
        words = "cannot read 'caf\udce9.toml'\0" + 5000 * "!"
        bench.end_badly(crashed, Cause.CRASH, reason=words)
        bench.end_badly(failed, Cause.ERROR, reason=words, failure="\0")
        bench.turn()
        assert [bench.run(number).state for number in (0, 1)] == [State.RUNNING, State.FAILED]
        assert str(bench.run(1).reason).startswith("cannot read 'caf\ufffd.toml'\ufffd!")


def test_verdict__that_no_database_takes_is_made_legible(
    tmp_path: Path, database_url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    with open_bench(tmp_path, database_url=database_url) as bench:
        bench.store.create_sweep(sweep_of(runs_of("verdict")))
        [ticket] = bench.turn()
        bench.compute(ticket)
        file = Path(ticket.directory) / "result.json"
        answer = json.loads(file.read_text())
        file.write_text(json.dumps(answer | {"reason": "at \ud83d\0"}))
        bench.end(ticket, Ending(None, "", "", (describe(file),), 1.0))
        bench.turn()
        assert (bench.run().cause, bench.run().reason) == (Cause.VERDICT, "at \ufffd\ufffd")


# --- beside the turns ----------------------------------------------------------------------------


@contextmanager
def slow(patch: pytest.MonkeyPatch, number: int) -> Iterator[None]:
    """Let the digests of a run take until the end of the block."""
    may_go_on, is_intact = threading.Event(), Artifacts.is_intact

    def wait_for_it(artifacts: Artifacts, file: Stored) -> bool:
        if run_id(number) in file.path:
            assert may_go_on.wait(DEADLINE)
        return is_intact(artifacts, file)

    patch.setattr(Artifacts, "is_intact", wait_for_it)
    try:
        yield
    finally:
        may_go_on.set()


def test_large_result__does_not_hold_up_the_turns(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench.store.create_sweep(sweep_of(3))
    large, small = bench.turn()
    with slow(monkeypatch, 0):
        bench.end_well(large)
        monkeypatch.setattr(reign, "WAIT_SECONDS", 0.0)
        assert len(bench.turn()) == 1  # its slot is free
        monkeypatch.setattr(reign, "WAIT_SECONDS", DEADLINE)
        bench.end_well(small)
        bench.turn()
        assert [bench.run(number).state for number in (0, 1)] == [State.RUNNING, State.SUCCEEDED]
        assert bench.run().attempt == 1
    assert bench.inbox is not None
    assert bench.inbox.get(timeout=DEADLINE) is None  # a turn is asked for
    bench.turn()
    assert bench.run().state is State.SUCCEEDED


def test_log_of_a_failure__is_brought_to_the_disk(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.compute(ticket)
    bench.end_badly(ticket, Cause.ERROR)
    reached: list[Path] = []
    monkeypatch.setattr("service.artifacts.to_disk", reached.append)
    bench.turn()
    assert Path(ticket.directory) / "log.txt" in reached
