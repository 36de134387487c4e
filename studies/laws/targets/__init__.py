"""What a projectile hits, as laws see it: a plate or a block here, and what features add.

A feature adds one through the entry-point group ``whipple.studies.laws.targets``. Its parameters, where a shot states
some, make a shot of its own kind: a :class:`Shot` with more fields.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

from solver.registry import entries
from studies.laws._shot import Shot
from studies.materials import Material, load
from studies.quantities.parameters import Value

Stated = Mapping[str, float | int | bool | str]  # parameters of a shot, SI, without those that are None
Materials = Mapping[str, Material]  # by the parameter that names it


@dataclass(frozen=True)
class Target:
    """A kind of target."""

    name: str
    place: int  # of several whose parameters are stated the first one counts
    named_by: frozenset[str]  # its parameters; of what is hit where no other target is named, none
    scenario: str  # that simulates such shots
    roles: Callable[[Stated], tuple[str, ...]]  # the parameters that name a material, besides the projectile
    shot: Callable[[Stated, Materials], Shot]  # KeyError where a parameter is missing


def targets() -> list[Target]:
    """All targets, by their places."""
    return sorted(entries(__name__, "TARGET").values(), key=lambda target: target.place)


def target_of(stated: Collection[str]) -> Target:
    """The target that parameters name."""
    return next(target for target in targets() if not target.named_by or not target.named_by.isdisjoint(stated))


def shot_from(parameters: Mapping[str, Value], materials: Materials | None = None) -> Shot:
    """The shot of a scenario's parameters (SI) and its materials by role; by default those that ship, by their names.

    KeyError where speed, projectile_diameter, projectile, target or a cylinder's length are missing or None.

    >>> shot = {"speed": 6500.0, "projectile": "al-2017-t4", "projectile_diameter": 5e-3, "target": "al-6061-t6"}
    >>> shot_from({**shot, "plate_thickness": 1e-3}).thickness_ratio
    0.2
    """
    stated = {name: value for name, value in parameters.items() if value is not None}
    target = target_of(stated)
    if materials is None:
        materials = {role: load(str(stated[role])) for role in ("projectile", *target.roles(stated))}
    return target.shot(stated, materials)


def plain_shot(stated: Stated, materials: Materials, role: str = "target", thickness: str = "plate_thickness") -> Shot:
    """The shot at the plate of a role's material whose thickness a parameter states; at a block where it does not."""
    diameter, length_ratio = float(stated["projectile_diameter"]), 1.0
    if stated.get("projectile_shape") == "cylinder":
        length = float(stated["projectile_length"])
        length_ratio = length / diameter
        # The sphere of equal volume: pi/6 d_eq^3 = pi/4 d^2 L.
        diameter = float((1.5 * diameter**2 * length) ** (1.0 / 3.0))
    return Shot(
        speed=float(stated["speed"]),
        projectile_diameter=diameter,
        plate_thickness=float(stated[thickness]) if thickness in stated else None,
        projectile=materials["projectile"],
        target=materials[role],
        obliquity=float(stated.get("obliquity", 0.0)),
        length_ratio=length_ratio,
    )


TARGET = (
    Target("plate", 50, frozenset({"plate_thickness"}), "thin_plate", lambda stated: ("target",), plain_shot),
    Target("block", 100, frozenset(), "thick_plate", lambda stated: ("target",), plain_shot),
)
