"""The same bits for one and two threads, and for a run that was stopped and went on, whatever the numerics."""

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, get_args

from studies.recipes import Recipe, SchemeName, Shape
from studies.verification import Case, Row, at_most
from studies.verification._impacts import advanced, differing_values, impact_setting

if TYPE_CHECKING:
    from solver.problem import Problem
    from solver.simulation import Outcome

# Past the first reordering of the particles (every 50 steps), so that a restart falls between two.
STEPS = {"axisymmetric": 70, "quarter": 60}
STOPPED_AFTER = 33
GEOMETRIES = ("axisymmetric", "quarter")
# Of a cell: GIMP particles whose edge lies on a node leave it a mass of round-off, with which USL cannot live.
OFFSET = 0.3


def _run(recipe: Recipe) -> Iterator[Row]:
    for geometry in GEOMETRIES:
        for shape in get_args(Shape):
            for scheme in get_args(SchemeName):
                chosen = replace(recipe, shape=shape, scheme=scheme)
                yield from _rows(f"{geometry}, {shape}, {scheme}", geometry, chosen)


def _rows(where: str, geometry: str, recipe: Recipe) -> Iterator[Row]:
    problem = impact_setting(
        recipe, geometry=geometry, material="copper-ofhc", offset=OFFSET
    ).problem
    one, two = (advanced(problem, STEPS[geometry], threads=threads) for threads in (1, 2))
    yield at_most(
        f"{where}: values that differ between one thread and two",
        limit=0,
        got=differing_values(one.particles, two.particles) + (one.time != two.time),
    )
    problem = replace(problem, end_time=one.time)
    through, restarted = _through(problem), _stopped_and_resumed(problem)
    bits = differing_values(through.snapshot.particles, restarted.snapshot.particles)
    bits += sum(
        getattr(through, name) != getattr(restarted, name)
        for name in ("audit", "counters", "smallest_step", "particle_steps")
    )
    yield at_most(f"{where}: values that differ after a restart", limit=0, got=bits)


def _through(problem: "Problem") -> "Outcome":
    from solver.simulation import simulate

    return simulate(problem, threads=1)


def _stopped_and_resumed(problem: "Problem") -> "Outcome":
    from solver.checkpoint import Checkpointing
    from solver.errors import Interrupted
    from solver.simulation import simulate

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "checkpoint"
        told: list[str] = []
        try:
            simulate(
                problem, threads=1, checkpoint=Checkpointing(path=path, leave=_after(STOPPED_AFTER))
            )
        except Interrupted:
            outcome = simulate(
                problem, threads=1, checkpoint=Checkpointing(path=path, tell=told.append)
            )
    if not told or not told[0].startswith("from the checkpoint"):
        raise AssertionError(f"the run did not go on from its checkpoint: {told}")
    return outcome


def _after(steps: int) -> Callable[[], bool]:
    """True from the call with that number on."""
    calls = 0

    def leave() -> bool:
        nonlocal calls
        calls += 1
        return calls >= steps

    return leave


CASE = Case(
    name="bits",
    title="Threads and restarts change no bit: every shape, scheme and geometry",
    source="sums in a fixed order",
    run=_run,
    quick=False,
)
