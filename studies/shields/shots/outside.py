"""What lies outside of all published shots on shields, where nothing is known of how likely a wall fails."""

import math
from collections.abc import Iterator, Mapping
from functools import cache

from solver.units import Metre
from studies.shields.shield import ALUMINIUM, ShotAtShield
from studies.shields.shots.table import published


def outside_of_shots(shot: ShotAtShield) -> Iterator[str]:
    """Why a shot on a shield is like none of the published ones."""
    if shot.shield.further_bumpers:
        yield "all shots have two walls"
    metals = {"projectile": shot.projectile.family, "bumper": shot.target.family, **shot.shield.of_other_metal}
    for role, family in metals.items():
        if family != ALUMINIUM:
            yield f"the {role} is {family}, all shots are of aluminium"
    if shot.length_ratio != 1.0:
        yield f"L/d = {shot.length_ratio:.3g}, all shots are of spheres"
    for (name, unit), value in _ratios(shot).items():
        low, high = _limits()[name]
        if not low <= value <= high:
            ends, bound = ("begin", low) if value < low else ("end", high)
            yield f"{name} = {value:.3g}{unit}, shots {ends} at {bound:.3g}{unit}"


def bounds_of_shots(shot: ShotAtShield) -> Mapping[str, tuple[Metre, Metre]]:
    """The smallest and the largest sphere, wall and stand-off for which there are shots, all else as in the shot."""
    limits = _limits()
    (thin, thick), (near, far) = limits["d/t_b"], limits["S/d"]
    bumper, space, diameter = shot.shield.bumper_thickness, shot.shield.stand_off, shot.projectile_diameter
    return {
        "projectile_diameter": (max(thin * bumper, space / far), min(thick * bumper, space / near)),
        "wall_thickness": (1e-3 * limits["t_w"][0], 1e-3 * limits["t_w"][1]),
        "stand_off": (near * diameter, far * diameter),
    }


def _ratios(shot: ShotAtShield) -> dict[tuple[str, str], float]:
    """What a shot is compared by with the range of the published ones, by name and unit."""
    return {
        ("d/t_b", ""): shot.projectile_diameter / shot.shield.bumper_thickness,
        ("S/d", ""): shot.shield.stand_off / shot.projectile_diameter,
        ("t_w", " mm"): 1e3 * shot.shield.wall_thickness,
        ("v", " km/s"): 1e-3 * shot.speed,
        ("angle", " deg"): math.degrees(shot.obliquity),
    }


@cache
def _limits() -> Mapping[str, tuple[float, float]]:
    """The smallest and the largest of each ratio among the published shots."""
    ratios = [_ratios(shot.as_shot()) for shot in published().shots]
    columns = {name: [of_shot[name, unit] for of_shot in ratios] for name, unit in ratios[0]}
    return {name: (min(column), max(column)) for name, column in columns.items()}
