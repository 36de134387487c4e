"""The order to read again, over HTTP: what it answers, and what the sweep says of itself meanwhile."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from service import remeasuring
from service.jobs import Kind
from studies.files import STATE
from tests.service.api import Api, open_api
from tests.service.doubles import stored

HOLE = "hole_diameter"


@pytest.fixture
def api(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Api]:
    """A service by whose definitions a hole is of version 2."""
    monkeypatch.setattr(remeasuring, "outdated", _outdated)
    with open_api(tmp_path) as opened:
        yield opened


def _outdated(_scenario: str, measured: dict[str, Any]) -> tuple[str, ...]:
    return (HOLE,) if measured[HOLE].get("version", 1) != 2 else ()


def computed(api: Api, *, keep: bool = True, version: int = 1, **changes: Any) -> str:
    """A sweep of two runs, of which the first has kept its final state."""
    id = api.submit(**changes)
    epoch = api.epoch()
    for place, claim in enumerate(api.store.claim(10, epoch)):
        assert claim.kind is Kind.RUN
        result = api.result(claim.id)
        summary = {"measurements": {HOLE: {"value": 0.01, "flags": [], "version": version}}}
        more = (stored(STATE, f"{claim.id}/{STATE}"),) if keep and place == 0 else ()
        api.store.finish(claim, replace(result, files=(*result.files, *more), summary=summary))
    api.compute()
    return id


def remeasure(api: Api, id: str) -> Any:
    return api.http.post(f"/v1/sweeps/{id}/remeasure")


def test_remeasure__says_what_is_read_and_what_was_not_kept(api: Api) -> None:
    id = computed(api)
    response = remeasure(api, id)
    said = response.json()
    assert response.status_code == 202
    counts = {
        name: said[name] for name in ("remeasured", "up_to_date", "not_kept", "without_result")
    }
    assert counts == {"remeasured": 1, "up_to_date": 0, "not_kept": 1, "without_result": 0}
    runs = [point.run.id for point in api.store.sweep_runs(id).items]
    assert said["not_kept_runs"] == [runs[1]]
    sweep = api.http.get(said["links"]["sweep"]).json()
    assert sweep["state"] == "publishing"
    assert "cube.nc" in sweep["links"]  # the earlier one, until there is another
    [claim] = api.store.claim(10, api.epoch())
    assert claim.spec == {"remeasure": True}


def test_remeasure__of_what_is_up_to_date_orders_nothing(api: Api) -> None:
    id = computed(api, version=2)
    said = remeasure(api, id).json()
    assert (said["remeasured"], said["up_to_date"]) == (0, 2)
    assert api.http.get(f"/v1/sweeps/{id}").json()["state"] == "succeeded"


def test_remeasure__of_a_sweep_that_kept_numbers_alone_leaves_it(api: Api) -> None:
    id = computed(api, keep=False)
    said = remeasure(api, id).json()
    assert (said["remeasured"], said["not_kept"]) == (0, 2)
    assert api.http.get(f"/v1/sweeps/{id}").json()["state"] == "succeeded"


def test_remeasure__twice_is_one_order(api: Api) -> None:
    id = computed(api)
    assert remeasure(api, id).json() == remeasure(api, id).json()
    assert len(api.store.claim(10, api.epoch())) == 1


def test_remeasure__of_failed_runs_counts_them_apart(api: Api) -> None:
    id = api.submit()
    api.compute(failures=2)
    assert remeasure(api, id).json()["without_result"] == 2


def test_remeasure__while_the_sweep_is_computed_is_a_conflict(api: Api) -> None:
    computed(api)
    axes = {"speed": ["3 km/s", "7 km/s"]}
    id = api.submit(axes=axes)
    response = remeasure(api, id)
    assert response.status_code == 409
    assert "remeasure it when that is done" in response.json()["detail"]


def test_remeasure__of_an_unknown_sweep_is_404(api: Api) -> None:
    assert remeasure(api, "0" * 32).status_code == 404
