"""The model part of an uncertainty: what strength, failure and equation of state leave open.

It stands apart from the numerical error bar. Its contributions come from stored sensitivities (``sensitivities.json``,
written by ``python -m docs.model_part``) or from screening runs of the sweep itself (``studies.sweeps.screening``).
"""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from studies.cubes.cells import MISSING, Cell
from studies.runs.results import RunResult
from studies.sweeps.screening import CONTRIBUTIONS, contributions_of

STORED = Path(__file__).with_name("sensitivities.json")
NOT_ASSESSED = "not assessed"
BASE = "default"  # among the stored answers, before any change
ROUND_OFF = 1e-9  # relative

Assess = Callable[[Cell, str], "ModelPart"]


@dataclass(frozen=True)
class ModelPart:
    """What the choice of models leaves open of one value."""

    uncertainty: float | None  # standard, in the unit of the quantity; None: not assessed
    reason: str  # the contributions with their source, or why there are none
    shares: Mapping[str, float] = field(default_factory=dict)  # relative, by contribution
    # Largest factor by which the run is outside of the speeds and t/d of what is stored; 1: inside; None: not stored.
    distance: float | None = None
    alloy: str = ""  # of what is stored, where it is not that of the run


def assessment(sweep: Any, results: Mapping[str, RunResult]) -> Assess:
    """The function that assesses a quantity of a cell, by the sweep's ``model_part``."""
    if sweep.model_part == "none":
        return lambda cell, quantity: ModelPart(None, f"{NOT_ASSESSED}: model_part is none")
    if sweep.model_part == "screen":
        screened = _Screened(sweep, results)
        return lambda cell, quantity: _part(cell, quantity, *screened.shares(quantity))
    return _stored


def _part(cell: Cell, quantity: str, shares: Mapping[str, float], source: str) -> ModelPart:
    """The model part of a value from relative contributions."""
    measured = cell.measured(quantity)
    if not shares or measured is None or measured.value is None:
        return ModelPart(None, f"{NOT_ASSESSED}: {source}" if not shares else "")
    texts = [
        f"{name} {100.0 * shares[name]:.2g} %" if name in shares else f"{name} {NOT_ASSESSED}" for name in CONTRIBUTIONS
    ]
    uncertainty = abs(measured.value) * math.hypot(*shares.values())
    return ModelPart(uncertainty, f"{', '.join(texts)} ({source})", shares)


# ---- stored --------------------------------------------------------------------------------------


@cache
def classes() -> list[Mapping[str, Any]]:
    """What is stored: answers of the runs of a metal in a scenario, by quantity, change and speed."""
    classes: list[Mapping[str, Any]] = json.loads(STORED.read_text(encoding="utf-8"))
    return classes


def _stored(cell: Cell, quantity: str) -> ModelPart:
    """The model part of a value by the stored answers of its metal, at its speed.

    A contribution that the metal has no sources for is that of the first metal of its family that has them.
    """
    if not cell.is_resolved:
        return ModelPart(None, "")
    scenario, target = cell.run.scenario, cell.run.materials.get("target", {})
    alike = [
        each
        for each in classes()
        if (each["scenario"], each["family"]) == (scenario, target.get("family")) and quantity in each["quantities"]
    ]
    if not alike:
        metal = target.get("name", "no target")
        return _part(cell, quantity, {}, f"nothing is stored for {quantity} of {scenario} in {metal}")
    alike.sort(key=lambda each: bool(each["alloy"] != target.get("alloy")))  # its own alloy first
    parameters, entry = cell.run.parameters, alike[0]
    shares: dict[str, float] = {}
    borrowed = []
    for each in alike:
        more = stored_shares(each, quantity, float(parameters.get("speed") or each["speeds"][0]))
        for name in more.keys() - shares.keys():
            shares[name] = more[name]
            borrowed += [f"{name} of {each['material']}"] if each is not entry else []
    ratio = _thickness_ratio(entry["parameters"])
    plate = "" if ratio is None else f"t/d {ratio:g}, "
    speeds = f"{min(entry['speeds']) / 1e3:g} to {max(entry['speeds']) / 1e3:g} km/s"
    cells = f"{entry['parameters']['cells_per_diameter']:g} cells a diameter"
    metal = ", ".join([entry["material"], *borrowed])
    source = f"stored: {metal} at {plate}{speeds}, {cells}, physics {entry['physics']}, {entry['command']}"
    alloy = "" if entry["alloy"] == target.get("alloy") else str(entry["alloy"])
    return replace(_part(cell, quantity, shares, source), distance=_distance(parameters, entry), alloy=alloy)


def stored_shares(entry: Mapping[str, Any], quantity: str, speed: float) -> dict[str, float]:
    """The contributions to a quantity at a speed (m/s), each linear between the stored speeds that have it."""
    answers = entry["quantities"][quantity]
    at_speeds = [
        contributions_of(base, {name: v[place] for name, v in answers.items() if name != BASE and v[place] is not None})
        for place, base in enumerate(answers[BASE])
        if base
    ]
    speeds = [speed for speed, base in zip(entry["speeds"], answers[BASE], strict=True) if base]
    shares = {}
    for name in CONTRIBUTIONS:
        told = [(stored, each[name]) for stored, each in zip(speeds, at_speeds, strict=True) if name in each]
        if told:
            at, values = np.array(told).T
            shares[name] = float(np.interp(speed, at, values))
    return shares


def _distance(parameters: Mapping[str, Any], entry: Mapping[str, Any]) -> float | None:
    """The largest factor between speed and t/d of a run and the nearest of an entry; 1 inside, None without both."""
    measured, ratio = _thickness_ratio(entry["parameters"]), _thickness_ratio(parameters)
    sides = ((parameters.get("speed"), min(entry["speeds"]), max(entry["speeds"])), (ratio, measured, measured))
    factors = [max(low / value, value / high) for value, low, high in sides if value and low and high]
    return max((factor if factor > 1.0 + ROUND_OFF else 1.0 for factor in factors), default=None)


def _thickness_ratio(parameters: Mapping[str, Any]) -> float | None:
    """Thickness of a thin plate over the diameter of its projectile."""
    thickness, diameter = parameters.get("plate_thickness"), parameters.get("projectile_diameter")
    return thickness / diameter if thickness and diameter else None


# ---- screened ------------------------------------------------------------------------------------


class _Screened:
    """The answers of the screening runs of a sweep."""

    def __init__(self, sweep: Any, results: Mapping[str, RunResult]) -> None:
        self.middle, self.screens = sweep.screening()
        self.results = results

    def shares(self, quantity: str) -> tuple[Mapping[str, float], str]:
        """The contributions to a quantity, and where they come from; without any, why."""
        base = self._value(self.middle.id, quantity)
        if not base:
            return {}, "the run at the middle of the sweep has no value"
        answers, lacking = {}, []
        for screen in self.screens:
            value = None if screen.run is None else self._value(screen.run.id, quantity)
            if value is not None:
                answers[screen.name] = value
            else:
                lacking.append(f"{screen.name}: {screen.reason or 'its screening run has no value'}")
        text = "screening runs at the middle of the sweep"
        return contributions_of(base, answers), "; ".join([text, *lacking])

    def _value(self, run_id: str, quantity: str) -> float | None:
        result = self.results.get(run_id, MISSING)
        measured = result.measurements.get(quantity)
        return measured.value if measured is not None and result.state == "succeeded" else None
