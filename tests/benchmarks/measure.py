"""Measures in a process of its own: ``python -m tests.benchmarks.measure WHAT [JSON]``.

The answer is one JSON object on stdout. Times are of the processor, in turns with a reference kernel that does the
same work beside every version; what counts is the ratio to it.
"""

import json
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numba
import numpy as np

from solver.methods.fem.mesh import lattice, node_masses
from solver.problem import Body, Face, Problem
from solver.problem.geometry import Cartesian3D, grid
from solver.simulation import Simulation, start
from studies.materials import load
from studies.runs.run import Run, resolve
from studies.runs.stages import setting_of
from studies.scenarios.parts.matter import matter
from tests.cases.verification.setups.methods import COURANT, SPH
from tests.contracts.features import ROOT

WARM, PAIRS = 60, 5  # steps before, and pairs of blocks
BLOCK = 3e6  # particle-steps in a block, about
TURNS = 600  # of the reference kernel in a block

AXISYMMETRIC = {"12k": 32.0, "117k": 101.0, "1m": 296.0}  # cells per diameter
WIDE = {"12k": 5.1, "117k": 11.2, "1m": 22.5}
FAMILIES: dict[str, tuple[dict[str, Any], dict[str, float]]] = {
    "axisymmetric_default": ({"geometry": "axisymmetric"}, AXISYMMETRIC),
    "axisymmetric_linear": ({"geometry": "axisymmetric", "shape": "linear"}, AXISYMMETRIC),
    "axisymmetric_gimp": ({"geometry": "axisymmetric", "shape": "gimp"}, AXISYMMETRIC),
    "3d_linear": ({"geometry": "quarter", "recipe": "thesis"}, {"12k": 7.75, "117k": 16.8, "1m": 34.0}),
    "3d_gimp": ({"geometry": "quarter", "shape": "gimp", "particles_per_cell": 3}, WIDE),
    "3d_spline": ({"geometry": "quarter", "particles_per_cell": 3}, WIDE),
    "3d_sph": ({"geometry": "quarter", "method": "sph"}, {"12k": 7.75, "117k": 16.8}),
}
PROBLEMS: dict[str, dict[str, Any]] = {
    f"{family}_{size}": {**choices, "cells_per_diameter": cells}
    for family, (choices, sizes) in FAMILIES.items()
    for size, cells in sizes.items()
}

# Copper bars that hit a rigid wall: particles or elements across (a radius) and along. Plane strain has no scenario.
BARS: dict[str, dict[str, tuple[int, int]]] = {
    "plane_sph": {"12k": (50, 240), "117k": (156, 750)},
    "3d_hexahedra": {"12k": (14, 61), "117k": (30, 130)},
}
BAR_SPEED, BAR_SPACING = 200.0, 1e-4  # m/s, m
ELEMENT_COURANT = 0.8  # of the bound of each element, as in their verification cases


@numba.njit
def reference(values: Any, turns: int) -> float:
    """Additions, multiplications, a square root and a division of each number in turn."""
    total = 0.0
    for _ in range(turns):
        for i in range(values.size):
            x = values[i]
            total += np.sqrt(x * x + 1.0) / (x + 2.0)
            values[i] = 0.5 * (x + total / (1.0 + abs(total)))
    return total


def measured(what: str, *arguments: Any) -> Any:
    """What a function of this module finds, in a process of its own."""
    command = [sys.executable, "-m", "tests.benchmarks.measure", what, *map(json.dumps, arguments)]
    answer = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(answer.stdout)


def reference_ns() -> float:
    """Processor time of a number in the reference kernel, ns."""
    values = np.linspace(0.0, 1.0, 1 << 14)
    reference(values, 1)
    begin = time.process_time()
    reference(values, TURNS)
    return (time.process_time() - begin) / TURNS / values.size * 1e9


def question(**parameters: Any) -> Run:
    """A copper sphere of 8 mm on a plate of 2 mm at 4 km/s, as a run."""
    copper = load("copper-ofhc")
    chosen = {
        "speed": 4e3,
        "projectile_diameter": 8e-3,
        "plate_thickness": 2e-3,
        "projectile": "copper-ofhc",
        "target": "copper-ofhc",
        **parameters,
    }
    return resolve("thin_plate", chosen, {"projectile": copper, "target": copper})


def simulation(name: str, threads: int = 1, warm: int = WARM) -> Simulation:
    """A problem by its name, some steps on, so that the shock is inside."""
    made = start(problem_of(name), threads=threads)
    advance(made, warm)
    return made


def problem_of(name: str) -> Problem:
    """A problem by its name, which ends with its size."""
    family, size = name.rsplit("_", 1)
    if family in BARS:
        return bar(family, *BARS[family][size])
    return setting_of(question(**PROBLEMS[name])).problem


def bar(family: str, across: int, along: int) -> Problem:
    """A bar of finite elements, or of smoothed particles in plane strain, with so many across and along."""
    copper, is_smoothed = load("copper-ofhc"), family == "plane_sph"
    counts = (across, across, along) if family == "3d_hexahedra" else (across, along)
    middles = 0.5 * BAR_SPACING if is_smoothed else 0.0
    lines = [middles + BAR_SPACING * np.arange(n + (not is_smoothed)) for n in counts]
    if is_smoothed:
        position, mesh = np.stack([*np.meshgrid(*lines, indexing="ij"), np.zeros(counts)], axis=-1).reshape(-1, 3), None
    else:
        position, mesh = lattice(*lines)
    velocity = np.zeros(3)
    velocity[len(counts) - 1] = -BAR_SPEED
    body = Body(
        name="bar",
        matter=matter(copper),
        position=position,
        velocity=velocity,
        mass=node_masses(mesh, position, copper.density)
        if mesh
        else np.full(len(position), copper.density * BAR_SPACING**2),
        density=copper.density,
        spacing=(BAR_SPACING, BAR_SPACING, 1.0 if is_smoothed else BAR_SPACING),
        mesh=mesh,
    )
    cells = [2 * n for n in counts] + [0] * (3 - len(counts))
    return Problem(
        geometry=grid(Cartesian3D, lower=np.zeros(3), cells=cells, spacing=BAR_SPACING),
        bodies=(body,),
        faces=((Face.SYMMETRIC, Face.FREE),) * 3,
        end_time=1.0,
        smoothing=SPH if is_smoothed else None,
        courant=COURANT if is_smoothed else ELEMENT_COURANT,
    )


def advance(made: Simulation, steps: int) -> int:
    """Take steps; returns the particle-steps, or those of elements."""
    done = 0
    for _ in range(steps):
        done += counted(made)
        made.advance()
    return done


def counted(made: Simulation) -> int:
    """Particles of a simulation; elements where its bodies are meshes."""
    meshes = [body.mesh for body in made.problem.bodies if body.mesh]
    return sum(len(mesh.nodes) for mesh in meshes) or int(made.particles.mass.size)


def cost(made: Simulation) -> dict[str, Any]:
    """Nanoseconds of a particle-step and of the reference, in pairs, and the medians with that of the ratios."""
    steps = max(5, round(BLOCK / counted(made)))
    reference_ns()
    pairs = []
    for _ in range(PAIRS):
        begin = time.process_time()
        done = advance(made, steps)
        pairs.append(((time.process_time() - begin) / done * 1e9, reference_ns()))
    return {
        "particles": counted(made),
        "ns": statistics.median(ours for ours, _ in pairs),
        "reference_ns": statistics.median(theirs for _, theirs in pairs),
        "ratio": statistics.median(ours / theirs for ours, theirs in pairs),
    }


def steps(problems: list[str], threads: int = 1) -> dict[str, Any]:
    """The cost of a particle-step in each problem."""
    return {name: cost(simulation(name, threads)) for name in problems}


def first_step(problem: str) -> dict[str, float]:
    """One step of a problem; what is measured is this process."""
    return {"particles": simulation(problem, warm=1).particles.mass.size}


def memory(problem: str) -> dict[str, float]:
    """Largest growth of the resident memory from before the start of a problem, once its kernels are loaded."""
    small = simulation(problem.rsplit("_", 1)[0] + "_12k", warm=2)
    del small
    Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew: proc(5)
    before = _status("VmRSS")
    made = simulation(problem, warm=2)
    peak = _status("VmHWM")
    return {"particles": made.particles.mass.size, "bytes": peak - before}


def _status(name: str) -> int:
    """A figure of this process in bytes: proc(5)."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(name)) * 1024


if __name__ == "__main__":
    what, *arguments = sys.argv[1:]
    print(json.dumps(globals()[what](*map(json.loads, arguments))))
