"""A real service whose clock jumps: nothing is deleted by age, and it says so."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from studies.sweeps import examples
from studies.sweeps.document import read_yaml
from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.crash.support.clock import SetClock, set_clock
from tests.crash.support.serving import Service, http, serving
from tests.service.support.fakes import wait_until

DAY = 24 * 3600.0
RULE = {  # ages that the jumps pass by far; rows and files are looked at every half second
    "WHIPPLE_TARGETS_MODULE": "tests.service.support.targets",
    "WHIPPLE_RETENTION_DAYS": "30",
    "WHIPPLE_RECONCILE_SECONDS": "0.5",
    "WHIPPLE_WORKERS": "1",
}
SEEN_SECONDS, ROUNDS_SECONDS = 30.0, 5.0  # until a jump is said; ten rounds of the collector
SMOKE = read_yaml(examples.text("smoke"), "smoke")


@pytest.fixture
def clock(tmp_path: Path) -> SetClock:
    return set_clock(tmp_path)


def queue(service: Service) -> Any:
    return http().get(f"{service.url}/v1/queue", timeout=30).json()


def metric(service: Service, name: str) -> float:
    """The value of a metric without labels."""
    lines = http().get(f"{service.url}/metrics", timeout=30).text.splitlines()
    return float(next(line.split()[1] for line in lines if line.startswith(f"{name} ")))


def submit(service: Service, speed: str) -> str:
    return service.submit({**SMOKE, "axes": {"speed": [speed]}})


def finish(service: Service, id: str) -> str:
    wait_until(lambda: state_of(service, id) == "succeeded", seconds=120.0)
    return id


def command(service: Service, name: str) -> None:
    """Pause or resume the queue."""
    assert http().post(f"{service.url}/v1/queue/{name}", timeout=30).is_success


def state_of(service: Service, id: str) -> str | None:
    """The state of a sweep; None: it is gone."""
    answer = http().get(f"{service.url}/v1/sweeps/{id}", timeout=30)
    return None if answer.status_code == 404 else str(answer.json()["state"])


def left(service: Service, ids: Sequence[str]) -> int:
    """Number of these sweeps that are there."""
    return sum(state_of(service, id) is not None for id in ids)


def rounds(service: Service) -> None:
    """Let the collector go round some times."""
    end = time.monotonic() + ROUNDS_SECONDS
    wait_until(lambda: time.monotonic() > end, seconds=2 * ROUNDS_SECONDS)


@pytest.mark.slow
@pytest.mark.claim("mend", "clock-jumps", minutes=0.3)
@pytest.mark.parametrize(("days", "stopped"), [(45, False), (45, True), (-400, False)])
def test_clock__that_jumps_deletes_nothing_and_is_said(
    tmp_path: Path, clock: SetClock, compared: Compared, days: int, stopped: bool
) -> None:
    """A clock that jumps by 45 days or back by 400 deletes nothing, and queue, metric and log say that it jumped."""
    case = f"{days:+} days{' while the service is stopped' if stopped else ''}"
    said = f"{'forward' if days > 0 else 'back'} by {abs(days)} days"
    with serving(tmp_path / "data", **RULE, **clock.environment) as service:
        ids = [finish(service, submit(service, speed)) for speed in ("3 km/s", "4 km/s")]
        command(service, "pause")
        ids.append(submit(service, "5 km/s"))
        assert queue(service)["deletion_paused"] is None
        if stopped:
            service.leave()
        clock.set(days * DAY)
        if stopped:
            service.start()
            service.wait_until_listening()
        wait_until(lambda: queue(service)["deletion_paused"], seconds=SEEN_SECONDS)
        age = metric(service, "whipple_queue_age_seconds")
        command(service, "resume")
        finish(service, ids[-1])
        rounds(service)
        logged = service.log.read_text().count("nothing is deleted by age")
        compared(
            equal(f"{case}: sweeps left of three", expected=3, got=left(service, ids)),
            equal(f"{case}: the queue says {said}", expected=True, got=said in queue(service)["deletion_paused"]),
            equal(f"{case}: the metric says so", expected=1.0, got=metric(service, "whipple_deletion_paused")),
            equal(f"{case}: lines of the log that say so", expected=1, got=logged),
            equal(f"{case}: the age of the queue is negative", expected=False, got=age < 0),
        )
        clock.set(0)
        rounds(service)
        is_paused = queue(service)["deletion_paused"] is not None
        compared(  # what ended while the clock was behind looks old as soon as it is right
            equal(f"{case}, and right again: paused", expected=days < 0, got=is_paused),
            equal(f"{case}, and right again: sweeps left of three", expected=3, got=left(service, ids)),
        )
