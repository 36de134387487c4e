"""Whatever is sent, the answer is clear: accepted, or refused with a reason, and never a failure."""

import json
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.service.support.api import SWEEP, Api, open_api

FEW, MANY = 40, 10_000  # bodies for a service on each database, the same each time; many for the claim
JSON, YAML = "application/json", "application/yaml"
REFUSALS = (413, 415, 422)

NUMBERS = st.integers() | st.floats() | st.sampled_from([10**400, -(10**30), 1e308, -0.0])
UNITS = ("km/s", "mm", "%", "", "m^m", "K**9", "Δ", "m/0", "degC")
NAMES = st.sampled_from(
    [
        *(*SWEEP, *SWEEP["fixed"], "speed", "materials", "observations", "combine", "offsets", "accuracy", "recipe"),
        *("target.strength.A", "target.", ".", "start", "stop", "step", "count", "__class__", "taylor_bar", "zip"),
    ]
)
QUANTITIES = st.builds("{} {}".format, NUMBERS, st.sampled_from(UNITS))
SCALARS = st.none() | st.booleans() | NUMBERS | QUANTITIES | NAMES | st.text(max_size=8)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(NAMES | st.text(max_size=8), inner, max_size=4),
    max_leaves=12,
)


@st.composite
def changed_sweeps(draw: st.DrawFn) -> Any:
    """The sweep of the tests with some of it replaced or added."""
    document: dict[str, Any] = json.loads(json.dumps(SWEEP))
    places = [document, document["fixed"], document["axes"]]
    for place in draw(st.lists(st.sampled_from(places), min_size=1, max_size=3)):
        place[draw(NAMES)] = draw(VALUES)
    return document


DOCUMENTS = changed_sweeps() | VALUES
TEXTS = DOCUMENTS.map(json.dumps) | DOCUMENTS.map(lambda document: yaml.safe_dump(document, allow_unicode=True))
SIGNS = st.text(alphabet="{}[]:-&*!|>%@`'\"\\ \n\t#,?ab01.e+~\0\ufeff\u2028", max_size=60)


@st.composite
def damaged_texts(draw: st.DrawFn) -> bytes:
    """A document with a piece of it cut out, or something put in."""
    body = draw(TEXTS).encode("utf-8", "surrogatepass")
    first, last = sorted(draw(st.tuples(*[st.integers(0, len(body))] * 2)))
    return body[:first] + draw(st.binary(max_size=6)) + body[draw(st.sampled_from([first, last])) :]


BODIES_SENT = st.one_of(
    (TEXTS | SIGNS).map(lambda text: text.encode("utf-8", "surrogatepass")), damaged_texts(), st.binary(max_size=100)
)
MEDIA_TYPES = st.sampled_from(
    [JSON, YAML, "text/yaml", "application/json; charset=utf-16", "text/plain", "", "a/b;;", "JSON"]
)
QUERIES = st.fixed_dictionaries(
    {},
    optional={
        "priority": st.integers(-200, 200).map(str) | st.text(max_size=5),
        "keep": st.sampled_from(["numbers", "final", "film", "all", ""]),
        "verdicts": st.text(max_size=3),
    },
)
KEYS = st.none() | st.sampled_from(["k1", "k2", '"k1"', "", " "]) | st.text(max_size=5)


@pytest.fixture(scope="module", params=["sqlite", "postgresql"])
def api(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Api]:
    """A service on each database: what the one takes as text, the other may not."""
    with ExitStack() as ends:
        url = None
        if request.param == "postgresql":
            url = ends.enter_context(request.getfixturevalue("postgresql").database())
        folder = tmp_path_factory.mktemp("bodies")
        yield ends.enter_context(open_api(folder, max_runs=200, database_url=url))


def is_clear(response: Any) -> bool:
    """Whether a refusal says what is wrong, and what to do."""
    problem = response.json()
    told = all(error[word] for error in problem.get("errors", ()) for word in ("limit", "cure"))
    return problem["status"] == response.status_code and bool(problem["detail"]) and told


def submit_any(api: Api, count: int) -> None:
    """Submit so many bodies; each is accepted, or refused with a reason and nothing stored."""

    @settings(max_examples=count, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
    @given(body=BODIES_SENT, media_type=MEDIA_TYPES, query=QUERIES, key=KEYS, estimate=st.booleans())
    def check(body: bytes, media_type: str, query: dict[str, str], key: str | None, estimate: bool) -> None:
        headers = {b"Content-Type": media_type.encode()}
        if key is not None:
            headers[b"Idempotency-Key"] = key.encode("utf-8", "surrogatepass").translate(None, b"\r\n\0")
        before = api.store.events.last()
        path = "/v1/sweeps/estimate" if estimate else "/v1/sweeps"
        response = api.http.post(path, content=body, headers=headers, params=query)
        if response.is_success:
            assert response.status_code in (200, 202)
        else:
            assert response.status_code in REFUSALS, (body, response.text)
            assert is_clear(response), (body, response.text)
            assert api.store.events.last() == before, "something was stored"

    check()


def test_anything__sent_is_accepted_or_refused(api: Api) -> None:
    submit_any(api, FEW)


@pytest.mark.claim("api", "bodies", minutes=30.0)
def test_bodies__by_the_thousand_are_accepted_or_refused(api: Api) -> None:
    """20 000 bodies that Hypothesis invents are accepted or refused with a reason: none fails."""
    submit_any(api, MANY)
