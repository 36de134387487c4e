"""A bar: its shape, where its energy has gone, the wave in its middle, its rear face, and the push of its wall.

The view has its particles by their place in the initial lattice.

An edge is that of a particle: the centre of the outermost particle of a lattice row, and half of the particle's own
width beyond. The width is that of the moment, stretched with the body: the distance to the neighbour in the row. An
undeformed bar then has exactly its length and diameter, and a uniformly stretched one exactly what it was stretched
to. In three dimensions the rows along x and along y beside the symmetry planes are taken, which end on the bar's own
radius; a slanted row of a lattice cylinder ends on a step.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from studies.bars.setting import BarSetting, References
from studies.measurements import RESOLUTION_IN_CELLS, History, Measurement, NoValue, OnGrid, Reading, measurement
from studies.quantities.measured import LOST_PARTICLES

if TYPE_CHECKING:
    from solver.problem import Body
    from solver.state import Particles, Snapshot

TWICE_THE_SHEAR = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])  # six components in a double contraction


@dataclass(frozen=True)
class BarView(OnGrid):
    """A bar: particles, with what the set-up says of it. Heights are distances from the wall."""

    place: np.ndarray  # (n, 3) in the initial lattice: across, across, along; from 0
    position: np.ndarray  # (n, 3) x, y, height; in axisymmetry r, 0, height; m
    velocity: np.ndarray  # (n, 3) in the same order, m/s
    mass: np.ndarray  # (n,) kg, per radian in axisymmetry
    strain_energy: np.ndarray  # (n,) elastic, J/kg
    stress: np.ndarray  # (n,) along the bar, without artificial viscosity, Pa
    height: np.ndarray  # (n,) initial, m
    width: float  # of a particle across, initially, m
    cell: float  # m
    length: float  # initial, m
    speed: float  # initial, towards the wall, m/s
    is_loaded: bool  # whether more than the wall acts on it
    references: References

    @property
    def share(self) -> float:
        """Standard uncertainty of a share of the whole bar that one run cannot see: one cell of its length."""
        return RESOLUTION_IN_CELLS * self.cell / self.length


def view(setting: BarSetting, snapshot: "Snapshot") -> BarView:
    """The view of a snapshot."""
    from solver.problem.geometry import impact_axis

    particles = snapshot.particles
    living = np.flatnonzero(particles.alive)
    bodies, body = setting.problem.bodies, setting.problem.bodies[0]
    axis = impact_axis(setting.problem.geometry)
    return BarView(
        place=setting.place[particles.number[living]],
        position=_ordered(particles.position[living], axis),
        velocity=_ordered(particles.velocity[living], axis),
        mass=particles.mass[living],
        strain_energy=_strain_energy(body, particles, living),
        stress=particles.deviator[living, axis] - particles.pressure[living],
        height=np.concatenate([part.position[:, axis] for part in bodies])[particles.number[living]],
        width=body.spacing[0],
        cell=setting.problem.geometry.spacing,
        length=setting.length,
        speed=setting.speed,
        is_loaded=bool(setting.problem.tractions) or any(setting.problem.gravity),
        references=setting.references,
    )


def _ordered(vectors: np.ndarray, axis: int) -> np.ndarray:
    """Components across, across, along the bar; a body of revolution has no swirl."""
    if axis == 2:
        return vectors
    return np.stack([vectors[:, 0], np.zeros(len(vectors)), vectors[:, 1]], axis=1)


def _strain_energy(body: "Body", particles: "Particles", living: np.ndarray) -> np.ndarray:
    """Energy of elastic strain, J/kg: that of p = K (rho / rho0 - 1) in the volume, s : s / 4 G in the shape."""
    from solver.matter.eos import reference_sound_speed

    ratio = particles.density[living] / body.density
    volume = reference_sound_speed(body.matter.eos) ** 2 * (np.log(ratio) - 1.0 + 1.0 / ratio)
    deviator = particles.deviator[living]
    squares = (deviator**2 * TWICE_THE_SHEAR).sum(axis=1)
    shear = body.matter.shear_modulus
    shape = squares / (4.0 * shear * particles.density[living]) if shear else np.zeros_like(volume)
    return volume + shape


# ---- edges ---------------------------------------------------------------------------------------


def side_edges(view: BarView) -> tuple[np.ndarray, np.ndarray]:
    """Height and radius (m) of the bar's side, layer by layer from the impact face: mean over the rows across.

    NaN for a layer whose rows have lost particles.
    """
    directions = [0, 1] if view.place[:, 1].any() else [0]
    ends = np.stack([_row_ends(view, direction) for direction in directions])
    heights: np.ndarray = ends[:, :, 2].mean(axis=0)
    radii = np.stack([end[:, direction] for direction, end in zip(directions, ends, strict=True)])
    return heights, radii.mean(axis=0)


def end_edges(view: BarView) -> tuple[float, float]:
    """Height of the impact face and of the rear (m): the lowest and the highest end of the columns along the bar.

    NaN where the bar has lost particles.
    """
    column = np.unique(view.place[:, :2], axis=0, return_inverse=True)[1].ravel()
    height = np.full((column.max() + 1, view.place[:, 2].max() + 1), math.nan)
    height[column, view.place[:, 2]] = view.position[:, 2]
    if height.shape[1] < 2:
        return math.nan, math.nan
    foot = height[:, 0] - 0.5 * (height[:, 1] - height[:, 0])
    rear = height[:, -1] + 0.5 * (height[:, -1] - height[:, -2])
    return float(np.min(foot)), float(np.max(rear))


def _row_ends(view: BarView, direction: int) -> np.ndarray:
    """Where the row along ``direction`` beside the axis ends in each layer, (layers, 3) m."""
    row = view.place[:, 1 - direction] == 0
    layer, step = view.place[row, 2], view.place[row, direction]
    points = np.full((view.place[:, 2].max() + 1, step.max() + 1, 3), math.nan)
    points[layer, step] = view.position[row]
    last = points[:, -1]
    if points.shape[1] > 1:
        return last + 0.5 * (last - points[:, -2])
    alone = last.copy()
    alone[:, direction] += 0.5 * view.width
    return alone


LOADED = "loaded"  # has no value of what is measured against the initial motion of a bar on which its wall alone acts

# ---- shape ---------------------------------------------------------------------------------------


@measurement(
    title="Length of the bar",
    unit="m",
    meaning="distance between the lowest and the highest particle edge along the bar; an edge is the centre of the "
    "outermost particle and half of its present distance to the next one in its row",
    version=2,
)
def final_length(view: BarView) -> Reading:
    foot, rear = end_edges(view)
    if math.isnan(rear - foot):
        raise NoValue(LOST_PARTICLES)
    return Reading(rear - foot, {"resolution": view.resolution})


@measurement(
    title="Mushroom diameter",
    unit="m",
    meaning="diameter of the widest layer between particle edges; an edge is the centre of the outermost particle and "
    "half of its present distance to the next one in its row",
    version=2,
)
def mushroom_diameter(view: BarView) -> Reading:
    _, radii = side_edges(view)
    if np.isnan(radii).any():
        raise NoValue(LOST_PARTICLES)
    return Reading(2.0 * float(radii.max()), {"resolution": view.resolution})


HEIGHT = 0.2  # of the initial length: Ma (2005), section 2.3.2


@measurement(
    title="Width at a fifth of the length",
    unit="m",
    meaning="diameter between particle edges at 0.2 of the initial length above the impact face",
)
def width_at_fifth(view: BarView) -> Reading:
    """Diameter between the layers beside that height: W of a Taylor bar, Ma (2005), figure 2.3."""
    heights, radii = side_edges(view)
    level = end_edges(view)[0] + HEIGHT * view.length
    if np.isnan(radii).any() or math.isnan(level):
        raise NoValue(LOST_PARTICLES)
    below = np.flatnonzero(heights < level)
    if not below.size or below[-1] + 1 == heights.size:
        raise NoValue("too_short")
    first = int(below[-1])  # from the rear down: a lip beside the foot may curl
    share = (level - heights[first]) / (heights[first + 1] - heights[first])
    radius = radii[first] + share * (radii[first + 1] - radii[first])
    return Reading(2.0 * float(radius), {"resolution": view.resolution})


@measurement(
    title="Mean error of the Taylor bar",
    unit="1",
    meaning="mean of the relative errors of length, mushroom diameter and width at a fifth of the length, against the "
    "references of the run",
)
def taylor_error(view: BarView) -> Reading:
    """(|dL| / L + |dD| / D + |dW| / W) / 3, relative to the reference: that of Johnson, Ma (2005), Eq. 2-42."""
    readings = [measured.read(view) for measured in (final_length, mushroom_diameter, width_at_fifth)]
    flags = tuple(sorted({flag for reading in readings for flag in reading.flags}))
    errors, uncertainties = [], []
    for reading, reference in zip(readings, view.references, strict=True):
        if reference is None:
            raise NoValue("no_reference")
        errors.append(abs(reading.value - reference) / reference)
        uncertainties.append(reading.parts.get("resolution", 0.0) / reference)
    if flags:
        raise NoValue(*flags)
    return Reading(sum(errors) / 3.0, {"resolution": math.hypot(*uncertainties) / 3.0})


# ---- energy --------------------------------------------------------------------------------------


def _energies(view: BarView) -> tuple[float, float, float]:
    """Shares of the initial energy: rigid motion along the axis, motion of parts against the whole, elastic strain.

    Kinetic energy is split at the axial velocity of the centre of mass.
    """
    mass = float(view.mass.sum())
    initial = 0.5 * mass * view.speed**2
    kinetic = 0.5 * float((view.mass * (view.velocity**2).sum(axis=1)).sum())
    rigid = 0.5 * float((view.mass * view.velocity[:, 2]).sum()) ** 2 / mass
    strain = float((view.mass * view.strain_energy).sum())
    return rigid / initial, (kinetic - rigid) / initial, strain / initial


def _share(name: str, title: str, meaning: str, of: Callable[[float, float, float], float]) -> Measurement:
    def read(view: BarView) -> Reading:
        if view.is_loaded:
            raise NoValue(LOADED)
        return Reading(of(*_energies(view)), {"resolution": view.share})

    return Measurement(name=name, title=title, unit="1", meaning=meaning, definition=read)


ENERGIES = (
    _share(
        "rigid_energy",
        "Energy of rigid motion",
        "kinetic energy of the bar's motion as a whole along its axis, over the initial kinetic energy",
        lambda rigid, vibration, strain: rigid,
    ),
    _share(
        "vibration_energy",
        "Energy of vibration",
        "kinetic energy of the bar's parts against its centre of mass, over the initial kinetic energy",
        lambda rigid, vibration, strain: vibration,
    ),
    _share(
        "strain_energy",
        "Energy of strain",
        "elastic energy over the initial kinetic one; per mass K (ln r - 1 + 1/r) / rho0 + s:s / 4 G rho with "
        "r = rho / rho0",
        lambda rigid, vibration, strain: strain,
    ),
    # Heat of viscosity and plastic work, the energy that the wall took, and the drift, which the audit has alone.
    _share(
        "lost_energy",
        "Energy lost",
        "initial kinetic energy that is neither motion nor elastic strain any more, over itself",
        lambda rigid, vibration, strain: 1.0 - rigid - vibration - strain,
    ),
)

# ---- the middle: what a wave does that passes ----------------------------------------------------

WHERE = "of the matter beside the axis that stood halfway along the bar"


def _in_the_middle(view: BarView, values: np.ndarray) -> Reading:
    """A value (n,) beside the axis, halfway along the bar as it was at the start.

    Where particles stand at nodes, theirs.
    """
    inner = np.flatnonzero((view.place[:, :2] == 0).all(axis=1))[::-1]
    layers, first = np.unique(view.place[inner, 2], return_index=True)
    if layers.size <= view.place[:, 2].max():
        raise NoValue(LOST_PARTICLES)
    column = inner[first]
    return Reading(float(np.interp(0.5 * view.length, view.height[column], values[column])))


@measurement(title="Velocity in the middle", unit="m s-1", meaning=f"axial velocity, away from the wall, {WHERE}")
def middle_velocity(view: BarView) -> Reading:
    return _in_the_middle(view, view.velocity[:, 2])


@measurement(
    title="Stress in the middle",
    unit="Pa",
    meaning=f"axial stress, negative in compression and without artificial viscosity, {WHERE}",
)
def middle_stress(view: BarView) -> Reading:
    return _in_the_middle(view, view.stress)


def _peak(of: Measurement, title: str, quantity: str) -> Measurement:
    """The reading of largest magnitude, with its sign; uncertain by its distance to the readings beside it."""

    def read(history: History) -> Reading:
        values = history.values[of.name]
        if np.isnan(values).any():
            raise NoValue(LOST_PARTICLES)
        at = int(np.abs(values).argmax())
        beside = values[max(at - 1, 0) : at + 2]
        return Reading(float(values[at]), {"sampling": float(np.ptp(beside))})

    return Measurement(
        name=of.name.replace("middle", "middle_peak"),
        title=title,
        unit=of.unit,
        meaning=f"largest {quantity} so far, with its sign, {WHERE}",
        definition=read,
        follows=(of.name,),
    )


# ---- the rear face -------------------------------------------------------------------------------
# As an interferometer sees it. The velocity is that of the motion: velocities of particles have parts that the grid
# does not move them with; of single layers behind a front they differed from the motion by 3 to 5 % with two and three
# particles a cell (2026-11-23).


@measurement(
    title="Place of the rear face",
    unit="m",
    meaning="mean distance from the wall of the last layer of particles, at the end that is away from it",
)
def rear_face_place(view: BarView) -> Reading:
    layer = view.place[:, 2]
    last = layer == layer.max()
    if last.sum() < np.unique(view.place[:, :2], axis=0).shape[0]:
        raise NoValue(LOST_PARTICLES)
    place = float(np.average(view.position[last, 2], weights=view.mass[last]))
    return Reading(place, {"resolution": view.resolution})


@measurement(
    title="Velocity of the rear face",
    unit="m s-1",
    meaning="velocity, away from the wall, with which the rear face has moved since the observation before",
    follows=(rear_face_place.name,),
)
def rear_face_velocity(history: History) -> Reading:
    """The mean velocity since the last observation, uncertain by its change in that time."""
    at, place = history.times[-3:], history.values[rear_face_place.name][-3:]
    if np.isnan(place).any():
        raise NoValue(LOST_PARTICLES)
    velocities = np.diff(place) / np.diff(at)
    if not velocities.size:
        raise NoValue("one_observation")
    return Reading(float(velocities[-1]), {"sampling": float(np.ptp(velocities))})


# ---- the push of the wall, from the bar's momentum: nothing else acts along its axis --------------


@measurement(
    title="Momentum after the rebound",
    unit="1",
    meaning="axial momentum away from the wall over the initial one towards it: -1 before, 1 after a perfect rebound",
)
def rebound_momentum(view: BarView) -> Reading:
    if view.is_loaded:
        raise NoValue(LOADED)
    momentum = float((view.mass * view.velocity[:, 2]).sum())
    initial = float(view.mass.sum()) * view.speed
    return Reading(momentum / initial, {"resolution": view.share})


@dataclass(frozen=True)
class Push:
    """Mean push of a wall between observations."""

    times: np.ndarray  # (n - 1,) of the middles of the intervals, s
    rates: np.ndarray  # (n - 1,) share of the bar's initial momentum per second; negative: a pull
    impulse: np.ndarray  # (n,) so far, share of the initial momentum
    at: np.ndarray  # (n,) times of the observations, s


def push_of(history: History) -> Push:
    """The push between each two observations, empty before the second."""
    momentum, at = history.values[rebound_momentum.name], history.times
    if np.isnan(momentum).any():
        raise NoValue(LOADED)
    return Push(
        times=0.5 * (at[1:] + at[:-1]), rates=np.diff(momentum) / np.diff(at), impulse=momentum - momentum[0], at=at
    )


WHOLE = 0.99  # of the impulse: the time over which the mean push is taken
END = 0.5  # of the mean push: a front that the grid smears evenly does not move it


@measurement(
    title="Contact time",
    unit="s",
    meaning="time from the first touch until the wall's push falls, for the last time, below half of its mean; the "
    "mean is that over the time in which 99 % of the impulse is given",
    follows=(rebound_momentum.name,),
)
def contact_time(history: History) -> Reading:
    push = push_of(history)
    if push.rates.size < 2 or push.impulse.max() <= 0.0:
        raise NoValue("in_contact")
    whole = int(np.argmax(push.impulse >= WHOLE * push.impulse[-1]))
    level = END * push.impulse[whole] / (push.at[whole] - push.at[0])
    last = int(np.flatnonzero(push.rates >= level)[-1])
    if last + 1 == push.rates.size:
        raise NoValue("in_contact")
    before, after = push.rates[last], push.rates[last + 1]
    interval = push.times[last + 1] - push.times[last]
    end = push.times[last] + (before - level) / (before - after) * interval
    return Reading(float(end - push.at[0]), {"sampling": float(interval)})


@measurement(
    title="Largest pull of the wall",
    unit="1",
    meaning="largest pull of the wall on the bar between two observations, over its largest push",
    follows=(rebound_momentum.name,),
)
def wall_pull(history: History) -> Reading:
    push = push_of(history)
    if not push.rates.size or push.impulse.max() <= 0.0:
        raise NoValue("not_touched")
    return Reading(max(0.0, float(-push.rates.min())) / float(push.rates.max()))


MEASUREMENT = (
    final_length,
    mushroom_diameter,
    width_at_fifth,
    taylor_error,
    *ENERGIES,
    middle_velocity,
    middle_stress,
    _peak(middle_velocity, "Peak velocity in the middle", "axial velocity"),
    _peak(middle_stress, "Peak stress in the middle", "axial stress"),
    rear_face_place,
    rear_face_velocity,
    rebound_momentum,
    contact_time,
    wall_pull,
)
