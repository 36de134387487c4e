"""The method that computes an impact, and what each cannot do."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

from solver.units import Described, Dimensionless
from studies.values.errors import Finding

if TYPE_CHECKING:
    from solver.problem import ArtificialViscosity, Smoothing

# Of smoothed particles in place of a recipe's, which is that of cells: Monaghan (1992), section 4.1.
PAIR_LINEAR, PAIR_QUADRATIC = 1.0, 2.0
# Of contact between solids, of rho c^2: faces of two lattices press on each other with 5 to 7 times this at a distance
# of one spacing and with 0.1 to 0.2 times at one and a half: at 100 to 300 m/s (rho c v / 2) they meet at 1.1 to
# 1.3. Copper bars come as near as 0.7 at 2 km/s and pass through each other at 6 km/s: no contact of impacts.
STIFFNESS = 0.01
# Spacings within which particles of two solids repel each other: ``solver.sph.contact``.
REPULSION = 1.5


def is_smoothed(parameters: Any) -> bool:
    """Whether smoothed particles compute a run, or a part of it."""
    return getattr(parameters, "method", "mpm") in ("sph", "sph-fem")


def is_meshed(parameters: Any) -> bool:
    """Whether hexahedra compute a run, or a part of it."""
    return getattr(parameters, "method", "mpm") in ("fem", "sph-fem")


def is_on_grid(parameters: Any) -> bool:
    """Whether particles meet on a grid, with its shape functions."""
    return getattr(parameters, "method", "mpm") == "mpm"


def is_coupled(parameters: Any) -> bool:
    """Whether elements surround the smoothed particles of a run."""
    return getattr(parameters, "method", "mpm") == "sph-fem"


@dataclass(frozen=True, kw_only=True)
class Smoothed:
    """What smoothed particles take, whatever else a scenario is computed with."""

    artificial_stress: Annotated[
        Dimensionless,
        Described(
            "artificial stress of smoothed particles, of each principal stress that pulls: it keeps them from clumping "
            "in tension; 0.3 in Gray, Monaghan and Swift (2001), by default none",
            0.0,
            1.0,
            neutral=True,
            acts=is_smoothed,
        ),
    ] = 0.0


@dataclass(frozen=True, kw_only=True)
class ByCoupledMethod(Smoothed):
    """The choice of a method where elements may surround the particles."""

    method: Annotated[
        Literal["mpm", "sph", "sph-fem"],
        Described(
            "material points on a grid (mpm), smoothed particles (sph), or these in the projectile and the centre of "
            "the plate, coupled to hexahedra in the rest of it (sph-fem); the latter two in three dimensions",
            neutral=True,
        ),
    ] = "mpm"


@dataclass(frozen=True, kw_only=True)
class ByBarMethod(Smoothed):
    """The choice of a method for a bar."""

    method: Annotated[
        Literal["mpm", "sph", "fem", "sph-fem"],
        Described(
            "material points on a grid (mpm), smoothed particles (sph), hexahedra (fem), or hexahedra in the half away "
            "from the wall, coupled to smoothed particles in the other one (sph-fem); the latter three in three "
            "dimensions, particles with a symmetric wall, and hexahedra with a square section",
            neutral=True,
        ),
    ] = "mpm"


@dataclass(frozen=True, kw_only=True)
class ByMethod(Smoothed):
    """The choice of a method for particles alone."""

    method: Annotated[
        Literal["mpm", "sph"],
        Described(
            "material points on a grid (mpm), or the same particles smoothed over their neighbours (sph), in three "
            "dimensions, whose viscosity is 1 and 2 unless it is stated",
            neutral=True,
        ),
    ] = "mpm"


def smoothing(parameters: Any, viscosity: "ArtificialViscosity") -> "Smoothing | None":
    """The numerics of smoothed particles, those of their verification but for the viscosity; None for other methods."""
    from solver.problem import Smoothing
    from solver.sph.smoothing import CubicSpline

    if not is_smoothed(parameters):
        return None
    stiffness = STIFFNESS if parameters.contact == "repulsion" else 0.0
    return Smoothing(CubicSpline(), viscosity=viscosity, tensile=parameters.artificial_stress, stiffness=stiffness)


def check_method(parameters: Any, contacts: Sequence[str] = ("none",)) -> list[Finding]:
    """Findings on what a method cannot compute; ``contacts`` are those of its particles in the scenario."""
    if not is_smoothed(parameters) and not is_meshed(parameters):
        return []
    of_bar = hasattr(parameters, "wall")
    refused = (
        (of_bar and is_smoothed(parameters) and parameters.wall == "unilateral", "wall", "set wall to symmetric"),
        (of_bar and is_meshed(parameters) and parameters.section == "round", "section", "set section to square"),
        (parameters.geometry == "axisymmetric", "geometry", "set geometry to quarter"),
        (getattr(parameters, "edges", "fixed") == "absorbing", "edges", "set edges to fixed or free"),
        (parameters.contact not in contacts, "contact", f"set contact to {' or '.join(contacts)}"),
        (parameters.scheme not in (None, "musl"), "scheme", "leave scheme out"),
        (bool(parameters.damping_rate), "damping_rate", "leave damping_rate out"),
        (getattr(parameters, "debris", "follow") == "retire", "debris", "set debris to follow"),
    )
    return [
        Finding(name, str(getattr(parameters, name)), f"a value that method {parameters.method} computes", cure)
        for is_there, name, cure in refused
        if is_there
    ]
