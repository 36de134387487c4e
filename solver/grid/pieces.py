"""Debris of a body of revolution as pieces in three dimensions: what has parted flies on as spheres of a size.

A body of revolution has rings in place of pieces, and its debris loads what it hits evenly. Here the matter that has
parted (``matter/tension/opening.py``) is cut into pieces along a curve of Hilbert through its places at rest, so that a
piece is made of neighbours. Its mass is drawn: exponential, with the mean of a cube of the size where the cut begins
(Grady and Kipp (1985), J. Appl. Phys. 58, 1210). A piece is a sphere of matter without pressure, at a random angle
about the axis, with the mass, the momentum along the flight and the energy of what it is made of: the motion of its
parts against each other becomes heat. Matter that has not parted, and pieces smaller than a particle of the next grid,
are particles at evenly drawn angles.

The next grid is a quarter. A piece that would cross a plane of symmetry stands on it, of which half is in the quarter
(on the axis a quarter), or beside it, whichever is nearer. The planes give debris the momentum across the flight that
the axis has not.
"""

import math
from dataclasses import replace
from typing import NamedTuple, TypeVar

import numpy as np

from solver import state
from solver.audit import BodyBalance, Books, Ledger, Totals
from solver.grid.flight import Flight
from solver.matter.eos import density_at_rest
from solver.matter.laws import Matter
from solver.problem import Problem
from solver.state import Arrivals

QUARTER = 0.5 * math.pi  # rad
BITS = 10  # of a place on the curve: a millionth of the square about a body
LIGHTEST = 0.5  # of the mass of a particle: no drawn piece is lighter


Booked = TypeVar("Booked", Books, Ledger, Totals, BodyBalance)


class Debris(NamedTuple):
    """The matter of one body that flies to a grid, k particles of a body of revolution."""

    time: np.ndarray  # (k,) at which each comes to the face of the grid, s
    table: np.ndarray  # (LONGEST, k) the state there
    size: np.ndarray  # (k,) of the pieces that it makes, m; infinite where it has not parted
    rest: np.ndarray  # (k, 2) place at rest: radius and along the flight, m


class Scattered(NamedTuple):
    """A flight whose debris comes as pieces, and what they are."""

    flight: Flight
    diameter: np.ndarray  # (p,) of the pieces, m


def radius_of(arrivals: Arrivals, share: float) -> float:
    """Radius (m) within which arrivals of a body of revolution bring a share of their momentum along the flight."""
    momentum, order = arrivals.table[state.MASS] * arrivals.table[state.VY], np.argsort(arrivals.table[state.X])
    if not order.size:
        return 0.0
    within = np.cumsum(momentum[order])
    return float(arrivals.table[state.X, order[np.searchsorted(within, share * within[-1])]])


def median(diameter: np.ndarray) -> float | None:
    """The diameter (m) than which half of the mass of spheres (p,) is in smaller ones; None without any.

    >>> median(np.array([1.0, 1.0, 2.0]))
    2.0
    """
    if not diameter.size:
        return None
    ordered = np.sort(diameter)
    volume = np.cumsum(ordered**3)
    return float(ordered[np.searchsorted(volume, 0.5 * volume[-1])])


def scatter(problem: Problem, flight: Flight, sizes: np.ndarray, *, spacing: float, seed: int) -> Scattered:
    """The flight of a body of revolution as one to a quarter of the same grid.

    ``problem`` is the stage that it leaves, ``sizes`` (k,) are of the pieces of each arrival (m, infinite for whole
    matter), ``spacing`` is the distance of particles in the next grid (m), and ``seed`` draws masses and angles. The
    books of the flight become those of the quarter.
    """
    random, arrivals = np.random.default_rng(seed), flight.arrivals
    rest = np.concatenate([body.position[:, :2] for body in problem.bodies])
    if flight.number.max(initial=-1) >= len(rest):  # of a stage before: what is together flies together
        rest, flight = arrivals.table[state.VX : state.VY + 1].T, flight._replace(number=np.arange(arrivals.time.size))
    parts, diameters = [], []
    for number, body in enumerate(problem.bodies):
        mine = np.flatnonzero(arrivals.body == number)
        own = Debris(arrivals.time[mine], arrivals.table[:, mine], sizes[mine], rest[flight.number[mine]])
        whole = ~np.isfinite(own.size)
        parts.append((number, *_rings(_some(own, whole), spacing, body.density, random)))
        pieces, diameter = _pieces(_some(own, ~whole), body.matter, body.density, spacing, random)
        parts.append((number, *pieces))
        diameters.append(diameter)
    of_body = np.concatenate([np.full(time.size, number) for number, time, _ in parts])
    time, table = np.concatenate([part[1] for part in parts]), np.concatenate([part[2] for part in parts], axis=1)
    order = np.argsort(time, kind="stable")
    table = np.ascontiguousarray(table[:, order])
    landed = flight._replace(
        arrivals=Arrivals(time[order], of_body[order], table),
        books=_of_quarter(flight.books, given=(table[state.VX : state.VY + 1] * table[state.MASS]).sum(axis=1)),
        missed=QUARTER * flight.missed,
    )
    return Scattered(landed, np.concatenate(diameters))


def _some(debris: Debris, among: np.ndarray) -> Debris:
    """Select some of the particles."""
    return Debris(debris.time[among], debris.table[:, among], debris.size[among], debris.rest[among])


def _of_quarter(books: Books, *, given: np.ndarray) -> Books:
    """Books per radian as those of a quarter, whose planes gave an impulse (2,) across the flight, N s."""
    sums = ("mass", "kinetic", "internal")
    start = _scaled(books.start, *sums, "momentum_scale")
    ledger = _scaled(books.ledger, *sums, "expanding", "discarded")
    return replace(
        _scaled(books, "removed", "removed_by_contact", "worked"),
        start=replace(start, momentum=_along(books.start.momentum)),
        ledger=replace(ledger, momentum=_along(books.ledger.momentum)),
        impulse=_along(books.impulse) + np.array([*given, 0.0]),
        left=tuple(_scaled(balance, *vars(balance)) for balance in books.left),
    )


def _scaled(record: Booked, *names: str) -> Booked:
    """A record with some of its sums per radian as those of a quarter."""
    return replace(record, **{name: QUARTER * getattr(record, name) for name in names})


def _along(momentum: np.ndarray) -> np.ndarray:
    """The momentum (3,) of a quarter whose flight is along the third axis, from that per radian, along the second."""
    return np.array([0.0, 0.0, QUARTER * momentum[1]])


def _rings(
    debris: Debris, spacing: float, density: float, random: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Particles of whole matter, as many of each ring as fill it: times (n,) and columns of a table (LONGEST, n)."""
    count = np.maximum(1, np.rint(QUARTER * debris.table[state.MASS] / (density * spacing**3))).astype(np.int64)
    which = np.repeat(np.arange(count.size), count)
    place = np.arange(which.size) - np.repeat(np.cumsum(count) - count, count)
    angle = QUARTER * (place + random.uniform(size=which.size)) / count[which]
    table = debris.table[:, which].copy()
    table[state.MASS] *= QUARTER / count[which]
    return debris.time[which], _turned(table, angle)


def _turned(table: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Columns (rows, n) of a body of revolution, whose second axis is the flight, turned about it by angles (n,)."""
    cos, sin, out = np.cos(angle), np.sin(angle), table.copy()
    radius, along, outward, forward = table[state.X], table[state.Y], table[state.VX], table[state.VY]
    out[state.X], out[state.Y], out[state.Z] = radius * cos, radius * sin, along
    out[state.VX], out[state.VY], out[state.VZ] = outward * cos, outward * sin, forward
    radial, axial, hoop, shear = table[state.S11], table[state.S22], table[state.S33], table[state.S12]
    out[state.S11] = cos**2 * radial + sin**2 * hoop
    out[state.S22] = sin**2 * radial + cos**2 * hoop
    out[state.S33], out[state.S12] = axial, cos * sin * (radial - hoop)
    out[state.S31], out[state.S23] = cos * shear, sin * shear
    return out


def _pieces(
    debris: Debris, matter: Matter, density: float, spacing: float, random: np.random.Generator
) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray]:
    """Particles of the pieces of parted matter, their times and columns; and the diameters (p,) of the pieces."""
    order = np.argsort(_along_curve(debris.rest), kind="stable")
    debris = _some(debris, order)
    mass = QUARTER * debris.table[state.MASS]
    end, least = np.cumsum(mass), LIGHTEST * density * spacing**3
    total, begin, first = float(mass.sum()), 0.0, 0
    times, tables, diameters = [], [], []
    while first < mass.size and total - begin > 1e-12 * total:
        drawn = max(random.exponential(density * debris.size[first] ** 3), least)
        radius, angle = 0.5 * math.cbrt(6.0 * drawn / (math.pi * density)), QUARTER * random.uniform()
        place, part = _beside_planes(debris.table[state.X, first], angle, radius if 2.0 * radius > spacing else 0.0)
        stop = min(begin + part * drawn, total)
        if total - stop < least:
            stop = total
        last = min(int(np.searchsorted(end, stop)), mass.size - 1)
        among = np.arange(first, last + 1)
        shares = np.minimum(end[among], stop) - np.maximum(end[among] - mass[among], begin)
        time, column = _merged(_some(debris, among), shares, angle, place, matter)
        radius = 0.5 * math.cbrt(6.0 * shares.sum() / part / (math.pi * density))
        grain_times, grains = _grains(time, column, place, radius, spacing)
        times.append(grain_times)
        tables.append(grains)
        diameters.append(2.0 * radius)
        begin, first = stop, last if end[last] > stop else last + 1
    if not times:
        return (np.zeros(0), np.zeros((state.LONGEST, 0))), np.zeros(0)
    return (np.concatenate(times), np.concatenate(tables, axis=1)), np.array(diameters)


class Place(NamedTuple):
    """Where the middle of a piece is, in the plane across the flight."""

    on: tuple[bool, bool]  # whether it stands on the planes x = 0 and y = 0
    beside: tuple[float, float]  # least distance from them, m


def _beside_planes(distance: float, angle: float, radius: float) -> tuple[Place, float]:
    """Where a piece (radius, m) at a distance (m) from the axis and an angle stands, and its part in the quarter."""
    on = [radius > 0.0 and distance * along < 0.5 * radius for along in (math.cos(angle), math.sin(angle))]
    return Place((on[0], on[1]), (0.0 if on[0] else radius, 0.0 if on[1] else radius)), 0.5 ** sum(on)


def _merged(debris: Debris, shares: np.ndarray, angle: float, place: Place, matter: Matter) -> tuple[float, np.ndarray]:
    """A piece of particles (k), of each of which it has a mass (k,): its time, and its column of a table.

    Its middle is that of all of them at any one time.
    """
    table, total = debris.table, shares.sum()
    outward, forward = (shares @ table[row] / total for row in (state.VX, state.VY))
    time = float(shares @ (table[state.VY] * debris.time) / (total * forward))
    distance = abs(shares @ (table[state.X] + table[state.VX] * (time - debris.time)) / total)
    energy = shares @ (table[state.ENERGY] + 0.5 * (table[state.VX] ** 2 + table[state.VY] ** 2)) / total
    column = np.zeros(state.LONGEST)
    for row, part, on, beside in zip((0, 1), (math.cos(angle), math.sin(angle)), place.on, place.beside, strict=True):
        column[state.X + row] = 0.0 if on else max(distance * part, beside)
        column[state.VX + row] = 0.0 if on else outward * part
    column[state.Z], column[state.VZ], column[state.MASS] = table[state.Y, 0], forward, total
    column[state.ENERGY] = energy - 0.5 * (column[state.VX : state.VZ + 1] ** 2).sum()
    column[state.DENSITY] = density_at_rest(matter.eos, column[state.ENERGY])
    column[state.STRAIN], column[state.KELVIN] = (shares @ table[row] / total for row in (state.STRAIN, state.KELVIN))
    for row in (state.PRESSURE, state.VISCOSITY, state.DAMAGE, state.PARTED, state.GROWN):
        column[row] = 0.0  # a piece is whole
    return time, column


def _grains(
    time: float, column: np.ndarray, place: Place, radius: float, spacing: float
) -> tuple[np.ndarray, np.ndarray]:
    """The particles of a spherical piece in the quarter: their times, and columns of a table (LONGEST, n)."""
    reach = math.ceil(radius / spacing)
    line = spacing * (np.arange(-reach, reach) + 0.5)
    offset = np.stack([axis.ravel() for axis in np.meshgrid(line, line, line, indexing="ij")])
    offset = offset[:, (offset**2).sum(axis=0) <= radius**2]
    if offset.shape[1] < 8:  # smaller than eight particles: it is one
        offset = np.zeros((3, 1))
    else:
        for row, on in enumerate(place.on):
            if on:
                offset = offset[:, offset[row] > 0.0]
    table = np.repeat(column[:, None], offset.shape[1], axis=1)
    table[state.MASS] /= offset.shape[1]
    # The last piece of a body takes what is left, and may be wider than it was drawn.
    table[state.X : state.Y + 1] = np.maximum(table[state.X : state.Y + 1] + offset[:2], 0.0)
    return time - offset[2] / column[state.VZ], table


def _along_curve(place: np.ndarray) -> np.ndarray:
    """The index (n,) of places (n, 2) along a curve of Hilbert that fills the square about them."""
    if not place.size:
        return np.zeros(0, np.int64)
    lower = place.min(axis=0)
    edge = float((place - lower).max()) or 1.0
    x, y = ((place - lower) / edge * (2**BITS - 1)).astype(np.int64).T
    index = np.zeros(x.size, np.int64)
    side = 2 ** (BITS - 1)
    while side:
        right, up = (x & side > 0).astype(np.int64), (y & side > 0).astype(np.int64)
        index += side * side * ((3 * right) ^ up)
        flips = (up == 0) & (right == 1)
        x, y = np.where(flips, side - 1 - x, x), np.where(flips, side - 1 - y, y)
        x, y = np.where(up == 0, y, x), np.where(up == 0, x, y)
        side //= 2
    return index
