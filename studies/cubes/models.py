"""The model part of an uncertainty: what strength, failure and equation of state leave open.

It stands apart from the numerical error bar. Strength and equation of state make a symmetric part. Failures make a
one-sided part: how much smaller and larger the value becomes with each other failure that the rule of docs/failure.md
leaves; those that it throws out are named and not counted. Both come from stored sensitivities
(``sensitivities.json``, written by ``python -m docs.model_part``) or from screening runs of the sweep itself
(``studies.sweeps.screening``).
"""

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, partial
from pathlib import Path
from typing import TypedDict

import numpy as np

from studies.cubes.cells import MISSING, Cell, Results
from studies.quantities.parameters import Value
from studies.runs.run import Run
from studies.sweeps.screening import CONTRIBUTIONS, FAILURE, Screen, contributions_of, failures_of, thrown_out
from studies.sweeps.sweep import Sweep

STORED = Path(__file__).with_name("sensitivities.json")
NOT_ASSESSED = "not assessed"
BASE = "default"  # among the stored answers, before any change
ROUND_OFF = 1e-9  # relative

Assess = Callable[[Cell, str], "ModelPart"]
Told = Callable[[float, Mapping[str, float]], dict[str, float]]  # by a base, and the answers by each change


class Stored(TypedDict):
    """The stored answers of runs of a metal in a scenario."""

    scenario: str
    family: str  # of the metal, as laws mean it
    alloy: str
    material: str
    failure: str  # of every run but those that change it
    speeds: list[float]  # m/s
    parameters: dict[str, Value]
    command: str  # that computed them
    physics: int
    quantities: dict[str, dict[str, list[float | None]]]  # by quantity and change, at each speed


@dataclass(frozen=True)
class Side:
    """How far the failures that count move a value to one side."""

    size: float  # in the unit of the quantity; 0: none of them does
    failure: str  # that moves it farthest; empty where none does


@dataclass(frozen=True)
class ModelPart:
    """What the choice of models leaves open of one value."""

    # Standard, of strength and equation of state, in the unit of the quantity; None: not assessed.
    uncertainty: float | None
    reason: str  # the contributions with their source, or why there are none
    shares: Mapping[str, float] = field(default_factory=dict)  # relative, by contribution
    # Largest factor by which the run is outside of the speeds and t/d of what is stored; 1: inside; None: not stored.
    distance: float | None = None
    alloy: str = ""  # of what is stored, where it is not that of the run
    lower: Side | None = None  # None: no failure that counts is known
    upper: Side | None = None
    thrown_out: tuple[str, ...] = ()  # failures with a known answer that do not count


def assessment(sweep: Sweep, results: Results) -> Assess:
    """The function that assesses a quantity of a cell, by the sweep's ``model_part``."""
    if sweep.model_part == "none":
        return lambda cell, quantity: ModelPart(None, f"{NOT_ASSESSED}: model_part is none")
    if sweep.model_part == "screen":
        middle, screens = sweep.screening()
        return lambda cell, quantity: _part(cell, quantity, *_screened(cell, quantity, middle, screens, results))
    return _stored


def _part(
    cell: Cell, quantity: str, shares: Mapping[str, float], failures: Mapping[str, float], source: str
) -> ModelPart:
    """The model part of a value from relative contributions, and relative differences with other failures."""
    measured = cell.measured(quantity)
    if not (shares or failures):
        return ModelPart(None, f"{NOT_ASSESSED}: {source}")
    if measured is None or measured.value is None:
        return ModelPart(None, "")
    texts = [
        f"{name} {100.0 * shares[name]:.2g} %" if name in shares else f"{name} {NOT_ASSESSED}" for name in CONTRIBUTIONS
    ]
    every = {str(cell.parameters.get(FAILURE)): 0.0, **failures} if failures else {}
    counted = {name: share for name, share in every.items() if name not in thrown_out()}
    excluded = {name: share for name, share in failures.items() if name in thrown_out()}
    ends = {pick(counted, key=counted.__getitem__): None for pick in (min, max)} if counted else {}
    texts.append(f"{FAILURE} {', '.join(_with(name, counted[name]) for name in ends) or NOT_ASSESSED}")
    if excluded:
        texts.append(f"thrown out: {', '.join(_with(*share) for share in excluded.items())}")
    moved = {name: measured.value * share for name, share in counted.items()}
    return ModelPart(
        abs(measured.value) * math.hypot(*shares.values()) if shares else None,
        f"{', '.join(texts)} ({source})",
        shares,
        lower=_side({name: -size for name, size in moved.items()}),
        upper=_side(moved),
        thrown_out=tuple(excluded),
    )


def _with(failure: str, share: float) -> str:
    return f"{failure} {100.0 * share:+.2g} %"


def _side(moved: Mapping[str, float]) -> Side | None:
    """The farthest of signed changes to one side; None without any."""
    if not moved:
        return None
    farthest = max(moved, key=moved.__getitem__)
    return Side(moved[farthest], farthest) if moved[farthest] > 0.0 else Side(0.0, "")


# ---- stored --------------------------------------------------------------------------------------


@cache
def classes() -> list[Stored]:
    """What is stored: answers of the runs of a metal in a scenario, by quantity, change and speed."""
    stored: list[Stored] = json.loads(STORED.read_text(encoding="utf-8"))
    return stored


def _stored(cell: Cell, quantity: str) -> ModelPart:
    """The model part of a value by the stored answers of its metal, at its speed.

    A contribution or failure that the metal has no sources for is that of the first metal of its family that has them.
    """
    if cell.run is None:
        return ModelPart(None, "")
    scenario, target = cell.run.scenario, cell.run.materials.get("target")
    family, alloy = (target.family, target.alloy) if target else (None, None)
    of_family = [one for one in classes() if (one["scenario"], one["family"]) == (scenario, family)]
    alike = [one for one in of_family if quantity in one["quantities"]]
    if not alike:
        metal = target.name if target else "no target"
        return _part(cell, quantity, {}, {}, f"nothing is stored for {quantity} of {scenario} in {metal}")
    alike.sort(key=lambda one: one["alloy"] != alloy)  # its own alloy first
    parameters, entry = cell.parameters, alike[0]
    own_failure = parameters.get(FAILURE)
    shares: dict[str, float] = {}
    failures: dict[str, float] = {}
    borrowed = []
    for one in alike:
        at = (one, quantity, float(parameters.get("speed") or one["speeds"][0]))
        for known, more in ((shares, stored_shares(*at)), (failures, stored_failures(*at, own_failure))):
            for name in [name for name in more if name not in known]:
                known[name] = more[name]
                borrowed += [f"{name} of {one['material']}"] if one is not entry else []
    ratio = _thickness_ratio(entry["parameters"])
    plate = "" if ratio is None else f"t/d {ratio:g}, "
    speeds = f"{min(entry['speeds']) / 1e3:g} to {max(entry['speeds']) / 1e3:g} km/s"
    cells = f"{entry['parameters']['cells_per_diameter']:g} cells a diameter"
    metal = ", ".join([entry["material"], *borrowed])
    source = f"stored: {metal} at {plate}{speeds}, {cells}, physics {entry['physics']}, {entry['command']}"
    part, other = _part(cell, quantity, shares, failures, source), "" if entry["alloy"] == alloy else entry["alloy"]
    return replace(part, distance=_distance(parameters, entry), alloy=other)


def stored_shares(entry: Stored, quantity: str, speed: float) -> dict[str, float]:
    """The contributions to a quantity at a speed (m/s)."""
    return _at_speed(entry, quantity, speed, contributions_of)


def stored_failures(entry: Stored, quantity: str, speed: float, failure: Value) -> dict[str, float]:
    """The relative differences of a quantity with other failures from that with one of them, at a speed (m/s)."""
    return _at_speed(entry, quantity, speed, partial(failures_of, own=entry["failure"], of=failure))


def _at_speed(entry: Stored, quantity: str, speed: float, told: Told) -> dict[str, float]:
    """What the stored answers tell at a speed (m/s), each number linear between the stored speeds that have it."""
    answers = entry["quantities"][quantity]
    known: dict[str, list[tuple[float, float]]] = {}
    for place, (stored, base) in enumerate(zip(entry["speeds"], answers[BASE], strict=True)):
        others = {n: v for n, values in answers.items() if n != BASE and (v := values[place]) is not None}
        for name, share in told(base, others).items() if base else ():
            known.setdefault(name, []).append((stored, share))
    return {name: float(np.interp(speed, *np.transpose(pairs))) for name, pairs in known.items()}


def _distance(parameters: Mapping[str, Value], entry: Stored) -> float | None:
    """The largest factor between speed and t/d of a run and the nearest of an entry; 1 inside, None without both."""
    measured, ratio = _thickness_ratio(entry["parameters"]), _thickness_ratio(parameters)
    sides = (parameters.get("speed"), min(entry["speeds"]), max(entry["speeds"])), (ratio, measured, measured)
    known = [(float(value), low, high) for value, low, high in sides if value and low and high]
    factors = [max(low / value, value / high) for value, low, high in known]
    return max((factor if factor > 1.0 + ROUND_OFF else 1.0 for factor in factors), default=None)


def _thickness_ratio(parameters: Mapping[str, Value]) -> float | None:
    """Thickness of a thin plate over the diameter of its projectile."""
    thickness, diameter = parameters.get("plate_thickness"), parameters.get("projectile_diameter")
    if not isinstance(thickness, float) or not isinstance(diameter, float):
        return None
    return thickness / diameter


# ---- screened ------------------------------------------------------------------------------------


def _screened(
    cell: Cell, quantity: str, middle: Run, screens: Iterable[Screen], results: Results
) -> tuple[Mapping[str, float], Mapping[str, float], str]:
    """The contributions to a quantity, its differences with failures other than that of a cell, and their source;
    without any, why.
    """

    def value_of(run: Run) -> float | None:
        result = results.get(run.id, MISSING)
        measured = result.measurements.get(quantity)
        return measured.value if measured is not None and result.state == "succeeded" else None

    base = value_of(middle)
    if not base:
        return {}, {}, "the run at the middle of the sweep has no value"
    answers, lacking = {}, []
    for screen in screens:
        value = None if screen.run is None else value_of(screen.run)
        if value is not None:
            answers[screen.name] = value
        else:
            lacking.append(f"{screen.name}: {screen.reason or 'its screening run has no value'}")
    failures = failures_of(base, answers, middle.parameters.get(FAILURE), cell.parameters.get(FAILURE))
    source = "; ".join(["screening runs at the middle of the sweep", *lacking])
    return contributions_of(base, answers), failures, source
