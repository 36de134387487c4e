"""The numerics that every scenario shares: the parameters, the choices of a recipe, and what the solver takes."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Literal, Self, TypeVar

from solver.registry import entries
from solver.units import Described, Dimensionless, FromMaterial, PerSecond, Second, marked
from studies.quantities.files import MOST_FRAMES
from studies.quantities.findings import Finding
from studies.quantities.numerical_defaults import (
    FEW_PARTICLES,
    RECIPES,
    ImpactRecipe,
    Recipe,
    RecipeName,
    SchemeName,
    StepRuleName,
)
from studies.quantities.parameters import Choice
from studies.quantities.units import readable, round_quantity
from studies.scenarios import Materials
from studies.scenarios.parts.method import ON_GRID, MethodChoice

if TYPE_CHECKING:
    from solver.grid.shapes import ShapeEntry
    from solver.matter.tension import TensionEntry
    from solver.problem import Problem
    from studies.materials import Material

ContactName = Literal["none", "bardenhagen", "thesis", "gap"]
# The criterion (``solver.problem.Criterion``) of each contact on the grid.
CRITERIA = {"bardenhagen": "STEP", "thesis": "MAPPED", "gap": "GAP"}
BY_RECIPE = "by default that of the recipe"
OF_TWO_BODIES = ("contact", "friction")  # parameters of which a single body has no use

# Of smoothed particles in place of a recipe's, which is that of cells: Monaghan (1992), section 4.1.
PAIR_LINEAR, PAIR_QUADRATIC = 1.0, 2.0
# Of contact between solids, of rho c^2: faces of two lattices press on each other with 5 to 7 times this at a distance
# of one spacing and with 0.1 to 0.2 times at one and a half: at 100 to 300 m/s (rho c v / 2) they meet at 1.1 to
# 1.3. Copper bars come as near as 0.7 at 2 km/s and pass through each other at 6 km/s: no contact of impacts.
STIFFNESS = 0.01


def shapes() -> Mapping[str, "ShapeEntry"]:
    """Shape functions by name."""
    return entries("solver.grid.shapes", "SHAPE")


def tensions() -> Mapping[str, "TensionEntry"]:
    """Rules of tension by name."""
    return entries("solver.matter.tension", "TENSION")


def softens(stated: bool | None, materials: Iterable["Material"]) -> bool | None:
    """What is stated about thermal softening; None where no material melts."""
    return stated if any(material.thermal.melt_temperature is not None for material in materials) else None


ThermalSoftening = Annotated[bool | None, Described("whether temperature softens and melting takes all strength")]
GridOffset = Annotated[
    Dimensionless,
    Described(
        "shift of the grid against the bodies along the line of flight, in cells: it changes the mesh error alone",
        0.0,
        1.0,
    ),
]


@dataclass(frozen=True, kw_only=True)
class Numerics:
    """Numerical parameters of every scenario; what is left out follows from the geometry and ``recipe``."""

    recipe: Annotated[RecipeName, Described("preset for the numerical parameters that are left out")] = "whipple"
    shape: Annotated[str | None, Choice(shapes), Described(f"shape functions; {BY_RECIPE}")] = None
    scheme: Annotated[
        SchemeName | None,
        Described(f"nodal velocity that strains the particles, and its time in the step; {BY_RECIPE}"),
    ] = None
    particles_per_cell: Annotated[
        int | None,
        Described(f"particles per cell along each direction; {FEW_PARTICLES} in three dimensions, {BY_RECIPE}", 1, 6),
    ] = None
    viscosity_linear: Annotated[
        Dimensionless | None, Described(f"linear artificial viscosity; {BY_RECIPE}", 0.0, 2.0)
    ] = None
    viscosity_quadratic: Annotated[
        Dimensionless | None, Described(f"quadratic artificial viscosity; {BY_RECIPE}", 0.0, 10.0)
    ] = None
    courant: Annotated[
        Dimensionless | None, Described(f"part of a cell that a signal may cross in a step; {BY_RECIPE}", 0.01, 0.9)
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
        Described(f"largest part of a cell that a particle moves in a step; {BY_RECIPE}", 0.01, 1.0),
    ] = None
    damping_rate: Annotated[
        PerSecond | None,
        Described(
            f"rate at which the part of a velocity that its neighbours do not share decays; {BY_RECIPE}", 0.0, 1e12
        ),
    ] = None
    damping_order: Annotated[
        int | None, Described(f"order of the damping: 1 is the particle-in-cell update, 2 is XPIC; {BY_RECIPE}", 1, 2)
    ] = None
    tension: Annotated[
        str | None, Choice(tensions), Described(f"rule for the lowest pressure that matter sustains; {BY_RECIPE}")
    ] = None
    jaumann: Annotated[
        bool | None,
        Described("whether stress turns with the matter (Jaumann's rate), or its components stay as they are in space"),
    ] = True
    contact: Annotated[
        ContactName | None,
        Described(
            "bodies share one velocity field, or have separate fields with contact on the nodes: where their "
            "surfaces meet (gap), where they approach (bardenhagen), by the criterion printed in the thesis (thesis)"
        ),
    ] = "none"
    friction: Annotated[Dimensionless | None, Described("Coulomb friction of bodies in contact", 0.0, 10.0)] = 0.0
    fixed_dt: Annotated[
        Second | None, Described("constant time step instead of the stable one, for comparisons", 1e-15, 1e-3)
    ] = None
    film_interval: Annotated[
        Second | None,
        Described(
            "time between two frames of a film, where one is kept; a thousandth of the run at least, a 48th by default",
            1e-15,
            1.0,
        ),
    ] = None

    def filled(
        self, materials: Materials, *, few: bool = False, method: MethodChoice = ON_GRID, unused: tuple[str, ...] = ()
    ) -> Self:
        """The parameters with those that were left out taken from the recipe, and None for those that do not act.

        With ``few``, the number of particles is that of three dimensions; ``unused`` are parameters of which a set-up
        has no use. A rule of tension acts where it needs no constants of the material, or a material has them.
        """
        preset = RECIPES[self.recipe]
        if few:
            preset = replace(preset, particles_per_cell=FEW_PARTICLES)
        if method.is_smoothed:
            preset = replace(preset, viscosity_linear=PAIR_LINEAR, viscosity_quadratic=PAIR_QUADRATIC)
        filled = filled_from(self, preset)
        record = tensions()[filled.choices.tension].record
        constants = [constant for material in materials.values() for constant in material.taken(record).values()]
        if marked(record, FromMaterial) and not any(constant is not None for constant in constants):
            unused = (*unused, "tension")
        return filled.acting(*unused, method=method)

    def acting(self, *unused: str, method: MethodChoice = ON_GRID) -> Self:
        """Filled parameters with None for those that do not act beside the others, and for ``unused`` ones."""
        idle = set(unused)
        if self.fixed_dt is not None:
            idle |= {"courant", "step_rule", "travel"}
        if not method.is_on_grid:
            idle |= {"shape", "step_rule"}
        if not self.damping_rate:
            idle.add("damping_order")
        if self.friction and self.contact not in CRITERIA:
            idle.discard("friction")  # ``check`` refuses it
        if self.contact in CRITERIA and not method.is_on_grid:
            idle.discard("contact")  # the method refuses it
        return replace(self, **dict.fromkeys(idle))  # type: ignore[arg-type]

    def check(self, end_time: float | None, method: MethodChoice = ON_GRID) -> list[Finding]:
        """Friction belongs to contact on the grid; a film has a bounded number of frames."""
        findings = []
        if self.friction and self.contact not in CRITERIA:
            limit = "0 for bodies without contact on the grid"
            cure = "leave friction out" if method.is_smoothed else "set contact to bardenhagen"
            findings.append(Finding("friction", f"{self.friction:g}", limit, cure))
        least = round_quantity((end_time or 0.0) / MOST_FRAMES)
        if self.film_interval is not None and self.film_interval < least:
            limit = f"at least a thousandth of the run, {readable(least, 's')}"
            value = readable(self.film_interval, "s")
            findings.append(Finding("film_interval", value, limit, "give a longer interval"))
        return findings

    @property
    def choices(self) -> Recipe:
        """The filled parameters as a recipe: those that do not act are as it has them."""
        recipe = RECIPES[self.recipe]
        acting = {name: value for name in vars(recipe) if (value := getattr(self, name)) is not None}
        return replace(recipe, **acting)

    def mean_step(self, cell: float, *, sound: float, speed: float) -> float:
        """The time step of a run, about (s), from the size of a cell (m) and the speeds of signals and matter (m/s)."""
        recipe = self.choices
        if self.fixed_dt:
            return self.fixed_dt
        if recipe.step_rule == "convective":
            return recipe.courant * cell / (sound + speed)
        return cell * min(recipe.courant / sound, recipe.travel / speed)

    def applied_to(self, problem: "Problem", method: MethodChoice = ON_GRID) -> "Problem":
        """The problem with these numerics; those of smoothed particles are as verified, but for the viscosity."""
        from solver.matter.tensor import Jaumann, Unturned
        from solver.problem import ArtificialViscosity, Contact, Criterion, Damping, Scheme, Smoothing, StepRule

        recipe, smoothing = self.choices, None
        viscosity = ArtificialViscosity(recipe.viscosity_linear, recipe.viscosity_quadratic)
        if method.is_smoothed:
            stiffness = STIFFNESS if str(self.contact) == "repulsion" else 0.0
            smoothing = Smoothing(viscosity=viscosity, tensile=method.artificial_stress or 0.0, stiffness=stiffness)
        criterion = CRITERIA.get(self.contact or "none")
        return replace(
            problem,
            shape=shapes()[recipe.shape].make(recipe.particles_per_cell),
            scheme=Scheme[recipe.scheme.upper()],
            viscosity=viscosity,
            courant=recipe.courant,
            step_rule=StepRule[recipe.step_rule.upper()],
            travel=recipe.travel,
            damping=Damping(recipe.damping_rate, recipe.damping_order),
            stress_rate=Unturned() if self.jaumann is False else Jaumann(),
            contact=Contact(self.friction or 0.0, Criterion[criterion]) if criterion else None,
            fixed_dt=self.fixed_dt,
            smoothing=smoothing,
        )


Parameters = TypeVar("Parameters")


def filled_from(parameters: Parameters, preset: Recipe | ImpactRecipe) -> Parameters:
    """The parameters with those that were left out taken from a recipe."""
    absent = {name: value for name, value in vars(preset).items() if getattr(parameters, name) is None}
    return replace(parameters, **absent)  # type: ignore[type-var]
