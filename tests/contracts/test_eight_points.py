"""Every law gives eight points at a time in a kernel the numbers that it gives point by point in plain Python."""

import math
from typing import Any

import numpy as np
import pytest

from solver.eos import below_range, outside_range, reference_density
from solver.jit import kernel
from solver.problem import ArtificialViscosity, Matter
from solver.stress import PointState, advance, signal_speed
from solver.vectors import LANES, first_lanes, load, store, where
from tests.contracts import test_eos, test_failure, test_strength, test_tension
from tests.solver.bodies import ROOM, SPACING, real_copper

POINTS = 5 * LANES + 3
DT = 1e-9
# Of the largest: what is left of fused additions where large stresses nearly cancel.
ROUND_OFF = 1e-12
VISCOSITY = ArtificialViscosity()

KINDS: tuple[dict[str, Any], ...] = (
    {f"eos={name}": test_eos.made(name) for name in test_eos.FORMS},
    {f"strength={name}": test_strength.copper(name) for name in test_strength.MEMBERS},
    {f"failure={name}": test_failure.copper(name) for name in test_failure.MEMBERS},
    {f"tension={name}": entry.record(*test_tension.COPPER[name]) for name, entry in test_tension.MEMBERS.items()},
)
# Each law once, with laws of the other kinds beside it: a kernel is compiled for each of these, so there are few.
LAWS: dict[str, Matter] = {
    " ".join(laws): real_copper()._replace(
        **{name.split("=")[0]: kind[name] for name, kind in zip(laws, KINDS, strict=True)}
    )
    for laws in ([list(kind)[number % len(kind)] for kind in KINDS] for number in range(max(map(len, KINDS))))
}
LAWS["never melts"] = real_copper()._replace(melt_temperature=math.inf)
NAMES = (
    *("density", "energy", "pressure", "viscosity", "s11", "s22", "s33", "s12", "s23", "s31"),
    *("plastic strain", "temperature", "damage", "energy to come", "tension floor", "molten"),
    *("unstable", "beyond", "below", "signal speed", "sound floor", "hardened", "stored"),
)


@kernel
def by_eights(matter, viscosity, gradients, states, dt, out):
    """All that a step makes of points, as the strain update takes it: rows of ``NAMES``."""
    count = states.shape[1]
    for p in range(0, count, LANES):
        lanes = first_lanes(count - p)
        gradient = (
            (load(gradients, 0, p, lanes), load(gradients, 1, p, lanes), load(gradients, 2, p, lanes)),
            (load(gradients, 3, p, lanes), load(gradients, 4, p, lanes), load(gradients, 5, p, lanes)),
            (load(gradients, 6, p, lanes), load(gradients, 7, p, lanes), load(gradients, 8, p, lanes)),
        )  # fmt: skip
        stress = (
            load(states, 4, p, lanes),
            load(states, 5, p, lanes),
            load(states, 6, p, lanes),
            load(states, 7, p, lanes),
            load(states, 8, p, lanes),
            load(states, 9, p, lanes),
        )
        old = PointState(
            load(states, 0, p, lanes),
            load(states, 1, p, lanes),
            load(states, 2, p, lanes),
            load(states, 3, p, lanes),
            stress,
            load(states, 10, p, lanes),
            load(states, 11, p, lanes),
            load(states, 12, p, lanes),
            load(states, 13, p, lanes),
            load(states, 14, p, lanes),
        )
        new, present, acts = advance(matter, viscosity, SPACING, dt, gradient, old)
        store(out, 0, p, new.density, lanes)
        store(out, 1, p, new.energy, lanes)
        store(out, 2, p, new.pressure, lanes)
        store(out, 3, p, new.viscosity, lanes)
        for c in range(6):
            store(out, 4 + c, p, new.deviator[c], lanes)
        store(out, 10, p, new.plastic_strain, lanes)
        store(out, 11, p, new.temperature, lanes)
        store(out, 12, p, new.damage, lanes)
        store(out, 13, p, present, lanes)
        store(out, 14, p, where(acts.tension_floor, 1.0, 0.0), lanes)
        store(out, 15, p, where(acts.molten, 1.0, 0.0), lanes)
        store(out, 16, p, where(acts.unstable, 1.0, 0.0), lanes)
        store(out, 17, p, where(outside_range(matter.eos, new.density), 1.0, 0.0), lanes)
        store(out, 18, p, where(below_range(matter.eos, new.density), 1.0, 0.0), lanes)
        rate = gradient[0][0] + gradient[1][1] + gradient[2][2]
        signal, floored = signal_speed(matter, viscosity, SPACING, rate, new)
        store(out, 19, p, signal, lanes)
        store(out, 20, p, where(floored, 1.0, 0.0), lanes)
        store(out, 21, p, new.hardened, lanes)
        store(out, 22, p, new.stored, lanes)


def one_by_one(matter: Matter, gradients: np.ndarray, states: np.ndarray) -> np.ndarray:
    """The same, point by point in plain Python."""
    columns = []
    for state, row in zip(states.T, gradients.T, strict=True):
        gradient = row.reshape(3, 3)
        density, energy, pressure, viscosity, *stress = state[:10]
        strain, *rest = state[10:]
        deviator = (stress[0], stress[1], stress[2], stress[3], stress[4], stress[5])
        old = PointState(density, energy, pressure, viscosity, deviator, strain, *rest)
        new, present, acts = advance(matter, VISCOSITY, SPACING, DT, gradient, old)
        rate = np.trace(gradient)
        beyond = outside_range(matter.eos, new.density), below_range(matter.eos, new.density)
        signal = signal_speed(matter, VISCOSITY, SPACING, rate, new)
        rows = (*new[:4], *new.deviator, *new[5:8], present, *acts, *beyond, *signal, *new[8:])
        columns.append(rows)
    return np.array(columns, float).T


def points(matter: Matter) -> tuple[np.ndarray, np.ndarray]:
    """Gradients (9, n) and states (15, n): at rest, compressed, stretched, cold, hot, molten, worked, broken."""
    random = np.random.default_rng(5)

    def anything(low: float, high: float) -> np.ndarray:
        return random.uniform(low, high, POINTS)

    def some(*values: float) -> np.ndarray:
        return random.choice(values, POINTS)

    density = reference_density(matter.eos)
    stress = random.uniform(-2e8, 2e8, (6, POINTS))
    stress[:3] -= stress[:3].mean(axis=0)
    states = np.array(
        [
            density * np.where(some(0, 1) > 0, anything(0.9, 1.1), np.exp(anything(-5.0, 1.4))),
            np.where(some(0, 1) > 0, anything(-1e4, 1e5), anything(0.0, 1e7)),
            np.where(some(0, 1) > 0, anything(-3e9, 3e9), anything(-2e11, 2e11)),
            some(0.0, 1e8),
            *stress,
            some(0.0, 1e-6, 0.05, 0.4, 2.0),
            np.where(some(0, 1) > 0, anything(ROOM - 50.0, 1400.0), some(ROOM, 5000.0)),
            some(0.0, 0.0, 0.0, 0.5, 1.0),
        ]
    )
    gradients = random.uniform(-1.0, 1.0, (9, POINTS)) * some(0.0, 1e4, 1e6, 5e7)
    history = some(0.0, 1e-6, 0.05, 0.4, 2.0), some(0.0, 0.0, 1e3, 1e5)
    states = np.vstack((states, history))
    states[:, 0] = density, 0.0, 0.0, 0.0, *np.zeros(6), 0.0, ROOM, 0.0, 0.0, 0.0
    gradients[:, 0] = 0.0
    return gradients, states


@pytest.mark.parametrize("law", LAWS)
def test_law__is_the_same_for_eight_points_as_for_one(law: str) -> None:
    matter = LAWS[law]
    gradients, states = points(matter)
    expected = one_by_one(matter, gradients, states)
    got = np.zeros(expected.shape)
    by_eights(matter, VISCOSITY, gradients, states, DT, got)
    assert np.isfinite(expected).all()
    for name, one, other in zip(NAMES, got, expected, strict=True):
        assert np.allclose(one, other, rtol=0.0, atol=ROUND_OFF * np.abs(other).max()), name


def test_points__come_to_every_branch() -> None:
    """Of copper's laws: each safeguard acts on some points and not on others, and some of them yield and fail."""
    matter = real_copper()._replace(failure=test_failure.copper("spall"))
    gradients, states = points(matter)
    result = dict(zip(NAMES, one_by_one(matter, gradients, states), strict=True))
    cold = dict(zip(NAMES, one_by_one(real_copper(), gradients, states), strict=True))
    for name in ("molten", "unstable", "beyond", "sound floor"):
        assert 0 < result[name].sum() < POINTS, name
    assert 0 < cold["tension floor"].sum() < POINTS
    slip = result["plastic strain"] > states[10]
    assert 0 < slip.sum() < POINTS
    fails = (result["damage"] >= 1.0) & (states[12] < 1.0)
    assert 0 < fails.sum() < POINTS
