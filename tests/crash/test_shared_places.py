"""Strangers and readers who ask without end: the list of another key is there within a second meanwhile."""

import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import psutil
import pytest
from fastapi.sse import EventSourceResponse

from service.api import reading
from service.api.turns import PROBES
from service.conversions import conversions
from service.records.jobs import Keep, Scope
from studies import observations
from tests.claims.marked import Compared
from tests.claims.rows import Row, at_least, at_most, equal
from tests.service.support.api import SWEEP, every_route, sweep_of
from tests.service.support.crowd import answers_of, crowd
from tests.service.support.fakes import issue_key, wait_until
from tests.service.support.serving import Service, serving

STRICT = {"WHIPPLE_TRUST_LOOPBACK": "false", "WHIPPLE_WORKERS": "1", "WHIPPLE_QUOTA_REQUESTS": "1000000"}
FAKES = {"WHIPPLE_TARGETS_MODULE": "tests.service.support.targets"}
LIST_SECONDS = 1.0  # what the list of another key may take
PATIENCE_SECONDS = conversions.WAIT_SECONDS + conversions.SECONDS  # after which the service itself gives up
COMPUTED_SECONDS = 300.0  # for two small runs and their report
PAUSE_SECONDS = 0.1  # between two requests of who is not to wait
LOOP_SECONDS = 30.0
CONVERTING_SECONDS = 300.0  # at most
# Of several thousand points, among them those of SWEEP.
LARGE = sweep_of(
    axes={"speed": {"start": "1000 m/s", "stop": "6000 m/s", "step": "10 m/s"}, "cells_per_diameter": [*range(8, 16)]},
    resolution=None,
)


@contextmanager
def served(place: Path, *names: str, **environment: str) -> Iterator[tuple[Service, dict[str, dict[str, str]]]]:
    """A service that asks everybody for a key, and the headers of some keys with the scope ``submit``."""
    with serving(place / "data", **STRICT, **environment) as service:
        service.wait_until_ready()
        keys = {name: issue_key(service.data, name, Scope.SUBMIT) for name in names}
        keys["operator"] = issue_key(service.data, "operator", Scope.ADMIN)
        yield service, {name: {"Authorization": f"Bearer {key}"} for name, key in keys.items()}


@contextmanager
def client_of(service: Service, headers: Mapping[str, str]) -> Iterator[httpx.Client]:
    limits = httpx.Limits(max_keepalive_connections=0)
    with httpx.Client(base_url=service.url, headers=headers, timeout=PATIENCE_SECONDS, limits=limits) as client:
        yield client


def request_of(path: str, key: str) -> str:
    """The text of a GET with a key."""
    return f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\n{key}\r\nConnection: close\r\n\r\n"


def watched(
    name: str, service: Service, list_of: httpx.Client, texts: Sequence[str], seconds: float
) -> tuple[list[Row], Counter[str]]:
    """What another key and a probe were answered while 64 connections sent some texts, and what those were."""
    statuses: dict[str, set[int]] = {"/v1/sweeps": set(), "/readyz": set()}
    slowest, asked = 0.0, 0
    with crowd(service.port, texts, seconds=seconds) as process:
        while process.poll() is None:
            for path, seen in statuses.items():
                begin = time.monotonic()
                seen.add(list_of.get(path).status_code)
                if path == "/v1/sweeps":
                    slowest, asked = max(slowest, time.monotonic() - begin), asked + 1
            time.sleep(PAUSE_SECONDS)
        answers = answers_of(process)
    rows = [
        at_most(f"{name}: slowest of {asked} lists of another key (s)", limit=LIST_SECONDS, got=slowest),
        *(equal(f"{name}: answers of {path}", expected={200}, got=seen) for path, seen in statuses.items()),
    ]
    return rows, answers


# --- whole requests ---------------------------------------------------------------------------------


def computing_paths(sweep: str, run: str, unfinished: str) -> list[str]:
    """The path of every GET but probes and streams of events; a new route is among them."""
    named = {
        **{"name": "result.json", "view": "cloud", "scenario": "thin_plate"},
        **{"table": observations.names()[0], "order": "cancel"},
    }
    paths = [
        f"/v1/sweeps/{unfinished}/cube.nc?partial=true",
        f"/v1/sweeps/{unfinished}/report.html?partial=true",
        *(f"/shields?speed={speed}+km%2Fs" for speed in (4, 5, 6, 7)),
    ]
    for route in every_route():
        if "GET" not in (route.methods or ()) or route.path in PROBES or route.response_class is EventSourceResponse:
            continue
        values = {**named, "id": run if "/runs/{id}" in route.path else sweep}
        values["name"] = {"histories": "energy", "materials": "al-6061-t6"}.get(
            route.path.split("/")[-2], named["name"]
        )
        paths.append(route.path.format(**values))
    return paths


def state_of(client: httpx.Client, sweep: str) -> str:
    return str(client.get(f"/v1/sweeps/{sweep}").json()["state"])


def submitted(client: httpx.Client, document: Mapping[str, Any], keep: Keep = Keep.NUMBERS) -> str:
    answer = client.post("/v1/sweeps", json=document, params={"keep": keep.value, "priority": 0})
    assert answer.status_code == 202, answer.text
    return str(answer.json()["id"])


@pytest.mark.claim("mend", "reader-loops", minutes=2.5)
def test_loops__of_a_reader_over_every_get_leave_the_list_of_another_below_a_second(
    tmp_path: Path, compared: Compared
) -> None:
    """While a reader asks in 64 loops for everything that computes, the list of another key takes a second at most."""
    with (
        served(tmp_path, "ann", "bob", WHIPPLE_MOST_KEPT="film") as (service, keys),
        client_of(service, keys["ann"]) as ann,
        client_of(service, keys["operator"]) as operator,
    ):
        small = submitted(operator, SWEEP, Keep.FILM)
        wait_until(lambda: state_of(ann, small) == "succeeded", seconds=COMPUTED_SECONDS)
        operator.post("/v1/queue/pause").raise_for_status()
        run = ann.get(f"/v1/sweeps/{small}/runs").json()["items"][0]["run"]["id"]
        paths = computing_paths(small, run, submitted(operator, LARGE))
        key = f"Authorization: {keys['bob']['Authorization']}"
        texts = [request_of(path, key) for path in paths]
        rows, answers = watched(f"64 loops over {len(paths)} paths", service, ann, texts, LOOP_SECONDS)
        compared(*rows)
        good = sum(count for line, count in answers.items() if " 200 " in line)
        compared(at_least(f"answers with 200 to the loops, of {answers.total()}", limit=len(paths), got=good))
        odd = {line for line in answers if " 500 " in line or (" 4" in line and " 429 " not in line)}
        compared(equal("other errors of the loops", expected=set(), got=odd))


# --- conversions ------------------------------------------------------------------------------------

OWN, OTHERS = 12, 4  # sweeps
# Requests of the owner while large cubes are made. Each of these is made once a minute, and takes about as long as one
# of the owner's (10 and 8 s of computing, 2026-11): as many as there are large ones, less those between two of them.
BESIDE = OTHERS // 2


@pytest.mark.claim("mend", "shares-of-conversions", minutes=3.0)
def test_partial_cubes__of_an_owner_are_made_while_a_reader_asks_for_large_ones(
    tmp_path: Path, compared: Compared
) -> None:
    """While a reader loops on the results so far of 4 000 points, an owner gets those of 40 runs each time."""
    with (
        served(tmp_path, "ann", "bob", **FAKES) as (service, keys),
        client_of(service, keys["ann"]) as ann,
        client_of(service, keys["operator"]) as operator,
    ):
        small = submitted(operator, SWEEP)
        wait_until(lambda: state_of(ann, small) == "succeeded", seconds=COMPUTED_SECONDS)
        operator.post("/v1/queue/pause").raise_for_status()
        speeds = [f"{speed} km/s" for speed in (3, 6, *(4 + number / 100 for number in range(38)))]
        own = [
            submitted(ann, sweep_of(title=f"own {number}", axes={"speed": speeds}, resolution=8))
            for number in range(OWN)
        ]
        large = [submitted(operator, {**LARGE, "title": f"large {number}"}) for number in range(OTHERS)]
        key = f"Authorization: {keys['bob']['Authorization']}"
        texts = [request_of(f"/v1/sweeps/{id}/cube.nc?partial=true", key) for id in large]
        statuses, nice, beside = Counter[int](), set[int](), 0
        with crowd(service.port, texts, seconds=CONVERTING_SECONDS, count=2) as process:
            wait_until(lambda: _conversions(service), seconds=PATIENCE_SECONDS)
            for id in own:
                others = _conversions(service)
                beside += bool(others)
                nice |= {each.nice() for each in others}
                statuses[ann.get(f"/v1/sweeps/{id}/cube.nc", params={"partial": "true"}).status_code] += 1
            process.kill()
        compared(equal("answers to the owner", expected={200: OWN}, got=dict(statuses)))
        compared(at_least("requests of the owner while a large cube was made", limit=BESIDE, got=beside))
        compared(at_least("niceness of the children", limit=reading.NICENESS, got=min(nice, default=-1)))
        with client_of(service, keys["bob"]) as bob:
            again = [bob.get(f"/v1/sweeps/{large[0]}/cube.nc", params={"partial": "true"}) for _ in range(2)]
        compared(equal("a large cube, asked for twice", expected=[200, 200], got=[each.status_code for each in again]))
        tags = {each.headers["ETag"] for each in again}
        compared(equal("its entity tags", expected=1, got=len(tags)))
        compared(at_most("its age (s)", limit=conversions.PART_SECONDS, got=float(again[1].headers["Age"])))


def _conversions(service: Service) -> list[psutil.Process]:
    """The children that make files."""
    children = psutil.Process(service.pid).children()
    return [each for each in children if conversions.__name__ in " ".join(_command(each))]


def _command(process: psutil.Process) -> list[str]:
    try:
        return process.cmdline()
    except psutil.NoSuchProcess:
        return []
