"""The figures of ``make bench``, in parts that can be measured one by one; names end with the unit.

A figure without one is a ratio or a count. Costs of steps and runs are processor time, in turns with the reference
kernel where versions are compared; only what says so is of the wall.
"""

import json
import math
import multiprocessing
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any
from unittest import mock

from service.demo.commands import DEMO
from solver.jit import Bound
from solver.problem.geometry import grid
from solver.simulation import Simulation, simulate, start
from studies.runs.execution import observer_of
from studies.runs.stages import setting_of
from studies.sweeps import examples
from studies.sweeps.document import read_yaml
from studies.sweeps.sweep import Sweep
from tests.benchmarks.measure import BARS, PAIRS, PROBLEMS, advance, measured, problem_of, question, simulation
from tests.contracts.features import ROOT

Figures = Iterator[tuple[str, float]]

NAMES = [*PROBLEMS, *(f"{family}_{size}" for family, sizes in BARS.items() for size in sizes)]
THREADS = 2
STEPS = 20  # in a block of what is measured in turns
NODES_PER_PARTICLE = 20  # of the large box
ELEMENTS = "3d_hexahedra"  # the family that counts elements
STAGED = ("axisymmetric_default_12k", "3d_linear_117k", "3d_spline_117k")
CRATER_SPEED = 5.5e3  # m/s
SMALLEST = {"cells_per_diameter": 2.0, "particles_per_cell": 1}  # a step of it is Python and calls


def steps(names: Iterable[str] = NAMES, threads: tuple[int, ...] = (1, THREADS)) -> Figures:
    """Cost of a step of a particle or an element."""
    references = []
    for name in names:
        for count in threads:
            [answer] = measured("steps", [name], count).values()
            tag = name if count == 1 else f"{name}_{count}_threads"
            yield f"{tag}_particles", answer["particles"]
            yield f"{tag}_ns", answer["ns"]
            yield f"{tag}_per_reference", answer["ratio"]
            references.append(answer["reference_ns"])
            if name.startswith(ELEMENTS):
                yield f"{tag}_elements_per_core_second", 1e9 / answer["ns"]
    yield "reference_ns", statistics.median(references)


def stages() -> Figures:
    """Processor time of each kernel of the step, with the call, and of the Python around them, ns per particle-step."""
    for name in STAGED:
        for stage, cost in _split(simulation(name)).items():
            yield f"{name}_stage_{stage}_ns", cost


def _split(made: Simulation) -> dict[str, float]:
    spent: dict[str, float] = defaultdict(float)
    call = Bound.__call__

    def timed(bound: Bound, *arguments: Any) -> Any:
        begin = time.process_time()
        answer = call(bound, *arguments)
        spent[bound.kernel.py_func.__name__] += time.process_time() - begin
        return answer

    with mock.patch.object(Bound, "__call__", timed):
        begin = time.process_time()
        done = advance(made, 2 * STEPS)
        whole = time.process_time() - begin
    spent["python"] = whole - sum(spent.values())
    return {name: seconds / done * 1e9 for name, seconds in spent.items()}


def threads() -> Figures:
    """Throughput of two threads in one run, over that of two runs of one thread at once, in turns; by the wall."""
    for family in ("axisymmetric_default", "3d_spline", "3d_linear", "3d_sph", ELEMENTS):
        yield f"{family}_two_threads_117k", _worth_of_threads(f"{family}_117k")


def _worth_of_threads(name: str) -> float:
    context = multiprocessing.get_context("spawn")
    pipes = [context.Pipe() for _ in range(THREADS)]
    others = [context.Process(target=_independent, args=(name, there)) for _, there in pipes]
    for other in others:
        other.start()
    made = simulation(name, threads=THREADS)
    for here, _ in pipes:
        here.recv()  # it is warm
    ratios = []
    for _ in range(PAIRS):
        begin = time.perf_counter()
        advance(made, STEPS)
        ours = STEPS / (time.perf_counter() - begin)
        for here, _ in pipes:
            here.send(STEPS)
        ratios.append(ours / sum(STEPS / here.recv() for here, _ in pipes))
    for (here, _), other in zip(pipes, others, strict=True):
        here.send(0)
        other.join()
    return statistics.median(ratios)


def _independent(name: str, pipe: Connection) -> None:
    """A run of one thread: takes the number of steps that it receives and sends back their seconds; 0 ends it."""
    made = simulation(name)
    pipe.send(0.0)
    while count := pipe.recv():
        begin = time.perf_counter()
        advance(made, count)
        pipe.send(time.perf_counter() - begin)


def overheads() -> Figures:
    """What a step costs beside its particles: Python, empty nodes; and a crater's observation."""
    made = start(setting_of(question(**SMALLEST)).problem, threads=1)
    yield "python_us_per_step", _median_cpu(made, 5 * STEPS) * 1e6
    for name in ("axisymmetric_default_12k", "3d_linear_117k"):
        yield f"{name}_large_box", _worth_of_box(name)
    yield "crater_observation_ms", _crater_observation() * 1e3


def _median_cpu(made: Simulation, count: int) -> float:
    """Processor time of a step, s."""
    advance(made, count)
    times = []
    for _ in range(PAIRS):
        begin = time.process_time()
        advance(made, count)
        times.append((time.process_time() - begin) / count)
    return statistics.median(times)


def _worth_of_box(name: str) -> float:
    """Cost of a step in a box that is longer in the flight's direction, over that in its own, in turns."""
    problem = problem_of(name)
    geometry = problem.geometry
    axis = 2 if geometry.nodes[2] > 1 else 1
    particles = sum(body.mass.size for body in problem.bodies)
    across = math.prod(geometry.nodes) // geometry.nodes[axis]
    cells = geometry.cells.copy()
    cells[axis] += math.ceil(NODES_PER_PARTICLE * particles / across) - geometry.nodes[axis]
    longer = grid(type(geometry), lower=geometry.lower, cells=cells, spacing=geometry.spacing)
    large = replace(problem, geometry=longer)
    both = [start(chosen, threads=1) for chosen in (problem, large)]
    for made in both:
        advance(made, STEPS)
    ratios = []
    for _ in range(PAIRS):
        times = []
        for made in both:
            begin = time.process_time()
            advance(made, max(STEPS, 1_000_000 // particles))
            times.append(time.process_time() - begin)
        ratios.append(times[1] / times[0])
    return statistics.median(ratios)


def _crater_observation() -> float:
    """Mean processor time of an observation in a run of the demo, s."""
    document = read_yaml(examples.text("craters"), "craters")
    [run] = [p.run for p in Sweep.parse(document).runs() if p.run.parameters["speed"] == CRATER_SPEED]
    watched = observer_of(run)
    times = []

    def observe(snapshot: Any) -> str | None:
        begin = time.process_time()
        stop = watched(snapshot)
        times.append(time.process_time() - begin)
        return stop

    simulate(watched.setting.problem, observe, interval=watched.rate.interval, threads=1)
    return statistics.mean(times)


def memory() -> Figures:
    """Resident memory that a run of a million particles adds, from before its problem is built, by particle."""
    for name in ("axisymmetric_default_1m", "3d_linear_1m"):
        answer = measured("memory", name)
        yield f"{name}_bytes_per_particle", answer["bytes"] / answer["particles"]


def compiling() -> Figures:
    """Core-seconds of a process to its first step with kernels from the disk, and of what compiling them adds."""
    kinds = []
    for family in ("axisymmetric_default", "3d_linear", "3d_spline"):
        with tempfile.TemporaryDirectory() as cache:
            cold = _core_seconds(_first_step(f"{family}_12k"), cache)
            warm = statistics.median(_core_seconds(_first_step(f"{family}_12k"), cache) for _ in range(3))
        kinds.append(cold - warm)
        yield f"{family}_compile_s", kinds[-1]
        yield f"{family}_first_step_s", warm
    yield "compile_kind_s", max(kinds)


def _first_step(name: str) -> list[str]:
    return ["-m", "tests.benchmarks.measure", "first_step", json.dumps(name)]


def _core_seconds(arguments: list[str], cache: str, stdin: str = "") -> float:
    """Processor time of a Python process and of all that it waits for, s."""
    command = [sys.executable, *arguments]
    environment = {**os.environ, "WHIPPLE_KERNEL_CACHE": cache}
    earlier = os.times()
    subprocess.run(command, cwd=ROOT, env=environment, check=True, capture_output=True, text=True, input=stdin)
    now = os.times()
    return now.children_user - earlier.children_user + now.children_system - earlier.children_system


def demo() -> Figures:
    """Sweeps of `make demo` from a cold cache: processor time, compiling, wall, work of the runs."""
    documents = [read_yaml(examples.text(name), name) for name in DEMO]
    with tempfile.TemporaryDirectory() as folder:
        cache, out = f"{folder}/kernels", Path(folder) / "demo"
        begin = time.perf_counter()
        compiled = _core_seconds(["-m", "studies.sweeps.kernels"], cache, json.dumps(documents))
        seconds = sum(_core_seconds(_sweep(name, out), cache) for name in DEMO)
        yield "demo_wall_s", time.perf_counter() - begin
        yield "demo_compile_core_s", compiled
        yield "demo_core_s", seconds
        results = [json.loads(file.read_text()) for file in out.rglob("result.json")]
    yield "demo_runs", len(results)
    for name in ("steps", "particle_steps"):
        yield f"demo_{name}", sum(result["numbers"][name] for result in results)


def _sweep(name: str, out: Path) -> list[str]:
    file = ROOT / "studies" / "sweeps" / "examples" / f"{name}.yaml"
    return ["-m", "service", "sweep", str(file), "--out", str(out / name)]


PARTS: dict[str, Callable[[], Figures]] = {
    "steps": steps,
    "stages": stages,
    "threads": threads,
    "overheads": overheads,
    "memory": memory,
    "compiling": compiling,
    "demo": demo,
}
