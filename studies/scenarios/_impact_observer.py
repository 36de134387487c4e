"""Observer of impacts: particles about the line of flight, and the part of the target that has come loose."""

from typing import TYPE_CHECKING, Any

from studies.scenarios import ImpactSetting, ObservationRate, ObserverOptions
from studies.scenarios._settling import settled_window
from studies.values.recipes import FEW_PARTICLES, RECIPES

if TYPE_CHECKING:
    from studies.films.section import SectionOptions

# A cross-check of connectivity, which alone decides what is plate: MPM3D-F90's holes were read from particles slower
# than this, m/s.
FAST = 300.0

# Times of the two pictures of debris before the end, in times in which the projectile flies its own length: while it
# goes through the plate, and when the debris, which is no faster than the projectile, is about to leave a grid of four
# projectile diameters.
MOMENTS = (1.5, 4.0)
# Part of the target in pictures, in projectile diameters from the point of impact: plates of the default size are
# whole, and craters of copper at 7 km/s have half of it as their radius.
REACH = 7.0


# Part of the uncertainty of what runs with ``FEW_PARTICLES`` of the default recipe's shape measure, relative: the root
# mean square difference from three particles on the draft's grid, and from ``FINE`` cells across the projectile on
# (``docs.recipe_study.particles``, tables in docs/recipe.md).
FINE = 24.0
OF_FEW_PARTICLES = {
    "hole_diameter": (0.035, 0.014),
    "hole_diameter_areal": (0.029, 0.015),
    "hole_diameter_midplane": (0.057, 0.036),
    # Craters were compared on the draft's grid alone.
    "crater_depth": (0.019, 0.019),
    "crater_diameter": (0.01, 0.01),
    "crater_depth_over_diameter": (0.021, 0.021),
}


def _rate(parameters: Any, setting: Any) -> ObservationRate:
    return ObservationRate.settling(parameters, settled_window(parameters))


def _view(setting: ImpactSetting, snapshot: Any) -> Any:
    from studies.measurements._impact import view

    return view(setting, snapshot)


def _numbers(view: Any) -> dict[str, float]:
    fast = view.attached_target & (view.speed > FAST)
    return {
        "separated_mass_fraction": 1.0 - _share(view, view.attached_target),
        "fast_mass_fraction": _share(view, fast),
    }


def _parts(parameters: Any, name: str) -> dict[str, float]:
    """The part that a low number of particles leaves; none for other shapes, of which nobody measured it."""
    default = RECIPES["whipple"]
    few = parameters.particles_per_cell <= FEW_PARTICLES < default.particles_per_cell
    if few and parameters.shape == default.shape and name in OF_FEW_PARTICLES:
        coarse, fine = OF_FEW_PARTICLES[name]
        return {"particles": coarse if parameters.cells_per_diameter < FINE else fine}
    return {}


def _share(view: Any, keep: Any) -> float:
    """Mass of some particles over that of the whole target."""
    return float(view.mass[keep].sum()) / view.target_mass


def _sections(parameters: Any, setting: ImpactSetting) -> "SectionOptions":
    from studies.films.section import SectionOptions

    diameter = setting.projectile_diameter
    longest = max(diameter, parameters.projectile_length or 0.0)
    moments = tuple(moment * longest / parameters.speed for moment in MOMENTS)
    return SectionOptions(moments=moments, reach=REACH * diameter)


IMPACT = ObserverOptions(
    rate=_rate,
    view=_view,
    numbers=_numbers,
    sections=_sections,
    parts=_parts,
    least_cells={"cells_per_diameter": 16.0, "cells_per_thickness": 4.0},
    # At 6 km/s a plate of a twentieth of the diameter has a hole of 16.4 mm with 0.8 cells through it, 11.3 with 2.4.
    fewest_cells={"cells_per_thickness": 2.0},
)
