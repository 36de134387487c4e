"""Smoothed particles: their functions, neighbours, balances and bits, and what they refuse."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from solver.errors import ProblemError
from solver.methods.sph.rates import tensile_part
from solver.methods.sph.smoothing import factor, height, slope
from solver.problem import ArtificialViscosity, Body, Contact, Damping, Face, Problem, Smoothing, Traction
from solver.simulation import Simulation, start
from solver.state import DENSITY as DENSITY_ROW
from solver.state import PRESSURE, S11, S12, S22, S23, S31, S33
from tests.claims.rows import Row, at_least, at_most
from tests.solver.bodies import (
    DENSITY,
    FREE,
    SOUND_SPEED,
    SPACING,
    SYMMETRIC,
    after,
    assert_balanced,
    box,
    elastic_copper,
)

ROUND_OFF = 1e-12  # of sums over a few hundred particles in some steps, relative
STEPS = 12
SPEED = 500.0  # m/s
MERGING, REPELLING = (Smoothing(tensile=0.2, stiffness=k) for k in (0.0, 0.01))
each_contact = pytest.mark.parametrize("smoothing", [MERGING, REPELLING], ids=["merge", "repel"])


def block(name: str, begin: tuple[float, ...], counts: tuple[int, int, int], speed: float) -> Body:
    lines = [SPACING * (low + np.arange(count) + 0.5) for low, count in zip(begin, counts, strict=True)]
    position = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
    return Body(
        name=name,
        matter=elastic_copper(),
        position=position,
        velocity=np.array([0.0, 0.0, -speed]),
        mass=np.full(len(position), DENSITY * SPACING**3),
        density=DENSITY,
        spacing=(SPACING,) * 3,
    )


def impact(**changes: Any) -> Problem:
    """A quarter of a block that falls onto another: two planes of symmetry, the rest free."""
    bodies = (block("target", (0, 0, 3), (7, 7, 3), 0.0), block("flyer", (0, 0, 6), (3, 3, 3), SPEED))
    mirror = (Face.SYMMETRIC, Face.FREE)
    values: dict[str, Any] = {"geometry": box(12, 12, 12), "smoothing": MERGING, "end_time": 1.0}
    return Problem(**{"bodies": bodies, "faces": (mirror, mirror, FREE), "courant": 0.3, **values, **changes})


@pytest.mark.parametrize("dimensions", [1, 2, 3])
def test_smoothing_function__has_the_integral_1_and_its_own_slope(dimensions: int) -> None:
    q = np.linspace(0.0, 2.0, 20_001)
    shell = {1: 2.0 + 0.0 * q, 2: 2.0 * np.pi * q, 3: 4.0 * np.pi * q * q}[dimensions]
    w = height(q)
    assert factor(dimensions) * np.trapezoid(w * shell, q) == pytest.approx(1.0, rel=1e-7)
    inner = slice(1, -1)
    assert slope(q)[inner] * q[inner] == pytest.approx(np.gradient(w, q)[inner], abs=1e-3)


@each_contact
def test_impact__keeps_momentum_and_energy_to_round_off(smoothing: Smoothing) -> None:
    audit = after(impact(smoothing=smoothing), STEPS, shares=3).audit()
    assert_balanced(audit)


@pytest.mark.claim("methods", "smoothed-contact", minutes=0.1)
def test_contact__bars_exchange_their_momentum_about_a_spacing_apart_and_get_its_energy_back() -> None:
    """Bars of smoothed particles exchange their momentum about a spacing apart and get its energy back."""
    calm = Smoothing(viscosity=ArtificialViscosity(0.06, 1.5), stiffness=0.01)
    bars = (block("target", (0, 0, 33), (4, 4, 30), 0.0), block("flyer", (0, 0, 65), (4, 4, 30), 200.0))
    sides = (Face.SYMMETRIC, Face.SYMMETRIC)
    problem = replace(impact(geometry=box(4, 4, 130), smoothing=calm), bodies=bars, faces=(sides, sides, FREE))
    made, nearest, taken = start(problem), np.inf, []
    while made.time < 2.0 * 2.0 * SPACING / 200.0 + 4.0 * 30.0 * SPACING / 4700.0:
        made.advance()
        height, velocity = made.particles.position[:, 2], made.particles.velocity[:, 2]
        flyer = made.body == 1
        nearest = min(nearest, height[flyer].min() - height[~flyer].max())
        taken.append(made.books.removed_by_contact)
    initial = 0.5 * bars[1].mass.sum() * 200.0**2
    assert velocity[~flyer].mean() == pytest.approx(-200.0, rel=0.01)
    assert 1.0 < nearest / SPACING < 1.5
    assert max(taken) > 0.01 * initial
    assert abs(taken[-1]) < 1e-3 * initial


@pytest.mark.parametrize(("side", "direction"), [(0, 1.0), (1, -1.0)])
def test_traction__presses_a_body_inwards_at_either_end(side: int, direction: float) -> None:
    """The pressure times the area of nine particles times the step is what a step adds to the momentum.

    Velocities live half a step apart from places, so that the first step adds half of it.
    """
    pressure = 1e6  # Pa
    load = Traction(0, 2, side, np.array([0.0, 1.0]), np.full(2, pressure))
    bodies = (block("bar", (4, 4, 3), (3, 3, 6), 0.0),)
    step = 1e-9  # s
    simulation = after(impact(bodies=bodies, faces=(FREE,) * 3, tractions=(load,), fixed_dt=step), 1)
    momentum = simulation.particles.mass @ simulation.particles.velocity
    np.testing.assert_allclose(momentum[2], direction * pressure * 9.0 * SPACING**2 * 0.5 * step, rtol=ROUND_OFF)


def test_contact__half_a_block_at_a_plane_of_symmetry_meets_as_the_whole_one() -> None:
    """On the plane stand halves of particles."""

    def made(across: np.ndarray, symmetric: bool) -> Simulation:
        bodies = []
        for name, bottom, speed in (("target", 4.0, 0.0), ("flyer", 9.4, 50.0)):
            lines = (SPACING * across, SPACING * (3.0 + np.arange(3.0)), SPACING * (bottom + np.arange(4.0)))
            position = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
            mass = np.full(len(position), DENSITY * SPACING**3)
            mass[position[:, 0] == 0.0] *= 0.5
            whole = block(name, (0, 0, 0), (1, 1, 1), speed)
            bodies.append(replace(whole, position=position, mass=mass))
        faces = ((Face.SYMMETRIC if symmetric else Face.FREE, Face.FREE), FREE, FREE)
        problem = impact(geometry=box(16, 9, 18), smoothing=REPELLING, fixed_dt=2e-8)
        return after(replace(problem, bodies=tuple(bodies), faces=faces), STEPS)

    half, whole = made(np.arange(4.0), True), made(np.arange(5.0, 12.0), False)
    assert half.books.removed_by_contact > 0.0
    assert half.books.removed_by_contact == pytest.approx(0.5 * whole.books.removed_by_contact, rel=1e-9)
    assert half.audit().momentum_error < ROUND_OFF


def pulled(tensile: float) -> float:
    """Root mean square speed of a patch in uniaxial tension after 250 steps, that was disturbed by 1 m/s."""
    pull = 8e9
    thinner = 1.0 - pull / 3.0 / (DENSITY * SOUND_SPEED**2)
    patch = block("patch", (0, 0, 0), (8, 8, 8), 0.0)
    speeds = np.random.default_rng(1).uniform(-1.0, 1.0, patch.position.shape)
    patch = replace(patch, density=thinner * DENSITY, mass=thinner * patch.mass, velocity=speeds)
    made = start(
        Problem(
            geometry=box(8, 8, 8),
            bodies=(patch,),
            faces=(SYMMETRIC,) * 3,
            end_time=1.0,
            courant=0.3,
            smoothing=Smoothing(tensile=tensile),
        ),
        threads=1,
    )
    for component, share in ((S11, 2.0), (S22, -1.0), (S33, -1.0)):
        made.table[component] += share * pull / 3.0
    for _ in range(250):
        made.advance()
    return float(np.sqrt((made.particles.velocity**2).sum(axis=1).mean()))


@pytest.mark.claim("mend-again", "artificial-stress", minutes=1.0)
def test_artificial_stress__slows_the_clumping_of_a_patch_that_is_pulled(compared: Callable[[Row], None]) -> None:
    """A patch in tension clumps without artificial stress, and less with that of Gray, Monaghan and Swift."""
    without = pulled(0.0)
    compared(at_least("speed without artificial stress (m/s)", limit=1.0, got=without))
    compared(at_most("speed with 0.3 (m/s)", limit=without, got=pulled(0.3)))


def test_artificial_stress__opposes_each_principal_stress_that_pulls() -> None:
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    table = np.zeros((max(DENSITY_ROW, PRESSURE, S11, S22, S33, S12, S23, S31) + 1, 1))
    stress = turn @ np.diag([3e9, -2e9, 1e9]) @ turn.T
    pressure = -np.trace(stress) / 3.0
    table[DENSITY_ROW], table[PRESSURE] = DENSITY, pressure
    rows = (S11, S22, S33, S12, S23, S31)
    places = ((0, 1, 2, 0, 1, 2), (0, 1, 2, 1, 2, 0))
    table[rows, 0] = (stress + pressure * np.eye(3))[places]
    expected = 0.3 * turn @ np.diag([3e9, 0.0, 1e9]) @ turn.T / DENSITY**2
    got = tensile_part(Smoothing(tensile=0.3), table)
    np.testing.assert_allclose(got[0], expected[places], rtol=1e-10, atol=1e-8)


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"contact": Contact()}, "contact"),
        ({"damping": Damping(1e5)}, "damping"),
        ({"geometry": box(12, 12)}, "axisymmetric"),
        ({"smoothing": Smoothing(ratio=0.5)}, "ratio"),
    ],
)
def test_problem__that_smoothed_particles_do_not_compute_is_refused_by_name(changes: dict[str, Any], word: str) -> None:
    with pytest.raises(ProblemError, match=word):
        start(impact(**changes))
