"""The interface against its own description: schemathesis, with fixed seeds, finds nothing.

The service is one that needs a key, so that what is said of keys is looked at too. Runs are computed
by hand between two calls, so that every state of a sweep is met.
"""

import copy
import itertools
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis.errors import Unsatisfiable
from hypothesis.stateful import run_state_machine_as_test
from schemathesis.generation import GenerationMode
from schemathesis.specs.openapi.checks import ensure_resource_availability, positive_data_acceptance

from service.api.app import build_app
from service.records.jobs import Scope
from service.settings import Settings
from tests.claims.marked import Compared
from tests.claims.rows import at_least
from tests.service.support.api import Api, SameFile, open_api, sweep_of
from tests.service.support.fakes import issue_key

HOST = "whipple.example.org"
SEED = 20261121
EXAMPLES = 4  # of each operation
THOROUGH, SEQUENCES = 120, 60  # of them, and of operations one after the other, for the claim
STEPS = 10  # of a sequence
SEEDS = 8  # at most, until the sequences have met every kind of answer
ENDLESS = "/v1/queue/events"  # an answer that does not end; tests/service/events listens to it
ENDED = 4  # sweeps that have ended when the tests begin
SUBMIT, ESTIMATE, DELETE = "POST /v1/sweeps", "POST /v1/sweeps/estimate", "DELETE /v1/sweeps/{id}"
# A schema cannot say which sweeps there are, what a unit is, or that a state allows an order.
EXCLUDED = [positive_data_acceptance]
BUDGET = settings(phases=[Phase.explicit, Phase.generate], suppress_health_check=list(HealthCheck))


@dataclass(frozen=True)
class Described:
    """A service with a sweep in each state, its description, and a key for it."""

    api: Api
    schema: Any
    unguarded: Any  # it says nothing of keys, so that ours is not replaced by invented ones
    sequential: Any  # the same, of the service that is on the stage
    stage: "Stage"
    headers: dict[str, str]
    sweeps: list[str]  # ids
    runs: list[str]
    seen: list[int] = field(default_factory=list)  # status of every answer

    def lead(self, case: Any, number: int, *, rightly: bool) -> None:
        """Let a call come through the door, and, every second one, to something that is there."""
        case.headers.pop("Authorization", None)  # ours is given with each call
        if not rightly or number % 2:
            return
        if case.operation.label in (SUBMIT, ESTIMATE):
            give_a_sweep(case, number)
        elif "id" in (case.path_parameters or {}):
            known = self.runs if "/runs/" in case.operation.path else self.sweeps
            if case.operation.path.endswith("/events"):
                known = known[:ENDED]  # their streams end
            case.path_parameters["id"] = known[number // 2 % len(known)]
            if "name" in case.path_parameters:
                case.path_parameters["name"] = "result.json"


def give_a_sweep(case: Any, number: int) -> None:
    """Let a call submit what can be computed."""
    speed = f"{3 + 0.01 * (number // 2 % 50)} km/s"
    case.body, case.media_type = sweep_of(axes={"speed": [speed]}), "application/json"
    case.headers.pop("Idempotency-Key", None)


class Stage:
    """An app in whose place another can be put."""

    app: Any = None

    async def __call__(self, *message: Any) -> None:
        await self.app(*message)


@pytest.fixture(scope="module")
def described(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Described]:
    with describing(tmp_path_factory.mktemp("described")) as opened:
        yield opened


@contextmanager
def describing(folder: Path) -> Iterator[Described]:
    """A service in a folder, with its description."""
    secret = issue_key(folder, "anna", Scope.ADMIN)
    with open_api(folder, host="0.0.0.0", allowed_hosts=(HOST, "testserver")) as api:
        app: Any = api.http.app
        app.state.conversions = SameFile(folder / "cache")
        app.state.wrong_keys.count = lambda address: (0, 0)  # schemathesis sends wrong keys, and expects 401 of each
        headers = {"Authorization": f"Bearer {secret}", "Host": HOST}
        sweeps, runs = [], []
        for number in range(8):
            body = sweep_of(axes={"speed": [f"{number + 2} km/s"]})
            answer = api.http.post("/v1/sweeps", json=body, headers=headers)
            sweeps.append(answer.json()["id"])
            runs.append(api.store.sweeps.points(sweeps[-1]).items[0].run.id)
            if number < ENDED:
                api.compute(failures=number // 2)
        document, stage = app.openapi(), Stage()
        yield Described(
            api,
            described_by(document, app),
            described_by(without_keys(document), app),
            described_by(without_keys(document), stage).exclude(path_regex="/events$"),
            *(stage, headers, sweeps, runs),
        )


def described_by(document: dict[str, Any], app: Any) -> Any:
    """What schemathesis makes of a description."""
    schema = schemathesis.openapi.from_dict(document)
    schema.app = app
    return schema.exclude(path=ENDLESS)


def without_keys(document: dict[str, Any]) -> dict[str, Any]:
    """A description that says nothing of keys."""
    plain = copy.deepcopy(document)
    for methods in plain["paths"].values():
        for operation in methods.values():
            operation.pop("security", None)
    return plain


def operations() -> dict[str, dict[str, Any]]:
    """Every operation that the interface describes, and its description."""
    app = build_app(Settings(), cast(Any, None), cast(Any, None))
    return {
        f"{method.upper()} {path}": operation
        for path, methods in app.openapi()["paths"].items()
        for method, operation in methods.items()
        if path != ENDLESS
    }


def calls() -> Iterator[tuple[str, GenerationMode]]:
    """Each operation and how it is called: wrongly where more than its path can be wrong, for any text is a path."""
    for label, operation in operations().items():
        yield label, GenerationMode.POSITIVE
        if "requestBody" in operation or any(each["in"] != "path" for each in operation.get("parameters", ())):
            yield label, GenerationMode.NEGATIVE


def call_operation(described: Described, operation: str, mode: GenerationMode, examples: int) -> None:
    """Call an operation rightly or wrongly; each response is as it is described."""
    method, path = operation.split()
    rightly = mode is GenerationMode.POSITIVE
    schema = described.schema if rightly else described.unguarded
    calls = itertools.count()

    @seed(SEED)
    @settings(BUDGET, max_examples=examples)
    @given(case=schema[path][method].as_strategy(generation_mode=mode))
    def check(case: Any) -> None:
        described.lead(case, next(calls), rightly=rightly)
        response = case.call_and_validate(headers=described.headers, excluded_checks=EXCLUDED)
        described.seen.append(int(response.status_code))

    with suppress(Unsatisfiable):  # an operation without parameters cannot be asked wrongly
        check()


@pytest.mark.parametrize(("operation", "mode"), calls())
def test_operation__answers_as_it_is_described(described: Described, operation: str, mode: GenerationMode) -> None:
    call_operation(described, operation, mode, EXAMPLES)


def test_calls__came_through_to_what_they_asked_for(described: Described) -> None:
    """Else the checks above would have seen nothing but refusals at the door."""
    if not described.seen:
        pytest.skip("the calls were not asked for")
    seen = {status: described.seen.count(status) for status in set(described.seen)}
    assert {200, 202, 204, 404, 409, 422} <= set(seen), seen
    assert not {401, 403, 421, 500} & set(seen), seen


@pytest.mark.claim("api", "openapi", minutes=15.0)
def test_openapi__describes_what_schemathesis_meets(described: Described, tmp_path: Path, compared: Compared) -> None:
    """schemathesis (fixed seed, a key, operations alone and in sequence) finds nothing against the description."""
    for operation, mode in itertools.product(operations(), GenerationMode):
        call_operation(described, operation, mode, THOROUGH)
    test_calls__came_through_to_what_they_asked_for(described)
    compared(at_least("calls of operations alone", limit=5_000, got=len(described.seen)))
    call_sequences(described, tmp_path, SEQUENCES)


def call_sequences(described: Described, folder: Path, count: int) -> None:
    """Call sequences of operations; each response is as it is described."""
    seen: set[tuple[str, int]] = set()
    folders = (folder / str(number) for number in itertools.count())

    class Machine(described.sequential.as_state_machine()):  # type: ignore[misc]
        """Each sequence has a service of its own, so that it goes the same way when it is repeated."""

        def setup(self) -> None:
            self.calls = itertools.count()
            self.parts = ExitStack()
            self.api = self.parts.enter_context(open_api(next(folders)))
            app: Any = self.api.http.app
            app.state.conversions = SameFile(self.api.settings.data / "cache")
            described.stage.app = app

        def teardown(self) -> None:
            self.parts.close()

        def before_call(self, case: Any) -> None:
            number = next(self.calls)
            if case.operation.label == SUBMIT:
                give_a_sweep(case, number)
            if number % 3 == 0 or case.operation.label == DELETE:  # what has not ended is not deleted
                self.api.compute(failures=number % 2)

        def get_call_kwargs(self, case: Any) -> dict[str, Any]:
            return {"headers": {"Host": "127.0.0.1"}}

        def validate_response(self, response: Any, case: Any, **given: Any) -> None:
            seen.add((case.operation.label, int(response.status_code)))
            # A sweep that was cancelled before its first result has no files.
            is_file = case.operation.path.endswith((".nc", ".html", ".json"))
            excluded = [*EXCLUDED, ensure_resource_availability] if is_file else EXCLUDED
            case.validate_response(response, excluded_checks=excluded, transport_kwargs=given, recorder=self.recorder)

    for more in range(SEEDS):  # which operations a seed leads to changes with the description
        run_state_machine_as_test(
            seed(SEED + more)(Machine), settings=settings(BUDGET, max_examples=count, stateful_step_count=STEPS)
        )
        if {200, 202, 204, 409} <= {status for _, status in seen}:
            break
    assert {200, 202, 204, 409} <= {status for _, status in seen}, seen
    assert len({label for label, _ in seen}) > 10, seen
