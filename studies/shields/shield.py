"""A Whipple shield, and the shot at one as laws see it."""

import math
from dataclasses import dataclass, replace

from solver.units import KilogramPerCubicMetre, Metre, Pascal
from studies.laws import Shot
from studies.laws.predicted import Predicted
from studies.laws.targets import Materials, Stated, Target, plain_shot
from studies.shields.bumpers import BUMPERS

ALUMINIUM = "aluminium"  # the family of metals that equations and shots are about
WALL_PERFORATED, CRITICAL_DIAMETER = "wall_perforated", "critical_diameter"  # what runs measure, and what laws predict
# Parameters of every shield, and all of which one names a shield.
NEEDED = ("bumper", "bumper_thickness", "stand_off", "wall_thickness")
NAMED_BY = frozenset({*NEEDED, "wall"})


@dataclass(frozen=True)
class FurtherBumper:
    """A bumper between the first one and the wall."""

    bumper_thickness: Metre
    stand_off: Metre  # between the back of this bumper and the front of what is next
    family: str = ALUMINIUM  # of its material


@dataclass(frozen=True)
class Shield:
    """A Whipple shield: a bumper of the target's material before a wall."""

    bumper_thickness: Metre
    wall_thickness: Metre
    stand_off: Metre  # between the back of the bumper and the front of what is next: the wall, or a further bumper
    wall_yield_stress: Pascal
    wall_density: KilogramPerCubicMetre | None = None  # None: that of the bumper
    further_bumpers: tuple[FurtherBumper, ...] = ()  # the outermost first; without any: two walls
    wall_family: str = ALUMINIUM  # of its material

    @property
    def of_other_metal(self) -> dict[str, str]:
        """The families of what stands behind the bumper, by name, where they are not aluminium."""
        families = {f"bumper {place}": bumper.family for place, bumper in enumerate(self.further_bumpers, 2)}
        families["wall"] = self.wall_family
        return {name: family for name, family in families.items() if family != ALUMINIUM}


@dataclass(frozen=True, kw_only=True)
class ShotAtShield(Shot):
    """A shot at a shield, whose bumper is the target."""

    shield: Shield


def at_shield(shot: Shot, shield: Shield) -> ShotAtShield:
    """A shot at a bumper as one at the shield behind it."""
    return ShotAtShield(**{**vars(shot), "shield": shield})


def shield_of(shot: Shot) -> Shield | None:
    """The shield that a shot is at; None of another target."""
    return shot.shield if isinstance(shot, ShotAtShield) else None


def _roles(stated: Stated) -> tuple[str, ...]:
    return (BUMPERS[0], "wall", *_further(stated))


def _further(stated: Stated) -> list[str]:
    """The names of the bumpers behind the first one."""
    return [name for name in BUMPERS[1:] if stated.get(f"{name}_thickness")]


def shot_from_parameters(stated: Stated, materials: Materials) -> ShotAtShield:
    """The shot at a shield of its parameters; its wall has the first yield stress that its material states, or NaN.

    >>> from studies.laws import shot_from
    >>> shield = {"bumper": "al-6061-t6", "wall": "al-6061-t6", "stand_off": 0.1, "wall_thickness": 2e-3}
    >>> shot = {"speed": 6500.0, "projectile": "al-2017-t4", "projectile_diameter": 5e-3, "bumper_thickness": 1e-3}
    >>> shot_from({**shot, **shield}).shield.wall_yield_stress
    276000000.0
    >>> second = {"bumper_2": "al-6061-t6", "bumper_2_thickness": 5e-4, "bumper_2_stand_off": 0.05}
    >>> shot_from({**shot, **shield, **second}).shield.further_bumpers
    (FurtherBumper(bumper_thickness=0.0005, stand_off=0.05, family='aluminium'),)
    """
    wall = materials["wall"]
    further = (
        FurtherBumper(float(stated[f"{name}_thickness"]), float(stated[f"{name}_stand_off"]), materials[name].family)
        for name in _further(stated)
    )
    shield = Shield(
        bumper_thickness=float(stated["bumper_thickness"]),
        wall_thickness=float(stated["wall_thickness"]),
        stand_off=float(stated["stand_off"]),
        wall_yield_stress=wall.yield_stresses[0].value if wall.yield_stresses else math.nan,
        wall_density=wall.density,
        further_bumpers=tuple(further),
        wall_family=wall.family,
    )
    return at_shield(plain_shot(stated, materials, BUMPERS[0], "bumper_thickness"), shield)


def reshielded(shot: ShotAtShield, **changes: float) -> ShotAtShield:
    """The shot at a shield with other sizes or another yield stress."""
    return replace(shot, shield=replace(shot.shield, **changes))  # type: ignore[arg-type]  # fields are numbers


TARGET = Target("shield", 10, NAMED_BY, "whipple_shield", _roles, shot_from_parameters)
PREDICTED = Predicted(
    CRITICAL_DIAMETER, "Projectile diameter above which a Whipple shield fails", 50, outcome=WALL_PERFORATED
)
