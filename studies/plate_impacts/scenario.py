"""A plate hits a plate, face to face: a plane shock in uniaxial strain, whose state the Hugoniots give exactly.

The model is a column through both plates with symmetric sides, in the laboratory's frame: the target rests, the flyer
flies towards +z and touches it at z = 0 at time zero.
"""

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Literal, Self

from solver.units import Described, Dimensionless, Metre, MetrePerSecond, Second
from studies.plate_impacts.setting import PlateSetting
from studies.quantities.findings import Finding
from studies.quantities.numerical_defaults import NO_FAILURE
from studies.quantities.parameters import Choice, MaterialName
from studies.quantities.units import round_quantity
from studies.scenarios import Materials, ObservationRate, Scenario, SetUp, Size
from studies.scenarios.parts.lattice import SECTORS, Geometry, along_flight, body, lattice, mesh
from studies.scenarios.parts.matter import Fracture, check_constants, elastic_speed, eos_forms, matter
from studies.scenarios.parts.numerics import Numerics

if TYPE_CHECKING:
    import numpy as np

    from solver.problem import Body
    from solver.state import Snapshot
    from studies.materials import Material
    from studies.plate_impacts.plates import PlateView

BODIES = ("flyer", "target")
CROSSED = 0.9  # of its plate that the first shock to cross has passed at the end: no reflection yet
OBSERVATIONS = 20
OBSERVATIONS_OF_A_SIGNAL = 100  # of a free surface, in the time in which the first shock crosses its plate
# Pulses of a flyer, 2 thicknesses over c0, in a run with a failure after the shock has crossed the target: the signal
# of a spall comes after one, and the layer that it cuts off needs another one to ring.
PULSES = 2.0
BEYOND = 2  # cells of grid outside the plates
HALVINGS = 60  # of the interval in which the interface velocity lies: to round-off


@dataclass(frozen=True, kw_only=True)
class PlateImpact(SetUp[PlateSetting, "PlateView"]):
    """Parameters of a plate impact."""

    speed: Annotated[MetrePerSecond, Described("impact speed", 1.0, 2e4)] = 2000.0
    flyer: Annotated[MaterialName, Described("material of the flying plate")] = "copper-ofhc"
    target: Annotated[MaterialName, Described("material of the plate at rest")] = "copper-ofhc"
    flyer_thickness: Annotated[Metre, Described("thickness of the flyer", 1e-6, 1.0)] = 10e-3
    target_thickness: Annotated[
        Metre | None, Described("thickness of the target; by default that of the flyer", 1e-6, 1.0)
    ] = None
    geometry: Annotated[
        Literal["axisymmetric", "quarter"],
        Described("column of round or of square section, its outside a plane of symmetry"),
    ] = "quarter"
    cells_per_thickness: Annotated[Dimensionless, Described("grid cells through the flyer", 10.0, 1e4)] = 100.0
    cells_across: Annotated[int, Described("grid cells across the column", 1, 16)] = 1
    end_time: Annotated[
        Second | None,
        Described(
            "end of the run; by default when the first shock has crossed 0.9 of its plate, and with a failure when the "
            "spall layer has rung: two pulses of the flyer after the shock has crossed the target",
            1e-12,
            1.0,
        ),
    ] = None
    strength: Annotated[
        Literal["none", "material"],
        Described("fluids, as the Hugoniot has them, or plates with the strength of their materials"),
    ] = "none"
    eos_form: Annotated[
        str,
        Choice(eos_forms),
        Described("Mie-Grueneisen about the exact Hugoniot, the thesis' cubic truncation of it, or linear elasticity"),
    ] = "hugoniot"
    fracture: Fracture
    numerics: Numerics

    @property
    def cell(self) -> float:
        """Size of a cell, m."""
        return self.flyer_thickness / self.cells_per_thickness

    @property
    def thicknesses(self) -> tuple[float, float]:
        """Of flyer and target, m."""
        return self.flyer_thickness, self.target_thickness or self.flyer_thickness

    @property
    def section(self) -> float:
        """Area of the column, m2 (m2 per radian)."""
        width = self.cells_across * self.cell
        return 0.5 * width**2 if self.geometry == "axisymmetric" else width**2

    def filled(self, materials: Materials) -> Self:
        target = round_quantity(self.thicknesses[1])
        fracture = self.fracture.filled(materials, NO_FAILURE)
        # Strain along one axis turns nothing.
        numerics = self.numerics.filled(materials, unused=("jaumann",))
        return replace(self, target_thickness=target, fracture=fracture, numerics=numerics)

    def check(self, materials: Materials) -> list[Finding]:
        findings = [*self.numerics.check(self.end_time), *self.fracture.check(materials), *check_constants(materials)]
        for role in BODIES:
            if materials[role].eos.kind != "mie-grueneisen":
                limit = "a material whose equation of state is a Hugoniot"
                findings.append(Finding(role, materials[role].name, limit, "use mie-grueneisen"))
        target, least = self.thicknesses[1], 10.0 * self.cell
        if target < least:
            limit, cure = f"at least ten cells, {least:g} m", "raise cells_per_thickness, or thicken the target"
            findings.append(Finding("target_thickness", f"{target:g} m", limit, cure))
        return findings

    def build(self, materials: Materials) -> PlateSetting:
        import numpy as np

        from solver.problem import Face, Problem

        flyer, target = self.thicknesses
        # A free face moves, like metals, no faster than the flyer; others up to twice as fast.
        travel = 2.0 * self.speed * max(self._end(materials) - self._crossing(materials), 0.0)
        room = BEYOND + math.ceil(travel / self.cell)
        before, behind = (math.ceil(thick / self.cell - 1e-9) + room for thick in self.thicknesses)
        geometry, faces = mesh(
            self.geometry,
            across=self.cells_across,
            along=before + behind,
            front=-before * self.cell,
            cell=self.cell,
            side=(Face.SYMMETRIC, Face.SYMMETRIC),
            flight=(Face.FREE, Face.FREE),
        )
        plates = [
            self._plate("flyer", materials, geometry, (-flyer, 0.0)),
            self._plate("target", materials, geometry, (0.0, target)),
        ]
        bodies = tuple(plate for plate, _ in plates)
        problem = Problem(geometry=geometry, bodies=bodies, faces=faces, end_time=self._end(materials))
        return PlateSetting(
            problem=self.numerics.applied_to(problem),
            sector=SECTORS[self.geometry],
            speed=self.speed,
            thicknesses=(flyer, target),
            section=self.section,
            impedance=materials["target"].density * materials["target"].sound_speed,
            crossing=self._crossing(materials),
            layer=np.concatenate([layer for _, layer in plates]),
        )

    def _plate(
        self, name: str, materials: Materials, geometry: Geometry, ends: tuple[float, float]
    ) -> tuple["Body", "np.ndarray"]:
        """A plate, and the layer of each of its particles."""
        import numpy as np

        begin, end = ends
        step = self.cell / self.numerics.choices.particles_per_cell
        where = lattice(self.geometry, breadth=self.cells_across * self.cell, begin=begin, end=end, step=step)
        made = matter(
            materials[name], eos_form=self.eos_form, tension=self.numerics.choices.tension, fracture=self.fracture
        )
        plate = body(
            name,
            made if self.strength == "material" else made._replace(shear_modulus=0.0),
            geometry,
            where,
            velocity=along_flight(self.geometry, self.speed if name == "flyer" else 0.0),
            density=materials[name].density,
            volume=self.section * (end - begin),
        )
        layer = np.floor(np.abs(where.along) / where.spacing[where.axis]).astype(np.int64)
        return plate, layer

    def _end(self, materials: Materials) -> float:
        """End of the run, s."""
        if self.end_time:
            return self.end_time
        if self.fracture.failure == NO_FAILURE:
            return CROSSED * self._crossing(materials)
        flyer, target = materials["flyer"], materials["target"]
        crossed = self.thicknesses[1] / shocks(flyer, target, self.speed).speeds[1]
        return crossed + PULSES * 2.0 * self.thicknesses[0] / flyer.sound_speed

    def _crossing(self, materials: Materials) -> float:
        """When the first wave has crossed its plate, s."""
        flyer, target = materials["flyer"], materials["target"]
        speeds = shocks(flyer, target, self.speed).speeds
        if self.strength == "material":  # a fluid has no elastic precursor
            speeds = max(speeds[0], elastic_speed(flyer)), max(speeds[1], elastic_speed(target))
        return min(thick / speed for thick, speed in zip(self.thicknesses, speeds, strict=True))

    def size(self, materials: Materials) -> Size:
        per_cell = self.numerics.choices.particles_per_cell
        layers = sum(self.thicknesses) / self.cell * per_cell
        across = self.cells_across * per_cell
        behind = max(shocks(materials["flyer"], materials["target"], self.speed).speeds)
        step = self.numerics.mean_step(self.cell, sound=behind, speed=self.speed)
        return Size(
            particles=round(layers * (across if self.geometry == "axisymmetric" else across**2)),
            steps=math.ceil(self._end(materials) / step),
        )

    def cells(self) -> dict[str, float]:
        return {"cells_per_thickness": self.cells_per_thickness}

    @staticmethod
    def view(setting: PlateSetting, snapshot: "Snapshot") -> "PlateView":
        from studies.plate_impacts.plates import view

        return view(setting, snapshot)

    def rate(self, setting: PlateSetting) -> ObservationRate:
        end = setting.problem.end_time
        if end <= setting.crossing:
            return ObservationRate(interval=end / OBSERVATIONS)
        return ObservationRate(interval=setting.crossing / OBSERVATIONS_OF_A_SIGNAL)


@dataclass(frozen=True)
class Shocks:
    """The exact state behind the shocks, from the Hugoniots us = c0 + s up of both plates."""

    pressure: float  # Pa
    speeds: tuple[float, float]  # of the shocks into flyer and target at rest, m/s


def shocks(flyer: "Material", target: "Material", speed: float) -> Shocks:
    """Impedance match: the interface velocity at which both plates have the same pressure."""

    def shock_speed(material: "Material", jump: float) -> float:
        c0, s = material.value_at("eos.c0"), material.value_at("eos.s")
        assert c0 is not None
        assert s is not None
        return c0 + s * jump

    def pressure(material: "Material", jump: float) -> float:
        return material.density * shock_speed(material, jump) * jump

    low, high = 0.0, speed
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if pressure(target, middle) < pressure(flyer, speed - middle):
            low = middle
        else:
            high = middle
    return Shocks(pressure(target, low), (shock_speed(flyer, speed - low), shock_speed(target, low)))


SCENARIO = Scenario(
    name="plate_impact",
    title="Plate on plate",
    description="A plate hits a plate face to face; the state behind the plane shocks is measured.",
    question="What is the state behind a plane shock?",
    place=80,
    parameters=PlateImpact,
    materials=BODIES,
    first=(
        *("plateau_pressure", "plateau_velocity", "target_shock_speed"),
        *("free_surface_velocity", "pullback_velocity", "spall_strength"),
    ),
    measurements=(
        "plateau_pressure",
        "plateau_scatter",
        "plateau_velocity",
        *(
            f"{plate}_{name}"
            for name in ("density", "density_from_spacing", "shock_front", "shock_speed")
            for plate in BODIES
        ),
        "free_surface_velocity",
        "free_surface_peak",
        "free_surface_minimum",
        "pullback_velocity",
        "acoustic_stress",
        "spall_strength",
    ),
)
