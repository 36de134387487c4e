"""The method that computes a run, and what each cannot do."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Self

from solver.steppers import methods
from solver.units import Described, Dimensionless
from studies.quantities.findings import Finding
from studies.quantities.parameters import Choice, Value

# Spacings within which particles of two solids repel each other: ``solver/methods/sph/contact.py``.
REPULSION = 1.5


def among(*names: str) -> Choice:
    """The choice of one of some methods, of those that are there."""
    return Choice(lambda: [name for name in names if name in methods()])


@dataclass(frozen=True, kw_only=True)
class MethodChoice:
    """The method of a scenario, and the parameters of smoothed particles; a subclass offers a choice of methods."""

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

    @property
    def is_on_grid(self) -> bool:
        """Whether particles meet on a grid, with its shape functions."""
        return self.method == "mpm"

    @property
    def is_smoothed(self) -> bool:
        """Whether smoothed particles compute a run, or a part of it."""
        return self.method in ("sph", "sph-fem")

    @property
    def is_meshed(self) -> bool:
        """Whether hexahedra compute a run, or a part of it."""
        return self.method in ("fem", "sph-fem")

    @property
    def is_coupled(self) -> bool:
        """Whether hexahedra surround the smoothed particles of a run."""
        return self.method == "sph-fem"

    def filled(self) -> Self:
        """The same method, with None for what goes with another one."""
        return replace(self, artificial_stress=self.artificial_stress if self.is_smoothed else None)

    def check(self, values: Mapping[str, Value], contacts: Sequence[str] = ("none",)) -> list[Finding]:
        """Findings on filled parameters that the method cannot compute; ``contacts`` are those of its particles."""
        if self.is_on_grid:
            return []
        refused = (
            (self.is_smoothed and values.get("wall") == "unilateral", "wall", "set wall to symmetric"),
            (self.is_meshed and values.get("section") == "round", "section", "set section to square"),
            (values.get("geometry") == "axisymmetric", "geometry", "set geometry to quarter"),
            (values.get("edges") == "absorbing", "edges", "set edges to fixed or free"),
            (values.get("contact") not in (*contacts, None), "contact", f"set contact to {' or '.join(contacts)}"),
            (values.get("scheme") != "musl", "scheme", "leave scheme out"),
            (bool(values.get("damping_rate")), "damping_rate", "leave damping_rate out"),
            (values.get("debris") == "retire", "debris", "set debris to follow"),
        )
        return [
            Finding(name, str(values.get(name)), f"a value that method {self.method} computes", cure)
            for is_refused, name, cure in refused
            if is_refused
        ]


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
