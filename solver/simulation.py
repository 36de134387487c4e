"""The loop: step, observe, audit, stop. ``simulate`` is what a run calls."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from solver.audit import Audit, Ledger, audit, totals
from solver.eos import reference_density, reference_sound_speed, temperature
from solver.errors import ProblemError, UnphysicalState
from solver.geometry import exit_face, node_count
from solver.problem import Body, Problem
from solver.state import Particles, Snapshot, empty_nodes, empty_particles, joined, selected
from solver.step import Stage, Stepper
from solver.stress import QUANTITIES, Limits, Tally, chunks_of, empty_tally
from solver.threads import Team
from solver.timestep import first_step, stable_step
from solver.transfer import slab_count

SORT_INTERVAL = 50  # steps between reorderings of the particle arrays: memory locality only

# Limits of a physical state. A shock of any strength compresses a solid less than fourfold; no particle ends ten times
# faster than the fastest body began, or with a hundred times its specific kinetic energy.
DENSEST, THINNEST, SPEED_FACTOR, ENERGY_FACTOR = 8.0, 1e-9, 10.0, 100.0

Observer = Callable[[Snapshot], str | None]


@dataclass
class Counters:
    """How often a safeguard acted, over all steps and particles: no clamp goes uncounted."""

    tension_floors: int = 0
    beyond_hugoniot: int = 0
    below_zero_kelvin: int = 0
    reflected: int = 0

    def add(self, tally: Tally) -> None:
        """Take over one step's tallies."""
        self.tension_floors += int(tally.tension_floors.sum())
        self.beyond_hugoniot += int(tally.beyond_hugoniot.sum())
        self.below_zero_kelvin += int(tally.below_zero_kelvin.sum())


@dataclass(frozen=True)
class Outcome:
    """What a simulation ends with."""

    snapshot: Snapshot  # the final state
    stop: str  # the observer's word, or "end_time"
    audit: Audit  # at the end
    history: tuple[Audit, ...]  # at each observation, the last one included
    counters: Counters
    smallest_step: float  # s
    particle_steps: int


@dataclass
class Simulation:
    """The moving parts of one simulation."""

    problem: Problem
    particles: Particles
    body: np.ndarray
    time: float = 0.0
    step: int = 0
    ledger: Ledger = field(default_factory=Ledger)
    counters: Counters = field(default_factory=Counters)
    smallest_step: float = math.inf
    particle_steps: int = 0
    team: Team = field(default_factory=Team)

    def __post_init__(self) -> None:
        problem = self.problem
        self.limits = _limits(problem)
        nodes = empty_nodes(node_count(problem.geometry))
        self.stepper = Stepper(problem, nodes, self.limits, self.team)
        self.slab_start = np.zeros(slab_count(problem.geometry) + 1, np.int64)
        self.impulse = np.zeros(3)
        self.start = totals(self.particles)
        self.dt = problem.fixed_dt or _first_step(problem)
        self._arrange()

    def snapshot(self) -> Snapshot:
        """The present state; the arrays are those of the simulation."""
        return Snapshot(self.time, self.step, self.particles, self.body)

    def audit(self) -> Audit:
        """The present balances."""
        return audit(
            self.problem.geometry,
            self.particles,
            time=self.time,
            start=self.start,
            ledger=self.ledger,
            impulse=self.impulse,
        )

    def advance(self) -> None:
        """One step; raises UnphysicalState."""
        if self.step and self.step % SORT_INTERVAL == 0:
            self._arrange()
        dt = self.dt
        impulse, reflected = self.stepper.advance(self.stage, self.tally, dt)
        self.impulse += impulse
        self.counters.reflected += reflected
        self.time += dt
        self.step += 1
        self.particle_steps += self.particles.mass.size
        self.smallest_step = min(self.smallest_step, dt)
        self._book()
        if self.problem.fixed_dt is None:
            self.dt = stable_step(
                self.tally,
                courant=self.problem.courant,
                spacing=self.problem.geometry.spacing,
                previous=dt,
            )

    def _book(self) -> None:
        """Counters, ledger and faults of the step that was just taken."""
        tally = self.tally
        self.counters.add(tally)
        faults = np.flatnonzero(tally.fault)
        if faults.size:
            self._raise(int(faults[0]))
        if tally.outside.any():
            gone = np.flatnonzero((self.particles.alive == 0) & ~self.booked)
            self.ledger = self.ledger.with_particles(self.particles, gone)
            self.booked[gone] = True
            if self.ledger.particles and not self.particles.alive.any():
                raise ProblemError("every particle has left the grid; enlarge it or end earlier")

    def _raise(self, row: int) -> None:
        culprit = int(self.tally.culprit[row])
        raise UnphysicalState(
            particle=int(self.particles.number[culprit]),
            body=self.problem.bodies[int(self.body[culprit])].name,
            time=self.time,
            step=self.step,
            quantity=QUANTITIES[int(self.tally.fault[row])],
            value=float(self.tally.value[row]),
        )

    def _arrange(self) -> None:
        """Drop the dead and sort the living by cell within each body, so that neighbours lie close in memory."""
        geometry = self.problem.geometry
        cell = np.zeros(self.particles.mass.size, np.int64)
        for axis in range(3):
            if geometry.nodes[axis] > 1:
                place = (self.particles.position[:, axis] - geometry.lower[axis]) / geometry.spacing
                cell = cell * geometry.nodes[axis] + place.astype(np.int64)
        cell += self.body.astype(np.int64) * node_count(geometry)
        order = np.argsort(cell, kind="stable")
        order = order[self.particles.alive[order] == 1]
        self.particles = selected(self.particles, order)
        self.body = np.ascontiguousarray(self.body[order])
        count = self.body.size
        edges = np.searchsorted(self.body, np.arange(len(self.problem.bodies) + 1))
        ranges = [(int(edges[i]), int(edges[i + 1])) for i in range(len(edges) - 1)]
        self.tally = empty_tally(sum(chunks_of(end - begin) for begin, end in ranges))
        self.stage = Stage(
            self.particles, np.empty((count, 3)), np.empty(count, np.int64), self.slab_start, ranges
        )
        self.booked = np.zeros(count, bool)


def simulate(
    problem: Problem,
    observe: Observer | None = None,
    *,
    interval: float | None = None,
    threads: int | None = None,
) -> Outcome:
    """Run a problem to its end time, or until the observer gives a reason to stop.

    ``observe`` is called with the initial state and then at the first step at or after each multiple of ``interval``
    (s); a word that it returns ends the run. Raises UnphysicalState and ProblemError.
    """
    simulation = start(problem, threads=threads)
    interval = interval or problem.end_time
    history: list[Audit] = []
    stop = None
    due = 0.0
    while stop is None:
        last = simulation.time >= problem.end_time
        if simulation.time >= due or last:
            history.append(simulation.audit())
            stop = observe(simulation.snapshot()) if observe else None
            due = (math.floor(simulation.time / interval * (1.0 + 1e-12)) + 1) * interval
        if stop is None and last:
            stop = "end_time"
        if stop is None:
            simulation.advance()
    return Outcome(
        snapshot=simulation.snapshot(),
        stop=stop,
        audit=history[-1],
        history=tuple(history),
        counters=simulation.counters,
        smallest_step=simulation.smallest_step,
        particle_steps=simulation.particle_steps,
    )


def start(problem: Problem, *, threads: int | None = None) -> Simulation:
    """The initial state of a problem; without ``threads`` the environment's WHIPPLE_THREADS counts, or one."""
    parts = [_initial(body) for body in problem.bodies]
    particles = joined(parts)
    body = np.repeat(np.arange(len(parts)), [part.mass.size for part in parts])
    _check_inside(problem, particles, body)
    return Simulation(problem, particles, body, team=Team(threads))


def _initial(body: Body) -> Particles:
    particles = empty_particles(body.mass.size)
    particles.position[:] = body.position
    particles.velocity[:] = body.velocity
    particles.mass[:] = body.mass
    particles.density[:] = body.density
    particles.temperature[:] = temperature(body.matter.eos, body.density, 0.0)
    return particles


def _check_inside(problem: Problem, particles: Particles, body: np.ndarray) -> None:
    for index in range(len(problem.bodies)):
        corners = particles.position[body == index]
        corners = np.stack([corners.min(axis=0), corners.max(axis=0)])
        for corner in range(2):
            face = exit_face(problem.geometry, corners, corner)
            if face >= 0:
                raise ProblemError(
                    f"body {problem.bodies[index].name!r} reaches {corners[corner, face // 2]:.6g} m "
                    f"on axis {face // 2}, "
                    f"outside the grid; enlarge the grid or move the body"
                )


def _fastest(problem: Problem) -> float:
    return max(float(np.sqrt((np.asarray(body.velocity) ** 2).sum())) for body in problem.bodies)


def _limits(problem: Problem) -> Limits:
    sound = max(reference_sound_speed(body.matter.eos) for body in problem.bodies)
    speed = max(_fastest(problem), sound)
    return Limits(
        densest=DENSEST,
        thinnest=THINNEST,
        energy=ENERGY_FACTOR * 0.5 * speed**2,
        speed=SPEED_FACTOR * speed,
    )


def _first_step(problem: Problem) -> float:
    sound = max(
        math.sqrt(
            reference_sound_speed(body.matter.eos) ** 2
            + 4.0 / 3.0 * body.matter.shear_modulus / reference_density(body.matter.eos)
        )
        for body in problem.bodies
    )
    return first_step(
        sound + _fastest(problem), courant=problem.courant, spacing=problem.geometry.spacing
    )
