"""Files that the disk loses after they were registered: whoever asks for them has them computed again."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from service.artifacts import Artifacts
from service.store import Store
from studies.files import ANSWER, STATE
from tests.acceptance.serving import Service, serving
from tests.service.api import SWEEP
from tests.service.doubles import open_store, settings_in

PATIENCE = 120.0  # s


@pytest.fixture
def service(tmp_path: Path) -> Iterator[Service]:
    with serving(tmp_path / "data", WHIPPLE_TARGETS_MODULE="tests.service.targets") as one:
        yield one


@pytest.fixture
def store(service: Service) -> Iterator[Store]:
    with closing(open_store(settings_in(service.data))) as one:
        yield one


def ended(service: Service, id: str) -> dict[str, int]:
    """The counts of a sweep that has succeeded."""
    with service.client() as client:
        status = client.sweep(id).wait(timeout=PATIENCE)
    assert status.state == "succeeded"
    return dict(status.counts)


def flip_a_bit(file: Path) -> None:
    """The same size, other bytes."""
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)


@pytest.mark.slow
def test_lost_files__are_made_again_for_a_sweep_that_shares_them_and_by_a_retry(
    service: Service, store: Store
) -> None:
    artifacts = Artifacts(service.data)
    first = service.submit(SWEEP)
    ended(service, first)
    lost, damaged = (point.run.id for point in store.sweep_runs(first).items)
    artifacts.path(store.run_file(lost, ANSWER)).unlink()
    artifacts.path(store.run_file(damaged, ANSWER)).write_text("{}")

    second = service.submit({**SWEEP, "name": "the-same-runs"})
    assert ended(service, second)["succeeded"] == 2
    for run in (lost, damaged):
        assert artifacts.is_intact(store.run_file(run, ANSWER))
        assert store.run(run).attempt == 2

    artifacts.path(store.run_file(lost, STATE)).unlink()
    flip_a_bit(artifacts.path(store.run_file(damaged, STATE)))
    with service.client() as client:
        client.sweep(second).retry()
    ended(service, second)
    for run in (lost, damaged):
        assert artifacts.is_intact(store.run_file(run, STATE))
        assert store.run(run).attempt == 3
