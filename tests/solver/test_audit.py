"""Sums and balances of states that can be added up by hand."""

from typing import Any

import numpy as np
import pytest

from solver.audit import HOTTEST_SHARE, Audit, Ledger, Totals, audit, totals
from solver.problem import ArtificialViscosity
from solver.simulation import simulate
from solver.state import Particles, empty_table, views
from tests.solver.bodies import box, two_blocks

CARTESIAN, AXISYMMETRIC = box(4, 4, 4), box(4, 4)
NO_IMPULSE = np.zeros(3)


def three() -> Particles:
    """Three particles: 1 kg along x at 2 m/s, 2 kg along -x at 1 m/s, 4 kg at rest with 5 J/kg."""
    particles = views(empty_table(3))
    particles.mass[:] = (1.0, 2.0, 4.0)
    particles.velocity[:, 0] = (2.0, -1.0, 0.0)
    particles.energy[:] = (0.0, 0.0, 5.0)
    return particles


def balance(
    particles: Particles,
    start: Totals,
    *,
    geometry: object = CARTESIAN,
    ledger: Ledger | None = None,
    impulse: np.ndarray = NO_IMPULSE,
) -> Audit:
    return audit(
        geometry, particles, time=1.0, start=start, ledger=ledger or Ledger(), impulse=impulse
    )


def test_totals__are_the_sums() -> None:
    sums = totals(three())
    assert sums.mass == 7.0
    assert sums.momentum.tolist() == [0.0, 0.0, 0.0]
    assert sums.kinetic == 3.0
    assert sums.internal == 20.0
    assert sums.momentum_scale == 4.0


def test_totals__of_some_particles_leave_the_others_out() -> None:
    assert totals(three(), np.array([0, 2])).mass == 5.0


def test_audit__of_the_initial_state_finds_nothing() -> None:
    found = balance(three(), totals(three()))
    assert (found.mass_error, found.momentum_error, found.energy_drift) == (0.0, 0.0, 0.0)
    assert (found.kinetic, found.internal, found.largest_speed) == (3.0, 20.0, 2.0)


def test_audit__sees_missing_mass() -> None:
    start = totals(three())
    particles = three()
    particles.mass[0] = 0.3
    assert balance(particles, start).mass_error == pytest.approx(0.1)


def test_audit__sees_momentum_from_nowhere() -> None:
    start = totals(three())
    particles = three()
    particles.velocity[2, 1] = 0.1
    assert balance(particles, start).momentum_error == pytest.approx(0.4 / 4.0)


def test_audit__takes_the_impulse_of_the_faces_into_account() -> None:
    start = totals(three())
    particles = three()
    particles.velocity[2, 1] = 0.1
    impulse = np.array([0.0, 0.4, 0.0])
    assert balance(particles, start, impulse=impulse).momentum_error == pytest.approx(
        0.0, abs=1e-15
    )


def test_audit__does_not_ask_for_radial_momentum_about_an_axis() -> None:
    start = totals(three())
    particles = three()
    particles.velocity[2, 0] = 1.0
    assert balance(particles, start, geometry=AXISYMMETRIC).momentum_error == 0.0
    particles.velocity[2, 1] = 1.0
    assert balance(particles, start, geometry=AXISYMMETRIC).momentum_error == 1.0


@pytest.mark.parametrize("field", ["energy", "velocity"])
def test_audit__sees_energy_from_nowhere(field: str) -> None:
    start = totals(three())
    particles = three()
    getattr(particles, field)[2] += 1.0
    added = {"energy": 4.0, "velocity": 6.0}[field]
    assert balance(particles, start).energy_drift == pytest.approx(added / 23.0)


def test_audit__counts_what_left_in_the_ledger_and_no_longer_on_the_grid() -> None:
    start = totals(three())
    particles = three()
    gone = np.array([1, 2])
    ledger = Ledger().with_particles(particles, gone)
    particles.alive[gone] = 0
    found = balance(particles, start, ledger=ledger)
    assert (found.mass_error, found.momentum_error, found.energy_drift) == (0.0, 0.0, 0.0)
    assert (found.kinetic, found.internal) == (2.0, 0.0)
    assert found.outflow_mass == pytest.approx(6.0 / 7.0)
    assert found.outflow_energy == pytest.approx(21.0 / 23.0)


def test_audit__sees_what_left_without_being_booked() -> None:
    start = totals(three())
    particles = three()
    particles.alive[2] = 0
    found = balance(particles, start)
    assert found.mass_error == pytest.approx(4.0 / 7.0)
    assert found.energy_drift == pytest.approx(-20.0 / 23.0)


def test_ledger__adds_up_over_bookings() -> None:
    particles = three()
    ledger = Ledger().with_particles(particles, np.array([0]))
    ledger = ledger.with_particles(particles, np.array([2]))
    assert (ledger.mass, ledger.kinetic, ledger.internal, ledger.particles) == (5.0, 2.0, 20.0, 2)
    assert ledger.momentum.tolist() == [2.0, 0.0, 0.0]


def test_audit__finds_the_hottest_thousandth() -> None:
    count = 4000
    particles = views(empty_table(count))
    particles.mass[:] = 1.0
    particles.energy[:] = 1.0
    hot = round(HOTTEST_SHARE * count)
    particles.energy[7 : 7 + hot] = 1000.0
    share = balance(particles, totals(particles)).hottest_energy_share
    assert share == pytest.approx(hot * 1000.0 / (hot * 1000.0 + count - hot))


def test_audit__of_cold_matter_has_no_hottest_share() -> None:
    particles = three()
    particles.energy[:] = 0.0
    assert balance(particles, totals(particles)).hottest_energy_share == 0.0


def test_audit__of_a_world_at_rest_and_cold_divides_by_nothing() -> None:
    particles = views(empty_table(2))
    particles.mass[:] = 1.0
    found = balance(particles, totals(particles))
    assert (found.energy_drift, found.momentum_error, found.outflow_energy) == (0.0, 0.0, 0.0)


def test_audit__computes_no_term_from_the_balance() -> None:
    """Energy that the viscosity takes and does not give back stays missing."""
    blind: dict[str, Any] = {"viscosity": ArtificialViscosity(heating=0.0)}
    sound, short = (
        simulate(two_blocks("axisymmetric", end_time=1e-6, **changes)).audit.energy_drift
        for changes in ({}, blind)
    )
    assert abs(sound) < 1e-12
    assert short < -0.01
