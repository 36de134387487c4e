"""The thick plate of Ma (2005), section 3.2.1, here and, where ``MPM3D_F90`` names its binary, in MPM3D-F90, in turns.

Nothing of MPM3D-F90 (Ma, Zhang, Huang; commit 367e024 is the one that was looked at) is kept here: the deck is written
from our own problem, in its units (mm, g, ms, N, MPa). Its ``sjc`` without hardening stands for perfect plasticity,
because its ``pla1`` has no equation of state.
"""

import math
import os
import re
import statistics
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from solver.problem import Problem
from solver.simulation import start
from studies.materials import load
from studies.runs.run import resolve
from studies.runs.stages import setting_of
from tests.benchmarks.measure import advance

MATERIAL = "copper-thesis-plastic"
SPHERE, PROJECTILE_MASS = 224, 0.5e-3  # particles of its half; kg: Ma (2005), section 3.2.1
DENSITY = 8930.0  # kg/m3: Ma (2005), Table 3.2
STEPS, PAIRS = 10, 3
END = 32.5e-6  # s
CELL = 1e-3  # m
DTSCALE = 0.2  # of a cell over the speed of a longitudinal wave
YOUNG, POISSON = 124e9, 0.35  # Pa: Ma (2005), Table 3.2
ELASTIC_WAVE = math.sqrt(YOUNG * (1 - POISSON) / (1 + POISSON) / (1 - 2 * POISSON) / DENSITY)
DT = DTSCALE * CELL / ELASTIC_WAVE


def figures() -> Iterator[tuple[str, float]]:
    """Cost of the first steps, by processor and by the wall, and the wall of the whole run extrapolated from it."""
    problem = plate()
    particles = sum(body.mass.size for body in problem.bodies)
    whole = math.ceil(END / DT)
    yield "thesis_particles", particles
    yield "thesis_particle_steps", particles * whole
    binary = os.environ.get("MPM3D_F90")
    text = deck(problem) if binary else ""
    advance(start(problem, threads=1), 1)  # its kernels are compiled or loaded
    pairs = [(ours(problem), theirs(binary, text) if binary else {}) for _ in range(PAIRS)]
    for prefix, costs in (
        ("thesis", [cost for cost, _ in pairs]),
        ("thesis_mpm3d_f90", [other for _, other in pairs if other]),
    ):
        if costs:
            yield f"{prefix}_ns", statistics.median(cost["ns"] for cost in costs)
            wall = statistics.median(cost["wall"] for cost in costs) * whole / STEPS
            yield f"{prefix}_extrapolated_wall_s", wall
    if binary:
        ratios = [other["ns"] / cost["ns"] for cost, other in pairs]
        yield "thesis_times_mpm3d_f90", statistics.median(ratios)
    else:
        print("MPM3D_F90=/path/to/binary runs the same problem in MPM3D-F90, in turns")


def plate() -> Problem:
    """A copper sphere of 0.5 g at 6 km/s on a half of a block of 80 by 80 by 40 mm, perfectly plastic."""
    diameter = (6.0 * PROJECTILE_MASS / (math.pi * DENSITY)) ** (1.0 / 3.0)
    parameters: dict[str, Any] = {
        "speed": 6e3,
        "projectile_diameter": diameter,
        "target_depth": 40e-3,
        "target_radius": 40e-3,
        "projectile": MATERIAL,
        "target": MATERIAL,
        "geometry": "half",
        "recipe": "thesis",
        "cells_per_diameter": diameter / CELL,
        "edges": "fixed",
        "eos_form": "cubic",
        "thermal_softening": False,
        "tension": "unlimited",
        "viscosity_linear": 0.0,
        "viscosity_quadratic": 1.5,
        "fixed_dt": DT,
        "end_time": END,
        "stop": "end_time",
    }
    copper = load(MATERIAL)
    run = resolve("thick_plate", parameters, {"projectile": copper, "target": copper})
    problem = setting_of(run).problem
    sphere, target = problem.bodies
    mass = np.full(SPHERE, 0.5 * PROJECTILE_MASS / SPHERE)
    sphere = replace(sphere, position=_sphere(), mass=mass)
    return replace(problem, bodies=(sphere, target))


def _sphere() -> np.ndarray:
    """The points of the thesis' sphere: those of the target's lattice nearest to a centre 2.5 mm in front of it, m."""
    centre = np.array([0.0, 0.0, -2.5e-3])
    along = (np.arange(-6, 6) + 0.5) * 0.5 * CELL
    points = np.stack(np.meshgrid(along, along[6:], along, indexing="ij"), axis=-1).reshape(-1, 3)
    order = np.argsort(np.linalg.norm(points, axis=1).round(9), kind="stable")
    return centre + points[order[:SPHERE]]


def ours(problem: Problem) -> dict[str, float]:
    """Processor time of a particle-step, ns, and the wall of the first steps, s."""
    made = start(problem, threads=1)
    wall, begin = time.perf_counter(), time.process_time()
    done = advance(made, STEPS)
    spent = time.process_time() - begin
    return {"ns": spent / done * 1e9, "wall": time.perf_counter() - wall}


def theirs(binary: str, text: str) -> dict[str, float]:
    """The same as MPM3D-F90 tells of itself: its loop over the steps, without what it reads and writes."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "plate.mpm").write_text(text)
        ran = subprocess.run([binary, "plate.mpm"], cwd=folder, check=True, capture_output=True, text=True)
    cycle = re.search(r"Time per particle cycle:\s*([\d.]+)", ran.stdout)
    wall = re.search(r"Total elasped time :\s*([\d.]+)", ran.stdout)
    if not cycle or not wall:
        raise RuntimeError(f"{binary} did not tell its times: {ran.stdout[-500:]}")
    return {"ns": float(cycle[1]), "wall": float(wall[1])}


def deck(problem: Problem) -> str:
    """The problem as MPM3D-F90 reads it, ending after the first steps."""
    geometry = problem.geometry
    lower = geometry.lower * 1e3
    upper = lower + geometry.cells * geometry.spacing * 1e3
    eos, strength = problem.bodies[0].matter.eos, problem.bodies[0].matter.strength
    lines = [
        "mpm3d *** thick plate",
        "nbco 1",
        f"nbbo {len(problem.bodies)}",
        f"nbmp {sum(body.mass.size for body in problem.bodies)}",
        "nmat 1",
        *(f"sp{axis} {low:.6f} {high:.6f}" for axis, low, high in zip("xyz", lower, upper, strict=True)),
        f"dcell {geometry.spacing * 1e3:.6f}",
        "fixed " + " ".join(str(int(face)) for pair in problem.faces for face in pair),
        f"dtscale {DTSCALE}",
        f"endtime {(STEPS - 0.5) * DT * 1e3:.8e}",
        f"outtime {END * 1e3}",
        f"rpttime {END * 1e3}",
        "musl on",
        "jaum on",
        f"bulk {problem.viscosity.quadratic} {problem.viscosity.linear}",
        "material",
        f"1 sjc {DENSITY * 1e-6:.6e} {YOUNG * 1e-6:.6e} {POISSON} {strength.yield_stress * 1e-6} 0 1 0 1e-3",
        f"seos 1 2 {eos.c0} {eos.s} {eos.gamma0} 0",
    ]
    return "\n".join([*lines, *_points(problem), "endi", ""])


def _points(problem: Problem) -> Iterator[str]:
    number = 0
    for body in problem.bodies:
        yield "particle point"
        yield f"1 {body.mass.size}"
        for mass, place in zip(body.mass * 1e3, body.position * 1e3, strict=True):
            number += 1
            yield f"{number} 1 {mass:.8e} {place[0]:.5f} {place[1]:.5f} {place[2]:.5f}"
    yield "velo"
    for index, body in enumerate(problem.bodies, start=1):
        yield f"body {index} {body.velocity[0]} {body.velocity[1]} {body.velocity[2]}"
    yield "endv"
