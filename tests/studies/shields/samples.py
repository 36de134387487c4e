"""Shields for shared tests: the shot that a law of their critical diameter is asked about, and a question."""

from studies.laws import Law, Shot
from studies.shields.shield import CRITICAL_DIAMETER, FurtherBumper, Shield, at_shield


def _shield(law: Law, scale: float = 1.0) -> Shield:
    """A shield, all lengths times a scale; with a second bumper for a law that is about three walls."""
    further = (FurtherBumper(1e-3 * scale, 0.05 * scale),) if law.name.endswith("three_walls") else ()
    return Shield(2e-3 * scale, 4e-3 * scale, 0.1 * scale, 345e6, further_bumpers=further)


def _at_shield(law: Law, shot: Shot, scale: float) -> Shot:
    return at_shield(shot, _shield(law, scale))


def _arguments(law: Law) -> tuple[float, float, Shield]:
    return 2700.0, 2800.0, _shield(law)


LAW_SHOTS = {CRITICAL_DIAMETER: _at_shield}  # by the quantity of laws: of a shot at the bumper
FORMULA_ARGUMENTS = {CRITICAL_DIAMETER: _arguments}  # behind the speed
# To laws and shots.
QUESTION = {
    "speed": "7 km/s",
    "projectile": "al-2017-t4",
    "projectile_diameter": "5 mm",
    "bumper": "al-6061-t6",
    "bumper_thickness": "1.2 mm",
    "stand_off": "10 cm",
    "wall_thickness": "3.2 mm",
    "wall_yield_stress": "275.8 MPa",
}
