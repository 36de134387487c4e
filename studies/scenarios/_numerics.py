"""The numerics that every scenario shares: the parameters, what a recipe fills in, and what the solver gets.

A scenario's parameters inherit ``Numerics``; its ``fill`` passes through ``filled_numerics``, its ``check`` adds
``check_numerics``, and its ``build`` hands ``**numerics(given)`` to ``Problem``.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from solver.units import Dimensionless, PerSecond, Second
from studies.scenarios._fields import described, explained, label
from studies.values.errors import Finding
from studies.values.recipes import RECIPES, RecipeName, SchemeName, Shape, StepRuleName, Tension

if TYPE_CHECKING:
    from solver.problem import Contact

BY_RECIPE = "by default that of the recipe"


@dataclass(frozen=True, kw_only=True)
class Numerics:
    """Numerical parameters of every scenario; what is left out follows from ``recipe``."""

    recipe: RecipeName = label(
        "preset for the numerical parameters that are left out", default="whipple"
    )
    shape: Shape | None = explained(f"shape functions; {BY_RECIPE}", default=None)
    scheme: SchemeName | None = explained(
        f"which nodal velocity strains the particles, and when in the step; {BY_RECIPE}",
        default=None,
    )
    particles_per_cell: int | None = described(
        f"particles per cell along each direction; {BY_RECIPE}", 1, 6, default=None
    )
    viscosity_linear: Dimensionless | None = described(
        f"linear artificial viscosity; {BY_RECIPE}", 0.0, 2.0, default=None
    )
    viscosity_quadratic: Dimensionless | None = described(
        f"quadratic artificial viscosity; {BY_RECIPE}", 0.0, 10.0, default=None
    )
    courant: Dimensionless | None = described(
        f"part of a cell that a signal may cross in a step; {BY_RECIPE}", 0.01, 0.9, default=None
    )
    step_rule: StepRuleName | None = explained(
        "what the Courant number limits: signals through the matter (acoustic; how far matter moves is limited by "
        f"travel), or through the grid, the speed of the particle on top (convective); {BY_RECIPE}",
        default=None,
    )
    travel: Dimensionless | None = described(
        f"largest part of a cell that a particle moves in a step; {BY_RECIPE}",
        0.01,
        1.0,
        default=None,
    )
    damping_rate: PerSecond | None = described(
        f"rate at which the part of a velocity that its neighbours do not share decays; {BY_RECIPE}",
        0.0,
        1e12,
        default=None,
    )
    damping_order: int | None = described(
        f"what damping leaves alone: 1 is the particle-in-cell update, 2 is XPIC; {BY_RECIPE}",
        1,
        2,
        default=None,
    )
    tension: Tension | None = explained(
        f"tensile floor at the spall strength, shrinking with temperature, or none; {BY_RECIPE}",
        default=None,
    )
    contact: Literal["none", "bardenhagen"] = explained(
        "bodies share one velocity field, or have their own and meet on the nodes", default="none"
    )
    friction: Dimensionless = described(
        "Coulomb friction of bodies in contact", 0.0, 10.0, default=0.0
    )
    fixed_dt: Second | None = described(
        "constant time step instead of the stable one, for comparisons", 1e-15, 1e-3, default=None
    )


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
        "shape": _shape(given),
        "scheme": Scheme[given.scheme.upper()],
        "viscosity": ArtificialViscosity(given.viscosity_linear, given.viscosity_quadratic),
        "courant": given.courant,
        "step_rule": StepRule[given.step_rule.upper()],
        "travel": given.travel,
        "damping": Damping(given.damping_rate, given.damping_order),
        "contact": _contact(given),
        "fixed_dt": given.fixed_dt,
    }


def _shape(given: Numerics) -> Any:
    if given.shape == "gimp":
        from solver.shapes.gimp import Gimp

        return Gimp(half=0.5 / particles_per_cell(given))
    if given.shape == "quadratic-bspline":
        from solver.shapes.quadratic_bspline import QuadraticBSpline

        return QuadraticBSpline()
    from solver.shapes.linear import Linear

    return Linear()


def _contact(given: Numerics) -> "Contact | None":
    from solver.problem import Contact

    return Contact(given.friction) if given.contact == "bardenhagen" else None
