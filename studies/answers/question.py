"""A question to laws: a shot at a plate, a block or a shield; a parameter may have several values."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Annotated, Any

from solver.units import Described, Metre, MetrePerSecond, Pascal, Radian
from studies import materials as shipped
from studies import scenarios
from studies.laws import Shot, shot_from
from studies.materials import Material, read_own
from studies.quantities.findings import Finding, Findings, InvalidInput, nearest_cure, refusal, shown
from studies.quantities.parameters import (
    MaterialName,
    Parameter,
    Value,
    declared,
    find,
    join,
    missing,
    nested,
    parse_value,
)
from studies.scenarios.parts.bumpers import BUMPERS, FurtherBumpers, by_place
from studies.sweeps.axes import Axis, AxisReader
from studies.sweeps.flat import as_sweep
from studies.sweeps.reading import KEYS

MOST_SHOTS = 2_000  # of one question: equations and shots of a shield take 20 ms for each (2026-11)
OWN_MATERIALS = "materials"  # the key beside the parameters, as in a sweep
PLATE = ("target", "plate_thickness")  # parameters of a plate or a block alone
SHIELD = ("bumper", "bumper_thickness", "stand_off", "wall_thickness")  # parameters of every shield
BEHIND = ("wall", "wall_yield_stress", *declared(FurtherBumpers))  # further parameters of a shield
ROLES = ("projectile", "target", *BUMPERS, "wall")


@dataclass(frozen=True, kw_only=True)
class ShotParameters:
    """What laws are told of a shot, in the words of the scenarios; a block has no plate_thickness."""

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
    bumper: Annotated[MaterialName | None, Described("material of a shield's bumper")] = None
    bumper_thickness: Annotated[Metre | None, Described("thickness of a shield's bumper", 1e-6, 1.0)] = None
    stand_off: Annotated[
        Metre | None,
        Described("distance from the back of a shield's bumper to its wall, or to a second bumper", 1e-6, 10.0),
    ] = None
    wall: Annotated[MaterialName | None, Described("material of a shield's wall; by default that of its bumper")] = None
    wall_thickness: Annotated[Metre | None, Described("thickness of a shield's wall", 1e-6, 1.0)] = None
    wall_yield_stress: Annotated[
        Pascal | None, Described("yield stress of a shield's wall; by default the first that its material states", 1e6)
    ] = None
    further: FurtherBumpers


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
        """What is hit: "shield", "plate" or "block"."""
        given = {name for name, value in self.fixed.items() if value is not None} | {axis.name for axis in self.axes}
        if given & {*SHIELD}:
            return "shield"
        return "plate" if "plate_thickness" in given else "block"

    def points(self) -> Iterator[dict[str, Value]]:
        """The parameters of each shot, SI, the last axis fastest."""
        names = [axis.name for axis in self.axes]
        for values in product(*(axis.values for axis in self.axes)):
            yield {**self.fixed, **dict(zip(names, values, strict=True))}

    def shot(self, point: Mapping[str, Value]) -> Shot:
        """The shot of one of the points; raises InvalidInput for bumpers and walls that make no shield."""
        given: dict[str, Any] = {name: value for name, value in point.items() if value is not None}
        if "projectile_length" in given:
            given["projectile_shape"] = "cylinder"
        if self.target == "shield":
            further = {name: value for name, value in given.items() if name in declared(FurtherBumpers)}
            if findings := [*nested(FurtherBumpers, further).check()]:
                raise InvalidInput(findings)
            given = {**dict.fromkeys((*BUMPERS, "wall"), given["bumper"]), **given}
        roles = {role: self.materials[given[role]] for role in ROLES if role in given}
        shot = shot_from(given, roles)
        if shot.shield is None:
            return shot
        stress = given.get("wall_yield_stress", shot.shield.wall_yield_stress)
        if math.isnan(stress):
            cure = "give wall_yield_stress, for instance 276 MPa"
            raise refusal("wall", given["wall"], "a material that states a yield stress", cure)
        return replace(shot, shield=replace(shot.shield, wall_yield_stress=stress))


def as_shot(document: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters of a shot, of a document of its own or of a sweep, without those that laws do not know.

    Raises InvalidInput where the values of a sweep are not every combination of those on its axes.
    """
    if not {*document} & ({*KEYS} - {OWN_MATERIALS}):
        return by_place(document)
    document = as_sweep(document, KEYS)
    combine = document.get("combine") or "grid"
    if combine != "grid":
        raise refusal("combine", combine, "grid, for laws", "leave combine out")
    scenario = scenarios.load(str(document.get("scenario")))
    left_out = {*declared(scenario.parameters)} - {*declared(ShotParameters)}
    fixed, axes = (document.get(key) or {} for key in ("fixed", "axes"))
    if not isinstance(fixed, Mapping) or not isinstance(axes, Mapping):
        raise refusal("fixed and axes", "no mapping", "names and values", "write fixed: {speed: 6 km/s}")
    stated = {**by_place(fixed, "fixed"), **{name: _asked(values) for name, values in axes.items()}}
    shot = {name: value for name, value in stated.items() if name not in left_out and "." not in name}
    return {**shot, **{key: document[key] for key in (OWN_MATERIALS,) if key in document}}


def _asked(values: Any) -> Any:
    """The values of an axis: the one that has no other by itself, and the ends of a search."""
    if isinstance(values, Mapping) and "limit_of" in values:
        return values.get("between")
    return values[0] if isinstance(values, list) and len(values) == 1 else values


def read_question(document: Any) -> Question:
    """The question of a document, its values with units: "6 km/s", or a list of them, or start, stop and step.

    Raises InvalidInput with every finding.
    """
    if not isinstance(document, Mapping):
        raise refusal("shot", document, "a mapping of parameters", "write speed: 6 km/s, projectile: al-2017-t4, ...")
    document = as_shot(document)
    findings = Findings()
    own = _own_materials(document.get(OWN_MATERIALS), findings)
    names = sorted({*shipped.names(), *own})
    parameters = declared(ShotParameters)
    reader = AxisReader(MOST_SHOTS, names)
    fixed = {name: each.default for name, each in parameters.items() if name not in declared(FurtherBumpers)}
    axes: list[Axis] = []

    def read(name: str, raw: Any) -> None:
        parameter = find(parameters, name)
        if isinstance(raw, list | tuple | Mapping):
            axes.append(reader.read(parameter, name, raw, name))
        else:
            fixed[name] = parse_value(parameter, raw, name, materials=names)

    for name, raw in document.items():
        if name != OWN_MATERIALS:
            findings.attempt(read, name, raw)
    findings.extend(_missing(document, parameters))
    findings.check()
    shots = math.prod(len(axis.values) for axis in axes)
    if shots > MOST_SHOTS:
        raise refusal("shot", f"{shots} shots", f"at most {MOST_SHOTS} in one question", "give fewer values")
    varied = {axis.name for axis in axes}
    used = {fixed[role] for role in ROLES if fixed.get(role) and role not in varied}
    used |= {value for axis in axes if axis.name in ROLES for value in axis.values}
    loaded = {str(name): own.get(str(name)) or shipped.load(str(name)) for name in used}
    question = Question({k: v for k, v in fixed.items() if k not in varied}, tuple(axes), loaded)
    for point in question.points():
        question.shot(point)  # what no shot can be made of is refused here
    return question


def _own_materials(raw: Any, findings: Findings) -> dict[str, Material]:
    if raw is None:
        return {}
    if not isinstance(raw, Mapping):
        findings.extend(
            refusal(OWN_MATERIALS, raw, "a mapping from names to materials", "see docs/materials.md").findings
        )
        return {}
    read = {
        str(name): findings.attempt(read_own, each, join(OWN_MATERIALS, name), str(name)) for name, each in raw.items()
    }
    return {name: material for name, material in read.items() if material is not None}


def _missing(document: Mapping[str, Any], parameters: Mapping[str, Parameter]) -> Iterator[Finding]:
    """A finding for what every shot needs, and for what a shield needs besides."""
    for parameter in parameters.values():
        if parameter.required and parameter.name not in document:
            yield missing(parameter)
    given = {name for name, value in document.items() if value is not None}
    if not given & {*SHIELD, *BEHIND}:
        if "target" not in given:
            yield missing(parameters["target"])
        return
    for name in PLATE:
        if name in given:
            yield Finding(name, shown(document[name]), "a shield has a bumper", nearest_cure(name, SHIELD))
    for name in SHIELD:
        if name not in given:
            yield Finding(name, "nothing", f"a shield has {', '.join(SHIELD)}", f"give {name}")
