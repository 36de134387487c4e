"""A sweep written as a shot: its parameters stand at the top of the document, as they do in a question to laws."""

from collections.abc import Collection, Mapping
from typing import Any

from studies import scenarios
from studies.laws import target_of
from studies.quantities.parameters import lists_of

ALWAYS = "speed"  # every shot has one, and no sweep has it as a key


def as_sweep(document: Mapping[str, Any], keys: Collection[str]) -> Mapping[str, Any]:
    """The document of a sweep, of either form, whose other ``keys`` stay; the scenario is that of what is hit.

    A shot without lists of values is a sweep over its speed alone.

    >>> shot = {"speed": "6 km/s", "target": "lead", "plate_thickness": ["1 mm", "2 mm"], "resolution": 16}
    >>> as_sweep(shot, ("resolution",))["axes"]
    {'plate_thickness': ['1 mm', '2 mm']}
    """
    if "scenario" in document or ALWAYS not in document:
        return document
    shot = {name: value for name, value in document.items() if name not in keys}
    scenario = target_of(shot).scenario
    lists = lists_of(scenarios.load(scenario).parameters)
    axes = {name: value for name, value in shot.items() if isinstance(value, list | Mapping) and name not in lists}
    axes = axes or {ALWAYS: [shot[ALWAYS]]}
    fixed = {name: value for name, value in shot.items() if name not in axes}
    rest = {name: value for name, value in document.items() if name in keys}
    return {"scenario": scenario, "fixed": fixed, "axes": axes, **rest}
