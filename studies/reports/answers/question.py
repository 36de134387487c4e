"""A question to laws: a shot at a plate, a block or a shield; a parameter may have several values."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import permutations, product
from typing import Annotated, Any

from solver.units import Described, Metre, MetrePerSecond, Pascal, Radian
from studies import materials as shipped
from studies.laws import InnerBumper, Shield, Shot, shot_from
from studies.materials import Material, read_own
from studies.quantities.findings import Finding, Findings, refusal
from studies.quantities.parameters import MaterialName, Parameter, Value, declared, find, join, missing, parse_value
from studies.sweeps.axes import Axis, AxisReader

MOST_SHOTS = 2_000  # of one question: equations and shots of a shield take 5 ms for each (2026-11)
OWN_MATERIALS = "materials"  # the key beside the parameters, as in a sweep
WALL = ("wall_thickness", "stand_off")  # a shield has both
INNER = ("inner_thickness", "inner_stand_off")  # a second bumper has both


@dataclass(frozen=True, kw_only=True)
class ShotParameters:
    """What laws are told of a shot."""

    speed: Annotated[MetrePerSecond, Described("impact speed", 100.0, 2e4)]
    projectile_diameter: Annotated[Metre, Described("diameter of the projectile", 1e-5, 1.0)]
    projectile: Annotated[MaterialName, Described("material of the projectile")]
    target: Annotated[MaterialName, Described("material of the plate or block; of a shield, of its bumper")]
    plate_thickness: Annotated[
        Metre | None, Described("thickness of the plate, or of a shield's bumper; omitted for a thick block", 1e-6, 1.0)
    ] = None
    projectile_length: Annotated[
        Metre | None, Described("length of a cylinder that flies along its axis; omitted for a sphere", 1e-5, 1.0)
    ] = None
    obliquity: Annotated[
        Radian, Described("angle between the flight and the target's normal", 0.0, math.radians(85.0))
    ] = 0.0
    wall: Annotated[MaterialName | None, Described("material of a shield's wall; by default that of its bumper")] = None
    wall_thickness: Annotated[Metre | None, Described("thickness of a shield's wall", 1e-6, 1.0)] = None
    stand_off: Annotated[
        Metre | None,
        Described("distance from the back of a shield's bumper to its wall, or to a second bumper", 1e-6, 10.0),
    ] = None
    inner_thickness: Annotated[
        Metre | None,
        Described("thickness of a second bumper between the first and the wall; omitted for none", 1e-6, 1.0),
    ] = None
    inner_stand_off: Annotated[
        Metre | None, Described("distance from the back of the second bumper to the wall", 1e-6, 10.0)
    ] = None
    wall_yield_stress: Annotated[
        Pascal | None, Described("yield stress of a shield's wall; by default the first that its material states", 1e6)
    ] = None


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
        if "wall_thickness" in given:
            return "shield"
        return "plate" if "plate_thickness" in given else "block"

    def points(self) -> Iterator[dict[str, Value]]:
        """The parameters of each shot, SI, the last axis fastest."""
        names = [axis.name for axis in self.axes]
        for values in product(*(axis.values for axis in self.axes)):
            yield {**self.fixed, **dict(zip(names, values, strict=True))}

    def shot(self, point: Mapping[str, Value]) -> Shot:
        """The shot of one of the points."""
        given: dict[str, Any] = {name: value for name, value in point.items() if value is not None}
        if "projectile_length" in given:
            given["projectile_shape"] = "cylinder"
        roles = {role: self.materials[given[role]] for role in ("projectile", "target")}
        return replace(shot_from(given, roles), shield=self._shield(given))

    def _shield(self, given: Mapping[str, Any]) -> Shield | None:
        if "wall_thickness" not in given:
            return None
        inner = [float(given[name]) for name in INNER if name in given]
        return Shield(
            bumper_thickness=given["plate_thickness"],
            wall_thickness=given["wall_thickness"],
            stand_off=given["stand_off"],
            wall_yield_stress=given.get("wall_yield_stress") or _yield_stress(self._wall(given), given),
            wall_density=self._wall(given).density,
            inner_bumper=InnerBumper(inner[0], inner[1]) if len(inner) == len(INNER) else None,
            wall_family=self._wall(given).family,
        )

    def _wall(self, given: Mapping[str, Any]) -> Material:
        return self.materials[given.get("wall", given["target"])]


def _yield_stress(wall: Material, given: Mapping[str, Any]) -> float:
    """The first yield stress that a material states, Pa; raises InvalidInput."""
    if wall.yield_stresses:
        return wall.yield_stresses[0].value
    cure = "give wall_yield_stress, for instance 276 MPa"
    raise refusal("wall", given.get("wall", given["target"]), "a material that states a yield stress", cure)


def read_question(document: Any) -> Question:
    """The question of a document, its values with units: "6 km/s", or a list of them, or start, stop and step.

    Raises InvalidInput with every finding.
    """
    if not isinstance(document, Mapping):
        raise refusal("shot", document, "a mapping of parameters", "write speed: 6 km/s, projectile: al-2017-t4, ...")
    findings = Findings()
    own = _own_materials(document.get(OWN_MATERIALS), findings)
    names = sorted({*shipped.names(), *own})
    parameters = declared(ShotParameters)
    reader = AxisReader(MOST_SHOTS, names)
    fixed: dict[str, Value] = {name: parameter.default for name, parameter in parameters.items()}
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
    used = {fixed[role] for role in ("projectile", "target", "wall") if fixed[role] and role not in varied}
    used |= {value for axis in axes if axis.name in ("projectile", "target", "wall") for value in axis.values}
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
    for one, other in permutations(INNER):
        if document.get(one) is not None and document.get(other) is None:
            yield Finding(
                other, "nothing", f"a second bumper has {' and '.join(INNER)}", f"give it, or leave {one} out"
            )
    about_wall = [name for name in (*WALL, *INNER, "wall", "wall_yield_stress") if document.get(name) is not None]
    if about_wall:
        for name in ("plate_thickness", *WALL):
            if document.get(name) is None:
                cure = f"give it, or leave {about_wall[0]} out"
                yield Finding(name, "nothing", f"a shield has a bumper (plate_thickness), {' and '.join(WALL)}", cure)
