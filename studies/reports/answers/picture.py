"""Pictures of an answer: critical diameter of a shield, or hole of a plate, against speed, with every law and shot."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from studies import laws
from studies.laws import Shot
from studies.observations.shields.probability import diameters_at
from studies.observations.shields.shots import ShieldShot, published
from studies.reports.answers.answer import ask, nearest, of_target
from studies.reports.figures import CHANCES, EVEN_CHANCE, FAILED, HELD, OBSERVED, THIS, Figure, Panel, Series
from studies.reports.view import Scale

if TYPE_CHECKING:
    from markupsafe import Markup

SPEED = Scale("speed", "speed", "m s-1")
SLOWEST, FASTEST = 1e3, 12e3  # m/s: of the curves, as far as the shots go
POINTS = 45  # of a curve: every 250 m/s
# A shield is like another where bumper, wall and distance are the same within a third or so, and the angle within 15
# degrees: the root of the summed squares of ln ratios and of the angle in rad.
LIKE = 0.4
DRAWN = (0.1, 0.5, 0.9)  # probabilities of failure


def picture(shot: Shot, target: str) -> Figure:
    """The picture of an answer; a block has crater depth over diameter against speed."""
    if target == "shield":
        return _of_shield(shot)
    name, symbol = ("hole_diameter", "D/d") if target == "plate" else ("crater_depth", "p/d")
    diameter = shot.projectile_diameter
    drawn = curves_of(name, shot, 1.0 / diameter)
    near = [each.shot for each in nearest(shot, target) if each.shot.quantity == name and each.shot.value is not None]
    seen = Series(
        "observation",
        OBSERVED,
        tuple(float(each.parameters["speed"] or 0.0) for each in near),
        tuple((each.value or 0.0) / float(each.parameters["projectile_diameter"] or 1.0) for each in near),
        notes=tuple(f"{each.source}; {each.confidence}" for each in near),
    )
    shots = (seen,) if near else ()
    title = f"{symbol} against speed, {shot.projectile.name} on {shot.target.name}"
    return Figure(
        f"{name}_against_speed",
        title,
        f"Laws that cover this {target} at some speed; dotted outside their range.",
        SPEED,
        Scale("ratio", symbol, "1"),
        (Panel(of_target(shot, target), {}, (*drawn, *shots)),),
    )


def _of_shield(shot: Shot) -> Figure:
    like = like_shields(shot)
    mine = Series("limit", THIS, (shot.speed,), (shot.projectile_diameter,))
    return Figure(
        "critical_diameter_against_speed",
        "Diameter of the projectile above which the wall fails, against speed",
        f"{len(like)} of {len(published().shots)} published shots are on shields like this one. "
        "Lines: equations, dotted outside their range. The probability has a curve for each range of the normal speed, "
        "below 3, 3 to 7 and from 7 km/s, and jumps between them.",
        SPEED,
        Scale("critical_diameter", "diameter of the projectile", "m"),
        (
            Panel(
                of_target(shot, "shield"),
                {},
                (*_chances(shot), *curves_of("critical_diameter", shot), *outcomes_of(like), mine),
            ),
        ),
    )


def like_shields(shot: Shot) -> list[ShieldShot]:
    """The published shots on shields like that of a shot, at any speed and of any diameter."""
    assert shot.shield is not None
    mine = shot.shield

    def apart(each: ShieldShot) -> float:
        pairs = (
            (each.bumper_thickness, mine.bumper_thickness),
            (each.wall_thickness, mine.wall_thickness),
            (each.stand_off, mine.stand_off),
        )
        return math.hypot(*(math.log(a / b) for a, b in pairs), each.obliquity - shot.obliquity)

    return [each for each in published().shots if apart(each) <= LIKE]


def outcomes_of(shots: Sequence[ShieldShot]) -> Iterator[Series]:
    """Published shots as marks: those whose wall failed, and those whose wall held."""
    for label, failed in ((FAILED, True), (HELD, False)):
        of = [each for each in shots if each.is_perforated is failed]
        if of:
            yield Series(
                "observation",
                label,
                tuple(each.speed for each in of),
                tuple(each.projectile_diameter for each in of),
                notes=tuple(f"{each.source} {each.shot}".strip() for each in of),
            )


def curves_of(quantity: str, shot: Shot, factor: float = 1.0) -> Iterator[Series]:
    """The laws of a quantity that may judge and cover the shot at some speed, over the speed."""
    for law in laws.answering(quantity):
        if law.use != "verdict":
            continue
        said = [ask(replace(shot, speed=speed))(law) for speed in _speeds()]
        if any(each.in_range for each in said):
            values = tuple(None if math.isnan(each.value) else each.value * factor for each in said)
            yield Series("curve", law.title, _speeds(), values, in_range=tuple(each.in_range for each in said))


def _chances(shot: Shot) -> Iterator[Series]:
    """The diameters that fail with the drawn probabilities, as a band and its middle; none without an equation."""
    each = [diameters_at(replace(shot, speed=speed), DRAWN) for speed in _speeds()]
    low, even, high = ([None if math.isnan(d) else d for d in column] for column in zip(*each, strict=True))
    inside = tuple(d is not None for d in even)
    if any(inside):
        yield Series("band", CHANCES, _speeds(), low=tuple(low), high=tuple(high), in_range=inside)
        yield Series("trend", EVEN_CHANCE, _speeds(), tuple(even))


def _speeds() -> tuple[float, ...]:
    return tuple(SLOWEST + (FASTEST - SLOWEST) * place / (POINTS - 1) for place in range(POINTS))


def draw(figure: Figure, file: Path) -> Path:
    """Draw the picture of an answer into a file, whose ending is its format: svg, png or pdf."""
    from studies.reports.drawing import charts

    return charts.draw(figure, file)


def drawn_for_page(figure: Figure) -> "Markup":
    """The picture as SVG in the widths of a page."""
    from studies.reports.drawing import charts

    return charts.of_page(figure, "answer")
