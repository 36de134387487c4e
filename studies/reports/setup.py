"""The set-up of a report's runs before impact, to scale, with its dimensions and what the sweep varies."""

import json
from collections.abc import Mapping, Sequence

import xarray as xr

from studies import scenarios
from studies.cubes.points import by_run, plain
from studies.cubes.variable import variable_name
from studies.quantities.parameters import Value, declared
from studies.quantities.units import readable
from studies.reports.sections.pictures import DrawnSetUp


def setup_of(dataset: xr.Dataset) -> DrawnSetUp | None:
    """The set-up of the first run: outlines, dimensions, speed and materials; None where the scenario draws none."""
    values = {name: _values_of(dataset, name) for name in json.loads(dataset.attrs["vocabulary"])["parameters"]}
    return setup(scenarios.load(dataset.attrs["scenario"]), values)


def setup(scenario: scenarios.Scenario, values: Mapping[str, Sequence[Value]]) -> DrawnSetUp | None:
    """The set-up of the first of the values (SI) of each parameter, as ``setup_of`` gives it."""
    outline = scenario.parameters.outline({name: several[0] for name, several in values.items() if several})
    if outline is None:
        return None
    units = {name: parameter.unit or "1" for name, parameter in declared(scenario.parameters).items()}
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
    return DrawnSetUp(outline, labels, materials, f"The set-up of the first run, to scale: {'; '.join(spoken)}.")


def _values_of(dataset: xr.Dataset, parameter: str) -> list[float | str]:
    """The values of a parameter over the runs, each once, the first run's first; none where no run has it."""
    name = variable_name(parameter)
    if name not in dataset.variables:
        return []
    values = [plain(value) for value in by_run(dataset, name)]
    return [value for value in dict.fromkeys(values) if value not in ("", "nan") and value == value]


def _label(unit: str, values: Sequence[Value]) -> str:
    """A length or a speed in the unit that people read, to four digits, with its range where the sweep varies it."""
    numbers = [float(value) for value in values if value is not None]
    low, high = (readable(float(f"{end:.4g}"), unit) for end in (min(numbers), max(numbers)))
    if low == high:
        return low
    number, _, name = low.partition(" ")
    return f"{number if high.endswith(f' {name}') else low} to {high}"
