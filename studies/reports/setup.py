"""The set-up of a report's runs before impact, to scale, with its dimensions and what the sweep varies."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import xarray as xr

from studies import scenarios
from studies.cubes.points import by_run, plain
from studies.cubes.variable import variable_name
from studies.quantities.findings import InvalidInput
from studies.quantities.parameters import declared
from studies.quantities.units import readable


def setup_of(dataset: xr.Dataset) -> dict[str, Any] | None:
    """The set-up of the first run: outlines, dimensions, speed and materials; None where the scenario draws none."""
    values = {name: values_of(dataset, name) for name in json.loads(dataset.attrs["vocabulary"])["parameters"]}
    try:
        scenario = scenarios.load(dataset.attrs["scenario"])
    except InvalidInput:  # a scenario of another version
        return None
    return setup(scenario, values)


def setup(scenario: scenarios.Scenario, values: Mapping[str, Sequence[Any]]) -> dict[str, Any] | None:
    """The set-up of the first of the values (SI) of each parameter, as ``setup_of`` gives it."""
    outline = scenario.parameters.outline({name: each[0] for name, each in values.items() if each})
    if outline is None:
        return None
    units = {name: each.unit or "1" for name, each in declared(scenario.parameters).items()}
    names = dict.fromkeys([d.parameter for d in outline.dimensions])
    labels = {name: _label(units[name], values[name]) for name in (*names, "speed") if values.get(name)}
    bodies = [shape.body for shape in outline.shapes if shape.body in scenario.materials]
    materials = {
        body: ", ".join([*map(str, values[body][:3]), *(["…"] if len(values[body]) > 3 else [])])
        for body in bodies
        if values.get(body)
    }
    spoken = [f"{name.replace('_', ' ')} {label}" for name, label in labels.items()]
    spoken += [f"{body} of {text}" for body, text in materials.items()]
    return {
        "outline": asdict(outline),
        "labels": labels,
        "materials": materials,
        "alt": f"The set-up of the first run, to scale: {'; '.join(spoken)}.",
    }


def upward(setup: dict[str, Any] | None) -> float:
    """The factor that makes the coordinate along the line of flight point down: -1 where a body flies against it."""
    shapes = setup["outline"]["shapes"] if setup else ()
    return -1.0 if any((shape["heading"] or (0, 1))[1] < 0 for shape in shapes) else 1.0


def values_of(dataset: xr.Dataset, parameter: str) -> list[float | str]:
    """The values of a parameter over the runs, each once, the first run's first; none where no run has it."""
    name = variable_name(parameter)
    if name not in dataset.variables:
        return []
    values = [plain(value) for value in by_run(dataset, name)]
    return [value for value in dict.fromkeys(values) if value not in ("", "nan") and value == value]


def _label(unit: str, values: Sequence[float | str]) -> str:
    """A length or a speed in the unit that people read, to four digits, with its range where the sweep varies it."""
    ends = (min(map(float, values)), max(map(float, values)))
    low, high = (readable(float(f"{end:.4g}"), unit) for end in ends)
    if low == high:
        return low
    number, _, name = low.partition(" ")
    return f"{number if high.endswith(f' {name}') else low} to {high}"
