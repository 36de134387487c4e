"""Samples of decks for the tests that all measurements and scenarios share, and their states."""

from collections.abc import Callable
from typing import Any

import numpy as np

from studies.decks.whole import WholeView
from tests.samples import ANY
from tests.studies.decks.texts import appendix_deck, detonation_deck, fluid_deck, soil_deck


def whole(speed: float) -> WholeView:
    """Three particles of 1, 2 and 3 kg, the heaviest with a speed (m/s) along each axis."""
    velocity = np.zeros((3, 3))
    velocity[2] = speed, 2.0 * speed, -speed
    return WholeView(
        mass=np.array([1.0, 2.0, 3.0]),
        velocity=velocity,
        energy=np.array([10.0, 0.0, -1.0]),
        pressure=np.array([-5e9, 2e9, 1e9]),
    )


STATES: dict[type, dict[str, Callable[[], Any]]] = {
    WholeView: {"at rest": lambda: whole(0.0), "in flight": lambda: whole(300.0)}
}

SMALL = {"deck": {"deck": appendix_deck()}}
RESOLUTION = {"deck": ("refinement", "refinement")}
DIMENSIONS = {"deck": 3}
VARIED = [(("deck",), (*ANY, {"contact": "none"}, {"refinement": 2}, {"step": "stable"}, {"end_time": 1e-6}))]
COMPILED_ALONE = tuple(("deck", {"deck": deck}) for deck in (detonation_deck(20), soil_deck(), fluid_deck()))
CASES = {"deck": ("deck", {"end_time": 1e-5})}
REFUSED = [
    ("deck", {"step": "stable", "fixed_dt": 1e-8}, "fixed_dt", "leave fixed_dt out"),
    ("deck", {"contact": "none", "friction": 0.2}, "friction", "0 for bodies without contact"),
]
