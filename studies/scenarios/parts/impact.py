"""Impacts of a projectile on a plate or block: matter, lattices, faces, the size of the work, and what is observed.

The original surface of the target is z = 0, its body stands at z > 0, and the projectile flies towards +z and touches
it at time zero. Lattices have the recipe's particles per cell and direction, stretched by a few per cent where needed
so that lengths are exact; the masses of a body are scaled to the analytic mass, from which a lattice sphere differs by
2 to 4 %.
"""

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Self, TypeVar

from studies.convergence.experience import MeshGrid
from studies.measurements._settings import ImpactSetting
from studies.quantities.findings import Finding
from studies.quantities.numerical_defaults import DEFAULT_FAILURE, FEW_PARTICLES, RECIPES
from studies.quantities.parameters import Plain, flat
from studies.scenarios import Materials, ObservationRate, Setting, SetUp, Size, View
from studies.scenarios.parts.lattice import (
    SECTORS,
    BodyPoints,
    Faces,
    Geometry,
    along_flight,
    body,
    flight_axis,
    lattice,
    mesh,
    slab_clamp,
)
from studies.scenarios.parts.matter import Fracture, check_boiling, check_constants, check_eos, matter, yield_stress
from studies.scenarios.parts.method import ON_GRID
from studies.scenarios.parts.numerics import Numerics
from studies.scenarios.parts.outline import Dimension, Outline, Shape, number
from studies.scenarios.parts.shot import UPRIGHT, Settling, Shot

if TYPE_CHECKING:
    import numpy as np

    from solver.matter.laws import Matter
    from solver.problem import Absorber, Body
    from solver.state import Snapshot
    from studies.materials import Material
    from studies.measurements.impact.view import ImpactView
    from studies.sections.section import SectionOptions

SOUND_SPEED = 5000.0  # m/s, in the estimate of the number of steps

# Debris may be retired from here on, in times in which the projectile flies its own length. Matter moves at half of the
# impact speed or more while it is thrown out of a plate no thicker than the projectile, which takes four of them.
CLEAR = 5.0

# Below, a run is under-resolved, or too coarse to say how large its error is: at 6 km/s a plate of a twentieth of the
# diameter has a hole of 16.4 mm with 0.8 cells through it, 11.3 with 2.4.
LEAST_CELLS: Mapping[str, float] = {"cells_per_diameter": 16.0, "cells_per_thickness": 4.0}
FEWEST_CELLS: Mapping[str, float] = {"cells_per_thickness": 2.0}

# A cross-check of connectivity, which alone decides what is plate: MPM3D-F90's holes were read from particles slower
# than this, m/s.
FAST = 300.0

# Times of the two pictures of debris before the end, in times in which the projectile flies its own length: while it
# goes through the plate, and when the debris, which is no faster than the projectile, is about to leave a grid of four
# projectile diameters.
MOMENTS = (1.5, 4.0)
# Part of the target in pictures, in projectile diameters from the point of impact: plates of the default size are
# whole, and craters of copper at 7 km/s have half of it as their radius.
REACH = 7.0

# Relative uncertainty of a measurement with ``FEW_PARTICLES`` and the default recipe's shape: the root mean square
# difference from three particles, on 16 cells across the projectile, and from ``FINE`` cells on (docs/recipe.md).
FINE = 24.0
OF_FEW_PARTICLES = {
    "hole_diameter": (0.035, 0.014),
    "hole_diameter_areal": (0.029, 0.015),
    "hole_diameter_midplane": (0.057, 0.036),
    # Craters were compared on 16 cells alone.
    "crater_depth": (0.019, 0.019),
    "crater_diameter": (0.01, 0.01),
    "crater_depth_over_diameter": (0.021, 0.021),
}


# Parameters that say what is shot, on which grid, and how long it is observed. Experience of mesh errors is about the
# defaults of all others, which are numerics and models.
SHOT = frozenset(
    {
        *("projectile", "projectile_diameter", "projectile_shape", "projectile_length", "speed", "obliquity"),
        *("target", "plate_thickness", "plate_radius", "target_depth", "target_radius", "edges", "beyond_edge"),
        *("geometry", "cells_per_diameter", "offset", "end_time", "stop", "settled_growth", "settled_window"),
        "film_interval",
    }
)


ImpactStage = TypeVar("ImpactStage", bound=ImpactSetting)


@dataclass(frozen=True)
class Impact:
    """A projectile in front of a plate, or of a ``deep`` half-space whose back absorbs where its edges do."""

    parameters: "ImpactSetUp"
    _: KW_ONLY
    thickness: float  # of the target, m
    radius: float  # of the target, m: half its width where it is square
    deep: bool = False
    target: str = "target"  # name of the target's body, and of the parameter of its material
    expansion: float = math.inf  # as in ``solver.problem.Retirement``

    @property
    def shot(self) -> Shot:
        """The projectile, and the grid that it flies in."""
        return self.parameters.shot

    def check(self, materials: Materials) -> list[Finding]:
        """Findings that any impact may have."""
        return [
            *self.shot.check(),
            *self.parameters.numerics.check(self.shot.end_time, self.parameters.method),
            *self.parameters.fracture.check(materials),
            *check_eos(self.shot.eos_form, materials),
            *check_constants(materials),
            *check_boiling(self.parameters.numerics.choices.tension, self.shot.thermal_softening, materials),
        ]

    def cells(self) -> dict[str, float]:
        """Cells across the projectile and through the target."""
        return {
            "cells_per_diameter": self.shot.cells_per_diameter,
            "cells_per_thickness": self.thickness / self.shot.cell,
        }

    def size(self) -> Size:
        """Particles from volumes, and steps from the stable step of the undisturbed state."""
        shot = self.shot
        diameter, length = shot.projectile_diameter, shot.projectile_length
        if shot.geometry == "axisymmetric":
            half_plane = 0.5 * diameter * length if length else math.pi / 8.0 * diameter**2
            particles = (self.radius * self.thickness + half_plane) / self.step**2
        else:
            parts = 4 if shot.geometry == "quarter" else 2
            projectile = math.pi / 4.0 * diameter**2 * (length or 2.0 / 3.0 * diameter)
            particles = ((2.0 * self.radius) ** 2 * self.thickness + projectile) / parts / self.step**3
        # Half of the impact speed on top of 5 km/s of sound: the mean over runs of copper at 2 to 7 km/s.
        step = self.parameters.numerics.mean_step(shot.cell, sound=SOUND_SPEED, speed=0.5 * shot.speed)
        return Size(particles=round(particles), steps=round(self.end_time / step))

    def build(self, materials: Materials) -> ImpactSetting:
        """The problem at the moment when the projectile touches; an oblique one also flies towards +x."""
        from solver.problem import Problem, Retirement

        shot, angle = self.shot, self.parameters.angles.obliquity
        geometry, faces = self.grid()
        velocity = along_flight(shot.geometry, shot.speed * math.cos(angle))
        velocity[0] = shot.speed * math.sin(angle)
        projectile = self.body("projectile", materials["projectile"], geometry, *self._projectile(), velocity)
        target = self.body(self.target, materials[self.target], geometry, *self.points(), 0.0 * velocity)
        follows = shot.debris == "follow"
        problem = Problem(
            geometry=geometry,
            bodies=(projectile, target),
            faces=faces,
            clamp=slab_clamp(shot.geometry, self.thickness, shot.cell),
            absorbers=self._absorbers(target.matter),
            end_time=self.end_time,
            retirement=None if follows else Retirement(body=1, after=self.clear, expansion=self.expansion),
        )
        return ImpactSetting(
            problem=self.parameters.numerics.applied_to(problem, self.parameters.method),
            sector=SECTORS[shot.geometry],
            target=self.target,
            projectile_diameter=shot.projectile_diameter,
            thickness=self.thickness,
            radius=self.radius,
            speed=shot.speed,
        )

    @property
    def step(self) -> float:
        """Distance of two particles, m."""
        return self.shot.cell / self.parameters.numerics.choices.particles_per_cell

    @property
    def clear(self) -> float:
        """Time after the touch from which debris may be retired, s."""
        return CLEAR * max(self.shot.projectile_diameter, self.shot.length) / self.shot.speed

    @property
    def end_time(self) -> float:
        """Latest end of a run, s."""
        assert self.shot.end_time is not None
        return self.shot.end_time

    def grid(self) -> tuple[Geometry, Faces]:
        """The grid about projectile and target, and its faces."""
        from solver.problem import Face

        shot, cell, diameter = self.shot, self.shot.cell, self.shot.projectile_diameter
        assert shot.uprange is not None
        assert shot.downrange is not None
        beyond = (shot.beyond_edge or 0.0) * diameter
        before = math.ceil(shot.uprange * diameter / cell)
        before = max(before, math.ceil((self._height + 2.0 * cell) / cell))
        behind = math.ceil((self.thickness + shot.downrange * diameter) / cell)
        return mesh(
            shot.geometry,
            across=math.ceil((self.radius + beyond) / cell - 1e-9),
            along=before + behind,
            front=-(before + shot.offset) * cell,
            cell=cell,
            side=(Face.SYMMETRIC, Face.FIXED if shot.edges == "fixed" else Face.FREE),
            flight=(Face.FREE, Face.FREE),
        )

    def _absorbers(self, target: "Matter") -> "tuple[Absorber, ...]":
        """The rim of the target where edges absorb, and the back of a deep one."""
        from solver.grid.absorb import absorber

        if self.shot.edges != "absorbing":
            return ()
        geometry, radius = self.shot.geometry, self.radius
        rims = {"axisymmetric": [(0, 1)], "quarter": [(0, 1), (1, 1)], "half": [(0, 0), (0, 1), (1, 1)]}[geometry]
        surfaces = [(axis, side, radius if side else -radius) for axis, side in rims]
        if self.deep:
            surfaces.append((flight_axis(geometry), 1, self.thickness))
        return tuple(absorber(target, body=1, axis=axis, side=side, place=place) for axis, side, place in surfaces)

    @property
    def _lean(self) -> float:
        """Angle between the axis of a cylinder and the target's normal, rad; 0 for a sphere."""
        angles = self.parameters.angles
        return 0.0 if self.shot.projectile_shape == "sphere" else angles.obliquity + angles.yaw

    @property
    def _height(self) -> float:
        """Extent of the projectile along the target's normal, m."""
        if not self._lean:
            return self.shot.length
        across = self.shot.projectile_diameter * abs(math.sin(self._lean))
        return self.shot.length * abs(math.cos(self._lean)) + across

    def points(self) -> tuple[BodyPoints, float]:
        """Points of the target, and the volume of the modelled part, m3 (m3 per radian in axisymmetry)."""
        geometry = self.shot.geometry
        area = {"axisymmetric": 0.5, "quarter": 1.0, "half": 2.0}[geometry] * self.radius**2
        where = lattice(geometry, breadth=self.radius, begin=0.0, end=self.thickness, step=self.step)
        return where, area * self.thickness

    def _projectile(self) -> tuple[BodyPoints, float]:
        """As ``points``, around the projectile's own centre, so that a sphere is symmetric on any grid."""
        import numpy as np

        shot, lean = self.shot, self._lean
        radius, length = 0.5 * shot.projectile_diameter, shot.length
        block = lattice(shot.geometry, breadth=radius, begin=-length, end=0.0, step=self.step)
        if shot.projectile_shape == "sphere":
            inside = block.radius**2 + (block.along + radius) ** 2 < radius**2
            volume = 4.0 / 3.0 * math.pi * radius**3
        else:
            inside = block.radius < radius
            volume = math.pi * radius**2 * length
        where = block.where(inside)
        if lean:
            # About the middle of the cylinder, whose lowest edge then touches the surface.
            x, y, z = where.position.T
            height = z + 0.5 * length
            turned = x * math.cos(lean) + height * math.sin(lean)
            place = height * math.cos(lean) - x * math.sin(lean) - 0.5 * self._height
            where = replace(where, position=np.stack([turned, y, place], axis=-1))
        return where, volume * SECTORS[shot.geometry] / (2.0 * math.pi)

    def body(
        self,
        name: str,
        material: "Material",
        geometry: Geometry,
        where: BodyPoints,
        volume: float,
        velocity: "np.ndarray",
    ) -> "Body":
        """A body of a material, of a volume (m3, or m3 per radian)."""
        made = matter(
            material,
            eos_form=self.shot.eos_form,
            thermal_softening=self.shot.thermal_softening,
            tension=self.parameters.numerics.choices.tension,
            fracture=self.parameters.fracture,
        )
        return body(name, made, geometry, where, velocity=velocity, density=material.density, volume=volume)


@dataclass(frozen=True, kw_only=True)
class ImpactSetUp(SetUp[ImpactStage, View]):
    """The parameters that every impact has, and what follows from them."""

    of_shot: ClassVar[frozenset[str]] = SHOT

    shot: Shot
    fracture: Fracture
    numerics: Numerics
    # A scenario that varies these has parameters of its own in their place.
    angles = UPRIGHT
    method = ON_GRID
    settling = Settling()

    @property
    @abstractmethod
    def impact(self) -> Impact:
        """The projectile in front of its target."""

    def with_shot(self, materials: Materials, *, end_time: float, failure: str = DEFAULT_FAILURE) -> Self:
        """The parameters with shot, failure and numerics filled; ``end_time`` (s) and ``failure`` are defaults."""
        return replace(
            self,
            shot=self.shot.filled(materials, self.numerics, self.method, end_time=end_time),
            fracture=self.fracture.filled(materials, failure),
            numerics=self.numerics.filled(materials, few=self.shot.geometry != "axisymmetric", method=self.method),
        )

    def check(self, materials: Materials) -> list[Finding]:
        return [
            *self.method.check(flat(self)),
            *self.impact.check(materials),
            *self.settling.check(self.shot.projectile_diameter),
            *self.angles.check(self.shot),
        ]

    def build(self, materials: Materials) -> Setting:
        return self.impact.build(materials)

    def size(self, materials: Materials) -> Size:
        return self.impact.size()

    def cells(self) -> dict[str, float]:
        return self.impact.cells()

    def rate(self, setting: ImpactStage) -> ObservationRate:
        return self.settling.rate

    def mesh_grids(self, materials: Materials) -> dict[str, MeshGrid]:
        """The grid of a run that has the default numerics and failure, as those of the ensemble have."""
        impact, shot, target = self.impact, self.shot, materials[self.impact.target]
        strength = yield_stress(target)
        if not self.experienced or not strength or not self.has_defaults(materials, self.of_shot):
            return {}
        grid = MeshGrid(
            "",
            across=shot.cells_per_diameter,
            through=math.inf if impact.deep else impact.cells()["cells_per_thickness"],
            speed=shot.speed,
            strength=strength,
            density_ratio=materials["projectile"].density / target.density,
            length=shot.length / shot.projectile_diameter,
            obliquity=self.angles.obliquity,
            in_space=shot.geometry != "axisymmetric",
        )
        return {name: replace(grid, quantity=quantity) for name, quantity in self.experienced.items()}

    def sections(self, setting: ImpactStage) -> "SectionOptions":
        """Pictures while the projectile goes through, and when its debris is about to leave."""
        from studies.sections.section import SectionOptions

        shot = self.shot
        moments = tuple(moment * max(shot.projectile_diameter, shot.length) / shot.speed for moment in MOMENTS)
        return SectionOptions(moments=moments, reach=REACH * shot.projectile_diameter)

    def uncertainty_parts(self, measurement: str) -> Mapping[str, float]:
        """The part of few particles, with the shape functions for which it was measured."""
        shot, own, default = self.shot, self.numerics.choices, RECIPES["whipple"]
        few = own.particles_per_cell <= FEW_PARTICLES < default.particles_per_cell
        if few and own.shape == default.shape and measurement in OF_FEW_PARTICLES:
            coarse, fine = OF_FEW_PARTICLES[measurement]
            return {"particles": coarse if shot.cells_per_diameter < FINE else fine}
        return {}


class TargetSetUp(ImpactSetUp[ImpactSetting, "ImpactView"]):
    """The parameters of an impact of which the target is measured."""

    @staticmethod
    def view(setting: ImpactSetting, snapshot: "Snapshot") -> "ImpactView":
        from studies.measurements.impact.view import view

        return view(setting, snapshot)

    @staticmethod
    def numbers(view: "ImpactView") -> dict[str, float]:
        """Mass of the target that has come loose, and of what is fast in the rest, over that of the whole target."""
        attached = view.attached_target
        loose = 1.0 - float(view.mass[attached].sum()) / float(view.target_mass)
        fast = float(view.mass[attached & (view.speed > FAST)].sum()) / float(view.target_mass)
        return {"separated_mass_fraction": loose, "fast_mass_fraction": fast}


def outline(values: Mapping[str, Plain], *, thickness: str, radius: str, target: str = "target") -> Outline | None:
    """Projectile and target as they touch; ``thickness``, ``radius`` and material are the target's parameters."""
    diameter, depth, rim = (number(values, name) for name in ("projectile_diameter", thickness, radius))
    if not diameter or not depth or not rim:
        return None
    length, angle = number(values, "projectile_length") or diameter, number(values, "obliquity")
    is_sphere = values.get("projectile_shape", "sphere") == "sphere"
    half = 0.5 * diameter
    projectile = Shape(
        "projectile", -half, half, -length, 0.0, is_disc=is_sphere, heading=(math.sin(angle), math.cos(angle))
    )
    dimensions = [
        Dimension("projectile_diameter", (-half, -length), (half, -length)),
        Dimension(thickness, (rim, 0.0), (rim, depth)),
        Dimension(radius, (0.0, depth), (rim, depth)),
    ]
    if not is_sphere:
        dimensions.append(Dimension("projectile_length", (half, -length), (half, 0.0)))
    return Outline((projectile, Shape(target, -rim, rim, 0.0, depth)), tuple(dimensions))
