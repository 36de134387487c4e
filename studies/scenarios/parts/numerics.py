"""The numerics that every scenario shares: the parameters, the choices of a recipe, and the arguments of the solver."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeVar

from solver.registry import entries
from solver.units import Described, Dimensionless, FromMaterial, PerSecond, Second, marked
from studies.quantities.files import MOST_FRAMES
from studies.quantities.findings import Finding
from studies.quantities.numerical_defaults import FEW_PARTICLES, RECIPES, Recipe, RecipeName, SchemeName, StepRuleName
from studies.quantities.parameters import Choice
from studies.quantities.units import readable, round_quantity
from studies.scenarios.parts.method import ON_GRID, MethodChoice, is_on_grid, is_smoothed

if TYPE_CHECKING:
    from solver.problem import ArtificialViscosity, Smoothing

ContactName = Literal["none", "bardenhagen", "thesis", "gap"]
# The criterion (``solver.problem.Criterion``) of each contact on the grid.
CRITERIA = {"bardenhagen": "STEP", "thesis": "MAPPED", "gap": "GAP"}
BY_RECIPE = "by default that of the recipe"

# Of smoothed particles in place of a recipe's, which is that of cells: Monaghan (1992), section 4.1.
PAIR_LINEAR, PAIR_QUADRATIC = 1.0, 2.0
# Of contact between solids, of rho c^2: faces of two lattices press on each other with 5 to 7 times this at a distance
# of one spacing and with 0.1 to 0.2 times at one and a half: at 100 to 300 m/s (rho c v / 2) they meet at 1.1 to
# 1.3. Copper bars come as near as 0.7 at 2 km/s and pass through each other at 6 km/s: no contact of impacts.
STIFFNESS = 0.01


def shapes() -> Mapping[str, Any]:
    """Shape functions by name."""
    return entries("solver.grid.shapes", "SHAPE")


def tensions() -> Mapping[str, Any]:
    """Rules of tension by name."""
    return entries("solver.matter.tension", "TENSION")


def has_stable_step(parameters: Any) -> bool:
    """Whether the time step of a run follows from its state."""
    return parameters.fixed_dt is None


def has_tensile_limit(run: Any) -> bool:
    """Whether a material has the constants of a rule of tension; ``run`` has parameters and resolved materials."""
    records = [entry.record for entry in tensions().values()]
    paths = [mark.path for record in records for mark in marked(record, FromMaterial).values()]
    return any(_states(material, path) for material in run.materials.values() for path in paths)


def has_melting(run: Any) -> bool:
    """Whether a material melts."""
    return any(_states(each, "thermal.melt_temperature") for each in run.materials.values())


ThermalSoftening = Annotated[
    bool, Described("whether temperature softens and melting takes all strength", acts=has_melting)
]
GridOffset = Annotated[
    Dimensionless,
    Described(
        "shift of the grid against the bodies along the line of flight, in cells: it changes the mesh error alone",
        0.0,
        1.0,
    ),
]


def _states(material: Mapping[str, Any], path: str) -> bool:
    section, _, name = path.partition(".")
    return material.get(section, {}).get(name) is not None


@dataclass(frozen=True, kw_only=True)
class Numerics:
    """Numerical parameters of every scenario; what is left out follows from ``recipe``.

    The number of particles that is left out follows from the geometry first (``quantities.numerical_defaults``).
    """

    recipe: Annotated[RecipeName, Described("preset for the numerical parameters that are left out", label=True)] = (
        "whipple"
    )
    shape: Annotated[str | None, Choice(shapes), Described(f"shape functions; {BY_RECIPE}", acts=is_on_grid)] = None
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
        Dimensionless | None,
        Described(f"part of a cell that a signal may cross in a step; {BY_RECIPE}", 0.01, 0.9, acts=has_stable_step),
    ] = None
    step_rule: Annotated[
        StepRuleName | None,
        Described(
            "what the Courant number limits: signals through the matter (acoustic; how far matter moves is limited by "
            f"travel), or through the grid, the speed of the particle on top (convective); {BY_RECIPE}",
            acts=lambda parameters: is_on_grid(parameters) and has_stable_step(parameters),
        ),
    ] = None
    travel: Annotated[
        Dimensionless | None,
        Described(
            f"largest part of a cell that a particle moves in a step; {BY_RECIPE}", 0.01, 1.0, acts=has_stable_step
        ),
    ] = None
    damping_rate: Annotated[
        PerSecond | None,
        Described(
            f"rate at which the part of a velocity that its neighbours do not share decays; {BY_RECIPE}", 0.0, 1e12
        ),
    ] = None
    damping_order: Annotated[
        int | None,
        Described(
            f"order of the damping: 1 is the particle-in-cell update, 2 is XPIC; {BY_RECIPE}",
            1,
            2,
            acts=lambda parameters: bool(parameters.damping_rate),
        ),
    ] = None
    tension: Annotated[
        str | None,
        Choice(tensions),
        Described(f"rule for the lowest pressure that matter sustains; {BY_RECIPE}", acts=has_tensile_limit),
    ] = None
    jaumann: Annotated[
        bool,
        Described(
            "whether stress turns with the matter (Jaumann's rate), or its components stay as they are in space",
            neutral=True,
        ),
    ] = True
    contact: Annotated[
        ContactName,
        Described(
            "bodies share one velocity field, or have separate fields with contact on the nodes: where their "
            "surfaces meet (gap), where they approach (bardenhagen), by the criterion printed in the thesis (thesis)"
        ),
    ] = "none"
    friction: Annotated[Dimensionless, Described("Coulomb friction of bodies in contact", 0.0, 10.0, neutral=True)] = (
        0.0
    )
    fixed_dt: Annotated[
        Second | None, Described("constant time step instead of the stable one, for comparisons", 1e-15, 1e-3)
    ] = None
    film_interval: Annotated[
        Second | None,
        Described(
            "time between two frames of a film, where one is kept; a thousandth of the run at least, a 48th by default",
            1e-15,
            1.0,
            label=True,
        ),
    ] = None

    def filled(self, *, few: bool = False, method: MethodChoice = ON_GRID) -> Self:
        """The parameters with every one that was left out, from the recipe.

        But for the particles where ``few`` do, and for the viscosity of a method that smooths particles.
        """
        preset = RECIPES[self.recipe]
        if few:
            preset = replace(preset, particles_per_cell=FEW_PARTICLES)
        if is_smoothed(method):
            preset = replace(preset, viscosity_linear=PAIR_LINEAR, viscosity_quadratic=PAIR_QUADRATIC)
        return filled_from(self, preset)

    def check(self, end_time: float | None, method: MethodChoice = ON_GRID) -> list[Finding]:
        """Friction belongs to contact on the grid; a film has a bounded number of frames."""
        findings = []
        if self.friction > 0.0 and self.contact not in CRITERIA:
            limit = "0 for bodies without contact on the grid"
            cure = "leave friction out" if is_smoothed(method) else "set contact to bardenhagen"
            findings.append(Finding("friction", f"{self.friction:g}", limit, cure))
        least = round_quantity((end_time or 0.0) / MOST_FRAMES)
        if self.film_interval is not None and self.film_interval < least:
            limit = f"at least a thousandth of the run, {readable(least, 's')}"
            value = readable(self.film_interval, "s")
            findings.append(Finding("film_interval", value, limit, "give a longer interval"))
        return findings

    @property
    def choices(self) -> Recipe:
        """The filled parameters as a recipe: none of them is left out."""
        return Recipe(**{name: getattr(self, name) for name in vars(RECIPES[self.recipe])})

    def mean_step(self, cell: float, *, sound: float, speed: float) -> float:
        """The time step of a run, about (s), from the size of a cell (m) and the speeds of signals and matter (m/s)."""
        recipe = self.choices
        if self.fixed_dt:
            return self.fixed_dt
        if recipe.step_rule == "convective":
            return recipe.courant * cell / (sound + speed)
        return cell * min(recipe.courant / sound, recipe.travel / speed)

    def arguments(self, method: MethodChoice = ON_GRID) -> dict[str, Any]:
        """The arguments of ``Problem`` besides geometry, bodies, faces and time."""
        from solver.matter.tensor import Jaumann, Unturned
        from solver.problem import ArtificialViscosity, Contact, Criterion, Damping, Scheme, StepRule

        recipe = self.choices
        viscosity = ArtificialViscosity(recipe.viscosity_linear, recipe.viscosity_quadratic)
        criterion = CRITERIA.get(self.contact)
        return {
            "shape": shapes()[recipe.shape].make(recipe.particles_per_cell),
            "scheme": Scheme[recipe.scheme.upper()],
            "viscosity": viscosity,
            "courant": recipe.courant,
            "step_rule": StepRule[recipe.step_rule.upper()],
            "travel": recipe.travel,
            "damping": Damping(recipe.damping_rate, recipe.damping_order),
            "stress_rate": Jaumann() if self.jaumann else Unturned(),
            "contact": Contact(self.friction, Criterion[criterion]) if criterion else None,
            "fixed_dt": self.fixed_dt,
            "smoothing": self._smoothing(method, viscosity),
        }

    def _smoothing(self, method: MethodChoice, viscosity: "ArtificialViscosity") -> "Smoothing | None":
        """The numerics of smoothed particles, those of their verification but for the viscosity."""
        from solver.problem import Smoothing

        if not is_smoothed(method):
            return None
        stiffness = STIFFNESS if str(self.contact) == "repulsion" else 0.0
        return Smoothing(viscosity=viscosity, tensile=method.artificial_stress, stiffness=stiffness)


Parameters = TypeVar("Parameters")


def filled_from(parameters: Parameters, preset: Any) -> Parameters:
    """The parameters with those that were left out taken from a record of some of them."""
    absent = {name: value for name, value in vars(preset).items() if getattr(parameters, name) is None}
    return replace(parameters, **absent)  # type: ignore[type-var]
