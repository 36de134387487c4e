"""A run: its identity, what it refuses, and its cost."""

import dataclasses
import json
import math
from collections.abc import Callable
from typing import Any

import pytest

from studies import materials
from studies.materials import Material
from studies.materials.schema import NOT_SIMULATED, OF_OPENING
from studies.quantities.findings import InvalidInput
from studies.quantities.numerical_defaults import RECIPES
from studies.runs.run import Run, resolve
from studies.scenarios.parts.shot import WINDOW_PER_DIAMETER
from tests.contracts.test_scenarios import SMALL

COPPER = materials.load("copper-ofhc")
PLATE = SMALL["thin_plate"]


def asked(
    scenario: str = "thin_plate", *, target: Material = COPPER, projectile: Material = COPPER, **changes: Any
) -> Run:
    """A small impact, with some parameters changed; a parameter that is ``...`` is left out."""
    values = {name: value for name, value in {**SMALL[scenario], **changes}.items() if value is not ...}
    return resolve(scenario, values, {"projectile": projectile, "target": target})


def refused(scenario: str = "thin_plate", **changes: Any) -> list[str]:
    with pytest.raises(InvalidInput) as caught:
        asked(scenario, **changes)
    return [finding.field for finding in caught.value.findings]


# Identity; that of every parameter is a contract (tests/contracts/test_parameters.py).


OURS = {"projectile": COPPER, "target": COPPER}
SAME: dict[str, Callable[[], Run]] = {
    "order": lambda: resolve("thin_plate", dict(reversed(PLATE.items())), OURS),
    "JSON": lambda: Run.from_json(json.loads(json.dumps(asked().as_json(), allow_nan=False))),
    "defaults spelled out": lambda: asked(courant=RECIPES["whipple"].courant, geometry="axisymmetric", stop="settled"),
    "whole number": lambda: asked(speed=3000),
    "beyond 12 digits": lambda: asked(speed=3000.0 * (1.0 + 1e-14)),
    "constant beyond 12 digits": lambda: asked(target=COPPER.with_value("strength.A", 90e6 * (1.0 + 1e-14))),
    "name of a material": lambda: asked(target=dataclasses.replace(COPPER, name="cu", title="My", family="red")),
    "name in a parameter": lambda: resolve("thin_plate", {**PLATE, "projectile": "cu", "target": "cu"}, OURS),
    "numbers for laws alone": lambda: asked(
        target=dataclasses.replace(COPPER, yield_stresses=(), brinell_hardness=40.0)
    ),
}


@pytest.mark.parametrize("same", SAME)
def test_identity__of_the_same_problem_is_the_same(same: str) -> None:
    assert SAME[same]().id == asked().id
    assert len(asked().id) == 32


STATED = {path for path in COPPER.paths() if COPPER.value_at(path)}  # no zero


@pytest.mark.parametrize("path", sorted(STATED - {*NOT_SIMULATED}))
def test_identity__is_changed_by_every_physical_constant_of_each_material(path: str) -> None:
    value = COPPER.value_at(path)
    assert value is not None
    less = path == "thermal.solidus"  # which no constant may lie below
    other = COPPER.with_value(path, value * (1.0 - 1e-9 if less else 1.0 + 1e-9))
    opens = path.removeprefix("thermal.") in OF_OPENING
    rule = "opening" if opens else ...
    pairs = [(COPPER, COPPER), (other, COPPER), (COPPER, other)]
    assert len({asked(tension=rule, projectile=one, target=another).id for one, another in pairs}) == 3
    assert (asked().id == asked(target=other).id) == opens, "matter that does not open does not take them"


def test_identity__has_none_of_what_does_not_act() -> None:
    idle = {name for name, value in asked(fixed_dt=1e-9, courant=0.2).parameters.items() if value is None}
    assert idle >= {"courant", "travel", "step_rule", "damping_order", "beyond_edge", "failure_strain"}
    assert asked(fixed_dt=1e-9, courant=0.2).id == asked(fixed_dt=1e-9).id
    added = Run(asked().scenario, {**asked().parameters, "failure_added": None}, asked().materials)
    assert added.id == asked().id


# Refusals


@pytest.mark.parametrize("value", [-3000.0, 0.0, math.nan, 1e9, "fast", None, True, ...])
def test_resolve__refuses_an_invalid_speed(value: Any) -> None:
    assert refused(speed=value) == ["parameters.speed"]


@pytest.mark.parametrize("scenario", ["thin_plate", "thick_plate"])
@pytest.mark.parametrize("diameter", [1e-3, 8e-3])
def test_resolve__refuses_a_window_below_a_tenth_of_its_default(scenario: str, diameter: float) -> None:
    least = 0.1 * WINDOW_PER_DIAMETER * diameter
    allowed = asked(scenario, settled_window=least, projectile_diameter=diameter).parameters["settled_window"]
    assert allowed == pytest.approx(least)
    for window in (1e-9, 5e-9, 0.99 * least):
        assert refused(scenario, settled_window=window, projectile_diameter=diameter) == ["settled_window"]
