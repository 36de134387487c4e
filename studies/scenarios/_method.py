"""The method that computes an impact, and what each cannot do."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

from solver.units import Described
from studies.values.errors import Finding

if TYPE_CHECKING:
    from solver.problem import Smoothing


@dataclass(frozen=True, kw_only=True)
class ByMethod:
    """The choice of a method."""

    method: Annotated[
        Literal["mpm", "sph"],
        Described(
            "material points on a grid (mpm), or the same particles smoothed over their neighbours (sph), in three "
            "dimensions",
            neutral=True,
        ),
    ] = "mpm"


def is_smoothed(parameters: Any) -> bool:
    """Whether smoothed particles compute a run."""
    return getattr(parameters, "method", "mpm") == "sph"


def smoothing(parameters: Any) -> "Smoothing | None":
    """The numerics of smoothed particles, those of their verification; None for other methods."""
    from solver.problem import Smoothing
    from solver.sph.smoothing import CubicSpline

    return Smoothing(CubicSpline()) if is_smoothed(parameters) else None


def check_method(parameters: Any) -> list[Finding]:
    """Findings on what a method cannot compute."""
    if not is_smoothed(parameters):
        return []
    refused = (
        (parameters.geometry == "axisymmetric", "geometry", "set geometry to quarter or half"),
        (parameters.edges == "absorbing", "edges", "set edges to fixed or free"),
        (parameters.contact != "none", "contact", "set contact to none: bodies meet in the sums"),
        (parameters.scheme not in (None, "musl"), "scheme", "leave scheme out"),
        (bool(parameters.damping_rate), "damping_rate", "leave damping_rate out"),
        (parameters.debris == "retire", "debris", "set debris to follow"),
    )
    return [
        Finding(name, str(getattr(parameters, name)), "a value that method sph computes", cure)
        for is_there, name, cure in refused
        if is_there
    ]
