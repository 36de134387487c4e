"""The numerics that every scenario shares: the parameters, what a recipe fills in, and what the solver gets.

A scenario's parameters inherit ``Numerics``; its ``fill`` passes through ``filled_numerics``, its ``check`` adds
``check_numerics``, and its ``build`` hands ``**numerics(given)`` to ``Problem``.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

from solver.registry import entries
from solver.units import Described, Dimensionless, PerSecond, Second
from studies.values.errors import Finding
from studies.values.parameters import Choice
from studies.values.recipes import RECIPES, RecipeName, SchemeName, StepRuleName

if TYPE_CHECKING:
    from solver.problem import Contact

BY_RECIPE = "by default that of the recipe"


def shapes() -> Mapping[str, Any]:
    """Shape functions by name."""
    return entries("solver.shapes", "SHAPE")


def tensions() -> Mapping[str, Any]:
    """Rules of tension by name."""
    return entries("solver.tension", "TENSION")


@dataclass(frozen=True, kw_only=True)
class Numerics:
    """Numerical parameters of every scenario; what is left out follows from ``recipe``."""

    recipe: Annotated[
        RecipeName, Described("preset for the numerical parameters that are left out", label=True)
    ] = "whipple"
    shape: Annotated[str | None, Choice(shapes), Described(f"shape functions; {BY_RECIPE}")] = None
    scheme: Annotated[
        SchemeName | None,
        Described(f"which nodal velocity strains the particles, and when in the step; {BY_RECIPE}"),
    ] = None
    particles_per_cell: Annotated[
        int | None, Described(f"particles per cell along each direction; {BY_RECIPE}", 1, 6)
    ] = None
    viscosity_linear: Annotated[
        Dimensionless | None, Described(f"linear artificial viscosity; {BY_RECIPE}", 0.0, 2.0)
    ] = None
    viscosity_quadratic: Annotated[
        Dimensionless | None, Described(f"quadratic artificial viscosity; {BY_RECIPE}", 0.0, 10.0)
    ] = None
    courant: Annotated[
        Dimensionless | None,
        Described(f"part of a cell that a signal may cross in a step; {BY_RECIPE}", 0.01, 0.9),
    ] = None
    step_rule: Annotated[
        StepRuleName | None,
        Described(
            "what the Courant number limits: signals through the matter (acoustic; how far matter moves is limited by "
            f"travel), or through the grid, the speed of the particle on top (convective); {BY_RECIPE}"
        ),
    ] = None
    travel: Annotated[
        Dimensionless | None,
        Described(
            f"largest part of a cell that a particle moves in a step; {BY_RECIPE}", 0.01, 1.0
        ),
    ] = None
    damping_rate: Annotated[
        PerSecond | None,
        Described(
            f"rate at which the part of a velocity that its neighbours do not share decays; {BY_RECIPE}",
            0.0,
            1e12,
        ),
    ] = None
    damping_order: Annotated[
        int | None,
        Described(
            f"what damping leaves alone: 1 is the particle-in-cell update, 2 is XPIC; {BY_RECIPE}",
            1,
            2,
        ),
    ] = None
    tension: Annotated[
        str | None,
        Choice(tensions),
        Described(
            f"tensile floor at the spall strength, shrinking with temperature, or none; {BY_RECIPE}"
        ),
    ] = None
    contact: Annotated[
        Literal["none", "bardenhagen"],
        Described("bodies share one velocity field, or have their own and meet on the nodes"),
    ] = "none"
    friction: Annotated[
        Dimensionless, Described("Coulomb friction of bodies in contact", 0.0, 10.0)
    ] = 0.0
    fixed_dt: Annotated[
        Second | None,
        Described("constant time step instead of the stable one, for comparisons", 1e-15, 1e-3),
    ] = None


Given = TypeVar("Given", bound=Numerics)


def filled_numerics(given: Given) -> Given:
    """The parameters with every numerical one that was left out taken from the recipe."""
    return filled_from(given, RECIPES[given.recipe])


def filled_from(given: Given, preset: Any) -> Given:
    """The parameters with those that were left out taken from a record of some of them."""
    absent = {name: value for name, value in vars(preset).items() if getattr(given, name) is None}
    return replace(given, **absent) if absent else given


def check_numerics(given: Numerics) -> list[Finding]:
    """Friction belongs to contact."""
    if given.friction > 0.0 and given.contact == "none":
        limit = "0 for bodies that share one velocity field"
        return [Finding("friction", f"{given.friction:g}", limit, "set contact to bardenhagen")]
    return []


def particles_per_cell(given: Numerics) -> int:
    """Particles per cell along each direction."""
    count = filled_numerics(given).particles_per_cell
    assert count is not None
    return count


def mean_step(given: Numerics, cell: float, *, sound: float, speed: float) -> float:
    """A run's time step, about, for cells of a size (m), from its mean signal speed and that of its particles, s."""
    given = filled_numerics(given)
    assert given.courant is not None
    assert given.travel is not None
    if given.fixed_dt:
        return given.fixed_dt
    if given.step_rule == "convective":
        return given.courant * cell / (sound + speed)
    return cell * min(given.courant / sound, given.travel / speed)


def numerics(given: Numerics) -> dict[str, Any]:
    """What ``Problem`` takes besides geometry, bodies, faces and time."""
    from solver.problem import ArtificialViscosity, Damping, Scheme, StepRule

    given = filled_numerics(given)
    assert given.scheme is not None
    assert given.viscosity_linear is not None
    assert given.viscosity_quadratic is not None
    assert given.step_rule is not None
    assert given.damping_rate is not None
    assert given.damping_order is not None
    return {
        "shape": shapes()[str(given.shape)].make(particles_per_cell(given)),
        "scheme": Scheme[given.scheme.upper()],
        "viscosity": ArtificialViscosity(given.viscosity_linear, given.viscosity_quadratic),
        "courant": given.courant,
        "step_rule": StepRule[given.step_rule.upper()],
        "travel": given.travel,
        "damping": Damping(given.damping_rate, given.damping_order),
        "contact": _contact(given),
        "fixed_dt": given.fixed_dt,
    }


def _contact(given: Numerics) -> "Contact | None":
    from solver.problem import Contact

    return Contact(given.friction) if given.contact == "bardenhagen" else None
