"""Log lines: one JSON object each, with the ids of request, run and sweep."""

import io
import json
import logging
import warnings
from collections.abc import Callable
from typing import Any

import pytest

from service import logs
from service.records.jobs import Kind, Scope
from tests.service.support.api import Api
from tests.service.support.fakes import run_id
from tests.service.support.rows import lease_of

Lines = Callable[[], list[dict[str, Any]]]


@pytest.fixture
def lines() -> Lines:
    """Let the loggers write as they do in a service; gives what they wrote."""
    written = io.StringIO()
    logs.configure(written)
    return lambda: [json.loads(line) for line in written.getvalue().splitlines()]


def of_requests(lines: Lines) -> list[dict[str, Any]]:
    return [line for line in lines() if line["logger"] == "service.api.middleware"]


def test_line__has_time_level_logger_and_message(lines: Lines) -> None:
    logging.getLogger("service.queue.dispatcher").info("done", extra={"run": "7", "sweep": "9"})
    [line] = lines()
    assert line["time"].endswith("+00:00")
    assert (line["level"], line["logger"]) == ("info", "service.queue.dispatcher")
    assert (line["message"], line["run"], line["sweep"]) == ("done", "7", "9")


def test_line__of_an_attempt_names_its_run_or_sweep(lines: Lines) -> None:
    for lease in (lease_of(), lease_of(kind=Kind.PUBLISH, sweep_id="9")):
        extra = {**logs.about(lease), "secret": "whp_1"}  # which is no field of a line
        logging.getLogger("service").info("done", extra=extra)
    of_run, of_sweep = lines()
    assert (of_run["run"], of_run["attempt"]) == (run_id(7), 1)
    assert (of_sweep["sweep"], of_sweep["attempt"]) == ("9", 1)
    assert not {"secret", "sweep"} & of_run.keys()
    assert not {"secret", "run"} & of_sweep.keys()


def test_others__are_heard_from_warnings_on(lines: Lines) -> None:
    logging.getLogger("distributed.nanny").setLevel(logging.INFO)  # as it does itself
    logging.getLogger("distributed.nanny").info("chatter")
    logging.getLogger("distributed").warning("trouble")
    warnings.warn("old way", DeprecationWarning, stacklevel=1)
    assert [line["message"] for line in lines() if line["logger"] == "distributed"] == ["trouble"]
    assert not [line for line in lines() if line["message"] == "chatter"]


def test_equal_warnings__are_one_line_and_then_one_with_their_number(
    lines: Lines, monkeypatch: pytest.MonkeyPatch
) -> None:
    dispatcher = logging.getLogger("service.queue.dispatcher")
    for _ in range(300):
        dispatcher.warning("the database cannot be used now: %s", "full")
        dispatcher.info("done")
    monkeypatch.setattr(logs, "REPEAT_SECONDS", 0.0)
    dispatcher.warning("the database cannot be used now: %s", "locked")
    full = "the database cannot be used now: full"
    assert [line["message"] for line in lines() if "full" in line["message"]] == [full, f"299 times more: {full}"]
    assert sum(line["message"] == "done" for line in lines()) == 300
    assert sum("locked" in line["message"] for line in lines()) == 1


def test_equal_warnings__are_counted_in_a_last_line_at_the_end_and_begin_anew_after_a_pause(
    lines: Lines, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(logs, "REPEAT_SECONDS", 0.0)
    for _ in range(2):
        logging.getLogger("service").warning("trouble")
    assert [line["message"] for line in lines()] == ["trouble"] * 2
    monkeypatch.setattr(logs, "REPEAT_SECONDS", 60.0)
    for _ in range(3):
        logging.getLogger("service").warning("trouble")
    next(each for each in logging.getLogger().handlers if isinstance(each, logs.CountingHandler)).close()
    assert [line["message"] for line in lines()] == [*["trouble"] * 2, "3 times more: trouble"]


def test_request__is_a_line_with_route_status_and_seconds(api: Api, lines: Lines) -> None:
    id = api.submit()
    key = api.store.keys.issue("anna", [Scope.READ])[1]
    headers = {"X-Request-ID": "night.7", "Authorization": f"Bearer {key}"}
    api.http.get(f"/v1/sweeps/{id}?cursor=secret", headers=headers)
    submitted, shown = of_requests(lines)
    assert (submitted["method"], submitted["status"]) == ("POST", 202)
    assert (shown["route"], shown["status"], shown["sweep"]) == ("/v1/sweeps/{id}", 200, id)
    assert (shown["request_id"], shown["caller"]) == ("night.7", "anna")
    assert "caller" not in submitted  # by a user of this machine
    assert 0 < shown["seconds"] < 60
    assert "secret" not in json.dumps(shown)


def test_request__that_fails_has_its_id_on_every_line(api: Api, lines: Lines, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(id: str) -> None:
        logging.getLogger("service.store").warning("about to fail")
        raise RuntimeError("out of order")

    monkeypatch.setattr(api.store.sweeps, "get_with_files", broken)
    answer = api.http.get("/v1/sweeps/7", headers={"X-Request-ID": "night.8"})
    assert answer.status_code == 500
    assert answer.json()["request_id"] == "night.8"
    of_request = [line for line in lines() if line.get("request_id") == "night.8"]
    assert of_request[0]["message"] == "about to fail"
    assert any("out of order" in line.get("trace", "") for line in of_request)
    assert of_requests(lines)[-1]["status"] == 500


def test_request__of_what_is_not_there_is_a_line_without_what_was_written(api: Api, lines: Lines) -> None:
    api.http.get("/a/secret/path")
    api.http.get("/v1/sweeps/" + "x" * 500)
    unknown, long = of_requests(lines)
    assert unknown["route"] == "unknown"
    assert "secret" not in json.dumps(unknown)
    assert len(long["sweep"]) <= 64
