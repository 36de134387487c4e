"""A debris cloud: its sums, velocities, shape and melted share, before and behind a plate.

The view has all matter of an impact about its axis, and which of it is plate, behind or before it; ``fragments`` reads
the same view.

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

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from studies.measurements import Bins, Distribution, Measurement, NoValue, OnGrid, Reading, measurement
from studies.measurements.impact.edges import overlap, place_holding
from studies.measurements.impact.view import rim_of
from studies.quantities.measured import DEFINITION

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
    breakup: tuple[Any, Any]  # of projectile and target: studies.scenarios.debris_cloud.Breakup
    melting: tuple[Any, Any]  # of projectile and target: studies.scenarios.Melting, or the flag that says why not

    def behind(self, off: float = 0.0) -> np.ndarray:
        """(n,) whether it is farther than ``off`` (m) behind the back surface."""
        return self.depth > self.thickness + off

    def before(self, off: float = 0.0) -> np.ndarray:
        """(n,) whether it is farther than ``off`` (m) before the front surface."""
        return self.depth < -off


def view(setting: Any, snapshot: Any) -> CloudView:
    """The view of a snapshot (``solver.state.Snapshot``) in a ``CloudSetting``."""
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
    initial = np.concatenate([each.position for each in problem.bodies])
    if problem.arrivals is not None:  # they have the last numbers of all
        initial = np.concatenate([initial, problem.arrivals.table[X : Z + 1].T])
    initial = initial[whole("number")]
    across = [0] if axis == 1 else [0, 1]
    names = [each.name for each in problem.bodies]
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
        width=max(each.spacing[axis] for each in problem.bodies),
        thickness=setting.thickness,
        diameter=setting.projectile_diameter,
        speed=setting.speed,
        breakup=setting.breakup,
        melting=setting.melting,
    )


def _residual(problem: Any, snapshot: Any, living: np.ndarray) -> np.ndarray:
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


def connected(cell: np.ndarray) -> np.ndarray:
    """Number (n,) of the connected piece of each particle, by its cell (n, 3): cells touch at corners too.

    The work grows with the number of particles, however far apart they are.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if not cell.size:
        return np.zeros(0, np.int64)
    cell = cell - cell.min(axis=0) + 1
    size = cell.max(axis=0) + 2
    stride = np.array([size[1] * size[2], size[2], 1])
    occupied, of = np.unique(cell @ stride, return_inverse=True)
    pairs = []
    # Half of the neighbours: the others see the pair from their side.
    for offset in [each for each in product((-1, 0, 1), repeat=3) if each > (0, 0, 0)]:
        wanted = occupied + np.array(offset) @ stride
        place = np.searchsorted(occupied, wanted)
        found = np.flatnonzero(occupied[np.minimum(place, occupied.size - 1)] == wanted)
        pairs.append(np.stack([found, place[found]]))
    first, second = np.concatenate(pairs, axis=1)
    graph = coo_array((np.ones(first.size, bool), (first, second)), shape=(occupied.size,) * 2)
    piece: np.ndarray = connected_components(graph, directed=False)[1]
    return piece[of.ravel()].astype(np.int64)


def _copies(problem: Any, axis: int, cell: np.ndarray, fragment: np.ndarray) -> np.ndarray:
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


def _projectile(view: CloudView) -> np.ndarray:
    return view.projectile


VELOCITIES = (
    _velocity("tip_velocity_percent", "Tip velocity (1 %)", 0.01, "all matter", _all),
    _velocity("tip_velocity_permille", "Tip velocity (0.1 %)", 0.001, "all matter", _all),
    # The projectile makes the rear of a cloud: behind it comes the lip of the hole, which stays.
    _velocity("rear_velocity", "Rear velocity", 0.99, "the projectile", _projectile),
)

# ---- shape ---------------------------------------------------------------------------------------

SHARE = 0.01  # of the mass, which lies farther out
_FLAGS = "flags as those of the tip velocity"


@measurement(
    title="Largest radius of the cloud",
    unit="m",
    meaning=f"distance from the axis that {SHARE:.0%} of the mass behind the plate exceeds; {_FLAGS}",
)
def cloud_radius(view: CloudView) -> Reading:
    return exceeded_reading(view, view.radius, SHARE, view.behind(), is_length=True)


@measurement(
    title="Place of the largest radius",
    unit="m",
    meaning="mean distance, from the plate's original back surface, of the matter behind it that is at the largest "
    "radius or farther out",
)
def cloud_radius_place(view: CloudView) -> Reading:
    """Mean depth of what lies farther out than the largest radius, with the standard error of a mean."""
    radius, behind = cloud_radius.definition(view), view.behind()
    outside = overlap(view.radius[behind], view.width, radius.value, math.inf)
    mass, depth = view.mass[behind] * outside, view.depth[behind] - view.thickness
    mean = float((mass * depth).sum() / mass.sum())
    error = math.sqrt(float((mass**2 * (depth - mean) ** 2).sum())) / float(mass.sum())
    return Reading(mean, {"sampling": error, "resolution": view.resolution}, radius.flags)


@measurement(
    title="Length of the cloud",
    unit="m",
    meaning=f"distance from the plate's original back surface that {SHARE:.0%} of the mass behind it exceeds; {_FLAGS}",
)
def cloud_length(view: CloudView) -> Reading:
    return exceeded_reading(view, view.depth - view.thickness, SHARE, view.behind(), is_length=True)


@measurement(
    title="Length of the cloud over its diameter",
    unit="1",
    meaning="length of the cloud divided by twice its largest radius",
)
def cloud_length_over_diameter(view: CloudView) -> Reading:
    length, radius = cloud_length.definition(view), cloud_radius.definition(view)
    ratio = length.value / (2.0 * radius.value)
    parts = {
        name: abs(ratio) * float(np.hypot(part / length.value, radius.parts[name] / radius.value))
        for name, part in length.parts.items()
    }
    return Reading(ratio, parts, tuple(dict.fromkeys((*length.flags, *radius.flags))))


# ---- the melted share, from the residual energy of matter: what mesh and shocks leave in it, three grids say ------


def _molten(view: CloudView, kind: int) -> np.ndarray:
    """Melted share (n,) of each particle, were it matter of the projectile (0) or the target (1).

    At no pressure matter begins to melt with the energy e_m = c_v (T_m - T_0), and is liquid from e_m + L on, with the
    latent heat L of fusion; in between the share (e - e_m) / L of it is (lever rule). The energy tells it, because the
    temperature stays at T_m in between.
    """
    from solver.matter.melting import melted_share

    melting = view.melting[kind]
    onset = melting.heat_capacity * (melting.melt_temperature - melting.room_temperature)
    return melted_share(view.residual, onset, melting.latent_heat)


def _melted(name: str, title: str, matter: str, of: Callable[[CloudView], np.ndarray]) -> Measurement:
    """Melted share of some particles (n, bool); half of its excess over what is all liquid is its definition's part."""

    def read(view: CloudView) -> Reading:
        among = of(view)
        if not among.any():
            raise NoValue(NOTHING_BEHIND)
        kinds = [kind for kind, body in enumerate((view.projectile, ~view.projectile)) if body[among].any()]
        reasons = [each for kind in kinds if isinstance(each := view.melting[kind], str)]
        if reasons:
            raise NoValue(*dict.fromkeys(reasons))
        share = np.zeros(view.mass.size)
        for kind in kinds:
            mine = view.projectile if kind == 0 else ~view.projectile
            share[mine] = _molten(view, kind)[mine]
        mass = view.mass[among]
        value = float((mass * share[among]).sum() / mass.sum())
        liquid = float(mass[share[among] == 1.0].sum() / mass.sum())
        return Reading(value, {DEFINITION: HALF * (value - liquid)})

    return Measurement(
        name=name,
        title=title,
        unit="1",
        meaning=f"share of the mass of {matter} that is molten, by its specific internal energy once it has expanded "
        "to no pressure, against c_v (T_m - T_0) and the latent heat of fusion, in part where it is in between; never "
        "melts, no latent heat or Lindemann reference where a material does not have those constants",
        version=3,
        definition=read,
    )


MEASUREMENT = (
    *TOTALS,
    *VELOCITIES,
    cloud_radius,
    cloud_radius_place,
    cloud_length,
    cloud_length_over_diameter,
    _melted("melted_share_behind", "Melted share", "all matter behind the plate", CloudView.behind),
    _melted("melted_share_projectile", "Melted share of the projectile", "the projectile", _projectile),
)

# ---- distributions: arrays over fixed bins; a scenario names those of its runs -------------------

SPEEDS = Bins("relative_speed", "relative speed", "1", "speed over the impact speed", 0.05, 30)
ANGLES = Bins(
    "angle_of_flight",
    "angle of flight",
    "rad",
    "angle between velocity and line of flight, 0 downrange, pi uprange",
    math.pi / 36.0,
    36,
)


def _mass_in_bins(view: CloudView) -> np.ndarray:
    """Mass (speeds, angles) of all matter before and behind the plate, kg."""
    outside = view.behind() | view.before()
    along, across = view.axial_velocity[outside], view.transverse_velocity[outside]
    speed = SPEEDS.place(np.hypot(along, across) / view.speed)
    angle = ANGLES.place(np.arctan2(across, along))
    mass = np.zeros((SPEEDS.count, ANGLES.count))
    np.add.at(mass, (speed, angle), view.mass[outside])
    return mass


# Another one is an entry here; ``fragments`` has them all by name.
OF_CLOUD = (
    Distribution(
        name="mass_over_velocity_and_angle",
        title="Mass over velocity and angle",
        unit="kg",
        meaning="mass of all matter before and behind the plate's original surfaces, over its speed and the angle "
        "of its flight; the last speed holds all that is faster",
        bins=(SPEEDS, ANGLES),
        read=_mass_in_bins,
    ),
)
