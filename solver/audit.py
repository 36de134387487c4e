"""Balances of mass, momentum and energy, on the grid and in the ledger of particles that left it or were retired.

E = kinetic + internal + ledger + removed - work of loads. Every face stands still, so boundaries do no work; what they
give is the impulse. Damping, contact, absorbing surfaces and walls that stop a pulled node remove energy, which they
accumulate themselves. Each term is summed from its own quantity and none is the remainder of the others: their sum is
what drifts.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from solver.problem.geometry import Geometry, conserved_axes, impact_axis
from solver.state import Departed, Particles

HOTTEST_PART = 1e-3  # share of the particles, the hottest, whose internal energy is watched


@dataclass(frozen=True)
class Ledger:
    """Sums over particles that left through free faces, were retired or discarded (per radian in axisymmetry)."""

    mass: float = 0.0  # kg
    momentum: np.ndarray = field(default_factory=lambda: np.zeros(3))  # kg m/s
    kinetic: float = 0.0  # J
    internal: float = 0.0  # J
    particles: int = 0
    expanding: float = 0.0  # mass that left while its pressure still drove it apart (``problem.Retirement``), kg
    discarded: float = 0.0  # mass of stray particles that were discarded (``grid/strays.py``), kg

    def with_particles(
        self,
        particles: Particles | Departed,
        index: np.ndarray | slice,
        *,
        expanding: float = 0.0,
        discarded: float = 0.0,
    ) -> "Ledger":
        """The ledger with some particles (indices) added, or records of them; the rest is their part of it, kg."""
        part = totals(particles, index)
        return replace(
            self,
            mass=self.mass + part.mass,
            momentum=self.momentum + part.momentum,
            kinetic=self.kinetic + part.kinetic,
            internal=self.internal + part.internal,
            particles=self.particles + particles.mass[index].size,
            expanding=self.expanding + expanding,
            discarded=self.discarded + discarded,
        )


@dataclass(frozen=True)
class Totals:
    """Sums over particles at one time (per radian in axisymmetry)."""

    mass: float  # kg
    momentum: np.ndarray  # (3,) kg m/s
    kinetic: float  # J
    internal: float  # J
    momentum_scale: float  # sum of |m v|, kg m/s: what a momentum error is measured against


@dataclass(frozen=True)
class BodyBalance:
    """Sums over the particles of a body at one time, on the grid and departed (per radian in axisymmetry)."""

    kinetic: float  # J, on the grid
    internal: float  # J, on the grid
    momentum: float  # kg m/s along the line of flight, on the grid
    departed_kinetic: float  # J
    departed_internal: float  # J
    departed_momentum: float  # kg m/s along the line of flight


@dataclass(frozen=True)
class Books:
    """All that a simulation has booked: the next stage goes on from it (per radian in axisymmetry)."""

    start: Totals  # of all bodies of this stage and those before
    ledger: Ledger = field(default_factory=Ledger)
    impulse: np.ndarray = field(default_factory=lambda: np.zeros(3))  # (3,) given by faces, absorbers and loads, N s
    removed: float = 0.0  # energy that damping, walls, absorbers and contact took, J
    removed_by_contact: float = 0.0  # the part of it that contact took, J
    worked: float = 0.0  # work of tractions and gravity, J
    left: tuple[BodyBalance, ...] = ()  # what each body left behind in the stages before, all of it as departed

    def plain(self) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        """Plain objects and arrays that ``from_plain`` reads."""
        numbers = asdict(self)
        arrays = {f"{name}_momentum": numbers[name].pop("momentum") for name in ("start", "ledger")}
        return numbers, {"impulse": numbers.pop("impulse"), **arrays}

    @staticmethod
    def from_plain(numbers: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> "Books":
        """The books of which ``plain`` made plain objects and arrays."""
        start = Totals(**numbers["start"], momentum=arrays["start_momentum"])
        ledger = Ledger(**numbers["ledger"], momentum=arrays["ledger_momentum"])
        left = tuple(BodyBalance(**balance) for balance in numbers["left"])
        return Books(**{**numbers, "start": start, "ledger": ledger, "left": left, "impulse": arrays["impulse"]})


@dataclass(frozen=True)
class Exchanged:
    """What particles exchanged with faces, damping and contact up to a time (per radian in axisymmetry)."""

    removed: float  # energy that damping, contact, absorbers and walls took, J
    removed_by_contact: float  # the part of it that contact took, J
    impulse: float  # given to the particles by faces, absorbers and loads along the line of flight, N s
    worked: float = 0.0  # work of tractions and gravity, J


@dataclass(frozen=True)
class Audit:
    """How well a run kept its balances; relative numbers unless a unit is given."""

    time: float  # s
    mass_error: float  # of the initial mass
    momentum_error: float  # largest over conserved axes, of the initial sum of |m v|
    energy_drift: float  # (E - E0) / (E0 + |work of loads|)
    kinetic: float  # J, on the grid
    internal: float  # J, on the grid
    outflow_mass: float  # of the initial mass
    removed_energy: float  # by damping, contact, absorbers and walls, of the initial energy and |work|
    contact_energy: float  # the part of it that contact took
    outflow_energy: float  # likewise
    hottest_energy_share: float  # share of the internal energy that the hottest 0.1 % of the particles hold
    largest_speed: float  # m/s
    exchanged: Exchanged
    bodies: tuple[BodyBalance, ...] = ()  # in the order of the problem
    expanding_mass: float = 0.0  # left while its pressure still drove it apart, of the initial mass
    discarded_mass: float = 0.0  # of stray particles that were discarded, of the initial mass

    @staticmethod
    def from_plain(
        *, exchanged: Mapping[str, float], bodies: Sequence[Mapping[str, float]], **numbers: float
    ) -> "Audit":
        """The audit of which ``asdict`` made plain objects."""
        parts = tuple(BodyBalance(**body) for body in bodies)
        return Audit(**numbers, exchanged=Exchanged(**exchanged), bodies=parts)


def totals(particles: Particles | Departed, index: np.ndarray | slice = slice(None)) -> Totals:
    """Sums over some particles, or records of them; by default over all."""
    mass = particles.mass[index]
    momentum, scale, kinetic = np.zeros(3), 0.0, 0.0
    for axis in range(3):  # one after another takes a third of the memory
        velocity = particles.velocity[index, axis]
        momenta = mass * velocity
        momentum[axis] = momenta.sum()
        scale += float(np.abs(momenta).sum())
        kinetic += 0.5 * float((momenta * velocity).sum())
    return Totals(
        mass=float(mass.sum()),
        momentum=momentum,
        kinetic=kinetic,
        internal=float((mass * particles.energy[index]).sum()),
        momentum_scale=scale,
    )


def summed(first: Totals, second: Totals) -> Totals:
    """The sums over two sets of particles."""
    return Totals(**{name: value + getattr(second, name) for name, value in vars(first).items()})


def audit(
    geometry: Geometry,
    particles: Particles,
    books: Books,
    *,
    time: float,
    waiting: Totals | None = None,
    bodies: tuple[BodyBalance, ...] = (),
) -> Audit:
    """Balance the present state, what is still to join, the ledger and the impulse of the faces against the start."""
    start, ledger, impulse, worked = books.start, books.ledger, books.impulse, books.worked
    living = np.flatnonzero(particles.alive)
    here = totals(particles, living)
    now = summed(here, waiting) if waiting else here
    start_energy = start.kinetic + start.internal
    energy = now.kinetic + now.internal + ledger.kinetic + ledger.internal + books.removed - worked
    scale = start_energy + abs(worked)
    missing = now.momentum + ledger.momentum - impulse - start.momentum
    gauge = start.momentum_scale or float(np.abs(impulse).sum()) or 1.0
    return Audit(
        time=time,
        mass_error=abs(now.mass + ledger.mass - start.mass) / start.mass,
        momentum_error=float(np.abs(missing * np.array(conserved_axes(geometry))).max()) / gauge,
        energy_drift=(energy - start_energy) / scale if scale else 0.0,
        kinetic=here.kinetic,
        internal=here.internal,
        outflow_mass=ledger.mass / start.mass,
        removed_energy=books.removed / scale if scale else 0.0,
        contact_energy=books.removed_by_contact / scale if scale else 0.0,
        outflow_energy=(ledger.kinetic + ledger.internal) / scale if scale else 0.0,
        hottest_energy_share=_hottest_share(particles, living, here.internal),
        largest_speed=_largest_speed(particles, living),
        exchanged=Exchanged(books.removed, books.removed_by_contact, float(impulse[impact_axis(geometry)]), worked),
        bodies=bodies,
        expanding_mass=ledger.expanding / start.mass,
        discarded_mass=ledger.discarded / start.mass,
    )


def body_balances(
    geometry: Geometry, here: tuple[Particles, np.ndarray], *away: tuple[Particles | Departed, np.ndarray], count: int
) -> tuple[BodyBalance, ...]:
    """The sums of each of ``count`` bodies over particles on the grid, and over those away from it.

    Each set of particles comes with the index (n,) of each one's body. Particles that departed have no mass among those
    on the grid any more.
    """
    axis = impact_axis(geometry)

    def sums(matter: Particles | Departed, body: np.ndarray) -> np.ndarray:
        weights = (
            0.5 * matter.mass * np.einsum("ij,ij->i", matter.velocity, matter.velocity),
            matter.mass * matter.energy,
            matter.mass * matter.velocity[:, axis],
        )
        return np.array([np.bincount(body, weights=weight, minlength=count) for weight in weights])

    gone = sum((sums(*matter) for matter in away), np.zeros((3, count)))
    return tuple(BodyBalance(*map(float, balance)) for balance in np.concatenate([sums(*here), gone]).T)


def left_behind(balances: tuple[BodyBalance, ...], before: tuple[BodyBalance, ...]) -> tuple[BodyBalance, ...]:
    """Balances with what each body left behind in the stages before among what departed."""
    return tuple(
        replace(
            now,
            departed_kinetic=now.departed_kinetic + then.departed_kinetic,
            departed_internal=now.departed_internal + then.departed_internal,
            departed_momentum=now.departed_momentum + then.departed_momentum,
        )
        for now, then in zip(balances, before, strict=True)
    )


def _largest_speed(particles: Particles, living: np.ndarray) -> float:
    squared = np.zeros(living.size)
    for axis in range(3):
        squared += particles.velocity[living, axis] ** 2
    return float(np.sqrt(squared.max(initial=0.0)))


def _hottest_share(particles: Particles, living: np.ndarray, internal: float) -> float:
    if internal <= 0.0:
        return 0.0
    hottest = living[np.argsort(particles.energy[living])[-math.ceil(HOTTEST_PART * living.size) :]]
    return float((particles.mass[hottest] * particles.energy[hottest]).sum()) / internal
