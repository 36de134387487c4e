"""A pressed bar, half elements and half smoothed particles, against the same bar of elements alone.

Zhang, Qiang and Gao (2011), section 3.1: 5 by 5 by 100 mm, elastic, 40 GPa on the end of the elements for 1 us.
Particles stand at the nodes of the mesh that would go on, with the masses of these nodes.

Their numbers place what they plot: nodes 909, 910, 1215 and 1216 of lattices of 6 by 51 by 6, and particles 750, 800,
1050 and 1100 of columns of 50, are the four about the axis one layer of 1 mm before and behind the interface.

40 GPa strain the bar by a fifth. The same bar with a thousandth of the load, told in shares of it, is the theory of
small strains. There the peaks come when the published ones do, 0.8 us later than with large strains, and are 5 to 8 %
lower than they. The published velocities are too low for the published stresses, by two relations: a pulse that has
passed leaves the displacement of its impulse over rho c0, whatever its dispersion; and a plane wave of uniaxial strain,
the stiffest that goes one way, has rho c_L.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from solver.methods.fem.mesh import lattice, node_masses
from solver.problem import Body, Face, Problem, Traction
from solver.problem.geometry import Cartesian3D, grid
from solver.simulation import Outcome, simulate
from solver.state import Snapshot
from studies.quantities.numerical_defaults import Recipe
from tests.cases.verification import case
from tests.cases.verification.setups.matter import elastic
from tests.cases.verification.setups.methods import SPH
from tests.cases.verification.solutions.waves import Isotropic
from tests.claims.rows import Row, at_most, relative, reported

SIDE, LENGTH, END_TIME = 5e-3, 0.1, 14e-6  # m, m, s
MATTER = Isotropic(7830.0, 207e9, 0.3)
PRESSURE, PULSE = 40e9, 1e-6  # Pa, s
CELLS = (5, 10)  # across the bar; the first is the published spacing
# s for a spacing of 1 mm, the same in both bars: velocities live half a step before the time of a snapshot, and with
# steps of their own, read 35 ns apart, the bars differed by 5.02 % and 2.07 %.
STEP = 2e-8
ROOM = 3e-3  # beside the bar, m
SMALL = 1e-3  # of the load: strains of 2e-4
LOADS = {"40 GPa": 1.0, "small strains": SMALL}
INTERFACE = 0.05  # m from the unloaded end
# m: where the published node and particle stand. Their peaks: time (s), velocity (m/s) and stress (Pa).
PUBLISHED = {0.051: (10.5e-6, -582.0, -27.3e9), 0.049: (11e-6, -539.0, -27.9e9)}
PLACES = (INTERFACE, *PUBLISHED)
# m: between this place and the loaded end what the interface reflects comes back before the end.
SECTION = 0.06
INTERVAL = 4e-8  # s

# Asked beforehand, at the interface with the published load and spacing: of the peaks of the bar of elements alone, for
# peaks and root mean squares. Largest differences were known to miss it.
AT_INTERFACE, REFLECTED, SYMMETRY = 0.05, 0.02, 1e-9
# Of the published peak stresses and times. It was asked of both with small strains, where the stresses miss it by 0.4
# and 3.2 %; with the published load it was known that stresses hold, and times and velocities miss it.
OFF_PUBLISHED = 0.05
IMPEDANCE = MATTER.density * MATTER.bar_speed  # rho c0, Pa s/m
PASSED = 0.05  # of it: what trails behind the pulse passes after the end


@dataclass(frozen=True)
class BarHistory:
    """Histories about the axis at some places, and of a section of elements; shares of the load are scaled to it."""

    time: np.ndarray  # (t,) s
    velocity: np.ndarray  # (t, places) along the bar, m/s
    stress: np.ndarray  # (t, places) along the bar, Pa
    section: np.ndarray  # (t,) mean velocity along the bar, m/s
    asymmetry: float  # largest difference between points about the axis, m/s
    outcome: Outcome


def bar(cells: int, *, coupled: bool, share: float = 1.0) -> Problem:
    """The bar along the third axis, loaded at its upper end; coupled, its lower half is particles.

    It stands about the axis; an even number of cells has nodes on the axis, and is a quarter.
    """
    spacing = SIDE / cells
    quarter = cells % 2 == 0
    lower = 0.0 if quarter else -0.5 * SIDE
    across = np.linspace(lower, 0.5 * SIDE, (cells // 2 if quarter else cells) + 1)
    middle = round(0.5 * LENGTH / spacing)
    along = np.linspace(0.0, LENGTH, 2 * middle + 1)
    upper = _meshed("elements", across, along[middle:] if coupled else along)
    bodies = [upper]
    if coupled:
        bodies.append(replace(_meshed("particles", across, along[: middle + 1]), mesh=None))
    room = math.ceil(ROOM / spacing)
    before = 0 if quarter else room
    geometry = grid(
        Cartesian3D,
        lower=(lower - before * spacing,) * 2 + (-4.0 * room * spacing,),
        cells=(across.size - 1 + before + room,) * 2 + (2 * middle + 5 * room,),
        spacing=spacing,
    )
    load = Traction(0, 2, 1, np.array([0.0, PULSE]), np.full(2, share * PRESSURE))
    free = (Face.FREE, Face.FREE)
    side = (Face.SYMMETRIC, Face.FREE) if quarter else free
    return Problem(
        geometry=geometry,
        bodies=tuple(bodies),
        faces=(side, side, free),
        end_time=END_TIME,
        fixed_dt=STEP * spacing / 1e-3,
        tractions=(load,),
        smoothing=SPH if coupled else None,
    )


def _meshed(name: str, across: np.ndarray, along: np.ndarray) -> Body:
    position, mesh = lattice(across, across, along)
    return Body(
        name=name,
        matter=elastic(MATTER),
        position=position,
        velocity=np.zeros(3),
        mass=node_masses(mesh, position, MATTER.density),
        density=MATTER.density,
        spacing=(float(across[1] - across[0]),) * 3,
        mesh=mesh,
    )


def read(problem: Problem, share: float = 1.0) -> BarHistory:
    """Run a bar and watch its axis: the particles there, or the nodes where there are none."""
    place = np.concatenate([body.position for body in problem.bodies])
    spacing = problem.geometry.spacing
    about = np.abs(place[:, :2]).max(axis=1) < 0.7 * spacing
    points = [np.flatnonzero(about & (np.abs(place[:, 2] - z) < 0.1 * spacing)) for z in PLACES]
    # At the interface the particles, which come last, stand on as many nodes.
    axis = min(found.size for found in points)
    points = [found[-axis:] for found in points]
    section = np.flatnonzero(np.abs(place[:, 2] - SECTION) < 0.1 * spacing)
    rows, asymmetry = [], 0.0

    def watch(snapshot: Snapshot) -> None:
        nonlocal asymmetry
        p = snapshot.particles
        column = np.argsort(p.number)
        own, across = column[np.array(points)], column[section]
        velocity, stress = p.velocity[own, 2], p.deviator[own, 2] - p.pressure[own]
        asymmetry = max(asymmetry, float(np.ptp(velocity, axis=1).max()))
        mean = float(np.average(p.velocity[across, 2], weights=p.mass[across]))
        rows.append((snapshot.time, velocity.mean(axis=1), stress.mean(axis=1), mean))

    outcome = simulate(problem, watch, interval=INTERVAL)
    time, velocity, stress, mean = (np.array(values) for values in zip(*rows, strict=True))
    return BarHistory(time, velocity / share, stress / share, mean / share, asymmetry / share, outcome)


@case(
    "coupled-bar",
    says="at the interface of a bar of elements and smoothed particles peaks of velocity and stress, and in the root "
    "mean square whole histories, are those of elements alone within 5 % of the peak, and at most 2 % comes back; the "
    "published peak stresses hold within 5 %, their times with small strains, and the published velocities are missed",
    source="Zhang, Qiang and Gao (2011), section 3.1: the coupled algorithm, its bar and the peaks of its figure 4",
)
def _run(recipe: Recipe) -> Iterator[Row]:
    for cells in CELLS:
        for load, share in LOADS.items():
            where = f"coupled bar, {SIDE / cells * 1e3:g} mm, {load}"
            coupled, alone = (read(bar(cells, coupled=coupled, share=share), share) for coupled in (True, False))
            asked = cells == CELLS[0] and share == 1.0
            for z in PLACES:
                yield from _apart(where, z, coupled, alone, asked=asked and z == INTERFACE)
            yield _judged(_reflection(where, coupled, alone), REFLECTED, asked=asked)
            for z in PUBLISHED:
                yield from _beside_published(where, z, coupled, alone, asked=(cells == CELLS[0], share == SMALL))
            yield from _impedances(where, coupled, alone, asked=share == SMALL)
            if cells == CELLS[0]:  # four points about the axis
                yield at_most(
                    f"{where}: difference between symmetric particles (of the peak velocity)",
                    limit=SYMMETRY,
                    got=coupled.asymmetry / np.abs(alone.velocity).max(),
                )
            yield reported(f"{where}: drift of the energy", coupled.outcome.audit.energy_drift)
            yield reported(f"{where}: error of the momentum", coupled.outcome.audit.momentum_error)


def _judged(row: Row, limit: float, *, asked: bool) -> Row:
    return row if asked else row.ungated(limit)


def _peak(time: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Time and value of the largest of a history."""
    at = int(np.abs(values).argmax())
    return float(time[at]), float(values[at])


def _apart(where: str, z: float, coupled: BarHistory, alone: BarHistory, *, asked: bool) -> Iterator[Row]:
    """Peaks and whole histories of both bars at a place, from the time on at which the fastest wave is there."""
    at = PLACES.index(z)
    there = alone.time >= (LENGTH - z) / MATTER.longitudinal_speed
    for name, unit, size in (("velocity", "m/s", 1.0), ("stress", "GPa", 1e9)):
        ours, theirs = (getattr(bar, name)[:, at] / size for bar in (coupled, alone))
        (_, peak), (_, expected) = _peak(coupled.time, ours), _peak(alone.time, theirs)
        off = np.abs(np.interp(alone.time, coupled.time, ours) - theirs)[there] / abs(expected)
        quantity = f"{where}, {z * 1e3:g} mm: {name}"
        parts = (
            (f"peak, {peak:.4g} {unit}", abs(peak - expected) / abs(expected), asked),
            ("history, root mean square", float(np.sqrt((off**2).mean())), asked),
            ("history, largest difference", float(off.max()), False),
        )
        for part, got, gated in parts:
            claim = f"{quantity}: {part}, off elements alone (of their peak)"
            row = at_most(claim, limit=AT_INTERFACE, got=got)
            row = replace(row, others={"peak of elements alone": expected})
            yield _judged(row, AT_INTERFACE, asked=gated)


def _reflection(where: str, coupled: BarHistory, alone: BarHistory) -> Row:
    back = np.interp(alone.time, coupled.time, coupled.section) - alone.section
    return at_most(
        f"{where}: velocity that comes back from the interface at {SECTION * 1e3:g} mm (of the peak there)",
        limit=REFLECTED,
        got=float(np.abs(back).max() / np.abs(alone.section).max()),
    )


def _beside_published(
    where: str, z: float, coupled: BarHistory, alone: BarHistory, *, asked: tuple[bool, bool]
) -> Iterator[Row]:
    """The published peaks at a place, and when they come; ``asked`` is whether spacing and strains are those asked."""
    spacing, small = asked
    when, velocity, stress = PUBLISHED[z]
    at = PLACES.index(z)
    for name, bar in (("elements alone", alone), ("coupled", coupled)):
        (_, fastest), (time, highest) = (_peak(bar.time, values[:, at]) for values in (bar.velocity, bar.stress))
        for quantity, expected, got, size, holds in (
            ("peak stress (GPa)", stress, highest, 1e9, spacing and not small),
            ("time of the peak stress (us)", when, time, 1e-6, spacing and small),
            ("peak velocity (m/s)", velocity, fastest, 1.0, False),
        ):
            row = relative(
                f"{where}, {z * 1e3:g} mm, {name}, published {quantity}",
                expected=expected / size,
                got=got / size,
                within=OFF_PUBLISHED,
            )
            yield _judged(row, OFF_PUBLISHED, asked=holds and bar is alone)


def _impedances(where: str, coupled: BarHistory, alone: BarHistory, *, asked: bool) -> Iterator[Row]:
    """Stress over velocity: of the whole pulse at the interface, and of the peaks."""
    at = PLACES.index(INTERFACE)
    for name, bar in (("elements alone", alone), ("coupled", coupled)):
        impulse, displacement = (np.trapezoid(values[:, at], bar.time) for values in (bar.stress, bar.velocity))
        row = relative(
            f"{where}, {INTERFACE * 1e3:g} mm, {name}: impulse over displacement (of rho c0)",
            expected=1.0,
            got=float(impulse / displacement) / IMPEDANCE,
            within=PASSED,
        )
        yield _judged(row, PASSED, asked=asked and bar is alone)
    bound = MATTER.longitudinal_speed / MATTER.bar_speed
    for z, (_, velocity, stress) in PUBLISHED.items():
        at = PLACES.index(z)
        (_, fastest), (_, highest) = (_peak(alone.time, values[:, at]) for values in (alone.velocity, alone.stress))
        row = reported(
            f"{where}, {z * 1e3:g} mm, elements alone: peak stress over peak velocity (of rho c0)",
            highest / fastest / IMPEDANCE,
        )
        others = {"published": stress / velocity / IMPEDANCE, "plane wave": bound}
        yield replace(row, others=others)


CASE = _run
