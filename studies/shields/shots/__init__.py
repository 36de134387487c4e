"""Shots on Whipple shields: outcomes of the wall, published or the user's own, and what they say about a shield.

``table`` reads, screens and finds them; ``judged`` counts how often each equation was right; ``chance`` makes of
the margins of the equations the probability that the wall fails, and ``joined`` joins it with a simulation;
``answers`` has all of that for a designer's shield.
"""

from studies.observations.tables import ShotTable


def _count() -> int:
    from studies.shields.shots.table import published

    return len(published().shots)


TABLE = ShotTable(
    "shields",
    "Spheres on Whipple shields of two aluminium walls, each with whether the wall was perforated, from the collection "
    "of Ryan and Schonberg (pyBLOSSUM).",
    "/shots/shields",
    _count,
)
