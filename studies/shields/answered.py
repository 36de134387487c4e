"""A shield as a question to laws and shots: its parameters, and what it adds to what laws say."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from solver.units import Described, Metre, Pascal
from studies.answers.targets import AnsweredTarget
from studies.laws import Shot
from studies.laws.targets import Stated
from studies.materials import Material
from studies.quantities.findings import Finding, InvalidInput, nearest_cure, refusal, shown
from studies.quantities.parameters import MaterialName, Parameter, Plain, declared, nested
from studies.reports.figure import Figure
from studies.shields.bumpers import BUMPERS, FurtherBumpers
from studies.shields.shield import CRITICAL_DIAMETER, NEEDED, ShotAtShield, reshielded

PLATE = ("target", "plate_thickness")  # parameters of a plate or a block alone


@dataclass(frozen=True, kw_only=True)
class ShieldParameters:
    """What laws are told of a shield, in the words of its scenario."""

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


class AnsweredShield(AnsweredTarget):
    """Shields: the probability to fail, equations, shots near it, and the sizes that are just safe."""

    def missing(self, document: Mapping[str, Plain], parameters: Mapping[str, Parameter]) -> Iterator[Finding]:
        """A finding for each parameter of every shield that is missing, and for those of a plate."""
        for name in PLATE:
            if document.get(name) is not None:
                yield Finding(name, shown(document[name]), "a shield has a bumper", nearest_cure(name, NEEDED))
        for name in NEEDED:
            if document.get(name) is None:
                yield Finding(name, "nothing", f"a shield has {', '.join(NEEDED)}", f"give {name}")

    def shot(self, stated: Stated, materials: Mapping[str, Material]) -> ShotAtShield:
        """The shot; raises InvalidInput for bumpers that make no shield, and a wall without a yield stress."""
        further = {name: value for name, value in stated.items() if name in declared(FurtherBumpers)}
        if findings := [*nested(FurtherBumpers, further).check()]:
            raise InvalidInput(findings)
        whole = {**dict.fromkeys((*BUMPERS, "wall"), stated["bumper"]), **stated}
        shot = super().shot(whole, materials)
        assert isinstance(shot, ShotAtShield)
        stress = float(stated.get("wall_yield_stress", shot.shield.wall_yield_stress))
        if math.isnan(stress):
            cure = "give wall_yield_stress, for instance 276 MPa"
            raise refusal("wall", whole["wall"], "a material that states a yield stress", cure)
        return reshielded(shot, wall_yield_stress=stress)

    def picture(self, shot: Shot) -> Figure:
        """Critical diameter against speed, with every equation and the shots on shields like it."""
        from studies.shields.picture import picture

        assert isinstance(shot, ShotAtShield)
        return picture(shot)

    def sizes(self, shot: Shot) -> Sequence[tuple[str, float]]:
        """Stand-off and wall."""
        if not isinstance(shot, ShotAtShield):
            return ()
        return ("", shot.shield.stand_off), ("wall", shot.shield.wall_thickness)


TARGET = AnsweredShield(
    name="shield",
    quantities=(CRITICAL_DIAMETER, "hole_diameter"),  # its bumper is a plate
    parameters=ShieldParameters,
    roles=("projectile", *BUMPERS, "wall"),
    example=Path(__file__).with_name("shield.yaml"),
    adds="studies.shields.shots.answers:ShieldAnswer",
    untold=(CRITICAL_DIAMETER,),
    templates={
        "note": "studies.shields:answer_note.html",
        "first": "studies.shields:answer_first.html",
        "last": "studies.shields:answer_last.html",
    },
)
