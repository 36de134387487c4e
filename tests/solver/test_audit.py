"""Sums and balances of states that can be added up by hand."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from solver.audit import Audit, Books, Ledger, Totals, audit, totals
from solver.problem import ArtificialViscosity, Contact
from solver.problem.geometry import impact_axis
from solver.simulation import simulate, start
from solver.state import Particles, empty_table, views
from tests.solver.bodies import ROUND_OFF, box, leaving, two_blocks


def three() -> Particles:
    """Three particles: 1 kg along x at 2 m/s, 2 kg along -x at 1 m/s, 4 kg at rest with 5 J/kg."""
    particles = views(empty_table(3))
    particles.mass[:] = (1.0, 2.0, 4.0)
    particles.velocity[:, 0] = (2.0, -1.0, 0.0)
    particles.energy[:] = (0.0, 0.0, 5.0)
    return particles


def balance(particles: Particles, start: Totals | None = None, **changes: Any) -> Audit:
    geometry = changes.pop("geometry", box(4, 4, 4))
    books = Books(**{"start": start or totals(three()), "ledger": Ledger(), "impulse": np.zeros(3), **changes})
    return audit(geometry, particles, books, time=1.0)


def put(name: str, index: Any, value: float) -> Callable[[Particles], None]:

    def change(particles: Particles) -> None:
        getattr(particles, name)[index] = value

    return change


@pytest.mark.parametrize(
    ("change", "mass", "momentum", "energy"),
    [
        (put("mass", 2, 4.0), 0.0, 0.0, 0.0),  # what it is
        (put("mass", 0, 0.3), 0.7 / 7.0, 1.4 / 4.0, -1.4 / 23.0),
        (put("velocity", (2, 1), 0.1), 0.0, 0.4 / 4.0, 0.02 / 23.0),
        (put("velocity", (2, 0), 1.0), 0.0, 4.0 / 4.0, 2.0 / 23.0),
        (put("energy", 2, 6.0), 0.0, 0.0, 4.0 / 23.0),
        (put("alive", 2, 0), 4.0 / 7.0, 0.0, -20.0 / 23.0),  # left without being recorded
    ],
)
def test_audit__sees_what_appears_and_what_is_missing(
    change: Callable[[Particles], None], mass: float, momentum: float, energy: float
) -> None:
    particles = three()
    change(particles)
    result = balance(particles)
    assert result.mass_error == pytest.approx(mass)
    assert result.momentum_error == pytest.approx(momentum)
    assert result.energy_drift == pytest.approx(energy)


@pytest.mark.claim("numerics", "viscosity-work")
def test_audit__computes_no_term_from_the_balance() -> None:
    """Switching off the work of the artificial viscosity makes the energy audit see it."""
    whole, short = (
        simulate(two_blocks("axisymmetric", viscosity=ArtificialViscosity(heating=heating))).audit
        for heating in (1.0, 0.0)
    )
    assert abs(whole.energy_drift) < ROUND_OFF
    assert short.energy_drift < -0.01


@pytest.mark.parametrize("kind", ["axisymmetric", "cartesian"])
def test_bodies__sum_to_the_audited_totals(kind: str) -> None:
    """Energy by kind and body, with what departed and what was removed, is all that the audit knows."""
    problem = replace(leaving(kind, end_time=2e-6), contact=Contact())
    outcome, initial = simulate(problem, interval=0.5e-6), start(problem).books.start
    energy = initial.kinetic + initial.internal
    axis = impact_axis(problem.geometry)
    assert outcome.audit.bodies[1].departed_kinetic > 0.0
    for balanced in outcome.history:
        kinds = ("kinetic", "internal", "departed_kinetic", "departed_internal")
        sums = sum(getattr(body, name) for body in balanced.bodies for name in kinds)
        whole = energy * (1.0 + balanced.energy_drift)
        assert sums + balanced.exchanged.removed == pytest.approx(whole, rel=ROUND_OFF)
        momentum = sum(body.momentum + body.departed_momentum for body in balanced.bodies)
        momentum -= balanced.exchanged.impulse
        assert momentum == pytest.approx(initial.momentum[axis], rel=ROUND_OFF)


def test_hottest_energy_share__counts_particles_whatever_their_mass() -> None:
    """A thousand warm grains beside cold ones of a thousand times their mass are no runaway; a single hot one is."""
    particles = views(empty_table(2000))
    particles.mass[:1000], particles.mass[1000:] = 1.0, 1e3
    particles.energy[:1000] = 1.0
    assert balance(particles, totals(particles)).hottest_energy_share == pytest.approx(2.0 / 1000.0)
    particles.energy[0] = 3000.0
    assert balance(particles, totals(particles)).hottest_energy_share == pytest.approx(3001.0 / 3999.0)
