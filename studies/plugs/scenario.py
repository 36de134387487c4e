"""A hard projectile cuts a plug out of a clamped plate: Borvik et al. (1999), Int. J. Impact Eng. 22, 855.

The front face of the plate is z = 0, its body stands at z > 0, and the projectile flies along +z with its tip a gap
away from the plate at time zero. The clamp is the outer edge of the grid. Projectile and plate are solids of
revolution; what fills them with particles knows nothing else of them.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Literal, Self

from solver.units import Described, Dimensionless, Metre, MetrePerSecond, Second
from studies.measurements._settings import ImpactSetting
from studies.plugs.coupled_plate import EVEN, coupled_plate, plate_size
from studies.quantities.findings import Finding
from studies.quantities.numerical_defaults import RECIPES
from studies.quantities.parameters import Choice, MaterialName, Plain, flat
from studies.quantities.units import round_quantity
from studies.scenarios import Materials, ObservationRate, Scenario, SetUp, Size
from studies.scenarios.parts.lattice import SECTORS, Faces, Geometry, along_flight, body, lattice, mesh, slab_clamp
from studies.scenarios.parts.matter import (
    HUGONIOT,
    Fracture,
    check_boiling,
    check_constants,
    check_eos,
    elastic_speed,
    failures,
    matter,
)
from studies.scenarios.parts.method import REPULSION, MethodChoice, among
from studies.scenarios.parts.numerics import ContactName, GridOffset, Numerics, ThermalSoftening, shapes, softens
from studies.scenarios.parts.outline import Dimension, Outline, Shape, number

if TYPE_CHECKING:
    import numpy as np

    from solver.matter.laws import Matter
    from solver.problem import Body
    from solver.state import Snapshot
    from studies.materials import Material
    from studies.plugs.plug import PlugView
    from studies.sections.section import SectionOptions

RADIUS = 12.5  # of the plate, in projectile diameters: 500 mm for 20 mm, Borvik et al. (1999), as recalled
CONE = 1.0  # default length of a conical nose, in projectile diameters

# The projectile of the seed has cut its plug when it would have flown 2.7 thicknesses (120 us at 285.4 m/s); slower
# ones need longer.
FLIGHT = 5.0  # thicknesses of the plate that the projectile would fly behind the first touch
FASTEST = 1.25  # speed of the plug over that of the projectile before the impact, at most: room behind the plate
AROUND = 2.0  # cells of grid around what moves
# Half width of the particles in a coupled plate, in projectile diameters: the 47 133 particles of Zhang, Qiang and Gao
# (2011) are 80 layers of 316 in the projectile, and 13 layers of 41 by 41 in the plate, 1 mm apart.
SQUARE = 1.0
# Cells of flight between two observations, in which the first contact is read, and observations of a run at most.
OBSERVED, MOST_OBSERVED = 0.25, 2000
MOMENTS = (1.0 / 3.0, 2.0 / 3.0)  # of the run: sections before the end
REACH = 2.5  # of the sections, in projectile diameters


@dataclass(frozen=True)
class BodyShape:
    """A solid of revolution or a prism about the line of flight, before any method has filled it."""

    role: str  # the parameter that names its material
    begin: float  # along the flight, m
    end: float
    breadth: float  # largest distance from the line of flight, m
    is_round: bool  # a prism of square section where it is not
    nose: str = "blunt"  # of its end
    nose_length: float = 0.0  # m
    speed: float = 0.0  # along the flight, m/s

    @property
    def volume(self) -> float:
        """Volume of the whole solid, m3."""
        area = math.pi * self.breadth**2 if self.is_round else 4.0 * self.breadth**2
        share = {"blunt": 1.0, "conical": 1.0 / 3.0, "hemispherical": 2.0 / 3.0}[self.nose]
        return area * (self.end - self.begin - (1.0 - share) * self.nose_length)

    def radius(self, place: "np.ndarray") -> "np.ndarray":
        """Radius of a round solid at places (n,) along the flight, m."""
        import numpy as np

        if self.nose == "blunt":
            return np.full(np.shape(place), self.breadth)
        part = np.clip((self.end - place) / self.nose_length, 0.0, 1.0)
        shape = part if self.nose == "conical" else np.sqrt(part * (2.0 - part))
        return self.breadth * shape


@dataclass(frozen=True, kw_only=True)
class PluggingFracture(Fracture):
    """What breaks a plate for good."""

    failure: Annotated[str, Choice(failures), Described("failure model of what has constants for it")] = (
        "modified-johnson-cook"
    )


@dataclass(frozen=True, kw_only=True)
class PluggingNumerics(Numerics):
    """Numerics of two bodies that touch."""

    # Splines feel the other body two cells early: docs/recipe.md.
    shape: Annotated[str | None, Choice(shapes), Described("shape functions")] = "gimp"
    particles_per_cell: Annotated[
        int | None, Described("particles per cell along each direction; by default 2, 1 of smoothed ones", 1, 6)
    ] = None
    contact: Annotated[
        Literal[ContactName, "repulsion"] | None,
        Described(
            "bodies share one velocity field, or have separate fields with contact on the nodes: where their "
            "surfaces meet (gap), where they approach (bardenhagen), by the criterion printed in the thesis (thesis); "
            "smoothed particles of different bodies repel each other (repulsion), or meet in their sums (none); by "
            "default gap, and repulsion of smoothed particles"
        ),
    ] = None  # type: ignore[assignment]  # which follows from the method

    def filled_for(self, materials: Materials, method: MethodChoice) -> Self:
        """With the particles, the contact and the viscosity of a method.

        Monaghan's linear viscosity of 1 resists shear as matter with a viscosity of rho c h / 10 does: at 1 mm by 120
        MPa at the 2.5e4 1/s of a band of four spacings, a quarter of what the plate can bear. Particles have that of a
        grid.
        """
        smoothed = method.is_smoothed
        chosen = replace(
            self,
            particles_per_cell=self.particles_per_cell or (1 if smoothed else 2),
            contact=self.contact or ("repulsion" if smoothed else "gap"),
        )
        return chosen.filled(materials).acting(method=method)


@dataclass(frozen=True, kw_only=True)
class CoupledMethod(MethodChoice):
    """The choice of a method where elements may surround the particles."""

    method: Annotated[
        str,
        among("mpm", "sph", "sph-fem"),
        Described(
            "material points on a grid (mpm), smoothed particles (sph), or these in the projectile and the centre of "
            "the plate, coupled to hexahedra in the rest of it (sph-fem); the latter two in three dimensions"
        ),
    ] = "mpm"


@dataclass(frozen=True, kw_only=True)
class Plugging(SetUp[ImpactSetting, "PlugView"]):
    """Parameters of the plugging of a plate."""

    speed: Annotated[MetrePerSecond, Described("impact speed, normal to the plate", 1.0, 2000.0)]
    projectile_diameter: Annotated[Metre, Described("diameter of the projectile", 1e-4, 1.0)] = 20e-3
    projectile_length: Annotated[Metre, Described("length of the projectile, its nose included", 1e-4, 1.0)] = 80e-3
    nose: Annotated[Literal["blunt", "conical", "hemispherical"], Described("nose of the projectile")] = "blunt"
    nose_length: Annotated[
        Metre | None, Described("length of a conical nose, a diameter by default; other noses have none", 1e-5, 1.0)
    ] = None
    plate_thickness: Annotated[Metre, Described("thickness of the plate", 1e-5, 1.0)] = 12e-3
    plate_radius: Annotated[
        Metre | None,
        Described(
            "radius of a round plate, half the width of a square one; by default 12.5 diameters of the projectile",
            1e-4,
            10.0,
        ),
    ] = None
    gap: Annotated[Metre, Described("distance of the tip from the plate at the start", 0.0, 1.0)] = 2e-3
    projectile: Annotated[MaterialName, Described("material of the projectile")] = "arne-elastic"
    target: Annotated[MaterialName, Described("material of the plate")] = "weldox-460-e"
    geometry: Annotated[
        Literal["axisymmetric", "quarter"],
        Described("body of revolution, or a quarter of a square plate in three dimensions"),
    ] = "axisymmetric"
    cells_per_diameter: Annotated[
        Dimensionless, Described("grid cells across the projectile's diameter", 4.0, 512.0)
    ] = 40.0
    end_time: Annotated[
        Second | None,
        Described(
            "end of the run; by default when the projectile would have flown the gap and five thicknesses of the plate",
            1e-9,
            1.0,
        ),
    ] = None
    thermal_softening: ThermalSoftening = True
    offset: GridOffset = 0.0
    fracture: PluggingFracture
    numerics: PluggingNumerics
    method: CoupledMethod

    @property
    def cell(self) -> float:
        """Size of a cell, m."""
        return self.projectile_diameter / self.cells_per_diameter

    @property
    def step(self) -> float:
        """Distance of two particles, m."""
        return self.cell / self.numerics.choices.particles_per_cell

    @property
    def radius(self) -> float:
        """Radius of the plate, m."""
        return self.plate_radius or RADIUS * self.projectile_diameter

    @property
    def length_of_nose(self) -> float:
        """Length of the nose, m; 0 of a blunt one."""
        if self.nose == "conical":
            return self.nose_length or CONE * self.projectile_diameter
        return 0.5 * self.projectile_diameter if self.nose == "hemispherical" else 0.0

    @property
    def end(self) -> float:
        """End of the run, s."""
        return self.end_time or (self.gap + FLIGHT * self.plate_thickness) / self.speed

    @property
    def solids(self) -> tuple[BodyShape, BodyShape]:
        """Projectile and plate."""
        projectile = BodyShape(
            role="projectile",
            begin=-self.gap - self.projectile_length,
            end=-self.gap,
            breadth=0.5 * self.projectile_diameter,
            is_round=True,
            nose=self.nose,
            nose_length=self.length_of_nose,
            speed=self.speed,
        )
        plate = BodyShape(
            role="target",
            begin=0.0,
            end=self.plate_thickness,
            breadth=self.radius,
            is_round=self.geometry == "axisymmetric",
        )
        return projectile, plate

    def filled(self, materials: Materials) -> Self:
        return replace(
            self,
            plate_radius=round_quantity(self.radius),
            end_time=round_quantity(self.end),
            nose_length=round_quantity(self.length_of_nose) if self.nose == "conical" else self.nose_length,
            thermal_softening=softens(self.thermal_softening, materials.values()),
            method=self.method.filled(),
            numerics=self.numerics.filled_for(materials, self.method),
        )

    def check(self, materials: Materials) -> list[Finding]:
        return [
            *self.method.check(flat(self), ("repulsion", "none")),
            *self._check_shape(),
            *self.numerics.check(self.end_time, self.method),
            *self.fracture.check(materials),
            *check_eos(HUGONIOT, materials),
            *check_constants(materials),
            *check_boiling(self.numerics.choices.tension, self.thermal_softening, materials),
        ]

    def _check_shape(self) -> Iterator[Finding]:
        """A nose fits on its projectile, and the plate is wider than that and no thinner than two cells."""
        length, diameter, nose = self.projectile_length, self.projectile_diameter, self.length_of_nose
        if self.nose != "conical" and self.nose_length is not None:
            limit = f"no length of a {self.nose} nose"
            yield Finding("nose_length", f"{self.nose_length:g} m", limit, "leave it out")
        if length < nose:
            limit = f"at least the length of the nose, {nose:g} m"
            yield Finding("projectile_length", f"{length:g} m", limit, "lengthen the projectile")
        narrowest, limit = diameter, f"at least the projectile's diameter, {diameter:g} m"
        if self.method.is_coupled:
            narrowest = SQUARE * diameter + (EVEN + 1) * self.step
            limit = f"at least {narrowest:g} m, the particles and {EVEN + 1} elements"
        if self.radius < narrowest:
            yield Finding("plate_radius", f"{self.radius:g} m", limit, "enlarge the plate")
        repels = self.numerics.contact == "repulsion"
        if repels and not self.method.is_smoothed:
            limit = "none, bardenhagen, thesis or gap, the contacts of material points"
            yield Finding("contact", "repulsion", limit, "take another contact")
        reach = REPULSION * self.step
        if repels and self.gap < reach * (1.0 - 1e-9):
            limit = f"at least {reach:g} m, {REPULSION:g} spacings of particles that repel each other"
            cure = "enlarge the gap, raise the resolution (cells per diameter), or set contact to none"
            yield Finding("gap", f"{self.gap:g} m", limit, cure)
        least = 2.0 * self.cell
        if self.plate_thickness < least:
            limit, cure = f"at least two cells, {least:g} m", "raise the resolution (cells per diameter)"
            yield Finding("plate_thickness", f"{self.plate_thickness:g} m", limit, cure)

    def build(self, materials: Materials) -> ImpactSetting:
        from solver.problem import ArtificialViscosity, Problem

        geometry, faces = self._grid()
        projectile, plate = self.solids
        flying, target = self._body(projectile, materials["projectile"], geometry), materials["target"]
        if self.method.is_coupled:
            elements, particles = coupled_plate(
                plate.role,
                self._matter(target),
                density=target.density,
                begin=plate.begin,
                end=plate.end,
                **self._square(),
            )
            bodies: tuple[Body, ...] = (elements, flying, particles)
        else:
            bodies = (flying, self._body(plate, target, geometry))
        clamp = slab_clamp(self.geometry, self.plate_thickness, self.cell)
        problem = Problem(geometry=geometry, bodies=bodies, faces=faces, clamp=clamp, end_time=self.end)
        problem = self.numerics.applied_to(problem, self.method)
        if self.method.is_coupled:
            # Elements beside particles have the viscosity of the recipe, that of a grid.
            recipe = RECIPES[self.numerics.recipe]
            viscosity = ArtificialViscosity(recipe.viscosity_linear, recipe.viscosity_quadratic)
            problem = replace(problem, viscosity=viscosity)
        return ImpactSetting(
            problem=problem,
            sector=SECTORS[self.geometry],
            target="target",
            projectile_diameter=self.projectile_diameter,
            thickness=self.plate_thickness,
            radius=self.radius,
            speed=self.speed,
        )

    def _square(self) -> dict[str, float]:
        """Half widths of the particles of a coupled plate and of the plate, and their spacing, m."""
        return {"square": SQUARE * self.projectile_diameter, "width": self.radius, "step": self.step}

    def _grid(self) -> tuple[Geometry, Faces]:
        from solver.problem import Face

        projectile, plate = self.solids
        before = math.ceil(-projectile.begin / self.cell + AROUND)
        flown = FASTEST * self.speed * self.end - self.gap
        behind = math.ceil((plate.end + max(flown, plate.end)) / self.cell + AROUND)
        return mesh(
            self.geometry,
            across=math.ceil(plate.breadth / self.cell - 1e-9),
            along=before + behind,
            front=-(before + self.offset) * self.cell,
            cell=self.cell,
            side=(Face.SYMMETRIC, Face.FIXED),
            flight=(Face.FREE, Face.FREE),
        )

    def _body(self, solid: BodyShape, material: "Material", geometry: Geometry) -> "Body":
        """A solid filled with the particles of the material point method."""
        where = lattice(self.geometry, breadth=solid.breadth, begin=solid.begin, end=solid.end, step=self.step)
        if solid.is_round:
            where = where.where(where.radius < solid.radius(where.along))
        return body(
            solid.role,
            self._matter(material),
            geometry,
            where,
            velocity=along_flight(self.geometry, solid.speed),
            density=material.density,
            volume=solid.volume * SECTORS[self.geometry] / (2.0 * math.pi),
        )

    def _matter(self, material: "Material") -> "Matter":
        return matter(
            material,
            thermal_softening=self.thermal_softening,
            tension=self.numerics.choices.tension,
            fracture=self.fracture,
        )

    def size(self, materials: Materials) -> Size:
        if self.geometry == "axisymmetric":
            particles = sum(solid.breadth * (solid.end - solid.begin) for solid in self.solids) / self.step**2
        elif self.method.is_coupled:
            particles = self.solids[0].volume / 4.0 / self.step**3
            particles += plate_size(thickness=self.plate_thickness, **self._square())
        else:
            particles = sum(solid.volume for solid in self.solids) / 4.0 / self.step**3
        sound = max(elastic_speed(material) for material in materials.values())
        step = self.numerics.mean_step(self.cell, sound=sound, speed=self.speed)
        return Size(particles=round(particles), steps=math.ceil(self.end / step))

    def cells(self) -> dict[str, float]:
        return {"cells_per_diameter": self.cells_per_diameter, "cells_per_thickness": self.plate_thickness / self.cell}

    @staticmethod
    def view(setting: ImpactSetting, snapshot: "Snapshot") -> "PlugView":
        from studies.plugs.plug import view

        return view(setting, snapshot)

    def rate(self, setting: ImpactSetting) -> ObservationRate:
        interval = OBSERVED * self.cell / self.speed
        return ObservationRate(interval=max(interval, setting.problem.end_time / MOST_OBSERVED))

    def sections(self, setting: ImpactSetting) -> "SectionOptions":
        from studies.sections.section import SectionOptions

        moments = tuple(moment * setting.problem.end_time for moment in MOMENTS)
        return SectionOptions(moments=moments, reach=REACH * self.projectile_diameter)

    @staticmethod
    def outline(values: Mapping[str, Plain]) -> Outline | None:
        """Projectile and plate at the start; the nose is drawn blunt."""
        names = ("projectile_diameter", "projectile_length", "plate_thickness", "plate_radius", "gap")
        diameter, length, thickness, rim, gap = (number(values, name) for name in names)
        if not diameter or not length or not thickness or not rim:
            return None
        half = 0.5 * diameter
        projectile = Shape("projectile", -half, half, -length - gap, -gap, heading=(0.0, 1.0))
        return Outline(
            (projectile, Shape("target", -rim, rim, 0.0, thickness)),
            (
                Dimension("projectile_diameter", (-half, -length - gap), (half, -length - gap)),
                Dimension("projectile_length", (half, -length - gap), (half, -gap)),
                Dimension("plate_thickness", (rim, 0.0), (rim, thickness)),
                Dimension("plate_radius", (0.0, thickness), (rim, thickness)),
            ),
        )


SCENARIO = Scenario(
    name="plugging",
    title="Plugging of a plate",
    description="A hard projectile with a blunt, conical or hemispherical nose hits a clamped plate at right angles; "
    "the projectile, the plug and the hole are measured.",
    question="Does a plate stop a hard projectile?",
    place=50,
    parameters=Plugging,
    materials=("projectile", "target"),
    measurements=(
        "perforated",
        "projectile_velocity",
        "residual_velocity",
        "plug_velocity",
        "plug_mass",
        "hole_diameter_front",
        "hole_diameter_rear",
        "dishing",
        "first_contact",
        "plug_separation",
    ),
    least_cells={"cells_per_thickness": 8.0},
    fewest_cells={"cells_per_thickness": 4.0},
)
