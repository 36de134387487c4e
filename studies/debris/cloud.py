"""The debris of an impact: its view, and its sums and velocities before and behind a plate.

The view has all matter of an impact about its axis, and which of it is plate, behind or before it. Debris clouds and
shields read it, and offer the measurements.

What has departed from the grid belongs to it, flown straight from there (``solver.state.Departed``). What lies beyond
the plane of the plate's original back surface is *behind* the plate, what lies before that of its original front
surface is *before* it; between the planes it is neither. That holds for all matter, the lips of the hole included:
what hangs together with the plate is decided by the mesh. What *came off* does not hang together with the target's rim
through cells that hold the target's matter, as in the measurement of a hole; half of the difference that it makes to
count this alone is the part of the definition.

A share of the mass exceeds a velocity x when that share of the mass has more: particles are taken in ascending order,
each stands where half of its own mass lies below, and x is interpolated between them. A share of the mass exceeds a
place when it lies farther out, each particle spread evenly over its initial width.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from studies.debris.breakup import Breakup
from studies.debris.setting import CloudSetting, Melting
from studies.measurements import Measurement, NoValue, OnGrid, Reading
from studies.measurements.impact.edges import place_holding
from studies.measurements.impact.view import connected, rim_of
from studies.quantities.measured import DEFINITION

if TYPE_CHECKING:
    from solver.problem import Problem
    from solver.state import Snapshot

NOTHING_BEHIND, FEW_PARTICLES = "nothing_behind", "few_particles"

HALF = 0.5  # of the difference between two definitions, or between two neighbours: a standard uncertainty


@dataclass(frozen=True)
class CloudView(OnGrid):
    """Particles of whole bodies about the axis of an impact, those that departed included."""

    radius: np.ndarray  # (n,) from the axis, m
    depth: np.ndarray  # (n,) along the flight from the plate's original front surface, m
    initial_radius: np.ndarray  # (n,) the same before the impact, of debris from another grid as it came, m
    initial_depth: np.ndarray  # (n,) m
    axial_velocity: np.ndarray  # (n,) m/s
    transverse_velocity: np.ndarray  # (n,) not negative, m/s
    mass: np.ndarray  # (n,) kg, of the whole body
    energy: np.ndarray  # (n,) specific internal energy, J/kg
    residual: np.ndarray  # (n,) specific internal energy once it has expanded to no pressure, J/kg
    projectile: np.ndarray  # (n,) whether it is matter of the projectile
    plate: np.ndarray  # (n,) whether it is target that hangs together with the rim
    fragment: np.ndarray  # (n,) number of the connected piece of what came off, -1 of the plate
    copies: np.ndarray  # (n,) pieces that its piece of the model stands for in the whole body
    cell: float  # m
    width: float  # of a particle, initially, m
    thickness: float  # of the plate, m
    diameter: float  # of the projectile, m
    speed: float  # of the impact, m/s
    breakup: tuple[Breakup, ...]  # of projectile and target
    melting: tuple[Melting | str, ...]  # of projectile and target, or the flag that says why not

    def behind(self, off: float = 0.0) -> np.ndarray:
        """(n,) whether it is farther than ``off`` (m) behind the back surface."""
        return self.depth > self.thickness + off

    def before(self, off: float = 0.0) -> np.ndarray:
        """(n,) whether it is farther than ``off`` (m) before the front surface."""
        return self.depth < -off


def view(setting: CloudSetting, snapshot: "Snapshot") -> CloudView:
    """The view of a snapshot."""
    from solver.grid.debris import flown
    from solver.problem.geometry import impact_axis
    from solver.state import X, Z

    problem, particles, departed = setting.problem, snapshot.particles, snapshot.departed
    living = particles.alive == 1
    axis = impact_axis(problem.geometry)

    def whole(name: str) -> np.ndarray:
        return np.concatenate([getattr(particles, name)[living], getattr(departed, name)])

    position = np.concatenate([particles.position[living], flown(problem, departed, snapshot.time)])
    velocity, body = whole("velocity"), np.concatenate([snapshot.body[living], departed.body])
    initial = np.concatenate([own.position for own in problem.bodies])
    if problem.arrivals is not None:  # they have the last numbers of all
        initial = np.concatenate([initial, problem.arrivals.table[X : Z + 1].T])
    initial = initial[whole("number")]
    across = [0] if axis == 1 else [0, 1]
    names = [own.name for own in problem.bodies]
    target = body == names.index(setting.target)
    on_grid = np.arange(body.size) < living.sum()
    rim = rim_of(setting, position[:, across], position[:, axis], target & on_grid)
    cell = np.floor((position - problem.geometry.lower) / problem.geometry.spacing)
    cell = np.where(problem.geometry.cells > 0, cell, 0.0).astype(np.int64)
    plate = np.zeros(body.size, bool)
    piece = connected(cell[target])
    plate[target] = np.isin(piece, np.unique(piece[rim[target]]))
    fragment = np.full(body.size, -1)
    fragment[~plate] = connected(cell[~plate])
    return CloudView(
        radius=np.sqrt((position[:, across] ** 2).sum(axis=1)),
        depth=position[:, axis],
        initial_radius=np.sqrt((initial[:, across] ** 2).sum(axis=1)),
        initial_depth=initial[:, axis],
        axial_velocity=velocity[:, axis],
        transverse_velocity=np.sqrt((np.delete(velocity, axis, axis=1) ** 2).sum(axis=1)),
        mass=whole("mass") * (2.0 * np.pi / setting.sector),
        energy=whole("energy"),
        residual=_residual(problem, snapshot, living),
        projectile=body == names.index("projectile"),
        plate=plate,
        fragment=fragment,
        copies=_copies(problem, axis, cell, fragment),
        cell=problem.geometry.spacing,
        width=max(own.spacing[axis] for own in problem.bodies),
        thickness=setting.thickness,
        diameter=setting.projectile_diameter,
        speed=setting.speed,
        breakup=setting.breakup,
        melting=setting.melting,
    )


def _residual(problem: "Problem", snapshot: "Snapshot", living: np.ndarray) -> np.ndarray:
    """Residual energy (n,) of the living particles (n, bool of all) and of the departed, J/kg.

    All energy of what departed counts as residual: it flies on as it was, and expands no more.
    """
    from solver.matter.melting import residual_energy

    particles, residual = snapshot.particles, snapshot.particles.energy.copy()
    for number, body in enumerate(problem.bodies):
        mine = living & (snapshot.body == number)
        state = (getattr(particles, name)[mine] for name in ("density", "energy", "pressure"))
        residual[mine] = residual_energy(body.matter.eos, *state)
    return np.concatenate([residual[living], snapshot.departed.energy])


def _copies(problem: "Problem", axis: int, cell: np.ndarray, fragment: np.ndarray) -> np.ndarray:
    """Pieces (n,) of the whole body for which that of a particle stands: twice for each plane that it does not touch.

    A body of revolution has no planes: its pieces are rings.
    """
    from solver.problem import Face

    copies = np.ones(fragment.size)
    if axis == 1:
        return copies
    for across in (0, 1):
        if problem.faces[across][0] == Face.SYMMETRIC:
            touching = np.isin(fragment, fragment[cell[:, across] == 0])
            copies[~touching] *= 2.0
    return copies


def exceeded(values: np.ndarray, mass: np.ndarray, share: float, width: float = 0.0) -> float:
    """The value that a share of the mass exceeds; ``values`` and ``mass`` (n,), places are spread over a ``width``."""
    if width:
        return place_holding(values, mass, width, (1.0 - share) * float(mass.sum()))
    order = np.lexsort((mass, values))
    middles = np.cumsum(mass[order]) - HALF * mass[order]
    return float(np.interp((1.0 - share) * mass.sum(), middles, values[order]))


def exceeded_reading(
    view: CloudView, values: np.ndarray, share: float, among: np.ndarray, *, is_length: bool = False
) -> Reading:
    """The reading of a value that a share of the mass of some particles (n, bool) exceeds; ``values`` (n,).

    Its parts: half of what one particle more or less changes, a cell for a length, and what came off alone.
    """
    if not among.any():
        raise NoValue(NOTHING_BEHIND)
    width = view.width if is_length else 0.0

    def of(which: np.ndarray, share: float) -> float:
        return exceeded(values[which], view.mass[which], share, width)

    value, loose = of(among, share), among & ~view.plate
    step = float(view.mass[among].max() / view.mass[among].sum())
    few = (FEW_PARTICLES,) if min(share, 1.0 - share) < step else ()
    near = [of(among, min(max(share + side * step, 1e-9), 1.0)) for side in (-1.0, 1.0)]
    parts = {"sampling": HALF * abs(near[0] - near[1])}
    if is_length:
        parts["resolution"] = view.resolution
    if loose.any():
        parts[DEFINITION] = HALF * abs(of(loose, share) - value)
    return Reading(value, parts, few)


# ---- mass, momentum and energy before and behind the plate ---------------------------------------


def _total(
    name: str,
    title: str,
    unit: str,
    of: Callable[[CloudView], np.ndarray],
    place: str,
    inside: Callable[[CloudView, float], np.ndarray],
) -> Measurement:
    """A sum over the matter on one side of the plate.

    Its parts: half of what a plane one cell farther out leaves away, and what came off alone.
    """

    def read(view: CloudView) -> Reading:
        summed, within = of(view), inside(view, 0.0)
        value, farther = float(summed[within].sum()), float(summed[inside(view, view.resolution)].sum())
        loose = float(summed[within & ~view.plate].sum())
        parts = {"resolution": HALF * abs(farther - value), DEFINITION: HALF * abs(loose - value)}
        return Reading(value, parts)

    return Measurement(
        name=f"{name}_{place}",
        title=f"{title} {place} the plate",
        unit=unit,
        meaning=f"{title.lower()} of all matter {place} the plate's original surfaces, the lips of the hole and what "
        "departed from the grid included, of whole bodies",
        version=2,
        definition=read,
    )


def _kinetic_energy(view: CloudView) -> np.ndarray:
    return 0.5 * view.mass * (view.axial_velocity**2 + view.transverse_velocity**2)


TOTALS = tuple(
    _total(name, title, unit, of, place, inside)
    for name, title, unit, of in (
        ("mass", "Mass", "kg", lambda view: view.mass),
        ("momentum", "Axial momentum", "N s", lambda view: view.mass * view.axial_velocity),
        ("kinetic_energy", "Kinetic energy", "J", _kinetic_energy),
        ("internal_energy", "Internal energy", "J", lambda view: view.mass * view.energy),
    )
    for place, inside in (("behind", CloudView.behind), ("before", CloudView.before))
)

# ---- how fast the front and the rear fly ---------------------------------------------------------


def _velocity(name: str, title: str, share: float, whose: str, of: Callable[[CloudView], np.ndarray]) -> Measurement:
    def read(view: CloudView) -> Reading:
        return exceeded_reading(view, view.axial_velocity, share, view.behind() & of(view))

    return Measurement(
        name=name,
        title=title,
        unit="m s-1",
        meaning=f"axial velocity that {100.0 * share:g} % of the mass of {whose} behind the plate exceeds; few "
        "particles where one of them has more than the share",
        definition=read,
    )


def _all(view: CloudView) -> np.ndarray:
    return np.ones(view.mass.size, bool)


def of_projectile(view: CloudView) -> np.ndarray:
    """(n,) whether it is matter of the projectile."""
    return view.projectile


VELOCITIES = (
    _velocity("tip_velocity_percent", "Tip velocity (1 %)", 0.01, "all matter", _all),
    _velocity("tip_velocity_permille", "Tip velocity (0.1 %)", 0.001, "all matter", _all),
    # The projectile makes the rear of a cloud: behind it comes the lip of the hole, which stays.
    _velocity("rear_velocity", "Rear velocity", 0.99, "the projectile", of_projectile),
)
