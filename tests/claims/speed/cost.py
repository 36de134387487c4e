"""What steps, runs, the demo and memory cost: the figures of ``make bench``, by the same code.

Times of the processor; a quiet machine is meant, and one that is not fails some of these. How many times as fast a
step is goes through the reference kernel (``tests.benchmarks.baseline``).
"""

import functools
from collections.abc import Iterator

from tests.benchmarks import figures
from tests.benchmarks.measure import SWEEP
from tests.claims import Row, at_least, at_most, claim

FASTER = {"axisymmetric_default": 6.0, "3d_linear": 4.0, "3d_spline": 4.5}
NANOSECONDS = {
    "axisymmetric_default_12k": 110.0,
    "3d_linear_117k": 130.0,
    "3d_linear_1m": 150.0,
    "3d_spline_117k": 185.0,
}
BOX = 1.05  # of a step's cost in its own box
PYTHON_US, OBSERVATION_MS = 30.0, 10.0
SWEEP_SHARE = 0.1
DEMO_CORE_S, DEMO_WALL_S = 200.0, 150.0
TWO_THREADS = 0.85
BYTES = 450.0


@functools.cache
def _steps() -> dict[str, float]:
    return dict(figures.steps(NANOSECONDS, threads=(1,)))


@claim(
    "faster-step",
    says="a particle-step is 6 times as fast as before in axisymmetry, 4 times in 3-D linear, 4.5 times in 3-D splines",
)
def faster_step() -> Iterator[Row]:
    for family, limit in FASTER.items():
        got = _steps()[f"{family}_speedup"]
        yield at_least(f"{family}: times as fast as the former step", limit=limit, got=got)


@claim("particle-step", says="what a particle-step costs on a quiet machine")
def particle_step() -> Iterator[Row]:
    for name, limit in NANOSECONDS.items():
        yield at_most(f"{name}: processor time (ns)", limit=limit, got=_steps()[f"{name}_ns"])
    yield Row("a number of the reference kernel (ns)", "", _steps()["reference_ns"], None)


@claim(
    "beside-the-particles",
    says="empty nodes cost at most 5 %, Python at most 30 us a step, a crater's observation at most 10 ms",
)
def beside_the_particles() -> Iterator[Row]:
    for name, got in figures.overheads():
        if name.endswith("large_box"):
            text = f"{name}: cost with {figures.NODES_PER_PARTICLE} nodes a particle over its own"
            yield at_most(text, limit=BOX, got=got)
        else:
            limit = PYTHON_US if name == "python_us_per_step" else OBSERVATION_MS
            yield at_most(name, limit=limit, got=got)


@claim("converged-sweep", says="six speeds at three resolutions cost a tenth of what they did")
def converged_sweep() -> Iterator[Row]:
    figures_by_name = dict(figures.sweep())
    measured_runs = int(figures_by_name["sweep_former_runs"])
    yield Row("runs that the former tree was measured on", len(SWEEP), measured_runs, measured_runs == len(SWEEP))
    share = figures_by_name["sweep_share_of_former"]
    yield at_most("core-seconds over the former ones", limit=SWEEP_SHARE, got=share)
    for name in ("core_s", "former_core_s", "particle_steps", "former_particle_steps"):
        yield Row(name, "", figures_by_name[f"sweep_{name}"], None)


@claim("demo-cost", says="the demo's 22 runs take at most 200 core-seconds, and 150 s on two cores from a cold start")
def demo_cost() -> Iterator[Row]:
    figures_by_name = dict(figures.demo())
    yield Row("runs", 22, figures_by_name["demo_runs"], figures_by_name["demo_runs"] == 22)
    yield at_most("core-seconds", limit=DEMO_CORE_S, got=figures_by_name["demo_core_s"])
    yield at_most("wall, cold start included (s)", limit=DEMO_WALL_S, got=figures_by_name["demo_wall_s"])


@claim("two-threads", says="two threads of a run do 0.85 of the work of two runs of one thread")
def two_threads() -> Iterator[Row]:
    for name, got in figures.threads():
        if name == "3d_linear_two_threads_117k":
            yield at_least("3-D linear, 117 k particles", limit=TWO_THREADS, got=got)
        else:
            yield Row(name, "", got, None)


@claim("memory", says="a million particles take at most 450 bytes each")
def memory() -> Iterator[Row]:
    for name, got in figures.memory():
        yield at_most(name, limit=BYTES, got=got)


@claim("thesis-plate", says="the thesis' thick plate beside MPM3D-F90, where MPM3D_F90 names it")
def thesis_plate() -> Iterator[Row]:
    for name, got in figures.PARTS["thesis"]():
        expected = 1_024_224 if name == "thesis_particles" else ""
        yield Row(name, expected, got, got == expected if expected else None)
