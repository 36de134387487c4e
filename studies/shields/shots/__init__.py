"""Shots on Whipple shields: outcomes of the wall, published or the user's own, and what they say about a shield.

``table`` reads, screens and finds them; ``judged`` counts how often each equation was right; ``chance`` makes of
the margins of the equations the probability that the wall fails, and ``joined`` says whether a simulation adds to it;
``answers`` has all of that for a designer's shield.
"""

from collections.abc import Sequence

from studies.observations.tables import Point, ShotTable


def _count() -> int:
    from studies.shields.shots.table import published

    return len(published().shots)


def _points() -> tuple[str, Sequence[Point], Sequence[Point]]:
    from studies.shields.shots.table import published

    failed, held = (
        [(shot.speed, shot.projectile_diameter) for shot in published().shots if shot.is_perforated is outcome]
        for outcome in (True, False)
    )
    return "Diameter of the projectile against speed: filled where the wall failed", failed, held


TABLE = ShotTable(
    "shields",
    "Spheres on Whipple shields of two aluminium walls, each with whether the wall was perforated, from the collection "
    "of Ryan and Schonberg (pyBLOSSUM).",
    "/shots/shields",
    _count,
    _points,
)
