"""Shots: the data that laws are asked about."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

from solver.units import Dimensionless, KilogramPerCubicMetre, Metre, MetrePerSecond, Pascal, Radian
from studies.materials import Material, load

SHIELD_ROLES = ("bumper", "wall")  # materials of a shield, its target first
FURTHER = ("bumper_2", "bumper_3", "bumper_4")  # and of the bumpers behind the first one


@dataclass(frozen=True)
class FurtherBumper:
    """A bumper between the first one and the wall."""

    bumper_thickness: Metre
    stand_off: Metre  # between the back of this bumper and the front of what is next
    family: str = "aluminium"  # of its material


@dataclass(frozen=True)
class Shield:
    """A Whipple shield: a bumper of the target's material before a wall."""

    bumper_thickness: Metre
    wall_thickness: Metre
    stand_off: Metre  # between the back of the bumper and the front of what is next: the wall, or a further bumper
    wall_yield_stress: Pascal
    wall_density: KilogramPerCubicMetre | None = None  # None: that of the bumper
    further_bumpers: tuple[FurtherBumper, ...] = ()  # the outermost first; without any: two walls
    wall_family: str = "aluminium"  # of its material

    @property
    def of_other_metal(self) -> dict[str, str]:
        """The families of what stands behind the bumper, by name, where they are not aluminium."""
        families = {f"bumper {place}": each.family for place, each in enumerate(self.further_bumpers, 2)}
        families["wall"] = self.wall_family
        return {name: family for name, family in families.items() if family != "aluminium"}


@dataclass(frozen=True)
class Shot:
    """The data of a shot that laws use: impact of a projectile on a plate or a block."""

    speed: MetrePerSecond
    projectile_diameter: Metre  # diameter of the sphere with the projectile's volume
    plate_thickness: Metre | None  # None for a target without a back face
    projectile: Material
    target: Material
    obliquity: Radian = 0.0  # between the flight and the target's normal
    length_ratio: Dimensionless = 1.0  # length of the projectile over its own diameter
    shield: Shield | None = None  # the shield whose bumper is the target; None: a plate or a block

    @property
    def normal_speed(self) -> float:
        """Component of the velocity along the target's normal, m/s."""
        return self.speed * math.cos(self.obliquity)

    @property
    def density_ratio(self) -> float:
        """Density of the projectile over that of the target."""
        return self.projectile.density / self.target.density

    @property
    def mass(self) -> float:
        """Mass of the projectile, kg."""
        return self.projectile.density * math.pi / 6.0 * self.projectile_diameter**3

    @property
    def brinell_hardness(self) -> float:
        """Brinell hardness number of the target; NaN where its material states none."""
        hardness = self.target.brinell_hardness
        return math.nan if hardness is None else hardness

    @property
    def thickness_ratio(self) -> float:
        """t/d; NaN without a plate."""
        if self.plate_thickness is None:
            return math.nan
        return self.plate_thickness / self.projectile_diameter


@lru_cache(maxsize=256)
def aluminium(density: float, name: str = "") -> Material:
    """Aluminium of a density, kg/m3: equations of shields read no other constant of projectile and bumper."""
    return replace(load("al-6061-t6"), name=name or "aluminium", density=density)


def shot_of(run: Any) -> Shot:
    """The shot that a run (``studies.runs.run.Run``) computes."""
    materials = {role: Material.from_resolved(plain) for role, plain in run.materials.items()}
    return shot_from(run.parameters, materials)


def shot_from(parameters: Mapping[str, Any], materials: Mapping[str, Material] | None = None) -> Shot:
    """The shot of a scenario's parameters (SI) and its materials by role; by default those that ship, by their names.

    The bumper of a shield is the target. KeyError where speed, projectile_diameter, projectile, target or a cylinder's
    length are missing or None.

    >>> shield = {"bumper": "al-6061-t6", "wall": "al-6061-t6", "stand_off": 0.1, "wall_thickness": 2e-3}
    >>> shot = {"speed": 6500.0, "projectile": "al-2017-t4", "projectile_diameter": 5e-3, "bumper_thickness": 1e-3}
    >>> shot_from({**shot, **shield}).shield.wall_yield_stress
    276000000.0
    >>> second = {"bumper_2": "al-6061-t6", "bumper_2_thickness": 5e-4, "bumper_2_stand_off": 0.05}
    >>> shot_from({**shot, **shield, **second}).shield.further_bumpers
    (FurtherBumper(bumper_thickness=0.0005, stand_off=0.05, family='aluminium'),)
    """
    values = {name: value for name, value in parameters.items() if value is not None}
    target, *others = SHIELD_ROLES if "bumper_thickness" in values else ("target",)
    roles = ("projectile", target, *others, *_further(values))
    materials = materials or {role: load(values[role]) for role in roles}
    return Shot(
        speed=values["speed"],
        projectile_diameter=_equivalent_diameter(values),
        plate_thickness=values.get("bumper_thickness", values.get("plate_thickness")),
        projectile=materials["projectile"],
        target=materials[target],
        obliquity=values.get("obliquity", 0.0),
        length_ratio=_length_ratio(values),
        shield=_shield(values, materials) if others else None,
    )


def _shield(values: Mapping[str, Any], materials: Mapping[str, Material]) -> Shield:
    """The shield, its wall of the first yield stress that its material states; NaN where it states none."""
    wall = materials["wall"]
    return Shield(
        bumper_thickness=values["bumper_thickness"],
        wall_thickness=values["wall_thickness"],
        stand_off=values["stand_off"],
        wall_yield_stress=wall.yield_stresses[0].value if wall.yield_stresses else math.nan,
        wall_density=wall.density,
        further_bumpers=tuple(
            FurtherBumper(values[f"{name}_thickness"], values[f"{name}_stand_off"], materials[name].family)
            for name in _further(values)
        ),
        wall_family=wall.family,
    )


def _further(values: Mapping[str, Any]) -> list[str]:
    """The names of the bumpers behind the first one."""
    return [name for name in FURTHER if values.get(f"{name}_thickness")]


def _equivalent_diameter(values: Mapping[str, Any]) -> float:
    """Diameter of the sphere of equal volume: pi/6 d_eq^3 = pi/4 d^2 L of a cylinder."""
    diameter = values["projectile_diameter"]
    if values.get("projectile_shape") != "cylinder":
        return diameter
    return (1.5 * diameter**2 * values["projectile_length"]) ** (1.0 / 3.0)


def _length_ratio(values: Mapping[str, Any]) -> float:
    """L/d of a cylinder; 1 of a sphere."""
    if values.get("projectile_shape") != "cylinder":
        return 1.0
    return values["projectile_length"] / values["projectile_diameter"]
