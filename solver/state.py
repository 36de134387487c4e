"""The particles of a simulation, and the picture of them that leaves the solver. Allocation only.

Kernels see a table. In it each number has a row, so that eight neighbours are one vector; ``Particles`` are views of
its rows. Tables of nodes, neighbours and gradients have a line of eight numbers instead, 64 bytes, which is what the
memory moves at a time.
"""

import mmap
from typing import NamedTuple

import numpy as np

LINE = 8  # numbers of a line

# Rows of the table of particles.
X, Y, Z, VX, VY, VZ, MASS, DENSITY, ENERGY, PRESSURE, VISCOSITY = range(11)
S11, S22, S33, S12, S23, S31, STRAIN, KELVIN, DAMAGE, PARTED, GROWN = range(11, 22)
NEW_X, NEW_Y, NEW_Z = range(22, 25)  # positions at n+1 while those at n are still needed
ROWS = 25
# Behind those of all matter. Of explosives: the time at which the detonation arrives.
LIGHTING = ROWS
# Of matter whose damage weakens it, or whose plastic work is not all heat: ``PointState`` says what they are.
HARDENED, STORED = ROWS + 1, ROWS + 2
# Where an audit asks what heated matter: work of shear, of tension and of viscosity since the start, J/kg.
SHEARED, PULLED, DAMPED = ROWS + 3, ROWS + 4, ROWS + 5
LONGEST = ROWS + 6  # rows of a table that has all of them


class Particles(NamedTuple):
    """Material points, n of them, sorted body by body. In axisymmetry mass is per radian."""

    position: np.ndarray  # (n, 3) m
    velocity: np.ndarray  # (n, 3) m/s
    mass: np.ndarray  # (n,) kg
    density: np.ndarray  # (n,) kg/m3
    energy: np.ndarray  # (n,) specific internal energy at the time level of the velocity, J/kg
    pressure: np.ndarray  # (n,) Pa, of the equation of state after the tensile floor
    viscosity: np.ndarray  # (n,) Pa, artificial, not negative
    deviator: np.ndarray  # (n, 6) Pa, components 11 22 33 12 23 31
    plastic_strain: np.ndarray  # (n,)
    temperature: np.ndarray  # (n,) K
    damage: np.ndarray  # (n,) 0 whole .. 1 failed
    parted: np.ndarray  # (n,) 1/s, rate of growth of volume, or of shear, with which voids linked; 0 while closed
    grown: np.ndarray  # (n,) logarithm of the factor by which plastic flow has made voids grow
    number: np.ndarray  # (n,) permanent, int64
    alive: np.ndarray  # (n,) 1 on the grid, 0 once it has left, uint8


class Departed(NamedTuple):
    """Particles that left the grid or were retired (``debris.py``), k of them, each with all of its state then.

    Each has flown straight since. A particle departs once, so that a run has at most as many records as particles.
    """

    number: np.ndarray  # (k,) permanent, int64
    body: np.ndarray  # (k,) index of its body
    time: np.ndarray  # (k,) of departure, s
    position: np.ndarray  # (k, 3) m
    velocity: np.ndarray  # (k, 3) m/s
    mass: np.ndarray  # (k,) kg (per radian in axisymmetry)
    density: np.ndarray  # (k,) kg/m3
    energy: np.ndarray  # (k,) specific internal energy, J/kg
    pressure: np.ndarray  # (k,) Pa
    viscosity: np.ndarray  # (k,) Pa
    deviator: np.ndarray  # (k, 6) Pa
    plastic_strain: np.ndarray  # (k,)
    temperature: np.ndarray  # (k,) K
    damage: np.ndarray  # (k,) 0 whole .. 1 failed
    parted: np.ndarray  # (k,) 1/s, as of ``Particles``
    grown: np.ndarray  # (k,) as of ``Particles``
    remembered: np.ndarray  # (k, 5) rows HARDENED to DAMPED of the table; 0 where matter does not remember


class Arrivals(NamedTuple):
    """Particles, k of them, that fly straight and join the grid at a time of their own; ascending in that time."""

    time: np.ndarray  # (k,) s
    body: np.ndarray  # (k,) index of its body
    table: np.ndarray  # (LONGEST, k) the state at that time, in the rows of a table


def empty_table(count, *, burns=False, remembers=False):
    """A table (ROWS, n) of particles at rest, without stress; a row takes no memory until it is written.

    With an explosive among the bodies it has the row ``LIGHTING`` too, with matter that remembers those behind it.
    """
    return np.zeros((LONGEST if remembers else ROWS + burns, count))


def views(table, number=None, alive=None):
    """The particles whose numbers are the columns of a table (ROWS, n); by default alive, numbered in their order."""
    count = table.shape[1]
    if number is None:
        number = np.arange(count, dtype=np.int64)
    if alive is None:
        alive = np.ones(count, np.uint8)
    return Particles(
        position=table[X : Z + 1].T,
        velocity=table[VX : VZ + 1].T,
        mass=table[MASS],
        density=table[DENSITY],
        energy=table[ENERGY],
        pressure=table[PRESSURE],
        viscosity=table[VISCOSITY],
        deviator=table[S11 : S31 + 1].T,
        plastic_strain=table[STRAIN],
        temperature=table[KELVIN],
        damage=table[DAMAGE],
        parted=table[PARTED],
        grown=table[GROWN],
        number=number,
        alive=alive,
    )


def reordered(table, order):
    """Columns of a table in the order of their indices, in the table's own memory: (ROWS, n), n at most as before."""
    memory, count = table.reshape(-1), order.size
    rows = table.shape[0]
    for row in range(rows):  # rows that are still to be read stand behind what is written
        memory[row * count : (row + 1) * count] = table[row, order]
    return memory[: rows * count].reshape(rows, count)


def lines(count, *, sparse=False):
    """A table (count, 8) of zeros with each line in one cache line; a page takes memory once it is written.

    numpy asks for huge pages. In a ``sparse`` table, most of which is never written, those hold three times the memory.
    """
    size = count * LINE * np.dtype(np.float64).itemsize
    if sparse and size:
        return np.frombuffer(mmap.mmap(-1, size)).reshape(count, LINE)  # begins with a page
    memory = np.zeros(count * LINE + LINE)
    skipped = -memory.ctypes.data % (LINE * memory.itemsize) // memory.itemsize
    return memory[skipped : skipped + count * LINE].reshape(count, LINE)


def records(time, particles, body, index, remembered=None):
    """The records of particles (indices) that depart at a time (s); ``remembered`` (5, n) where matter remembers."""
    last = {name: getattr(particles, name)[index] for name in Particles._fields if name in Departed._fields}
    kept = np.zeros((len(index), LONGEST - HARDENED)) if remembered is None else remembered[:, index].T
    return Departed(body=body[index], time=np.full(len(index), time), remembered=kept, **last)


def remembered_in(table):
    """The rows HARDENED to DAMPED of a table (5, n), None where its matter does not remember."""
    return table[HARDENED:] if table.shape[0] > HARDENED else None


def columns(departed):
    """The records of departures as columns of a table (LONGEST, k), each as it was when it departed."""
    table = empty_table(departed.number.size, remembers=True)
    particles = views(table)
    for name in Particles._fields:
        if name not in ("number", "alive"):
            getattr(particles, name)[:] = getattr(departed, name)
    table[HARDENED:] = departed.remembered.T
    return table


def joined(parts):
    """The records of several departures, in their order."""
    return Departed(*map(np.concatenate, zip(*parts, strict=True)))


NONE_DEPARTED = records(0.0, views(empty_table(0)), np.zeros(0, np.int64), np.zeros(0, np.int64))


class Snapshot(NamedTuple):
    """A state at rest on one time level, for observers and files; arrays are views, copy to keep."""

    time: float  # s
    step: int
    particles: Particles
    body: np.ndarray  # (n,) index of each particle's body
    departed: Departed = NONE_DEPARTED
    waiting: float = 0.0  # mass that is still to join, kg (per radian in axisymmetry)
    remembered: np.ndarray | None = None  # (5, n) as in ``Departed``
