"""The loop: step, observe, audit, stop. ``simulate`` is what a run calls."""

import math
from collections.abc import Callable
from contextlib import closing
from dataclasses import asdict, dataclass, field, fields, replace
from time import monotonic
from typing import Protocol

import numpy as np

from solver import state
from solver.audit import Audit, Books, audit, body_balances, left_behind, summed, totals
from solver.checkpoints import Carried, Checkpointing, Fingerprint, fingerprint
from solver.errors import Interrupted, ProblemError, UnphysicalState
from solver.grid.debris import clear_debris
from solver.grid.flight import flown_columns, is_on_grid
from solver.grid.step import Stepper, shares_of
from solver.grid.strays import MOST_DISCARDED, strays
from solver.matter.eos import reference_sound_speed
from solver.matter.failure import weakens
from solver.matter.strength import stored_part
from solver.problem import Body, Problem
from solver.problem.geometry import node_count
from solver.state import (
    NONE_DEPARTED,
    Departed,
    Particles,
    Snapshot,
    empty_table,
    joined,
    records,
    remembered_in,
    reordered,
    views,
)
from solver.steppers import stepper_of
from solver.steps.crossing import exit_face
from solver.steps.method import Partition
from solver.steps.points import StateLimits, Tally, first_fault, unphysical
from solver.steps.threads import ThreadPool, asked_threads
from solver.steps.timestep import fastest, first_step, joining_step, stable_step

# Steps between reorderings of the particle arrays, for memory locality; debris is retired before them.
SORT_INTERVAL = 100
# Steps between joins of what arrives: in so many a particle moves through five cells at most (``Problem.travel`` of a
# half), and tables are laid out anew.
JOIN_INTERVAL = 10

# Particles of a share, about, and the most shares: each has a table of nodes of its own.
SHARE, MOST_SHARES = 32768, 16

# Limits of a physical state. The strongest shock compresses a solid s/(s - 1) times, with s the slope of the Hugoniot:
# twofold to fivefold for most metals. No particle ends ten times faster than the fastest body began, or with a hundred
# times its specific kinetic energy.
DENSEST, THINNEST, SPEED_FACTOR, ENERGY_FACTOR = 8.0, 1e-9, 10.0, 100.0

CARRIED_NUMBERS = ("time", "step", "dt", "smallest_step", "particle_steps", "arrived")  # of a Simulation
DEPARTED = "departed_"  # before the names of its arrays

SnapshotObserver = Callable[[Snapshot], str | None]


class Recorder(Protocol):
    """Takes states at times of its own; it decides nothing."""

    @property
    def due(self) -> float:
        """Time of the next state that it takes, s."""

    def add(self, snapshot: Snapshot) -> None:
        """Take a state."""


@dataclass
class Counters:
    """Counts of the safeguards that acted on a state, over all steps and particles; every clamp is counted.

    Limits that belong to a model are part of it, and not counted: Johnson and Cook's T* below room temperature and
    their strain rate below the reference rate, the shear modulus of expanded matter, and in Steinberg and Guinan's
    strength the softest solid and the thinnest; of smoothed particles the least density of a length, and gradients that
    are not corrected where neighbours are few.
    """

    tension_floors: int = 0
    beyond_hugoniot: int = 0
    below_expansion: int = 0
    below_zero_kelvin: int = 0
    molten: int = 0
    sound_floors: int = 0
    unstable: int = 0
    failed: int = 0  # particles, each once
    reflected: int = 0
    discarded: int = 0  # stray particles

    def add(self, tally: Tally) -> None:
        """Add the tally of a step."""
        for name in COUNTED:
            count = getattr(tally, name)
            if count:
                setattr(self, name, getattr(self, name) + int(count))


# What each share of the particles counts for itself.
COUNTED = [one.name for one in fields(Counters) if one.name in Tally._fields]


@dataclass(frozen=True)
class Outcome:
    """The result of a simulation."""

    snapshot: Snapshot  # the final state
    stop: str  # the observer's word, or "end_time"
    audit: Audit  # at the end
    history: tuple[Audit, ...]  # at each observation, the last one included
    counters: Counters
    smallest_step: float  # s
    particle_steps: int
    books: Books  # at the end


@dataclass
class Simulation:
    """The moving parts of one simulation."""

    problem: Problem
    table: np.ndarray  # (ROWS, n) the particles, body by body
    body: np.ndarray  # (n,) index of each particle's body
    time: float = 0.0
    step: int = 0
    counters: Counters = field(default_factory=Counters)
    smallest_step: float = math.inf
    particle_steps: int = 0
    arrived: int = 0  # of the problem's arrivals, those that have joined
    pool: ThreadPool = field(default_factory=lambda: ThreadPool(1))
    shares: int = 0  # of the particles; decides the bits, and how many threads find work; 0: by their number

    def __post_init__(self) -> None:
        problem = self.problem
        self.particles = views(self.table)
        self.limits = _limits(problem)
        self.shares = self.shares or shares_for(problem.particle_count)
        self.stepper = stepper_of(problem)(problem, self.limits, self.pool, self.shares)
        self._departures = [NONE_DEPARTED]
        self.dt = problem.fixed_dt or first_step(problem)
        self._arrange()
        self.books = self._first_books()

    def snapshot(self) -> Snapshot:
        """The present state; the arrays are those of the simulation."""
        self.stepper.show(self.table)
        waiting, _ = self._waiting()
        return Snapshot(
            self.time,
            self.step,
            self.particles,
            self.body,
            self.departed,
            waiting=float(waiting.mass.sum()),
            remembered=remembered_in(self.table),
        )

    @property
    def departed(self) -> Departed:
        """Records of all particles that left the grid or were retired, in the order in which they did."""
        if len(self._departures) > 1:
            self._departures = [joined(self._departures)]
        return self._departures[0]

    def audit(self) -> Audit:
        """The present balances."""
        self.stepper.show(self.table)
        problem, departed, waiting = self.problem, self.departed, self._waiting()
        bodies = body_balances(
            problem.geometry,
            (self.particles, self.body),
            (departed, departed.body),
            *([waiting] if problem.arrivals is not None else []),
            count=len(problem.bodies),
        )
        if problem.books is not None:
            bodies = left_behind(bodies, problem.books.left)
        return audit(
            problem.geometry,
            self.particles,
            self.books,
            time=self.time,
            waiting=totals(waiting[0]) if problem.arrivals is not None else None,
            bodies=bodies,
        )

    def carried(self) -> Carried:
        """The state that passes from this step to the next, and into a checkpoint."""
        books, booked = self.books.plain()
        arrays = {
            "table": self.table,
            "number": self.particles.number,
            "alive": self.particles.alive,
            "body": self.body,
            **booked,
            **{DEPARTED + name: array for name, array in self.departed._asdict().items()},
            **self.stepper.carried(),
        }
        numbers = {name: getattr(self, name) for name in CARRIED_NUMBERS}
        return Carried({**numbers, "counters": asdict(self.counters), "books": books}, arrays)

    def take_over(self, carried: Carried) -> None:
        """Go on from what a simulation of the same problem carried."""
        numbers, arrays = carried.numbers, carried.arrays
        for name in CARRIED_NUMBERS:
            setattr(self, name, numbers[name])
        self.counters, self.books = Counters(**numbers["counters"]), Books.from_plain(numbers["books"], arrays)
        self._departures = [Departed(*(arrays[DEPARTED + name] for name in Departed._fields))]
        self.table, self.body = arrays["table"], arrays["body"]
        self.stepper.take_over(arrays)
        self._lay_out(arrays["number"], arrays["alive"])

    def advance(self) -> None:
        """One step; raises UnphysicalState."""
        if self.step and self.step % SORT_INTERVAL == 0:
            self._retire()
            self._arrange()
        if self.problem.arrivals is not None and self.step % JOIN_INTERVAL == 0:
            self._join()
        dt = self.dt
        balance = self.stepper.advance(self.partition, self.time, dt)
        self.tally = balance.tally
        self.books = replace(
            self.books,
            impulse=self.books.impulse + balance.impulse,
            removed=self.books.removed + (balance.energy + balance.contact),
            removed_by_contact=self.books.removed_by_contact + balance.contact,
            worked=self.books.worked + balance.work,
        )
        self.counters.reflected += balance.reflected
        self.time += dt
        self.step += 1
        self.particle_steps += self.particles.mass.size
        self.smallest_step = min(self.smallest_step, dt)
        self._book(balance.gone)
        if self.problem.fixed_dt is None:
            self.dt = stable_step(self.problem, self.tally, dt)

    def _book(self, gone: int) -> None:
        """Counters, ledger and faults of the step that was just taken."""
        self.counters.add(self.tally)
        if self.tally.fault:
            self._discard()
        if gone:
            self._drop(np.flatnonzero((self.particles.alive == 0) & (self.particles.mass > 0.0)), by_itself=True)
            if self.books.ledger.particles and not self.particles.alive.any():
                raise ProblemError("every particle has left the grid; enlarge it or end earlier")

    def _discard(self) -> None:
        """Discard the particles whose state is unphysical; raises UnphysicalState where they are no strays."""
        particles, books = self.particles, self.books
        beyond = np.zeros(0, np.int64)
        if isinstance(self.stepper, Stepper):
            beyond = unphysical(self.problem, self.limits, particles, self.body)
        lost = books.ledger.discarded + float(particles.mass[beyond].sum())
        many = lost > MOST_DISCARDED * books.start.mass
        if not beyond.size or many or not strays(self.problem, particles, beyond).all():
            self._raise(int(self.tally.culprit))
        particles.alive[beyond] = 0
        self.counters.discarded += beyond.size
        self._drop(beyond, discarded=True)

    def _retire(self) -> None:
        """Retire debris that nothing can meet any more."""
        rule = self.problem.retirement
        if rule is None or self.time < rule.after:
            return
        gone = clear_debris(self.problem, self.particles, self.body)
        self.particles.alive[gone] = 0
        self._drop(gone)

    def _first_books(self) -> Books:
        """Books with all matter, on the grid or on its way to it, that go on from those of the stages before."""
        here, before = totals(self.particles), self.problem.books
        if before is not None:
            return replace(before, start=summed(before.start, here))
        return Books(here if self.problem.arrivals is None else summed(here, totals(self._waiting()[0])))

    def _waiting(self) -> tuple[Particles, np.ndarray]:
        """What is still to join, as it will be at its own time, and the index of each one's body."""
        arrivals = self.problem.arrivals
        if arrivals is None:
            return views(self.table[:, :0]), self.body[:0]
        return views(arrivals.table[:, self.arrived :]), arrivals.body[self.arrived :]

    def _join(self) -> None:
        """Put arrivals that are due on the grid, as far inside as they have flown since their time.

        One that has flown past a corner of the grid by then departs at once.
        """
        arrivals = self.problem.arrivals
        assert arrivals is not None
        due = int(np.searchsorted(arrivals.time, self.time, side="right"))
        if due == self.arrived:
            return
        which = slice(self.arrived, due)
        coming = arrivals.table[:, which]
        flown = flown_columns(self.problem, coming, self.time - arrivals.time[which])
        turned = ((flown - coming)[state.VX : state.VZ + 1] * coming[state.MASS]).sum(axis=1)
        self.books = replace(self.books, impulse=self.books.impulse + turned)
        number = self.problem.particle_count - arrivals.time.size + np.arange(self.arrived, due)
        count = self.body.size
        self.table = np.concatenate([self.table, flown[: self.table.shape[0]]], axis=1)
        self.body = np.concatenate([self.body, arrivals.body[which]])
        self.particles = views(
            self.table,
            np.concatenate([self.particles.number, number]),
            np.concatenate([self.particles.alive, np.ones(number.size, np.uint8)]),
        )
        self.arrived = due
        past = count + np.flatnonzero(~is_on_grid(self.problem.geometry, self.particles.position[count:]))
        self.particles.alive[past] = 0
        self._drop(past)
        self._arrange()
        if self.problem.fixed_dt is None:
            self.dt = min(self.dt, joining_step(self.problem))

    def _raise(self, first: int) -> None:
        particles, body = self.stepper.material_points(self.particles, self.body)
        culprit, quantity, value = first_fault(self.problem, self.limits, particles, body, first)
        raise UnphysicalState(
            particle=int(particles.number[culprit]),
            body=self.problem.bodies[int(body[culprit])].name,
            time=self.time,
            step=self.step,
            quantity=quantity,
            value=value,
        )

    def _arrange(self) -> None:
        """Drop the dead and sort the living by cell within each body, so that neighbours lie close in memory."""
        geometry = self.problem.geometry
        cell = np.zeros(self.particles.mass.size, np.int64)
        for axis in range(3):
            if geometry.nodes[axis] > 1:
                place = self.particles.position[:, axis] - geometry.lower[axis]
                place /= geometry.spacing
                cell *= geometry.nodes[axis]
                cell += place.astype(np.int64)
        if any(body.mesh for body in self.problem.bodies):
            cell[:] = 0  # the nodes of a mesh keep their order
        cell += self.body * node_count(geometry)
        order = np.argsort(cell, kind="stable")
        if not self.particles.alive.all():
            order = order[self.particles.alive[order] == 1]
        self.table = reordered(self.table, order)
        self.body = self.body[order]
        self._lay_out(self.particles.number[order], self.particles.alive[order])

    def _lay_out(self, number: np.ndarray, alive: np.ndarray) -> None:
        """The views and shares that go with the present order of the particles."""
        self.particles = views(self.table, number, alive)
        edges = np.searchsorted(self.body, np.arange(len(self.problem.bodies) + 1))
        ranges = [(int(edges[i]), int(edges[i + 1])) for i in range(len(edges) - 1)]
        self.partition = Partition(self.table, self.particles, shares_of(ranges, self.shares))

    def _drop(self, gone: np.ndarray, *, by_itself: bool = False, discarded: bool = False) -> None:
        """Book and record particles; without mass they stay in a harmless place until the next reordering.

        Of those that leave ``by_itself`` the mass is booked too that its pressure still drives apart, and that of the
        ``discarded``.
        """
        if not gone.size:
            return
        expanding, rule, particles = 0.0, self.problem.retirement, self.particles
        if by_itself and rule is not None:
            driven = particles.pressure[gone] > rule.expansion * particles.density[gone]
            expanding = float(particles.mass[gone[driven]].sum())
        stray = float(particles.mass[gone].sum()) if discarded else 0.0
        ledger = self.books.ledger.with_particles(particles, gone, expanding=expanding, discarded=stray)
        self.books = replace(self.books, ledger=ledger)
        self._departures.append(records(self.time, particles, self.body, gone, remembered_in(self.table)))
        self.table[state.MASS, gone] = 0.0
        geometry = self.problem.geometry
        self.particles.position[gone] = geometry.lower + 0.5 * geometry.spacing


def simulate(
    problem: Problem,
    observe: SnapshotObserver | None = None,
    *,
    interval: float | None = None,
    recorder: Recorder | None = None,
    threads: int | None = None,
    shares: int = 0,
    checkpoint: Checkpointing | None = None,
) -> Outcome:
    """Run a problem to its end time, or until the observer gives a reason to stop.

    ``observe`` is called with the initial state and then at the first step at or after each multiple of ``interval``
    (s); a word that it returns ends the run. ``recorder`` takes the first state at or after each time that it asks for.
    With ``checkpoint`` the run goes on from the file, if it is there and
    fits, and ends with the same bits as one that never stopped. Raises UnphysicalState and ProblemError; Interrupted
    when ``checkpoint.must_stop`` asks for it.
    """
    simulation = start(problem, threads=threads, shares=shares)
    with closing(simulation.pool):
        return ObservedRun(simulation, observe, interval or problem.end_time, recorder, checkpoint).outcome()


@dataclass
class ObservedRun:
    """A simulation with what observes it, and the checkpoint from which it goes on."""

    simulation: Simulation
    observe: SnapshotObserver | None
    interval: float  # s
    recorder: Recorder | None
    checkpoint: Checkpointing | None
    history: list[Audit] = field(default_factory=list)
    due: float = 0.0  # time of the next observation, s
    written: float = field(default_factory=monotonic)  # time of the last checkpoint, of the wall clock

    def outcome(self) -> Outcome:
        """Go on from the checkpoint, or from the start, to the end."""
        simulation, stop = self.simulation, None
        mark = self._restored(self.checkpoint) if self.checkpoint else {}
        while stop is None:
            last = simulation.time >= simulation.problem.end_time
            if self.recorder and simulation.time >= self.recorder.due:
                self.recorder.add(simulation.snapshot())
            if simulation.time >= self.due or last:
                self.history.append(simulation.audit())
                stop = self.observe(simulation.snapshot()) if self.observe else None
                self.due = (math.floor(simulation.time / self.interval * (1.0 + 1e-12)) + 1) * self.interval
            if stop is None and last:
                stop = "end_time"
            if stop is None:
                simulation.advance()
                if self.checkpoint:
                    self._keep(self.checkpoint, mark)
        return Outcome(
            snapshot=simulation.snapshot(),
            stop=stop,
            audit=self.history[-1],
            history=tuple(self.history),
            counters=simulation.counters,
            smallest_step=simulation.smallest_step,
            particle_steps=simulation.particle_steps,
            books=simulation.books,
        )

    def _restored(self, checkpoint: Checkpointing) -> Fingerprint:
        """Continue from the checkpoint file where it can be used; the fingerprint of this run."""
        simulation, caller, shares = self.simulation, checkpoint.caller, str(self.simulation.shares)
        mark = fingerprint(simulation.problem, interval=repr(self.interval), caller=caller, shares=shares)
        if carried := checkpoint.read(mark):
            observing = carried.numbers["observing"]
            checkpoint.restore_observer(observing["observer"])
            self.history = [Audit.from_plain(**audit) for audit in observing["history"]]
            self.due = observing["due"]
            simulation.take_over(carried)
            checkpoint.on_checkpoint(simulation.step)
            checkpoint.log(f"from the checkpoint at t = {simulation.time:.6g} s, step {simulation.step}")
        return mark

    def _keep(self, checkpoint: Checkpointing, mark: Fingerprint) -> None:
        """Write a checkpoint when one is due; raise Interrupted when the caller asks the run to stop."""
        simulation, must_stop = self.simulation, checkpoint.must_stop()
        if must_stop or monotonic() - self.written >= checkpoint.seconds_between:
            carried = simulation.carried()
            observing = {
                "history": [asdict(audit) for audit in self.history],
                "due": self.due,
                "observer": checkpoint.observer_state(),
            }
            everything = Carried({**carried.numbers, "observing": observing}, carried.arrays)
            checkpoint.write(mark, everything, simulation.step)
            self.written = monotonic()
        if must_stop:
            raise Interrupted(time=simulation.time, step=simulation.step)


def shares_for(particles: int) -> int:
    """Number of shares that a number of particles is cut into: a power of two that does not depend on the threads."""
    shares = 1
    while shares < MOST_SHARES and 2 * shares * SHARE <= particles:
        shares *= 2
    return shares


def threads_for(particles: int, threads: int | None = None, shares: int = 0) -> int:
    """Threads for a number of particles: as many as asked for, here or by WHIPPLE_THREADS, and at most one a share."""
    return min(threads or asked_threads(), shares or shares_for(particles))


def start(problem: Problem, *, threads: int | None = None, shares: int = 0) -> Simulation:
    """The initial state of a problem; its threads are those of ``threads_for``.

    ``shares`` is how many parts of the particles threads may work on at once; by default as many as their number
    asks for. Another number of shares gives other bits, another number of threads does not.
    """
    sizes = [body.mass.size for body in problem.bodies]
    explosive = any(body.lighting is not None for body in problem.bodies)
    remembers = problem.audits_heat or any(map(_remembers, problem.bodies))
    table, begin = empty_table(sum(sizes), burns=explosive, remembers=remembers), 0
    for body, size in zip(problem.bodies, sizes, strict=True):
        _check_inside(problem, body)
        particles = views(table[:, begin : begin + size])
        particles.position[:], particles.velocity[:], particles.mass[:] = body.position, body.velocity, body.mass
        body.fill(particles)
        if body.lighting is not None:
            table[state.LIGHTING, begin : begin + size] = body.lighting
        begin += size
    index = np.repeat(np.arange(len(sizes)), sizes)
    pool = ThreadPool(threads_for(problem.particle_count, threads, shares))
    return Simulation(problem, table, index, time=problem.start_time, pool=pool, shares=shares)


def _remembers(body: Body) -> bool:
    """Whether the matter of a body needs the rows ``HARDENED`` and ``STORED``."""
    return bool(weakens(body.matter.failure) or stored_part(body.matter.strength) > 0.0)


def _check_inside(problem: Problem, body: Body) -> None:
    if body.mesh or not body.mass.size:  # of a mesh the grid's box holds the faces alone
        return
    corners = np.stack([body.position.min(axis=0), body.position.max(axis=0)])
    for corner in range(2):
        face = exit_face(problem.geometry, corners, corner)
        if face >= 0:
            raise ProblemError(
                f"body {body.name!r} reaches {corners[corner, face // 2]:.6g} m "
                f"on axis {face // 2}, "
                f"outside the grid; enlarge the grid or move the body"
            )


def _limits(problem: Problem) -> StateLimits:
    sound = max(reference_sound_speed(body.matter.eos) for body in problem.bodies)
    speed = max(fastest(problem), sound)
    return StateLimits(
        densest=DENSEST, thinnest=THINNEST, energy=ENERGY_FACTOR * 0.5 * speed**2, speed=SPEED_FACTOR * speed
    )
