"""A clock that jumps deletes nothing, and by rule at most a tenth of what is stored goes in a day."""

from collections.abc import Sequence
from pathlib import Path

import pytest

from service.files.disk_space import Space
from service.queue.clock_watch import ClockWatch
from service.queue.garbage_collection import GarbageCollector
from service.records import clock as rules
from service.records.clock import DAY, HOUR, ClockHistory, ClockReading
from tests.service.support.fakes import runs_of
from tests.service.support.harness import Harness, open_harness

LIMIT = 30 * DAY
BEGIN = ClockReading(wall=1.8e9, running=1000.0, boot="first")
Step = tuple[float, float] | tuple[float, float, str]


def later(reading: ClockReading, seconds: float, *, jump: float = 0.0, boot: str | None = None) -> ClockReading:
    """The clocks so many seconds later, after a jump of the wall clock, or a start of the machine."""
    running = reading.running + seconds if boot is None else 10.0
    return ClockReading(reading.wall + seconds + jump, running, boot or reading.boot)


def history_of(*steps: Step) -> ClockHistory:
    """A history of readings: seconds later, jump, and the boot where it is another one."""
    reading, history = BEGIN, ClockHistory(BEGIN)
    for seconds, jump, *boot in steps:
        reading = later(reading, seconds, jump=jump, boot=boot[0] if boot else None)
        history = history.seen(reading)
    return ClockHistory.from_json(history.as_json())


HISTORIES: dict[str, tuple[Sequence[Step], bool]] = {  # and whether deletion by age is paused after them
    "steady": ([(HOUR, 0.0), (60 * DAY, 0.0)], False),
    "asleep": ([(90 * DAY, 0.0)], False),
    "steps of a time server": ([(HOUR, 1.0), (HOUR, -2.0)], False),
    "forward": ([(HOUR, 45 * DAY)], True),
    "forward by small steps": ([(HOUR, 200.0)] * 4, True),
    "forward and back again": ([(HOUR, 45 * DAY), (HOUR, -45 * DAY)], False),
    "forward, and run for as long as the limit": ([(HOUR, 45 * DAY), (LIMIT + HOUR, 0.0)], False),
    "back": ([(HOUR, -400 * DAY)], True),
    "back and right again": ([(HOUR, -400 * DAY), (HOUR, 400 * DAY)], True),  # what was stamped between looks old
    "back and right again, long ago": ([(HOUR, -400 * DAY), (HOUR, 400 * DAY), (LIMIT + HOUR, 0.0)], False),
    "forward while no service ran": ([(HOUR, 0.0), (DAY, 45 * DAY)], True),
    "a short stop of the machine": ([(HOUR, 0.0), (HOUR, 0.0, "second")], False),
    "a long stop, at its end": ([(HOUR, 0.0), (60 * DAY, 0.0, "second"), (HOUR, 0.0)], True),
    "a long stop, and a day": ([(HOUR, 0.0), (60 * DAY, 0.0, "second"), (DAY + HOUR, 0.0)], False),
    "back while the machine was off": ([(HOUR, 0.0), (HOUR, -400 * DAY, "second")], True),
    "behind, then forward and back": ([(HOUR, -9 * DAY), (HOUR, 9 * DAY), (HOUR, DAY), (HOUR, -DAY)], True),
    "back, and right after a start": ([(HOUR, -400 * DAY), (HOUR, 400 * DAY, "second"), (2 * DAY, 0.0)], True),
}


@pytest.mark.parametrize("name", HISTORIES)
def test_clock__is_believed_unless_it_jumped(name: str) -> None:
    steps, is_paused = HISTORIES[name]
    assert (history_of(*steps).why_paused(LIMIT) is not None) == is_paused


def test_clock__that_a_person_trusts_is_believed() -> None:
    history = history_of((HOUR, 45 * DAY))
    assert "forward by 45 days" in str(history.why_paused(LIMIT))
    assert history.trusted().seen(later(history.reading, HOUR)).why_paused(LIMIT) is None


class Clocks:
    """Two clocks that a test moves."""

    def __init__(self) -> None:
        self.now = rules.read_clocks()

    def __call__(self) -> ClockReading:
        return self.now

    def move(self, seconds: float, *, jump: float = 0.0) -> None:
        self.now = later(self.now, seconds, jump=jump)


def collector(harness: Harness, clocks: Clocks, **settings: float) -> GarbageCollector:
    """A collector with clocks of its own; its limits of age are passed at once unless ``settings`` say otherwise."""
    chosen = harness.settings.model_copy(update=settings)
    clock = ClockWatch(chosen, harness.store, clocks)
    return GarbageCollector(chosen, harness.store, harness.artifacts, Space(chosen.data, 0), clock)


def finished(harness: Harness, count: int) -> list[str]:
    """So many sweeps that have ended."""
    ids = [harness.submit(runs_of("fine", first=number)) for number in range(count)]
    harness.compute_all()
    return ids


def left(harness: Harness) -> int:
    return harness.store.retention.sweeps()


def paused(harness: Harness) -> str:
    """What the queue says about deletion by age."""
    return harness.store.queue.status().deletion_paused or ""


@pytest.mark.parametrize("jump", [45 * DAY, -400 * DAY])
def test_jump__pauses_deletion_by_age_until_the_clock_is_back(tmp_path: Path, jump: float) -> None:
    clocks = Clocks()
    with open_harness(tmp_path) as harness:
        finished(harness, 2)
        going = collector(harness, clocks, retention_days=30.0)
        going.step()
        clocks.move(10.0, jump=jump)
        going.step()
        assert left(harness) == 2
        assert f"{'forward' if jump > 0 else 'back'} by {abs(jump) / DAY:g} days" in paused(harness)
        clocks.move(10.0, jump=-jump)
        going.step()
        assert paused(harness) == ("" if jump > 0 else paused(harness))
        clocks.move(60 * DAY)
        going.step()
        assert (left(harness), paused(harness)) == (1, "")


def test_jump__pauses_the_removal_of_orphans_and_of_runs_without_sweep(tmp_path: Path) -> None:
    clocks = Clocks()
    with open_harness(tmp_path) as harness:
        [id] = finished(harness, 1)
        [run] = (tmp_path / "runs").glob("*/*")
        orphan = run / "a0-c0ffee00"
        orphan.mkdir()
        harness.store.sweeps.delete(id)
        going = collector(harness, clocks, retire_seconds=1e-9)
        going.step()
        orphan.mkdir(exist_ok=True)
        clocks.move(10.0, jump=45 * DAY)
        for _ in range(3):
            going.step()
        assert orphan.is_dir()
        clocks.move(60 * DAY)
        for _ in range(3):
            going.step()
        assert not run.exists()


@pytest.mark.parametrize(("stored", "by_day"), [(3, [1, 1, 1]), (20, [2, 1, 1])])
def test_rule__deletes_at_most_a_tenth_of_the_sweeps_in_a_day(tmp_path: Path, stored: int, by_day: list[int]) -> None:
    clocks, gone = Clocks(), []
    with open_harness(tmp_path) as harness:
        finished(harness, stored)
        clocks.move(HOUR)
        going = collector(harness, clocks, retention_days=1e-9)
        for _ in by_day:
            before = left(harness)
            for _ in range(4):
                going._may_forget = True  # as after a round
                going.step()
            gone.append(before - left(harness))
            clocks.move(DAY + 2 * HOUR)
    assert gone == by_day
