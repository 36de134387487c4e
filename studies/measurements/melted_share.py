"""The melted share of matter, from its residual energy.

At no pressure the residual energy of matter is e = c_v (T - T_0), with the temperature of its equation of state. It
begins to melt at e_m = c_v (T_m - T_0) and is liquid from e_m + L on, with the latent heat L of fusion; in between the
share (e - e_m) / L of it is (lever rule).
"""

import math
from collections.abc import Callable

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._cloud import HALF, NOTHING_BEHIND, CloudView
from studies.values.results import DEFINITION


def _molten(view: CloudView, kind: int) -> np.ndarray:
    """Melted share (n,) of each particle, were it matter of the projectile (0) or the target (1)."""
    melting = view.melting[kind]
    energy = melting.heat_capacity * (view.temperature - melting.room_temperature)
    begin = melting.heat_capacity * (melting.melt_temperature - melting.room_temperature)
    molten: np.ndarray = np.clip((energy - begin) / melting.latent_heat, 0.0, 1.0)
    return molten


def _reading(view: CloudView, among: np.ndarray) -> Reading:
    """Melted share of some particles (n, bool); half of its excess over what is all liquid is its definition's part."""
    if not among.any():
        return Reading(math.nan, flags=(NOTHING_BEHIND,))
    kinds = [kind for kind, body in enumerate((view.projectile, ~view.projectile)) if body[among].any()]
    reasons = [each for kind in kinds if isinstance(each := view.melting[kind], str)]
    if reasons:
        return Reading(math.nan, flags=tuple(dict.fromkeys(reasons)))
    share = np.zeros(view.mass.size)
    for kind in kinds:
        mine = view.projectile if kind == 0 else ~view.projectile
        share[mine] = _molten(view, kind)[mine]
    mass = view.mass[among]
    value = float((mass * share[among]).sum() / mass.sum())
    liquid = float(mass[share[among] == 1.0].sum() / mass.sum())
    return Reading(value, {DEFINITION: HALF * (value - liquid)})


def _behind(view: CloudView) -> Reading:
    return _reading(view, view.behind())


def _projectile(view: CloudView) -> Reading:
    return _reading(view, view.projectile)


def _share(name: str, title: str, matter: str, read: Callable[[CloudView], Reading]) -> Measurement:
    return Measurement(
        name=name,
        title=title,
        unit="1",
        meaning=f"share of the mass of {matter} that is molten, by its residual energy c_v (T - T_0) against "
        "c_v (T_m - T_0) and the latent heat of fusion, in part where it is in between; never melts, no latent heat or "
        "Lindemann reference where a material does not have those constants",
        version=2,
        read=read,
    )


MEASUREMENT = (
    _share("melted_share_behind", "Melted share", "all matter behind the plate", _behind),
    _share("melted_share_projectile", "Melted share of the projectile", "the projectile", _projectile),
)
