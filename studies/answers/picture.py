"""Pictures of an answer: the hole of a plate, or the depth of a crater, against speed, with every law and shot."""

from collections.abc import Iterator
from dataclasses import replace

from studies import laws
from studies.answers.answer import nearest, shot_in_words
from studies.answers.targets import targets
from studies.laws import Shot
from studies.reports.figure import OBSERVED, Figure, Panel, Scale, Series, numbers

SPEED = Scale("speed", "speed", "m s-1")
SLOWEST, FASTEST = 1e3, 12e3  # m/s: of the curves, as far as the shots go
POINTS = 45  # of a curve: every 250 m/s
SPEEDS = tuple(SLOWEST + (FASTEST - SLOWEST) * place / (POINTS - 1) for place in range(POINTS))


def picture(shot: Shot, target: str) -> Figure:
    """The picture of an answer: that of its target, or a quantity over the diameter against speed."""
    if (own := targets()[target].picture(shot)) is not None:
        return own
    name, symbol = targets()[target].drawn
    diameter = shot.projectile_diameter
    drawn = curves_of(name, shot, 1.0 / diameter)
    near = [seen.shot for seen in nearest(shot, target) if seen.shot.quantity == name and seen.shot.value is not None]
    measured = Series(
        "observation",
        OBSERVED,
        tuple(float(seen.parameters["speed"] or 0.0) for seen in near),
        tuple((seen.value or 0.0) / float(seen.parameters["projectile_diameter"] or 1.0) for seen in near),
        notes=tuple(f"{seen.source}; {seen.confidence}" for seen in near),
    )
    shots = (measured,) if near else ()
    return Figure(
        f"{name}_against_speed",
        f"{symbol} against speed, {shot.projectile.name} on {shot.target.name}",
        f"Laws that cover this {target} at some speed; dotted outside their range.",
        SPEED,
        Scale("ratio", symbol, "1"),
        (Panel(shot_in_words(shot), {}, (*drawn, *shots)),),
    )


def curves_of(quantity: str, shot: Shot, factor: float = 1.0) -> Iterator[Series]:
    """The laws of a quantity that may judge and cover the shot at some speed, over the speed."""
    for law in laws.answering(quantity):
        if law.use != "verdict":
            continue
        shots = [replace(shot, speed=speed) for speed in SPEEDS]
        inside = tuple(law.evaluate(shot, law.variants(shot)[0]).in_range for shot in shots)
        if any(inside):
            values = numbers(0.5 * factor * sum(law.band(shot)) for shot in shots)
            yield Series("curve", law.title, SPEEDS, values, in_range=inside)
