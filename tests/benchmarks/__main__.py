"""``make bench``: nanoseconds per particle-step by shape, their split over the stages, the worth of a second thread.

``SECONDS_PER_PARTICLE_STEP`` in studies/run.py has its figures from here. Machines are noisy: what counts are ratios
within one run, with nothing else at work. Each figure is the median over repetitions of the same steps.
"""

import statistics
import time
from collections import defaultdict
from collections.abc import Callable
from typing import Any, get_args

from solver import step
from solver.simulation import Simulation, start
from studies.execution import setting_of
from studies.materials import load
from studies.recipes import Shape
from studies.run import resolve

WARM, STEPS, REPEATS = 60, 40, 7  # steps before, steps in a repetition, repetitions
STAGES = (
    "scatter_state",
    "add_lines",
    "close_nodes",
    "solve_momentum",
    "mirror_nodes",
    "book_ghosts",
    "move_particles",
    "close_mapped",
    "take_mapped",
    "clear_lines",
    "update_particles",
)


def simulation(geometry: str, cells: int, shape: str, threads: int) -> Simulation:
    """A copper perforation at 4 km/s in the thesis' numerics but for the shape, warmed until the shock is inside."""
    copper = load("copper-ofhc")
    materials = {"projectile": copper, "target": copper}
    parameters = {
        "speed": 4e3,
        "projectile_diameter": 8e-3,
        "plate_thickness": 2e-3,
        "projectile": "copper-ofhc",
        "target": "copper-ofhc",
        "geometry": geometry,
        "cells_per_diameter": float(cells),
        "recipe": "thesis",
        "shape": shape,
    }
    run = resolve("thin_plate", parameters, materials)
    made = start(setting_of(run).problem, threads=threads)
    for _ in range(WARM):
        made.advance()
    return made


def nanoseconds(made: Simulation) -> float:
    """Median cost of a particle-step, ns."""
    costs = []
    for _ in range(REPEATS):
        particles = made.particles.mass.size
        begin = time.perf_counter()
        for _ in range(STEPS):
            made.advance()
        costs.append((time.perf_counter() - begin) / STEPS / particles * 1e9)
    return statistics.median(costs)


def split(made: Simulation) -> dict[str, float]:
    """Nanoseconds per particle-step in each stage of the step."""
    spent: dict[str, float] = defaultdict(float)
    originals = {name: getattr(step, name) for name in STAGES}

    def timed(name: str) -> Callable[..., Any]:
        def call(*arguments: Any) -> Any:
            begin = time.perf_counter()
            answer = originals[name](*arguments)
            spent[name] += time.perf_counter() - begin
            return answer

        return call

    try:
        for name in STAGES:
            setattr(step, name, timed(name))
        for _ in range(STEPS):
            made.advance()
    finally:
        for name, original in originals.items():
            setattr(step, name, original)
    return {name: spent[name] / STEPS / made.particles.mass.size * 1e9 for name in STAGES}


def main() -> None:
    """Print the figures."""
    for geometry, cells in (("axisymmetric", 32), ("quarter", 16)):
        for shape in get_args(Shape):
            one = simulation(geometry, cells, shape, threads=1)
            cost = nanoseconds(one)
            particles = one.particles.mass.size
            size = f"{particles} particles in {one.shares} shares"
            print(f"{geometry}, {shape}, {size}: {cost:.0f} ns per particle-step")
            for name, part in split(one).items():
                print(f"    {name:16} {part:6.1f} ns  {part / cost:5.0%}")
            two = nanoseconds(simulation(geometry, cells, shape, threads=2))
            print(f"    two threads: {two:.0f} ns, {cost / two:.2f} times as fast")


if __name__ == "__main__":
    main()
