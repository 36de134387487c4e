"""Every law gives eight points at a time in a kernel the numbers that it gives point by point in plain Python."""

import math
from typing import Any

import numpy as np
import pytest

from solver.grid.shapes.linear import Linear
from solver.matter.eos import below_range, outside_range, reference_density
from solver.matter.failure import weakens
from solver.matter.laws import Matter
from solver.matter.strength import stored_part
from solver.matter.strength.johnson_cook import JohnsonCook
from solver.matter.stress import JAUMANN, PointState, advance, signal_speed
from solver.matter.tension import linking
from solver.problem import ArtificialViscosity
from solver.problem.geometry import AXES
from solver.state import DAMPED, DENSITY, GROWN, HARDENED, MASS, empty_table, lines
from solver.steps.points import StateLimits, Tally, update_particles
from solver.steps.space import VELOCITY, Gridless, new_pack
from solver.vectors import LANES
from tests.claims.marked import claimed
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
# The sets of these are compiled in the claim alone, 2.3 s each (2026-11): the two longest laws stay, and small runs of
# ``test_regression`` have stored numbers of metals.
IN_THE_CLAIM = ("modified-johnson", "linear-hardening", "void-growth", "never melts", "=johnson-cook t", "=spall t")
SOFTENS = next(matter for matter in LAWS.values() if isinstance(matter.strength, JohnsonCook))
LAWS["never melts"] = SOFTENS._replace(melt_temperature=math.inf)
ORDINARY = [law for law in LAWS if not any(each in law for each in IN_THE_CLAIM)]
# Rows of the table that laws act on, and the counts and largest values of a step.
ROWS = (*range(DENSITY, GROWN + 1), *range(HARDENED, DAMPED + 1))
ACTS = ("tension_floors", "molten", "unstable")
COUNTS = (*ACTS, "beyond_hugoniot", "below_expansion", "sound_floors", "below_zero_kelvin", "failed")
ANYTHING = StateLimits(np.inf, 0.0, np.inf, np.inf)
LATE = 1.0  # s: what burns has burnt


def by_eights(matter: Matter, gradients: np.ndarray, states: np.ndarray, whole_work: int) -> tuple[np.ndarray, Tally]:
    """The rows of points after the update that all methods call, and its tally."""
    table, places = empty_table(POINTS, remembers=True), lines(AXES * POINTS)
    table[list(ROWS)], table[MASS] = states, 1.0
    for axis in range(AXES):
        places[axis::AXES, VELOCITY : VELOCITY + AXES] = gradients[axis::AXES].T
    space = Gridless(np.zeros(3), SPACING, np.ones(3, np.int64), AXES, np.zeros((1, POINTS)))
    tallies = np.zeros((1, len(Tally._fields)))
    laws = (matter, JAUMANN, VISCOSITY, ANYTHING)
    update_particles(space, Linear(), new_pack(), *laws, table, 0, POINTS, places, tallies, 0, LATE, DT, whole_work, 1)
    return table[list(ROWS)], Tally(*tallies[0].tolist())


def one_by_one(matter: Matter, gradients: np.ndarray, states: np.ndarray) -> dict[str, np.ndarray]:
    """The same, point by point in plain Python: each row, the energy to come, and what counts."""
    found, stores, opens = [], bool(stored_part(matter.strength) > 0.0), bool(linking(matter.tension) < 1.0)
    for state, row in zip(states.T, gradients.T, strict=True):
        gradient = row.reshape(3, 3)
        density, energy, pressure, viscosity, *stress = state[:10]
        strain, kelvin, damage, parted, grown, hardened, stored, *heat = state[10:]
        deviator = (stress[0], stress[1], stress[2], stress[3], stress[4], stress[5])
        old = PointState(
            density,
            energy,
            pressure,
            viscosity,
            deviator,
            strain,
            kelvin,
            damage,
            hardened,
            stored * stores,
            parted * opens,
            grown * opens,
        )
        new, present, acts = advance(matter, VISCOSITY, SPACING, DT, gradient, old)
        signal, floored = signal_speed(matter, VISCOSITY, SPACING, np.trace(gradient), new)
        failed = new.damage >= 1.0 > old.damage
        beyond, below = outside_range(matter.eos, new.density), below_range(matter.eos, new.density)
        *counted, sheared, pulled, damped = acts
        counts = (*counted, beyond, below, floored, new.temperature < 0.0, failed)
        kept = new.hardened if weakens(matter.failure) else hardened, new.stored if stores else stored
        kept = *kept, *(was + part for was, part in zip(heat, (sheared, pulled, damped), strict=True))
        rows = (
            *new[:4],
            *new.deviator,
            new.plastic_strain,
            max(new.temperature, 0.0),
            new.damage,
            *((new.parted, new.grown) if opens else (parted, grown)),
            *kept,
        )
        found.append((*rows, present, signal, *counts))
    columns = np.array(found, float).T
    last = len(ROWS)
    return {"rows": columns[:last], "present": columns[last], "signal": columns[last + 1]} | dict(
        zip(COUNTS, columns[last + 2 :], strict=True)
    )


def points(matter: Matter) -> tuple[np.ndarray, np.ndarray]:
    """Gradients (9, n) and states (20, n): at rest, compressed, stretched, cold, hot, molten, worked, broken."""
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
    history = some(0.0, 1e-6, 0.05, 0.4, 2.0), some(0.0, 0.0, 1e3, 1e5), *np.zeros((3, POINTS))
    states = np.vstack((states, some(0.0, 0.0, 1e6), some(0.0, 0.0, 3.0, 5.0), history))
    states[:, 0] = density, 0.0, 0.0, 0.0, *np.zeros(6), 0.0, ROOM, *np.zeros(8)
    gradients[:, 0] = 0.0
    return gradients, states


@pytest.mark.parametrize("law", claimed(LAWS, ORDINARY, "laws", "eight-points"))
def test_law__is_the_same_for_eight_points_as_for_one(law: str) -> None:
    """A kernel gives eight points at a time the numbers of each law point by point, to round-off."""
    matter = LAWS[law]
    gradients, states = points(matter)
    expected = one_by_one(matter, gradients, states)
    assert np.isfinite(expected["rows"]).all()
    for whole_work in (0, 1):
        got, tally = by_eights(matter, gradients, states, whole_work)
        if whole_work:
            expected["rows"][1] = expected["present"]
        for row, one, other in zip(ROWS, got, expected["rows"], strict=True):
            assert np.allclose(one, other, rtol=0.0, atol=ROUND_OFF * np.abs(other).max()), row
        assert {name: getattr(tally, name) for name in COUNTS} == {name: expected[name].sum() for name in COUNTS}
        largest = expected["signal"].max(), np.abs(gradients[[0, 4, 8]].sum(axis=0)).max()
        assert np.allclose((tally.signal, tally.volume_rate), largest, rtol=ROUND_OFF, atol=0.0)
        assert not tally.fault
