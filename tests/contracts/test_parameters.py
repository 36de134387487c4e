"""Every parameter that a scenario takes for a method changes its runs, or is refused, or makes no new run."""

import hashlib
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from studies import scenarios
from studies.quantities.findings import InvalidInput
from studies.quantities.parameters import Parameter, declared
from studies.runs.run import Run
from tests import samples
from tests.claims.rows import Row, equal
from tests.contracts.test_scenarios import asked, built, given_of
from tests.solver.bodies import after

STEPS = 12
# What needs longer than these steps to act, by what it changes: seen in the problem.
LATER = {
    "failure": "damage takes a part of the impact",
    "failure_strain": "as failure",
    "failure_time": "as failure",
    "rubble_friction": "as failure",
    "tension": "waves have not come back from a free surface",
    "thermal_softening": "matter has to be hot",
    "step_rule": "the first steps grow to the stable one",
    "travel": "as step_rule",
    "friction": "bodies have not met",
    "contact": "as friction",
    "artificial_stress": "particles have to be in tension",
}
# They change no state: a preset is told by what it fills in, and a film shows a run.
NO_CONTENT = ("recipe", "film_interval")
SMOOTHED = samples.joined("SMOOTHED", {})


def methods() -> list[tuple[str, str]]:
    return [
        (name, method)
        for name in scenarios.names()
        for chosen in [declared(scenarios.load(name).parameters).get("method")]
        for method in (chosen.choices if chosen else ("",))
    ]


each_method = pytest.mark.parametrize(("name", "method"), methods(), ids=lambda text: text or "alone")


def base(name: str, method: str) -> dict[str, Any]:
    """What a small run of a method states."""
    if not method:
        return {}
    smoothed = {"geometry": "quarter", **SMOOTHED.get(name, {})} if method != "mpm" else {}
    return {"method": method, **smoothed}


def state(run: Run) -> tuple[str, str, str]:
    """Digest of a run after some steps; then its grid, faces, end and observation; then what acts later."""
    setting = built(run)
    problem = setting.problem
    digest = hashlib.sha256()
    for array in after(problem, STEPS).snapshot().particles:
        digest.update(np.ascontiguousarray(array).tobytes())
    seen = problem.geometry, problem.faces, problem.end_time, problem.retirement
    return (
        digest.hexdigest(),
        repr((seen, given_of(run).rate(setting), vars(setting) | {"problem": None})),
        repr(
            (
                [body.matter for body in problem.bodies],
                problem.step_rule,
                problem.travel,
                problem.contact,
                problem.smoothing,
            )
        ),
    )


def others(parameter: Parameter, value: Any) -> Iterator[Any]:
    low, high = parameter.minimum or 0.0, parameter.maximum or 0.0
    if parameter.kind == "choice":
        yield from (choice for choice in parameter.choices if choice != value)
    elif parameter.kind == "boolean":
        yield not value
    elif parameter.kind == "integer":
        yield from (each for each in range(1, 5) if each != value and low <= each <= high)
    elif parameter.kind == "quantity" and value:
        yield from (x for part in (1.1, 0.9, 1.5, 0.5) if low <= (x := part * value) <= high)
    elif parameter.kind == "quantity":
        yield from [math.sqrt(low * high)] if low > 0.0 else [part * high for part in (0.1, 1e-6)]


def varied(name: str, method: str) -> Iterator[tuple[str, Run]]:
    """The runs that differ from the small one in one parameter and are accepted; a number takes its first value."""
    start_of, chosen = base(name, method), scenarios.load(name).parameters
    first = asked(name, **start_of)
    for parameter in declared(chosen).values():
        if parameter.name in NO_CONTENT or parameter.name == "method":
            continue
        for value in others(parameter, first.parameters[parameter.name]):
            try:
                run = asked(name, **{**start_of, parameter.name: value})
            except InvalidInput:
                continue
            yield parameter.name, run
            if parameter.kind != "choice":
                break


@each_method
def test_parameter__makes_a_new_run_where_it_acts(name: str, method: str) -> None:
    first = asked(name, **base(name, method))
    for parameter, run in varied(name, method):
        assert (run.id != first.id) == (run.parameters != first.parameters), parameter
        assert run.parameters[parameter] is not None or run.id == first.id, parameter


@pytest.mark.claim("mend-again", "parameters-act", minutes=8.0)
@each_method
def test_parameter__changes_its_run_or_makes_no_new_one(
    name: str, method: str, compared: Callable[[Row], None]
) -> None:
    """A parameter that a scenario takes for a method changes its state or what is observed, or makes no new run."""
    first = asked(name, **base(name, method))
    before = state(first)
    for parameter, run in varied(name, method):
        after = state(run)
        acts = parameter in LATER and run.parameters[parameter] is not None
        places = (0, 1, 2) if acts else (0, 1)
        changed = any(before[place] != after[place] for place in places)
        where = f"{name} {method}, {parameter} {run.parameters[parameter]}: a new run"
        compared(equal(where, expected=changed, got=run.id != first.id))
