"""The method that computes a run, and what each cannot do."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Self

from solver.steppers import methods
from solver.units import Described, Dimensionless
from studies.quantities.findings import Finding
from studies.quantities.parameters import Choice, flat

# Spacings within which particles of two solids repel each other: ``solver/methods/sph/contact.py``.
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


def among(*names: str) -> Choice:
    """The choice of one of some methods, of those that are there."""
    return Choice(lambda: [name for name in names if name in methods()])


@dataclass(frozen=True, kw_only=True)
class MethodChoice:
    """The method of a scenario, with what smoothed particles take; a scenario with a choice offers its own."""

    artificial_stress: Annotated[
        Dimensionless | None,
        Described(
            "artificial stress of smoothed particles, of each principal stress that pulls: it keeps them from clumping "
            "in tension; 0.3 in Gray, Monaghan and Swift (2001), by default none",
            0.0,
            1.0,
        ),
    ] = 0.0
    method: str = "mpm"

    def filled(self) -> Self:
        """The same method, with None for what goes with another one."""
        return replace(self, artificial_stress=self.artificial_stress if is_smoothed(self) else None)


ON_GRID = MethodChoice()


@dataclass(frozen=True, kw_only=True)
class ParticleMethod(MethodChoice):
    """The choice of a method for particles alone."""

    method: Annotated[
        str,
        among("mpm", "sph"),
        Described(
            "material points on a grid (mpm), or the same particles smoothed over their neighbours (sph), in three "
            "dimensions, whose viscosity is 1 and 2 unless it is stated"
        ),
    ] = "mpm"


def check_method(parameters: Any, contacts: Sequence[str] = ("none",)) -> list[Finding]:
    """Findings on what the method of filled parameters cannot compute; ``contacts`` are those of its particles."""
    if is_on_grid(parameters.method):
        return []
    given, method = flat(parameters).get, parameters.method.method
    smoothed, meshed = is_smoothed(parameters.method), is_meshed(parameters.method)
    refused = (
        (smoothed and given("wall") == "unilateral", "wall", "set wall to symmetric"),
        (meshed and given("section") == "round", "section", "set section to square"),
        (given("geometry") == "axisymmetric", "geometry", "set geometry to quarter"),
        (given("edges") == "absorbing", "edges", "set edges to fixed or free"),
        (given("contact") not in (*contacts, None), "contact", f"set contact to {' or '.join(contacts)}"),
        (given("scheme") != "musl", "scheme", "leave scheme out"),
        (bool(given("damping_rate")), "damping_rate", "leave damping_rate out"),
        (given("debris") == "retire", "debris", "set debris to follow"),
    )
    return [
        Finding(name, str(given(name)), f"a value that method {method} computes", cure)
        for is_there, name, cure in refused
        if is_there
    ]
