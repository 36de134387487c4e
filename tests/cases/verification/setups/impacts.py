"""Impacts on a thin plate and what is done to them: scaled, shifted, mirrored, unfolded; and how two runs compare."""

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from solver.problem import Clamp, Problem
from solver.problem.geometry import grid
from solver.simulation import Simulation, start
from solver.state import Particles
from studies import scenarios
from studies.materials import load
from studies.quantities.numerical_defaults import Recipe
from studies.quantities.parameters import declared
from studies.scenarios.parts.impact import ImpactSetting

# Round-off of 50 steps: each adds a few units in the last place (1e-16), a stress is a small difference of large
# numbers (1e3), and what differs may grow from step to step.
STEPS = 50
ROUND_OFF = 1e-10

# A sphere of 8 cells on a plate of a quarter of its diameter; the plastic copper of Ma (2005), Table 3.3, knows no
# rate.
SMALL: Mapping[str, Any] = {
    "speed": 4e3,
    "projectile_diameter": 8e-3,
    "plate_thickness": 2e-3,
    "plate_radius": 12e-3,
    "cells_per_diameter": 8.0,
}
RATE_INDEPENDENT = "copper-thesis-plastic"

# Of a tensor, in the order of solver/matter/tensor.py.
COMPONENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))


def impact_setting(
    recipe: Recipe, *, name: str = "thin_plate", material: str = RATE_INDEPENDENT, **parameters: Any
) -> ImpactSetting:
    """The plate, or block, of a recipe; parameters (SI) on top of the small one."""
    scenario = scenarios.load(name)
    names = {"projectile": material, "target": material}
    small = {key: value for key, value in SMALL.items() if key in declared(scenario.parameters)}
    values = scenario.record({**small, **asdict(recipe), **names, **parameters})
    loaded = {role: load(name) for role, name in names.items()}
    return values.filled(loaded).build(loaded)  # type: ignore[return-value]


def scaled(problem: Problem, factor: float) -> Problem:
    """A problem enlarged by ``factor`` in length and time."""
    geometry = problem.geometry
    return replace(
        problem,
        geometry=geometry._replace(lower=geometry.lower * factor, spacing=geometry.spacing * factor),
        bodies=tuple(
            replace(
                body,
                position=body.position * factor,
                mass=body.mass * factor**3,
                spacing=(body.spacing[0] * factor, body.spacing[1] * factor, body.spacing[2] * factor),
            )
            for body in problem.bodies
        ),
        end_time=problem.end_time * factor,
        fixed_dt=problem.fixed_dt and problem.fixed_dt * factor,
        damping=problem.damping._replace(rate=problem.damping.rate / factor),
        clamp=_moved(problem.clamp, scale=factor),
        absorbers=tuple(a._replace(place=a.place * factor) for a in problem.absorbers),
    )


def enlarged(problem: Problem, before: np.ndarray, behind: np.ndarray) -> Problem:
    """A problem in a grid with more cells in front of its lower corner and behind its upper corner."""
    old = problem.geometry
    geometry = grid(
        type(old), lower=old.lower - before * old.spacing, cells=old.cells + before + behind, spacing=old.spacing
    )
    return replace(problem, geometry=geometry)


def shifted(problem: Problem, offset: np.ndarray) -> Problem:
    """A problem with its bodies moved by an offset (3,), m, in an unchanged grid."""
    bodies = tuple(replace(body, position=body.position + offset) for body in problem.bodies)
    absorbers = tuple(a._replace(place=a.place + float(offset[a.axis])) for a in problem.absorbers)
    return replace(problem, bodies=bodies, clamp=_moved(problem.clamp, offset=offset), absorbers=absorbers)


def _moved(clamp: Clamp, *, scale: float = 1.0, offset: np.ndarray | float = 0.0) -> Clamp:
    return clamp._replace(lower=clamp.lower * scale + offset, upper=clamp.upper * scale + offset)


def boosted(problem: Problem, velocity: np.ndarray) -> Problem:
    """A problem with a velocity (3,), m/s, added to all bodies."""
    bodies = tuple(replace(body, velocity=body.velocity + velocity) for body in problem.bodies)
    return replace(problem, bodies=bodies)


def mirrored(problem: Problem) -> Problem:
    """The mirror image in the plane where the first coordinate is zero."""
    old, sign = problem.geometry, _sign(0)
    lower = old.lower.copy()
    lower[0] = -(old.lower[0] + old.cells[0] * old.spacing)
    (low, high), *others = problem.faces
    return replace(
        problem,
        geometry=grid(type(old), lower=lower, cells=old.cells, spacing=old.spacing),
        bodies=tuple(
            replace(body, position=body.position * sign, velocity=body.velocity * sign) for body in problem.bodies
        ),
        faces=((high, low), *others),
    )


def unfolded(problem: Problem, axis: int) -> Problem:
    """The whole of which the problem is the half above a symmetric face at zero; each body is followed by its image."""
    old, sign = problem.geometry, _sign(axis)
    lower, cells = old.lower.copy(), old.cells.copy()
    lower[axis] = -old.cells[axis] * old.spacing
    cells[axis] = 2 * old.cells[axis]
    faces = list(problem.faces)
    faces[axis] = (faces[axis][1], faces[axis][1])
    return replace(
        problem,
        geometry=grid(type(old), lower=lower, cells=cells, spacing=old.spacing),
        bodies=tuple(
            replace(
                body,
                position=np.concatenate([body.position, body.position * sign]),
                velocity=np.concatenate([_field(body), _field(body) * sign]),
                mass=np.concatenate([body.mass, body.mass]),
            )
            for body in problem.bodies
        ),
        faces=tuple(faces),
    )


def _sign(axis: int) -> np.ndarray:
    sign = np.ones(3)
    sign[axis] = -1.0
    return sign


def _field(body: Any) -> np.ndarray:
    return np.ones((body.mass.size, 1)) * body.velocity


def advanced(problem: Problem, steps: int = STEPS, *, threads: int = 1, shares: int = 0) -> Simulation:
    """The problem after some steps; without ``shares`` its particles are cut as their number asks for."""
    simulation = start(problem, threads=threads, shares=shares)
    for _ in range(steps):
        simulation.advance()
    return simulation


def ordered(particles: Particles) -> Particles:
    """The particles by their permanent numbers."""
    index = np.argsort(particles.number)
    return type(particles)(*(field[index] for field in particles))


def image(particles: Particles, axis: int = 0) -> Particles:
    """The mirror image of a state in the plane where a coordinate is zero."""
    sign = _sign(axis)
    return particles._replace(
        position=particles.position * sign,
        velocity=particles.velocity * sign,
        deviator=particles.deviator * np.array([sign[i] * sign[j] for i, j in COMPONENTS]),
    )


def largest_difference(first: Particles, second: Particles, *, spacing: float, speed: float) -> float:
    """The largest difference of two runs, particle by particle, in all that a particle carries.

    Both in the order of their numbers. Each field is told in a scale of its own: cells, a gauge speed and its square,
    density times it, or the value itself; not a number where one of them is none.
    """
    stress = float(first.density.max()) * speed**2
    scales = {
        "position": spacing,
        "velocity": speed,
        "energy": speed**2,
        **dict.fromkeys(("pressure", "viscosity", "deviator"), stress),
        **dict.fromkeys(("plastic_strain", "damage"), 1.0),
        "temperature": float(first.temperature.max()),
    }
    differences = [abs(getattr(first, name) - getattr(second, name)).max() / scale for name, scale in scales.items()]
    differences += [abs(getattr(first, name) / getattr(second, name) - 1.0).max() for name in ("mass", "density")]
    gone = int((first.alive != second.alive).sum())  # particles that have left the grid in one of the two only
    return float(np.max([*differences, gone]))


def differing_values(first: Particles, second: Particles) -> int:
    """Values that differ in any bit, over all fields; both in the order of their numbers."""
    return sum(
        int(np.count_nonzero(left.view(np.uint8) != right.view(np.uint8)))
        if left.shape == right.shape
        else max(left.size, right.size)
        for left, right in zip(map(np.ascontiguousarray, first), map(np.ascontiguousarray, second), strict=True)
    )
