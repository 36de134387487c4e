"""Decks of MPM3D: the thesis' appendix, its bar, and the detonation of MPM3D-F90's Deto1k."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from solver.problem import Problem
from solver.simulation import simulate, start
from studies import scenarios
from studies.runs.run import materials_of, resolve
from studies.scenarios._deck import read_deck
from studies.verification._column import profile
from studies.verification._detonation import TNT, chapman_jouguet
from studies.verification.chapman_jouguet import STATE, at_front
from tests.claims import Row, at_most, claim, equal, relative
from tests.studies.support.decks import appendix_deck, bar_deck, detonation_deck

STEPS = 200
CELLS = 1600


def _problem(scenario: str, **parameters: Any) -> Problem:
    run = resolve(scenario, parameters, {})
    chosen = scenarios.load(scenario)
    return chosen.build(chosen.parameters(**run.parameters), materials_of(run)).problem


@claim(
    "appendix-a",
    says="the deck of the thesis' appendix A is read line by line: 1200 nodes and 260 particles, and its 400 steps "
    "keep energy and momentum",
)
def appendix_a() -> Iterator[Row]:
    """The counts, and the run to its end."""
    deck = read_deck(appendix_deck())
    yield equal("nodes", expected=1200, got=deck.nodes)
    yield equal("particles", expected=260, got=deck.particles)
    outcome = simulate(_problem("deck", deck=appendix_deck()))
    yield equal("steps", expected=400, got=outcome.snapshot.step)
    audit = outcome.audit
    yield at_most("drift of the energy", limit=1e-10, got=abs(audit.energy_drift))
    yield at_most("error of the momentum", limit=1e-10, got=audit.momentum_error)


@claim("deck-bar", says="the deck of the thesis' elastic bar equals its scenario bit for bit")
def deck_bar() -> Iterator[Row]:
    """Every number of every particle after some steps."""
    own = _problem("elastic_bar", geometry="quarter", recipe="thesis", wall="symmetric", fixed_dt=1e-8)
    text = bar_deck(own, young=100e9, poisson=0.3)
    first, second = (start(each) for each in (own, _problem("deck", deck=text)))
    for _ in range(STEPS):
        first.advance()
        second.advance()
    differing = int((first.table != second.table).sum())
    yield equal(f"numbers that differ after {STEPS} steps", expected=0, got=differing)


@claim("deto1k", says="the deck of a TNT bar reaches Chapman's and Jouguet's state within 2 %")
def deto1k() -> Iterator[Row]:
    """By the definition of the verification case, on a deck written here."""
    outcome = simulate(_problem("deck", deck=detonation_deck(CELLS)))
    line = profile(outcome.snapshot, 0)
    exact, speed = chapman_jouguet(TNT), line.place / line.time
    for name, expected, values in (
        ("pressure (GPa)", exact.pressure / 1e9, line.stress / 1e9),
        ("density (kg/m3)", exact.density, line.density),
        ("velocity (m/s)", exact.velocity, line.velocity),
    ):
        got = at_front(speed, np.asarray(values))
        yield relative(f"TNT, {CELLS} cells: {name}", expected=expected, got=got, within=STATE)
