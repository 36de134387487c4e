"""Two colliding plates: layers, the plateau behind each shock, and the shock's front.

The plateau of a plate is its matter between the interface and its shock, without the three cells next to the interface
and without the outer 20 % of that distance. The front is where the pressure, layer by layer, falls to half of the
pressure behind it. A state has no plateau before the shock is far enough, and none after it has reached a free face.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from studies.measurements import History, Measurement, OnGrid, Reading, measurement

# Cells left out at the interface: matter that met at the touch is heated by the start of the shock.
AT_INTERFACE = 3.0
OUTER = 0.2  # of the shocked distance, left out behind the front: its rise is smeared over cells
FEWEST = 4  # layers that make a plateau
HALF = 0.5  # of the pressure behind the front: where the front is
LATE = 0.5  # of the time of a run, from which on its fronts are fitted: the start of a shock is not steady

FLYER, TARGET = 0, 1
PLATES = {"flyer": FLYER, "target": TARGET}


@dataclass(frozen=True)
class PlateView(OnGrid):
    """Living particles of two plates."""

    body: np.ndarray  # (n,) FLYER or TARGET
    layer: np.ndarray  # (n,) in its plate, counted from the interface
    place: np.ndarray  # (n,) along the flight, m
    velocity: np.ndarray  # (n,) along the flight, m/s
    mass: np.ndarray  # (n,) kg (kg per radian)
    density: np.ndarray  # (n,) kg/m3
    pressure: np.ndarray  # (n,) Pa
    section: float  # area of the column, m2 (m2 per radian)
    cell: float  # m
    time: float  # s
    speed: float  # of the flyer, m/s


@dataclass(frozen=True)
class Profile:
    """The layers of a plate from the interface outwards: means over their particles."""

    distance: np.ndarray  # (k,) from the interface, m
    mass: np.ndarray  # (k,) kg
    pressure: np.ndarray  # (k,) Pa, volume-weighted


@dataclass(frozen=True)
class Front:
    """The front of a shock; ``flag`` says why there is none."""

    distance: float = math.nan  # from the interface, m
    flag: str = ""


def view(setting: Any, snapshot: Any) -> PlateView:
    """The view of a snapshot (``solver.state.Snapshot``) in a ``PlateSetting``."""
    from solver.problem.geometry import impact_axis

    particles = snapshot.particles
    living = np.flatnonzero(particles.alive)
    axis = impact_axis(setting.problem.geometry)
    return PlateView(
        body=snapshot.body[living],
        layer=setting.layer[particles.number[living]],
        place=particles.position[living, axis],
        velocity=particles.velocity[living, axis],
        mass=particles.mass[living],
        density=particles.density[living],
        pressure=particles.pressure[living],
        section=setting.section,
        cell=setting.problem.geometry.spacing,
        time=snapshot.time,
        speed=setting.speed,
    )


def interface(view: PlateView) -> float:
    """Where the plates meet: between their first layers (m)."""
    first = [view.place[(view.body == plate) & (view.layer == 0)].mean() for plate in (0, 1)]
    return float(0.5 * (first[FLYER] + first[TARGET]))


def profile(view: PlateView, plate: int) -> Profile:
    """The layers of a plate."""
    mine = view.body == plate
    layer, mass = view.layer[mine], view.mass[mine]
    volume = mass / view.density[mine]
    volumes, masses = np.bincount(layer, volume), np.bincount(layer, mass)
    place = np.bincount(layer, mass * view.place[mine]) / masses
    return Profile(
        distance=np.abs(place - interface(view)),
        mass=masses,
        pressure=np.bincount(layer, volume * view.pressure[mine]) / volumes,
    )


def front(layers: Profile) -> Front:
    """The outermost place where the pressure falls to half of what is behind it."""
    highest = float(layers.pressure.max())
    if highest <= 0.0:
        return Front(flag="no_shock")
    level = HALF * float(np.median(layers.pressure[layers.pressure > HALF * highest]))
    last = int(np.flatnonzero(layers.pressure >= level)[-1])
    if last + 1 == layers.pressure.size:
        return Front(flag="reflected")
    above, below = layers.pressure[last], layers.pressure[last + 1]
    near, far = layers.distance[last], layers.distance[last + 1]
    return Front(float(near + (above - level) / (above - below) * (far - near)))


def plateau(view: PlateView, plate: int) -> tuple[np.ndarray, str]:
    """The layers (k,) that make the plateau of a plate; a flag says why there are none."""
    layers = profile(view, plate)
    ends = front(layers)
    if ends.flag:
        return np.zeros(0, np.int64), ends.flag
    first, last = AT_INTERFACE * view.cell, (1.0 - OUTER) * ends.distance
    chosen = np.flatnonzero((layers.distance > first) & (layers.distance < last))
    if chosen.size < FEWEST:
        return np.zeros(0, np.int64), "no_plateau"
    return chosen, ""


def plateau_mean(view: PlateView, values: np.ndarray, plates: tuple[int, ...]) -> Reading:
    """Volume-weighted mean over the plateaus of some plates; its scatter is the part of its uncertainty."""
    inside = np.zeros(view.body.size, bool)
    for plate in plates:
        chosen, flag = plateau(view, plate)
        if flag:
            return Reading(math.nan, flags=(flag,))
        inside |= (view.body == plate) & np.isin(view.layer, chosen)
    volume = view.mass[inside] / view.density[inside]
    mean = float((volume * values[inside]).sum() / volume.sum())
    variance = float((volume * (values[inside] - mean) ** 2).sum() / volume.sum())
    return Reading(mean, {"scatter": math.sqrt(variance)})


@measurement(
    title="Plateau pressure",
    unit="Pa",
    meaning="volume-weighted mean pressure between the shocks, without three cells at the interface and the outer 20 % "
    "on each side",
    version=1,
)
def plateau_pressure(view: PlateView) -> Reading:
    return plateau_mean(view, view.pressure, (FLYER, TARGET))


@measurement(
    title="Scatter of the plateau pressure",
    unit="1",
    meaning="volume-weighted standard deviation of the pressure of particles on the plateau, over its mean",
    version=1,
)
def plateau_scatter(view: PlateView) -> Reading:
    """A plateau should be flat."""
    pressure = plateau_pressure.read(view)
    if pressure.flags:
        return Reading(math.nan, flags=pressure.flags)
    return Reading(pressure.parts["scatter"] / pressure.value)


@measurement(
    title="Plateau velocity",
    unit="m s-1",
    meaning="volume-weighted mean velocity between the shocks, without three cells at the interface and the outer 20 % "
    "on each side",
    version=1,
)
def plateau_velocity(view: PlateView) -> Reading:
    return plateau_mean(view, view.velocity, (FLYER, TARGET))


# ---- one of each plate ---------------------------------------------------------------------------


def _density(name: str, plate: int) -> Measurement:
    def read(view: PlateView) -> Reading:
        return plateau_mean(view, view.density, (plate,))

    return Measurement(
        name=f"{name}_density",
        title=f"Density in the {name}",
        unit="kg m-3",
        meaning=f"volume-weighted mean of the density that particles carry on the plateau of the {name}",
        version=1,
        read=read,
    )


def _density_from_spacing(name: str, plate: int) -> Measurement:
    def read(view: PlateView) -> Reading:
        """Mass between the outermost layers of a plateau over the volume between them."""
        chosen, flag = plateau(view, plate)
        if flag:
            return Reading(math.nan, flags=(flag,))
        layers = profile(view, plate)
        first, last = int(chosen[0]), int(chosen[-1])
        mass = layers.mass[first : last + 1].sum() - 0.5 * (layers.mass[first] + layers.mass[last])
        volume = view.section * (layers.distance[last] - layers.distance[first])
        steps = np.diff(layers.distance[first : last + 1])
        # The spread of single spacings, of which the ends have two.
        scatter = float(mass / volume * np.std(steps) * math.sqrt(2.0) / steps.sum())
        return Reading(float(mass / volume), {"scatter": scatter})

    return Measurement(
        name=f"{name}_density_from_spacing",
        title=f"Density in the {name} from spacing",
        unit="kg m-3",
        meaning=f"mass between the outermost layers of the plateau of the {name}, over the volume between them: what "
        "the positions of particles say, not what they carry",
        version=1,
        read=read,
    )


def _shock_front(name: str, plate: int) -> Measurement:
    def read(view: PlateView) -> Reading:
        """The distance (m) that the shock has run in its plate, in undisturbed matter."""
        ends = front(profile(view, plate))
        if ends.flag:
            return Reading(math.nan, flags=(ends.flag,))
        place = interface(view) + (ends.distance if plate == TARGET else -ends.distance)
        run = place if plate == TARGET else view.speed * view.time - place
        return Reading(run, {"resolution": view.resolution})

    return Measurement(
        name=f"{name}_shock_front",
        title=f"Shock front in the {name}",
        unit="m",
        meaning="distance of the shock front, where the pressure falls to half, from the impact face of the "
        f"undisturbed {name}",
        version=1,
        read=read,
    )


def _shock_speed(name: str, _: int) -> Measurement:
    def read(history: History) -> Reading:
        """Slope of a front's path, by least squares over the later half of the time so far; m/s."""
        path = history.values[f"{name}_shock_front"]
        late = np.isfinite(path) & (history.times >= LATE * history.times[-1])
        if late.sum() < FEWEST:
            return Reading(math.nan, flags=("no_plateau",))
        times, path = history.times[late], path[late]
        deviation = times - times.mean()
        slope = float((deviation * path).sum() / (deviation**2).sum())
        left = path - path.mean() - slope * deviation
        error = math.sqrt(float((left**2).sum()) / (times.size - 2) / float((deviation**2).sum()))
        return Reading(slope, {"fit": error})

    return Measurement(
        name=f"{name}_shock_speed",
        title=f"Shock speed in the {name}",
        unit="m s-1",
        meaning=f"speed of the shock relative to the undisturbed {name}: slope of the front's path in the later half "
        "of the time",
        version=1,
        read=read,
        follows=(f"{name}_shock_front",),
    )


MEASUREMENT = (
    plateau_pressure,
    plateau_scatter,
    plateau_velocity,
    *(
        of_plate(name, plate)
        for of_plate in (_density, _density_from_spacing, _shock_front, _shock_speed)
        for name, plate in PLATES.items()
    ),
)
