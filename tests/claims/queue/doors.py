"""The API and whatever is sent to it: it answers as it is described, and never fails."""

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from importlib import import_module
from itertools import product
from typing import Any
from unittest.mock import patch

from schemathesis.generation import GenerationMode

from tests.acceptance.checks.common import folder
from tests.claims import Row, claim
from tests.service.support.api import open_api
from tests.service.support.databases import postgresql_server


@claim(
    "openapi", says="schemathesis (fixed seed, operations alone and in sequence) finds nothing against the description"
)
def openapi() -> Iterator[Row]:
    tests = _loaded("test_openapi", WHIPPLE_EXAMPLES="60", WHIPPLE_SEQUENCES="60")
    with folder() as place, folder() as sequences, tests.describing(place) as described:
        for operation, mode in product(tests.operations(), GenerationMode):
            check = tests.test_operation__answers_as_it_is_described
            yield _row(f"{operation}, {mode.value} calls", check, described, operation, mode)
        check = tests.test_calls__came_through_to_what_they_asked_for
        yield _row("statuses that were met", check, described)
        check = tests.test_sequences__of_operations_answer_as_they_are_described
        yield _row("sequences of operations", check, described, sequences)


@claim("bodies", says="10 000 bodies that Hypothesis invents are accepted or refused with a reason: none fails")
def bodies() -> Iterator[Row]:
    tests = _loaded("test_bodies", WHIPPLE_BODIES="10000")
    with ExitStack() as ends:
        server = ends.enter_context(postgresql_server())
        urls = {"sqlite": None, "postgresql": ends.enter_context(server.database())}
        for name, url in urls.items():
            place = ends.enter_context(folder())
            api = ends.enter_context(open_api(place, max_runs=200, database_url=url))
            for subject in ("submission__is_accepted_or_refused", "change__is_made_or_refused"):
                yield _row(f"{name}: {subject}", getattr(tests, f"test_any_{subject}"), api)
            yield _row(f"{name}: addresses", tests.test_any_address__has_an_answer, api)


def _loaded(name: str, **environment: str) -> Any:
    """A module of tests of the API, which reads its numbers of examples as it is loaded."""
    import_module("tests.conftest")  # the profile: the same examples every time, and no deadline
    with patch.dict(os.environ, environment):
        return import_module(f"tests.service.api.{name}")


def _row(what: str, check: Callable[..., None], *arguments: Any) -> Row:
    """The findings of a check."""
    try:
        check(*arguments)
    except Exception as error:
        return Row(f"{what}: findings", "none", f"{type(error).__name__}: {error}", passed=False)
    return Row(f"{what}: findings", "none", "none", passed=True)
