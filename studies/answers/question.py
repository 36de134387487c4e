"""A question to laws: a shot at a plate, a block or what a feature adds; a parameter may have several values."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Annotated

from solver.units import Described, Metre, MetrePerSecond, Radian
from studies import materials as shipped
from studies import scenarios
from studies.answers.targets import meant, targets
from studies.laws import Shot, target_of
from studies.materials import Material, read_own
from studies.quantities.findings import Findings, refusal
from studies.quantities.parameters import (
    MaterialName,
    Parameter,
    Plain,
    Value,
    by_place,
    declared,
    find,
    grouped,
    join,
    missing,
    parse_value,
)
from studies.sweeps.axes import Axis, AxisReader
from studies.sweeps.flat import as_sweep
from studies.sweeps.reading import KEYS

MOST_SHOTS = 2_000  # of one question: equations and shots of a shield take 20 ms for each (2026-11)
OWN_MATERIALS = "materials"  # the key beside the parameters, as in a sweep


@dataclass(frozen=True, kw_only=True)
class ShotParameters:
    """What laws are told of a shot at a plate or a block, in the words of the scenarios; a block has no thickness."""

    speed: Annotated[MetrePerSecond, Described("impact speed", 100.0, 2e4)]
    projectile_diameter: Annotated[Metre, Described("diameter of the projectile", 1e-5, 1.0)]
    projectile: Annotated[MaterialName, Described("material of the projectile")]
    target: Annotated[MaterialName | None, Described("material of a plate or a block")] = None
    plate_thickness: Annotated[
        Metre | None, Described("thickness of a plate; omitted for a thick block", 1e-6, 1.0)
    ] = None
    projectile_length: Annotated[
        Metre | None, Described("length of a cylinder that flies along its axis; omitted for a sphere", 1e-5, 1.0)
    ] = None
    obliquity: Annotated[
        Radian, Described("angle between the flight and the target's normal", 0.0, math.radians(85.0))
    ] = 0.0


@dataclass(frozen=True)
class Question:
    """A checked question: its parameters, SI, and those that vary."""

    fixed: Mapping[str, Value]
    axes: tuple[Axis, ...]
    materials: Mapping[str, Material]  # by name

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values on each axis."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def target(self) -> str:
        """What is hit: a name of ``targets``."""
        stated = {name for name, value in self.fixed.items() if value is not None} | {axis.name for axis in self.axes}
        return target_of(stated).name

    def points(self) -> Iterator[dict[str, Value]]:
        """The parameters of each shot, SI, the last axis fastest."""
        names = [axis.name for axis in self.axes]
        for values in product(*(axis.values for axis in self.axes)):
            yield {**self.fixed, **dict(zip(names, values, strict=True))}

    def shot(self, point: Mapping[str, Value]) -> Shot:
        """The shot of one of the points; raises InvalidInput for parameters that make no target together."""
        stated = {name: value for name, value in point.items() if value is not None}
        if "projectile_length" in stated:
            stated["projectile_shape"] = "cylinder"
        return targets()[self.target].shot(stated, self.materials)


def records() -> tuple[type, ...]:
    """The records of the parameters of a question, that of plates and blocks first."""
    return (ShotParameters, *(target.parameters for target in targets().values() if target.parameters))


def shot_parameters() -> Mapping[str, Parameter]:
    """Every parameter of a question, those of plates and blocks first."""
    return {name: parameter for record in records() for name, parameter in declared(record).items()}


def single_parameters() -> Mapping[str, Parameter]:
    """Those of which a shot has one, and not several as it may have bumpers: what is not stated is not there."""
    return {name: declared(record)[name] for record in records() for name in grouped(record)[""]}


def as_shot(document: Mapping[str, Plain]) -> dict[str, Plain]:
    """The parameters of a shot, of a document of its own or of a sweep, without those that laws do not know.

    Raises InvalidInput where the values of a sweep are not every combination of those on its axes.
    """
    if not {*document} & ({*KEYS} - {OWN_MATERIALS}):
        return by_place(document, "", *records())
    document = as_sweep(document, KEYS)
    combine = document.get("combine") or "grid"
    if combine != "grid":
        raise refusal("combine", combine, "grid, for laws", "leave combine out")
    scenario = scenarios.load(str(document.get("scenario")))
    left_out = {*declared(scenario.parameters)} - {*shot_parameters()}
    fixed, axes = (document.get(key) or {} for key in ("fixed", "axes"))
    if not isinstance(fixed, Mapping) or not isinstance(axes, Mapping):
        raise refusal("fixed and axes", "no mapping", "names and values", "write fixed: {speed: 6 km/s}")
    stated = {**by_place(fixed, "fixed", *records()), **{name: _asked(values) for name, values in axes.items()}}
    shot = {name: value for name, value in stated.items() if name not in left_out and "." not in name}
    return {**shot, **{key: document[key] for key in (OWN_MATERIALS,) if key in document}}


def _asked(values: Plain) -> Plain:
    """The values of an axis: the one that has no other by itself, and the ends of a search."""
    if isinstance(values, Mapping) and "limit_of" in values:
        return values.get("between")
    return values[0] if isinstance(values, list) and len(values) == 1 else values


def read_question(document: Plain) -> Question:
    """The question of a document, its values with units: "6 km/s", or a list of them, or start, stop and step.

    Raises InvalidInput with every finding.
    """
    if not isinstance(document, Mapping):
        raise refusal("shot", document, "a mapping of parameters", "write speed: 6 km/s, projectile: al-2017-t4, ...")
    document = as_shot(document)
    findings = Findings()
    own = findings.attempt(_own_materials, document.get(OWN_MATERIALS), findings) or {}
    names = sorted({*shipped.names(), *own})
    parameters = shot_parameters()
    reader = AxisReader(MOST_SHOTS, names)
    fixed = {name: parameter.default for name, parameter in single_parameters().items()}
    axes: list[Axis] = []

    def read(name: str, raw: Plain) -> None:
        parameter = find(parameters, name)
        if isinstance(raw, list | tuple | Mapping):
            axes.append(reader.read(parameter, name, raw, name))
        else:
            fixed[name] = parse_value(parameter, raw, name, materials=names)

    for name, raw in document.items():
        if name != OWN_MATERIALS:
            findings.attempt(read, name, raw)
    absent = [name for name, parameter in parameters.items() if parameter.required and name not in document]
    findings.extend(missing(parameters[name]) for name in absent)
    findings.extend(meant({n for n, value in document.items() if value is not None}).missing(document, parameters))
    findings.check()
    shots = math.prod(len(axis.values) for axis in axes)
    if shots > MOST_SHOTS:
        raise refusal("shot", f"{shots} shots", f"at most {MOST_SHOTS} in one question", "give fewer values")
    varied = {axis.name for axis in axes}
    roles = {role for target in targets().values() for role in target.roles}
    used = {fixed[role] for role in roles if fixed.get(role) and role not in varied}
    used |= {value for axis in axes if axis.name in roles for value in axis.values}
    loaded = {str(name): own.get(str(name)) or shipped.load(str(name)) for name in used}
    question = Question({k: v for k, v in fixed.items() if k not in varied}, tuple(axes), loaded)
    for point in question.points():
        question.shot(point)  # what no shot can be made of is refused here
    return question


def _own_materials(raw: Plain, findings: Findings) -> dict[str, Material]:
    if raw is None:
        return {}
    if not isinstance(raw, Mapping):
        raise refusal(OWN_MATERIALS, raw, "a mapping from names to materials", "see docs/faq.md")
    read = {
        str(name): findings.attempt(read_own, stated, join(OWN_MATERIALS, name), str(name))
        for name, stated in raw.items()
    }
    return {name: material for name, material in read.items() if material is not None}
