"""``make bench``: what a particle-step costs, by shape, in stages, in threads and beside the step that it replaced.

``SECONDS_PER_PARTICLE_STEP`` in studies/run.py has its figures from here. Machines are noisy: what counts are ratios
within one run, with nothing else at work. ``make bench JSON=file`` writes the figures flat.
"""

import argparse
import json
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from solver import step
from solver.simulation import Simulation
from tests.benchmarks import baseline
from tests.benchmarks.measure import simulation

STEPS, REPEATS = 40, 7  # in a repetition
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


def fastest(made: Simulation) -> float:
    """Wall time of the fastest of some repetitions, ns per particle-step."""
    costs = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        for _ in range(STEPS):
            made.advance()
        costs.append((time.perf_counter() - begin) / STEPS / made.particles.mass.size * 1e9)
    return min(costs)


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


def figures() -> Iterator[tuple[str, float]]:
    """The figures by name, printed as they come."""
    before = json.loads(baseline.FILE.read_text())
    print(f"the step before: {before['commit']}, {before['processor']}, {before['date']}")
    for name, figure in baseline.cost_of(baseline.ROOT).items():
        speedup = before["figures"][name]["ratio"] / figure["ratio"]
        print(
            f"{name}, {figure['particles']} particles: {figure['ns']:.0f} ns per particle-step, "
            f"{figure['ratio']:.1f} times the reference; {speedup:.1f} times as fast as before"
        )
        yield f"{name}_speedup", speedup
        yield f"{name}_ns", figure["ns"]
        yield "reference_ns", figure["reference_ns"]
    for name in ("axisymmetric_default", "3d_linear"):
        print(f"{name} by stage")
        for stage, cost in split(simulation(name)).items():
            print(f"    {stage:16} {cost:6.1f} ns")
    yield "two_threads_3d_linear", _worth_of_a_thread("3d_linear")


def _worth_of_a_thread(name: str) -> float:
    one, two = (fastest(simulation(name, threads)) for threads in (1, 2))
    print(f"{name}, two threads: {two:.0f} ns, {one / two:.2f} times as fast as one")
    return one / two


def main() -> None:
    """Print the figures, and write them to a file where one is named."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there too")
    file = parser.parse_args().json
    found = dict(figures())
    if file:
        file.write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
