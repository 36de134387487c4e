"""Bitwise equal results for one and two threads, and for a resumed run, with every choice of numerics."""

import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, get_args

from solver.checkpoints import Checkpointing
from solver.errors import Interrupted
from solver.problem import Problem
from solver.registry import entries
from solver.simulation import Outcome, Simulation, simulate
from studies.quantities.numerical_defaults import Recipe, SchemeName
from tests.cases.verification import case
from tests.cases.verification.setups.impacts import advanced, differing_values, impact_setting
from tests.claims.rows import Row, at_least, at_most

# Past the first reordering of the particles (every 50 steps), so that a restart falls between two.
STEPS = {"axisymmetric": 70, "quarter": 60}
STOPPED_AFTER = 33
# Tension comes late: the first particles fail after 120 steps, forty of them before the stop and a hundred after it.
LATE_STEPS, LATE_STOPPED_AFTER = 160, 140
# Of the particles of each body, one for each of two threads and one that has to wait.
SHARES = 3
# Across the diameter: the shares of each body and the nodes are work for two threads, and shares meet at nodes.
CELLS = {"axisymmetric": 26.0, "quarter": 8.0}
PARTICLES_PER_CELL = 3
# Of a cell: GIMP particles whose edge lies on a node leave it a mass of round-off, with which USL cannot live.
OFFSET = 0.3
SOME = 1e-9  # of the energy, or one particle: an addition that does nothing proves nothing


@dataclass(frozen=True)
class Addition:
    """An addition to a recipe that is off by default."""

    parameters: Mapping[str, Any]
    sign: str  # of its having acted, in words
    shown: Callable[[Simulation], float]  # above zero where it did
    steps: int = STEPS["axisymmetric"]
    stopped_after: int = STOPPED_AFTER


# In the plane only.
ADDITIONS = {
    "damping": Addition(
        {"damping_rate": 1e5, "damping_order": 2},
        "energy that it took (of the initial)",
        lambda simulation: simulation.audit().removed_energy,
    ),
    "contact": Addition(
        {"contact": "bardenhagen", "friction": 0.3},
        "energy that it took (of the initial)",
        lambda simulation: simulation.audit().contact_energy,
    ),
    "contact at the gap": Addition(
        {"contact": "gap", "friction": 0.3},
        "energy that it took (of the initial)",
        lambda simulation: simulation.audit().contact_energy,
    ),
    # The wave comes to the rim of a narrow plate as late.
    "absorbing": Addition(
        {"edges": "absorbing", "plate_radius": 5e-3},
        "energy that it took (of the initial)",
        lambda simulation: simulation.audit().removed_energy,
        LATE_STEPS,
        LATE_STOPPED_AFTER,
    ),
    "failure": Addition(
        {"failure": "spall", "failure_time": 1e-9},
        "particles that failed",
        lambda simulation: simulation.counters.failed,
        LATE_STEPS,
        LATE_STOPPED_AFTER,
    ),
}


@case(
    "bits",
    says="threads and restarts change no bit, for every shape, scheme and geometry",
    source="sums in a fixed order",
)
def _run(recipe: Recipe) -> Iterator[Row]:
    for geometry in CELLS:
        for shape in entries("solver.grid.shapes", "SHAPE"):
            for scheme in get_args(SchemeName):
                chosen = replace(recipe, shape=shape, scheme=scheme)
                where, problem = f"{geometry}, {shape}, {scheme}", impact(geometry, chosen)
                yield from rows_of(where, problem, STEPS[geometry], STOPPED_AFTER)
    for name, addition in ADDITIONS.items():
        where = f"axisymmetric, {name}"
        problem = impact("axisymmetric", recipe, **addition.parameters)
        yield from rows_of(where, problem, addition.steps, addition.stopped_after)
        got = addition.shown(advanced(problem, addition.steps, shares=SHARES))
        yield at_least(f"{where}: {addition.sign}", limit=SOME, got=got)


def impact(geometry: str, recipe: Recipe, **parameters: Any) -> Problem:
    """The impact of a geometry."""
    setting = impact_setting(
        replace(recipe, particles_per_cell=PARTICLES_PER_CELL),
        geometry=geometry,
        material="copper-ofhc",
        offset=OFFSET,
        cells_per_diameter=CELLS[geometry],
        **parameters,
    )
    return setting.problem


def rows_of(where: str, problem: Problem, steps: int, stopped_after: int) -> Iterator[Row]:
    """Values that differ between one thread and two, and after a restart."""
    single, double = (advanced(problem, steps, threads=threads, shares=SHARES) for threads in (1, 2))
    bits = differing_values(single.particles, double.particles) + (single.time != double.time)
    bits += (single.audit() != double.audit()) + (single.counters != double.counters)
    yield at_most(f"{where}: values that differ between one thread and two", limit=0, got=bits)
    problem = replace(problem, end_time=single.time)
    through, restarted = _through(problem), _stopped_and_resumed(problem, stopped_after)
    bits = differing_values(through.snapshot.particles, restarted.snapshot.particles)
    bits += sum(
        getattr(through, name) != getattr(restarted, name)
        for name in ("audit", "counters", "smallest_step", "particle_steps")
    )
    yield at_most(f"{where}: values that differ after a restart", limit=0, got=bits)


def _through(problem: Problem) -> Outcome:
    return simulate(problem, threads=1, shares=SHARES)


def _stopped_and_resumed(problem: Problem, steps: int) -> Outcome:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "checkpoint"
        messages: list[str] = []
        leaving = Checkpointing(path=path, must_stop=_after(steps))
        resuming = Checkpointing(path=path, log=messages.append)
        try:
            simulate(problem, threads=1, shares=SHARES, checkpoint=leaving)
        except Interrupted:
            outcome = simulate(problem, threads=1, shares=SHARES, checkpoint=resuming)
    if not messages or not messages[0].startswith("from the checkpoint"):
        raise AssertionError(f"the run did not go on from its checkpoint: {messages}")
    return outcome


def _after(steps: int) -> Callable[[], bool]:
    """True from the call with that number on."""
    calls = 0

    def leave() -> bool:
        nonlocal calls
        calls += 1
        return calls >= steps

    return leave


CASE = _run
