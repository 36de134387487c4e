"""The frozen input of one simulation: bodies, grid, faces and numerics."""

import math
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from solver.errors import ProblemError
from solver.jit import Record
from solver.matter.eos import burns, pressure_terms, temperature_at
from solver.matter.laws import Matter
from solver.matter.tensor import Jaumann, Unturned
from solver.problem.geometry import Geometry
from solver.state import Arrivals, Particles
from solver.units import Dimensionless, JoulePerKilogram, KilogramPerCubicMetre, PerSecond, Second


class Face(IntEnum):
    """The action of a face of the grid on its nodes."""

    FREE = 0  # nothing; particles that pass it are booked in the outflow ledger
    FIXED = 1  # holds all components, within the problem's clamp
    SYMMETRIC = 2  # holds the normal component
    WALL = 3  # holds the normal component against approach only, and lets go


class Clamp(NamedTuple):
    """The box in which fixed faces hold; beyond it they are free."""

    lower: np.ndarray  # (3,) m
    upper: np.ndarray  # (3,) m

    def holds(self, position: np.ndarray, axis: int) -> np.ndarray:
        """Which places (n, 3) at a face across an axis lie within the box, by their place along the face."""
        along = np.arange(3) != axis
        place = position[:, along]
        inside: np.ndarray = ((place >= self.lower[along]) & (place <= self.upper[along])).all(axis=1)
        return inside


def clamp(*, lower: ArrayLike = -np.inf, upper: ArrayLike = np.inf) -> Clamp:
    """A clamp between two corners, one number or one for each axis; by default everywhere."""
    return Clamp(np.full(3, lower, np.float64), np.full(3, upper, np.float64))


class Scheme(IntEnum):
    """Which nodal velocity strains the particles, and when in the step: Ma (2005), section 2.2.4."""

    MUSL = 0  # mapped back from the moved particles, after them
    USF = 1  # mapped before the forces, which the new stress then gives
    USL = 2  # that of the grid's own momentum after the forces


class StepRule(IntEnum):
    """The signal whose path in a step the Courant number limits."""

    ACOUSTIC = 0  # through the matter; how far matter itself moves is limited apart, by ``travel``
    CONVECTIVE = 1  # through the grid, the particle's own speed on top


class Mesh(NamedTuple):
    """Hexahedra between the nodes of a body: ``solver/methods/fem``."""

    nodes: np.ndarray  # (e, 8) the body's particles: around the lower face from x to y, and those above them


@dataclass(frozen=True)
class Body:
    """A set of particles of one matter."""

    name: str
    matter: Matter
    position: np.ndarray  # (n, 3) m
    velocity: np.ndarray  # (3,) m/s, the same for all particles, or (n, 3)
    mass: np.ndarray  # (n,) kg (per radian in axisymmetry)
    density: KilogramPerCubicMetre  # initial
    spacing: tuple[float, float, float]  # of the initial lattice along each axis, m
    energy: JoulePerKilogram = 0.0  # initial specific internal energy
    # (n,) s, of an explosive alone: the time at which the detonation arrives.
    lighting: np.ndarray | None = None
    # With a mesh the particles are its nodes, and their masses those of ``fem.mesh.node_masses``.
    mesh: Mesh | None = None

    def fill(self, particles: Particles) -> None:
        """Write the initial state of the matter, in which particles are alike."""
        eos = self.matter.eos
        particles.density[:] = self.density
        particles.energy[:] = self.energy
        a, b = pressure_terms(eos, self.density, self.energy)
        particles.pressure[:] = a + b * self.energy
        particles.temperature[:] = temperature_at(eos, self.density, self.energy)


class ArtificialViscosity(NamedTuple):
    """q = rho h |D| (linear c + quadratic h |D|) where D = tr(velocity gradient) < 0, with the current sound speed c.

    von Neumann and Richtmyer (1950); Landshoff (1955). The constants are the defaults of MPM3D-F90 (commit
    367e024). ``heating`` 1 lets q do work on the internal energy; 0 is for the test which shows that the audit
    notices.
    """

    linear: float = 0.06
    quadratic: float = 1.5
    heating: float = 1.0


class Smoothing(NamedTuple):
    """The numerics of smoothed particles: ``solver/methods/sph``.

    The viscosity acts between pairs of particles, in place of that of the problem; with ``heating`` 1 its work heats.
    """

    ratio: Dimensionless = 1.3  # smoothing length over the particle spacing, (m / rho)^(1/d)
    corrected: bool = True  # gradients that are exact for linear fields
    viscosity: ArtificialViscosity = ArtificialViscosity(1.0, 2.0)
    tensile: Dimensionless = 0.0  # artificial stress, of the tension
    # Of contact between solids, of rho c^2 (``solver/methods/sph/contact.py``); with 0 bodies meet in the sums.
    stiffness: Dimensionless = 0.0


class Damping(NamedTuple):
    """The part of a velocity that its neighbours do not share decays at ``rate``; the energy it removes is accumulated.

    In a step of dt a particle gives up 1 - exp(-rate dt) of (1 - P)^order v, where P maps velocities to the nodes and
    back: order 1 is the particle-in-cell update, order 2 is XPIC (Hammerquist and Nairn 2017, Comput. Methods Appl.
    Mech. Eng. 318, 724). Defined per time, it does not depend on the step.
    """

    rate: PerSecond = 0.0
    order: int = 1


class Criterion(IntEnum):
    """The velocities by which bodies touch at a node, and whose approach the impulse ends: ``grid/contact.py``."""

    STEP = 0  # those after the step, where the bodies approach before its forces too
    MAPPED = 1  # those before the forces alone: Ma (2005), Eqs. 2-27 and 2-28
    GAP = 2  # those after the step, as far as they close the gap between the bodies


class Contact(NamedTuple):
    """Bodies with velocity fields of their own that meet on the nodes: Ma (2005), section 2.2.3."""

    friction: Dimensionless = 0.0  # Coulomb
    criterion: Criterion = Criterion.STEP


class Retirement(NamedTuple):
    """Debris leaves the particles once it is on a clear way out of the grid; see ``solver/grid/debris.py``."""

    body: int  # the target: what hangs together with most of this body is no debris
    after: Second
    # Largest mean of pressure over density in a piece that leaves: beyond, its pressure still drives it apart.
    expansion: JoulePerKilogram = math.inf


class Absorber(NamedTuple):
    """A flat part of a body's surface that lets waves out; see ``solver/grid/absorb.py``."""

    body: int  # its index
    axis: int  # across which the surface lies
    side: int  # of the body: 0 lower, 1 upper
    place: float  # m
    impedance: np.ndarray  # (3,) for each component of the velocity, Pa s/m


class Traction(NamedTuple):
    """A pressure on a flat part of a body's surface, as a table of time; see ``solver/grid/loads.py``."""

    body: int  # its index
    axis: int  # across which the surface lies
    side: int  # of the body: 0 lower, 1 upper
    time: np.ndarray  # (k,) s, ascending
    pressure: np.ndarray  # (k,) Pa, on the surface; linear in between, none outside the table


@dataclass(frozen=True)
class Problem:
    """Everything that decides the outcome of a simulation."""

    geometry: Geometry
    bodies: tuple[Body, ...]
    faces: tuple[tuple[Face, Face], ...]  # (lower, upper) for each axis
    end_time: Second
    shape: Record | None = None  # on the grid, of solver/grid/shapes; None: linear
    viscosity: ArtificialViscosity = field(default_factory=ArtificialViscosity)
    courant: Dimensionless = 0.4
    step_rule: StepRule = StepRule.CONVECTIVE
    travel: Dimensionless = 1.0  # largest part of a cell that a particle moves in a step
    fixed_dt: Second | None = None
    scheme: Scheme = Scheme.MUSL
    damping: Damping = field(default_factory=Damping)
    stress_rate: Jaumann | Unturned = field(default_factory=Jaumann)
    contact: Contact | None = None  # None: one velocity field for all bodies
    retirement: Retirement | None = None  # None: debris is followed to the edge of the grid
    clamp: Clamp = field(default_factory=clamp)
    absorbers: tuple[Absorber, ...] = ()  # away from fixed faces and walls
    tractions: tuple[Traction, ...] = ()  # likewise
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)  # on all matter, m/s2
    # None: particles meet on the grid. Else in sums over neighbours, without the shape, viscosity and step rule above.
    smoothing: Smoothing | None = None
    hourglass: Dimensionless = 0.05  # of bodies with a mesh: stiffness against hourglass modes (``fem.rates``)
    # A later stage: the time at which it begins, who flies to its grid, and the ``audit.Books`` of the stages before.
    start_time: Second = 0.0
    arrivals: Arrivals | None = None
    books: Any = None
    audits_heat: bool = False  # whether particles keep the work of shear, tension and viscosity (``state.SHEARED``)

    def __post_init__(self) -> None:
        empty = [body.name for body in self.bodies if not body.mass.size]
        if not self.bodies or (empty and self.arrivals is None) or len(empty) == len(self.bodies):
            raise ProblemError(f"bodies without particles: {empty or 'all'}; refine the grid")
        if self.arrivals is not None and (np.diff(self.arrivals.time) < 0.0).any():
            raise ProblemError("times of arrivals ascend; sort them")
        for body in self.bodies:
            if burns(body.matter.eos) != (body.lighting is not None):
                raise ProblemError(
                    f"body {body.name!r}: an explosive has times at which it is lit, and no other matter has them; "
                    "give lighting, or another equation of state"
                )
        if not 0.0 < self.courant <= 1.0:
            raise ProblemError(f"courant = {self.courant} lies outside (0, 1]")
        for load in self.tractions:
            if load.time.size < 2 or load.time.size != load.pressure.size:
                raise ProblemError(
                    f"a traction has {load.time.size} times and {load.pressure.size} pressures; give as many, and at "
                    "least two"
                )
            if not (np.diff(load.time) > 0.0).all() or not np.isfinite(load.pressure).all():
                raise ProblemError("times of a traction ascend and its pressures are finite; sort the table")
        if self.smoothing and not 1.0 <= self.smoothing.ratio <= 3.0:
            raise ProblemError(f"smoothing ratio = {self.smoothing.ratio} lies outside [1, 3]")
        if not 0.0 < self.travel <= 1.0:
            raise ProblemError(f"travel = {self.travel} lies outside (0, 1]")
        if not self.end_time > self.start_time:
            begin = f"after the start, {self.start_time} s" if self.start_time else "positive"
            raise ProblemError(f"end_time = {self.end_time} s is not {begin}")
        if self.retirement and any(
            Face.WALL in pair or pair == (Face.SYMMETRIC, Face.SYMMETRIC) for pair in self.faces
        ):
            raise ProblemError(
                "debris may come back from walls and between two planes of symmetry; follow it, without retirement"
            )

    @property
    def particle_count(self) -> int:
        """Particles of all bodies, those that are still to arrive included."""
        coming = 0 if self.arrivals is None else self.arrivals.time.size
        return sum(body.mass.size for body in self.bodies) + coming


def mean_pressure(load: Traction, begin: float, end: float) -> float:
    """Mean pressure of a traction between two times (s), Pa: linear between the times of its table, none outside.

    >>> ramp = Traction(0, 0, 1, np.array([1.0, 2.0, 4.0]), np.array([0.0, 6.0, 6.0]))
    >>> [mean_pressure(ramp, *times) for times in ((0.0, 1.0), (1.0, 2.0), (0.0, 4.0), (3.0, 5.0), (4.0, 9.0))]
    [0.0, 3.0, 3.75, 3.0, 0.0]
    """
    inside = load.time[(load.time > begin) & (load.time < end)]
    times = np.clip([begin, *inside, end], load.time[0], load.time[-1])
    pressure = np.interp(times, load.time, load.pressure)
    return float(np.trapezoid(pressure, times)) / (end - begin)
