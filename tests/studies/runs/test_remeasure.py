"""Stored final states read again: by today's definitions, with what a state cannot tell said, and nothing solved."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from solver import simulation
from studies import measurements, scenarios
from studies.measurements import Measurement, Reading
from studies.runs import execution
from studies.runs.remeasure import NEEDS_SOLVING, definitions, load_state, outdated, remeasure, versions_of
from studies.runs.results import RunResult
from tests.samples import needs
from tests.studies.runs.solved import RUNS, asked, solved, stored

Patch = Callable[..., None]
WHO = "the tests"
VERSION = measurements.load("hole_diameter").version


@pytest.fixture
def patched(monkeypatch: pytest.MonkeyPatch) -> Patch:
    """Give a measurement another version, and another definition if there is one; afterwards nothing is solved."""
    for scenario in RUNS:
        solved(scenario)
    plain = measurements.load
    changed: dict[str, Measurement] = {}
    monkeypatch.setattr(measurements, "load", lambda name: changed.get(name) or plain(name))
    for module in (execution, simulation):
        monkeypatch.setattr(module, "simulate", _never)

    def change(name: str, *, definition: Callable[[object], Reading] | None = None) -> None:
        now = measurements.load(name)
        changed[name] = replace(now, version=now.version + 1, definition=definition or now.definition)

    return change


def _never(*_: object, **__: object) -> None:
    raise AssertionError("something was solved")


def result_in(scenario: str) -> RunResult:
    return RunResult.from_json(stored(solved(scenario)))


def again(scenario: str, before: RunResult | None = None) -> RunResult:
    return remeasure(asked(scenario), before or result_in(scenario), solved(scenario) / "state.npz", by=WHO)


@pytest.mark.parametrize("scenario", sorted(RUNS))
def test_reading__of_a_stored_state_gives_the_same_bits_as_the_solver_did(scenario: str, patched: Patch) -> None:
    before = result_in(scenario)
    of_a_state = [name for name in before.measurements if not measurements.load(name).follows]
    for name in of_a_state:
        patched(name)
    renewed = again(scenario).measurements
    for name in of_a_state:
        was, now = before.measurements[name], renewed[name]
        parts = {part: size for part, size in was.parts.items() if part != "growth"}
        assert (now.value, now.parts, now.version) == (was.value, parts, was.version + 1)
        assert now.history == {"time": [before.numbers["end_time"]], "value": [was.value]}
        # A state says nothing of growth.
        assert {*now.flags} == {*was.flags, NEEDS_SOLVING} - {"still_growing"}


@needs("taylor_bar")
def test_bar__without_reference_sizes_has_no_error_and_nothing_to_read_again() -> None:
    bar = result_in("taylor_bar")
    assert "taylor_error" not in bar.measurements
    assert "taylor_error" not in outdated("taylor_bar", versions_of(bar))
    references = {"reference_length": 16e-3, "reference_diameter": 13e-3, "reference_width": 10e-3}
    assert "taylor_error" in scenarios.load("taylor_bar").measured_in(asked("taylor_bar", **references).parameters)


def test_nothing__changed_leaves_the_result_as_it_is() -> None:
    before = result_in("thin_plate")
    assert remeasure(asked("thin_plate"), before, Path("nowhere"), by=WHO) is before


def test_definition__that_changed_gives_its_values_and_the_rest_stays(patched: Patch) -> None:
    patched("hole_diameter", definition=lambda view: Reading(float(view.mass.sum()), {"resolution": 0.5}))
    before, after = result_in("thin_plate"), again("thin_plate")
    state = load_state(solved("thin_plate") / "state.npz")
    assert after.measurements["hole_diameter"].value == pytest.approx(state.particles.mass.sum())
    assert RunResult.from_json(json.loads(json.dumps(after.as_json(), allow_nan=False))) == after
    others = {name: each for name, each in after.measurements.items() if name != "hole_diameter"}
    assert others == {name: before.measurements[name] for name in others}
    entry = after.provenance.pop("remeasured")  # type: ignore[attr-defined]
    assert entry == f"hole_diameter {VERSION} to {VERSION + 1} by {WHO}"
    assert after.provenance == before.provenance
    assert replace(after, measurements={}) == replace(before, measurements={})


@pytest.mark.parametrize(
    "scenario", [pytest.param(name, marks=needs(name)) for name in ("elastic_bar", "plate_impact")]
)
def test_follower__that_changed_keeps_its_value_and_says_that_it_needs_solving(scenario: str, patched: Patch) -> None:
    name = next(name for name in definitions(scenario) if measurements.load(name).follows)
    before = result_in(scenario).measurements[name]
    patched(name)
    result = again(scenario)
    kept = result.measurements[name]
    assert (kept.value, kept.version) == (before.value, before.version)
    assert kept.flags == (*before.flags, NEEDS_SOLVING)
    assert outdated(scenario, versions_of(result)) == ()
