"""A debris cloud: its shape, its melted share, and its mass over speed and angle of flight.

Sums and velocities are those of ``studies.debris.cloud``, whose view all read.
"""

import math
from collections.abc import Callable

import numpy as np

from studies.debris.cloud import HALF, NOTHING_BEHIND, TOTALS, VELOCITIES, CloudView, exceeded_reading, of_projectile
from studies.debris.setting import Melting
from studies.measurements import Measurement, NoValue, Reading, measurement
from studies.measurements.distributions import Bins, Distribution
from studies.measurements.impact.edges import overlap
from studies.quantities.measured import DEFINITION

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


def _melted(name: str, title: str, matter: str, of: Callable[[CloudView], np.ndarray]) -> Measurement:
    """Melted share of some particles (n, bool); half of its excess over what is all liquid is its definition's part.

    At no pressure matter begins to melt with the energy e_m = c_v (T_m - T_0), and is liquid from e_m + L on, with the
    latent heat L of fusion; in between the share (e - e_m) / L of it is (lever rule). The energy tells it, because the
    temperature stays at T_m in between. Matter that melts over a range begins at its solidus, and takes up the heat of
    the range too.
    """

    def read(view: CloudView) -> Reading:
        from solver.matter.melting import melted_share

        among = of(view)
        if not among.any():
            raise NoValue(NOTHING_BEHIND)
        bodies = zip((view.projectile, ~view.projectile), view.melting, strict=True)
        kinds = [(mine, melting) for mine, melting in bodies if mine[among].any()]
        reasons = [melting for _, melting in kinds if isinstance(melting, str)]
        if reasons:
            raise NoValue(*dict.fromkeys(reasons))
        share = np.zeros(view.mass.size)
        for mine, melting in kinds:
            if isinstance(melting, Melting):
                share[mine] = melted_share(view.residual[mine], melting.onset, melting.heat)
        mass = view.mass[among]
        value = float((mass * share[among]).sum() / mass.sum())
        liquid = float(mass[share[among] == 1.0].sum() / mass.sum())
        return Reading(value, {DEFINITION: HALF * (value - liquid)})

    return Measurement(
        name=name,
        title=title,
        unit="1",
        meaning=f"share of the mass of {matter} that is molten, by its specific internal energy once it has expanded "
        "to no pressure, against c_v (T_m - T_0) and the latent heat of fusion, or the heats to the solidus and on to "
        "the liquidus, in part where it is in between; never melts, no latent heat or Lindemann reference where a "
        "material does not have those constants",
        version=4,
        definition=read,
    )


melted_share_behind = _melted("melted_share_behind", "Melted share", "all matter behind the plate", CloudView.behind)

MEASUREMENT = (
    *TOTALS,
    *VELOCITIES,
    cloud_radius,
    cloud_radius_place,
    cloud_length,
    cloud_length_over_diameter,
    melted_share_behind,
    _melted("melted_share_projectile", "Melted share of the projectile", "the projectile", of_projectile),
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
