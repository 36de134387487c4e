"""The client, against the real interface over a real connection."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from service.client.client import Client, ServiceError, StillRunning
from studies.sweeps import examples
from tests.service.support.api import Api, sweep_of


@pytest.fixture(scope="module")
def client(url: str) -> Iterator[Client]:
    with Client(url) as opened:
        yield opened


def test_submit__takes_a_file_with_the_observations_beside_it(client: Client, tmp_path: Path) -> None:
    text = examples.text("smoke") + "\nobservations: shots.csv\n"
    (tmp_path / "smoke.yaml").write_text(text)
    (tmp_path / "shots.csv").write_text(
        "speed,quantity,value,uncertainty,source\n3 km/s,hole_diameter,16 mm,1 mm,own shot 7\n"
    )
    assert "own shot 7" in str(client.submit(tmp_path / "smoke.yaml").document()["observations"])


def test_wait__past_its_deadline_says_where_the_sweep_stands(client: Client) -> None:
    handle = client.submit(sweep_of(axes={"speed": ["4.5 km/s"]}))
    with pytest.raises(StillRunning, match="queued"):
        handle.wait(timeout=0)


def test_fetch__of_a_damaged_file_leaves_nothing(shared_api: Api, client: Client, tmp_path: Path) -> None:
    handle = client.submit(sweep_of(name="damaged"))
    shared_api.compute()
    _, stored = shared_api.store.sweeps.get_with_file(handle.id, "cube.nc")
    assert stored is not None
    (shared_api.settings.data / stored.path).write_bytes(b"x" * stored.size)
    with pytest.raises(ServiceError, match="not the file that was registered"):
        handle.fetch(tmp_path)
    assert not list(tmp_path.iterdir())


def test_runs__come_from_every_page(shared_api: Api, client: Client) -> None:
    shared_api.compute()  # what other tests left in the queue
    axis = {"start": "1 km/s", "stop": "2.2 km/s", "step": "10 m/s"}
    handle = client.submit(sweep_of(axes={"speed": axis}))
    assert [point["ordinal"] for point in handle.runs()] == list(range(121))
    shared_api.compute(failures=2)
    assert len(list(handle.runs("failed"))) == 2
