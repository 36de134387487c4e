"""What steps, runs, the demo and memory cost: run by name alone.

Times of the processor; a quiet machine is meant, and one that is not fails some of these.
"""

import functools

import pytest

from tests.benchmarks import figures, queue
from tests.benchmarks.measure import BARS
from tests.claims.marked import Compared
from tests.claims.rows import Row, at_least, at_most, equal

NANOSECONDS = {
    "axisymmetric_default_12k": 110.0,
    "3d_linear_117k": 130.0,
    "3d_linear_1m": 150.0,
    "3d_spline_117k": 185.0,
}


@functools.cache
def _steps() -> dict[str, float]:
    return dict(figures.steps(NANOSECONDS, threads=(1,)))


@pytest.mark.claim("speed", "particle-step", minutes=4.0)
def test_step__costs_what_is_said_of_it(compared: Compared) -> None:
    """What a particle-step costs on a quiet machine."""
    for name, limit in NANOSECONDS.items():
        compared(at_most(f"{name}: processor time (ns)", limit=limit, got=_steps()[f"{name}_ns"]))
    compared(Row("a number of the reference kernel (ns)", "", _steps()["reference_ns"], None))


@pytest.mark.claim("methods", "methods-speed", minutes=6.0)
def test_methods__cost_what_is_shown(compared: Compared) -> None:
    """What a step of smoothed particles and of hexahedra costs, by one thread and by two."""
    for name, got in figures.steps(f"{family}_12k" for family in ("3d_sph", *BARS)):
        compared(Row(name, "", got, None))


@pytest.mark.claim("speed", "beside-the-particles", minutes=3.0)
def test_step__costs_little_beside_its_particles(compared: Compared) -> None:
    """Empty nodes cost at most 5 %, Python at most 30 us a step, a crater's observation at most 10 ms."""
    limits = {"python_us_per_step": 30.0, "crater_observation_ms": 10.0}
    for name, got in figures.overheads():
        compared(at_most(name, limit=limits.get(name, 1.05), got=got))


@pytest.mark.claim("speed", "demo-cost", minutes=5.0)
def test_demo__is_computed_in_minutes(compared: Compared) -> None:
    """The demo's 15 runs take at most 120 core-seconds, and 80 s on two cores from a cold start."""
    got = dict(figures.demo())
    compared(equal("runs", expected=15, got=got["demo_runs"]))
    compared(at_most("core-seconds", limit=120.0, got=got["demo_core_s"]))
    compared(at_most("wall, cold start included (s)", limit=80.0, got=got["demo_wall_s"]))


@pytest.mark.claim("speed", "two-threads", minutes=10.0)
def test_threads__do_the_work_of_two_runs(compared: Compared) -> None:
    """Two threads of a run do 0.85 of the work of two runs of one thread."""
    for name, got in figures.threads():
        gated = name == "3d_linear_two_threads_117k"
        compared(at_least(name, limit=0.85, got=got) if gated else Row(name, "", got, None))


@pytest.mark.claim("speed", "memory", minutes=2.0)
def test_memory__of_a_million_particles(compared: Compared) -> None:
    """A million particles take at most 450 bytes each."""
    for name, got in figures.memory():
        compared(at_most(name, limit=450.0, got=got))


@pytest.mark.claim("speed", "run-overhead", minutes=0.5)
def test_queue__costs_little_beside_a_run(compared: Compared) -> None:
    """A slot of the service waits at most 0.03 s from the end of a run to the next one, registration included."""
    slot, attempt = queue.overhead()
    compared(at_most("between two runs of a slot (s)", limit=queue.OVERHEAD_AIM, got=slot - attempt))
    compared(Row("runs a second by two slots that write their result alone", "", queue.WORKERS / slot, None))
