"""What a monitor reads."""

import json
import re
from pathlib import Path

import pytest
import yaml
from prometheus_client.parser import text_string_to_metric_families

from service.records.jobs import Cause
from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.service.api.test_queue_routes import look_again
from tests.service.support.api import Api
from tests.service.support.fakes import failing

MONITORING = Path(__file__).parents[3] / "docs" / "monitoring"


class Metrics(dict[tuple[str, frozenset[tuple[str, str]]], float]):
    """Every sample by name and labels."""

    def __init__(self, api: Api):
        response = api.http.get("/metrics")
        assert response.headers["Content-Type"].startswith("text/plain")
        for family in text_string_to_metric_families(response.text):
            self.update({(each.name, frozenset(each.labels.items())): each.value for each in family.samples})

    def of(self, name: str, **labels: str) -> float:
        return self[f"whipple_{name}", frozenset(labels.items())]


def test_metrics__count_jobs_by_state_and_seconds_of_runs(api: Api) -> None:
    api.submit()
    before = Metrics(api)
    assert [before.of("runs", state=state) for state in ("queued", "failed")] == [2, 0]
    assert before.of("publications", state="waiting") == 1
    api.compute(failures=1)  # a second for each run that succeeds
    after = Metrics(api)
    assert [after.of("runs", state=state) for state in ("queued", "failed")] == [0, 1]
    assert [after.of("attempts_failed_total", cause=cause) for cause in ("error", "crash")] == [1, 0]
    assert [after.of("run_seconds_bucket", le=edge) for edge in ("1.0", "+Inf")] == [1, 1]
    assert (after.of("run_seconds_count"), after.of("run_seconds_sum")) == (1, 1.0)


@pytest.mark.claim("doors", "monitoring")
def test_alerts_and_dashboard__read_metrics_that_are_there(api: Api, compared: Compared) -> None:
    """Every metric that the alert rules and the dashboard of the documentation name is one of the service."""
    api.submit()
    api.compute(failures=1)
    api.submit(name="another", axes={"speed": ["1 km/s"]})
    there = {name for name, _labels in Metrics(api)}
    rules = yaml.safe_load((MONITORING / "alerts.yml").read_text())["groups"][0]["rules"]
    panels = json.loads((MONITORING / "grafana.json").read_text())["panels"]
    texts = [*(rule["expr"] for rule in rules), *(each["expr"] for panel in panels for each in panel["targets"])]
    named = {name for text in texts for name in re.findall(r"\b(?:whipple|process)_\w+", text)}
    compared(equal("metrics that are not there", expected=[], got=sorted(named - there)))
    pages = [rule["expr"] for rule in rules if rule["labels"]["severity"] == "page"]
    compared(equal("an alarm when /readyz is not 200", expected=True, got="whipple_ready == 0" in pages))
    causes = re.findall(r"[a-z_]+", next(rule["expr"] for rule in rules if rule["alert"] == "WhippleCrashes"))
    assert {"crash", "stalled", "memory_limit"} <= {*Cause} & {*causes}


def test_metrics__say_how_long_the_queue_is_and_who_leads(api: Api) -> None:
    api.submit()
    metrics = Metrics(api)
    assert 0 <= metrics.of("queue_age_seconds") < 60
    assert [metrics.of(name) for name in ("queue_paused", "slots", "leader")] == [0, 2, 1]
    api.http.post("/v1/queue/pause")
    api.engine.slots = None
    metrics = Metrics(api)
    assert [metrics.of(name) for name in ("queue_paused", "slots", "leader")] == [1, 0, 0]


def states(api: Api) -> list[float]:
    """What the metrics say: ready, blocked, store up."""
    look_again(api)
    metrics = Metrics(api)
    assert metrics.of("ready") == float(api.http.get("/readyz").status_code == 200)
    return [metrics.of(name) for name in ("ready", "queue_blocked", "store_up")]


def test_metrics__say_what_readyz_says(api: Api, monkeypatch: pytest.MonkeyPatch) -> None:
    assert states(api) == [0, 0, 1]  # nobody leads
    api.term()
    assert states(api) == [1, 0, 1]
    with failing(api.store, "ping"):
        assert states(api) == [0, 1, 0]
    with failing(api.store.queue, "head"):
        assert states(api) == [0, 1, 0]
    api.engine.reason = "the disk is full"  # which the database does not know
    assert states(api) == [0, 1, 1]
    api.engine.refused = True
    assert states(api) == [0, 1, 0]


def test_metrics__count_requests_by_template_and_never_by_what_a_user_wrote(api: Api) -> None:
    id = api.submit()
    for path in (f"/v1/sweeps/{id}", "/v1/sweeps/nope", "/v1/nowhere/else"):
        api.http.get(path)
    api.http.request("BREW", "/v1/sweeps")
    metrics, template = Metrics(api), "/v1/sweeps/{id}"
    for route, method, status in (
        *((template, "GET", "200"), (template, "GET", "404"), ("/v1/sweeps", "POST", "202")),
        *(("unknown", "GET", "404"), ("/v1/sweeps", "other", "405")),
    ):
        assert metrics.of("http_requests_total", route=route, method=method, status=status) == 1
    assert metrics.of("http_request_seconds_count", route=template, method="GET") == 2
    assert not re.search(r"nope|BREW|nowhere|" + id, api.http.get("/metrics").text)
