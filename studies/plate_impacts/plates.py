"""Two colliding plates: layers, the plateau behind each shock, the shock's front, and the target's free surface.

The plateau of a plate is its matter between the interface and its shock, without the three cells next to the interface
and without the outer 20 % of that distance. The front is where the pressure, layer by layer, falls to half of the
pressure behind it. A state has no plateau before the shock is far enough, and none after it has reached a free face.

The free surface is the outermost three cells of the target. Its velocity rises to a peak when the shock arrives, falls
when the release from the back of the flyer arrives, and rises again when matter has broken inside: the fall from the
peak to that first minimum is the pull-back, and half of it times rho0 c0 the spall strength in the acoustic
approximation, as in the public code SPADE. No correction is made for strength.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from studies.measurements import History, Measurement, NoValue, OnGrid, Reading, measurement
from studies.plate_impacts.setting import PlateSetting

if TYPE_CHECKING:
    from solver.state import Snapshot

# Cells left out at the interface: matter that met at the touch is heated by the start of the shock.
AT_INTERFACE = 3.0
OUTER = 0.2  # of the shocked distance, left out behind the front: its rise is smeared over cells
FEWEST = 4  # layers that make a plateau
HALF = 0.5  # of the pressure behind the front: where the front is
# Cells at the free surface whose mean is its velocity. Waves that run in and out make it the mean over the time in
# which sound crosses twice as many, and particles behind a shock ring with a period of six to seven: copper at 190 m/s
# and aluminium at 1335 m/s with strength, without a failure, before any run had one.
SURFACE = 3.0
# Of the peak, by which the velocity of a free surface rises again after its first minimum. The same runs ripple by up
# to 1.4 % of it behind the shock, on 50 cells through the flyer. Fluids, and shocks of 20 GPa, ripple by more.
RECOVERED = 0.02
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
    thickness: float  # of the undeformed target, m
    impedance: float  # rho0 c0 of the target, Pa s/m
    cell: float  # m
    time: float  # s
    speed: float  # of the flyer, m/s


@dataclass(frozen=True)
class Profile:
    """The layers of a plate from the interface outwards: means over their particles."""

    distance: np.ndarray  # (k,) from the interface, m
    mass: np.ndarray  # (k,) kg
    pressure: np.ndarray  # (k,) Pa, volume-weighted


def view(setting: PlateSetting, snapshot: "Snapshot") -> PlateView:
    """The view of a snapshot."""
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
        thickness=setting.thicknesses[TARGET],
        impedance=setting.impedance,
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


def front(layers: Profile) -> float:
    """The distance (m) from the interface of the outermost place where the pressure falls to half of that behind it."""
    highest = float(layers.pressure.max())
    if highest <= 0.0:
        raise NoValue("no_shock")
    level = HALF * float(np.median(layers.pressure[layers.pressure > HALF * highest]))
    last = int(np.flatnonzero(layers.pressure >= level)[-1])
    if last + 1 == layers.pressure.size:
        raise NoValue("reflected")
    above, below = layers.pressure[last], layers.pressure[last + 1]
    near, far = layers.distance[last], layers.distance[last + 1]
    return float(near + (above - level) / (above - below) * (far - near))


def plateau(view: PlateView, plate: int) -> np.ndarray:
    """The layers (k,) that make the plateau of a plate."""
    layers = profile(view, plate)
    first, last = AT_INTERFACE * view.cell, (1.0 - OUTER) * front(layers)
    chosen = np.flatnonzero((layers.distance > first) & (layers.distance < last))
    if chosen.size < FEWEST:
        raise NoValue("no_plateau")
    return chosen


def plateau_mean(view: PlateView, values: np.ndarray, plates: tuple[int, ...]) -> Reading:
    """Volume-weighted mean over the plateaus of some plates; its scatter is the part of its uncertainty."""
    inside = np.zeros(view.body.size, bool)
    for plate in plates:
        inside |= (view.body == plate) & np.isin(view.layer, plateau(view, plate))
    volume = view.mass[inside] / view.density[inside]
    mean = float((volume * values[inside]).sum() / volume.sum())
    variance = float((volume * (values[inside] - mean) ** 2).sum() / volume.sum())
    return Reading(mean, {"scatter": math.sqrt(variance)})


@measurement(
    title="Plateau pressure",
    unit="Pa",
    meaning="volume-weighted mean pressure between the shocks, without three cells at the interface and the outer 20 % "
    "on each side",
)
def plateau_pressure(view: PlateView) -> Reading:
    return plateau_mean(view, view.pressure, (FLYER, TARGET))


@measurement(
    title="Scatter of the plateau pressure",
    unit="1",
    meaning="volume-weighted standard deviation of the pressure of particles on the plateau, over its mean",
)
def plateau_scatter(view: PlateView) -> Reading:
    pressure = plateau_pressure.definition(view)
    return Reading(pressure.parts["scatter"] / pressure.value)


@measurement(
    title="Plateau velocity",
    unit="m s-1",
    meaning="volume-weighted mean velocity between the shocks, without three cells at the interface and the outer 20 % "
    "on each side",
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
        definition=read,
    )


def _density_from_spacing(name: str, plate: int) -> Measurement:
    def read(view: PlateView) -> Reading:
        """Mass between the outermost layers of a plateau over the volume between them."""
        chosen, layers = plateau(view, plate), profile(view, plate)
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
        definition=read,
    )


def _shock_front(name: str, plate: int) -> Measurement:
    def read(view: PlateView) -> Reading:
        """The distance (m) that the shock has run in its plate, in undisturbed matter."""
        distance = front(profile(view, plate))
        place = interface(view) + (distance if plate == TARGET else -distance)
        run = place if plate == TARGET else view.speed * view.time - place
        return Reading(run, {"resolution": view.resolution})

    return Measurement(
        name=f"{name}_shock_front",
        title=f"Shock front in the {name}",
        unit="m",
        meaning="distance of the shock front, where the pressure falls to half, from the impact face of the "
        f"undisturbed {name}",
        definition=read,
    )


def _shock_speed(name: str, _: int) -> Measurement:
    def read(history: History) -> Reading:
        """Slope of a front's path, by least squares over the later half of the time so far; m/s."""
        path = history.values[f"{name}_shock_front"]
        late = np.isfinite(path) & (history.times >= LATE * history.times[-1])
        if late.sum() < FEWEST:
            raise NoValue("no_plateau")
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
        definition=read,
        follows=(f"{name}_shock_front",),
    )


# ---- the free surface of the target --------------------------------------------------------------


@measurement(
    title="Velocity of the free surface",
    unit="m s-1",
    meaning=f"mean velocity of the outermost {SURFACE:g} cells of the undeformed target, whose rear is free",
)
def free_surface_velocity(view: PlateView) -> Reading:
    target = np.flatnonzero(view.body == TARGET)
    if not target.size:
        raise NoValue("no_target")
    layers = int(view.layer[target].max()) + 1
    depth = (layers - view.layer[target] - 0.5) * view.thickness / layers
    last = target[depth < SURFACE * view.cell]
    return Reading(float((view.mass[last] * view.velocity[last]).sum() / view.mass[last].sum()))


@measurement(
    title="Acoustic stress of the free surface",
    unit="Pa",
    meaning="half of rho0 c0 of the target times the velocity of its free surface: the stress of a plane sound wave "
    "that would give it that velocity",
)
def acoustic_stress(view: PlateView) -> Reading:
    return Reading(0.5 * view.impedance * free_surface_velocity.definition(view).value)


@dataclass(frozen=True)
class Pullback:
    """The signal of a spall in a history of the free surface; ``flag`` says why there is none."""

    peak: float = math.nan  # largest value before the first minimum
    minimum: float = math.nan  # lowest value between the peak and the recovery
    flag: str = ""


def pullback(values: np.ndarray) -> Pullback:
    """The first fall from a peak (n,) after which the values rise again by ``RECOVERED`` of that peak."""
    peak = lowest = value = 0.0
    for value in values[np.isfinite(values)].tolist():
        if value > peak:
            peak = lowest = value
        lowest = min(lowest, value)
        if lowest < peak and value - lowest > RECOVERED * peak:
            return Pullback(peak, lowest)
    if peak == 0.0:
        return Pullback(flag="not_arrived")
    # No release has arrived yet, or the values still fall: a recovery may follow.
    is_early = peak - lowest <= RECOVERED * peak or value == lowest
    return Pullback(peak, flag="ended_before" if is_early else "no_minimum")


def _of_signal(name: str, title: str, meaning: str, of: Measurement, read: Callable[[Pullback], float]) -> Measurement:
    """A number of the signal in the history of a measurement, in its unit."""

    def definition(history: History) -> Reading:
        signal = pullback(history.values[of.name])
        value = read(signal)
        if not math.isfinite(value):
            raise NoValue(signal.flag)
        return Reading(value)

    return Measurement(name, title, of.unit, meaning, definition, follows=(of.name,))


SIGNALS = (
    _of_signal(
        "free_surface_peak",
        "Peak of the free surface",
        "largest velocity of the target's free surface before its first minimum",
        free_surface_velocity,
        lambda signal: signal.peak,
    ),
    _of_signal(
        "free_surface_minimum",
        "First minimum of the free surface",
        f"lowest velocity of the target's free surface after its peak, before it has risen again by {RECOVERED:g} of "
        "that peak",
        free_surface_velocity,
        lambda signal: signal.minimum,
    ),
    _of_signal(
        "pullback_velocity",
        "Pull-back velocity",
        "peak of the free surface's velocity less its first minimum",
        free_surface_velocity,
        lambda signal: signal.peak - signal.minimum,
    ),
    _of_signal(
        "spall_strength",
        "Spall strength",
        "rho0 c0 of the target times half of the pull-back velocity: the acoustic approximation, with the bulk sound "
        "speed and without a correction for strength",
        acoustic_stress,
        lambda signal: signal.peak - signal.minimum,
    ),
)


MEASUREMENT = (
    plateau_pressure,
    plateau_scatter,
    plateau_velocity,
    free_surface_velocity,
    acoustic_stress,
    *SIGNALS,
    *(
        of_plate(name, plate)
        for of_plate in (_density, _density_from_spacing, _shock_front, _shock_speed)
        for name, plate in PLATES.items()
    ),
)
