"""Parameters of impacts: projectile, speed and target, what settles, angles, and the plate."""

import math
from dataclasses import dataclass, replace
from typing import Annotated, Literal, Self

from solver.units import Described, Dimensionless, Metre, MetrePerSecond, Radian, Second
from studies.quantities.findings import Finding
from studies.quantities.numerical_defaults import IMPACT_RECIPES, DebrisName
from studies.quantities.parameters import Choice, MaterialName
from studies.quantities.units import readable, round_quantity
from studies.scenarios import Materials, ObservationRate
from studies.scenarios.parts.matter import eos_forms
from studies.scenarios.parts.method import ON_GRID, MethodChoice
from studies.scenarios.parts.numerics import BY_RECIPE, GridOffset, Numerics, ThermalSoftening, filled_from, softens

# As the latest end of a run: 5 us at 8 mm.
WINDOW_PER_DIAMETER = 5e-6 / 8e-3  # s/m

# Of the default window. In a tenth of it a hole that grows by 5 % in the whole counts as settled (0.5 %); in a shorter
# one it does while it is being made, and the growth in its error bar says nothing.
LEAST_WINDOW = 0.1

# Beyond, a projectile skids along a plate that is too small to hold its path.
STEEPEST = math.radians(75.0)

TargetName = Annotated[MaterialName, Described("material of the target")]

RADIUS = 3.5  # of a plate, in projectile diameters: fixed or free edges change the hole by less than 1 % (MPM3D-F90)


@dataclass(frozen=True, kw_only=True)
class Shot:
    """A projectile, the grid that it flies in, and how long its impact is observed."""

    speed: Annotated[MetrePerSecond, Described("impact speed, along the flight", 100.0, 2e4)]
    projectile_diameter: Annotated[Metre, Described("diameter of the projectile", 1e-5, 1.0)]
    projectile: Annotated[MaterialName, Described("material of the projectile")]
    projectile_shape: Annotated[
        Literal["sphere", "cylinder"],
        Described("shape of the projectile; a cylinder flies along its axis unless it yaws"),
    ] = "sphere"
    projectile_length: Annotated[Metre | None, Described("length of a cylinder; omitted for a sphere", 1e-5, 1.0)] = (
        None
    )
    geometry: Annotated[
        Literal["axisymmetric", "quarter", "half"],
        Described("body of revolution, or a quarter or half of a square target in three dimensions"),
    ] = "axisymmetric"
    cells_per_diameter: Annotated[
        Dimensionless, Described("grid cells across the projectile's diameter", 2.0, 512.0)
    ] = 32.0
    edges: Annotated[
        Literal["fixed", "free", "absorbing"],
        Described(
            "what holds the target's rim (absorbing: waves leave there, and through the back of a block); debris that "
            "flies past it leaves the grid"
        ),
    ] = "fixed"
    end_time: Annotated[
        Second | None,
        Described(
            "latest end of the run; by default 7.5 ms per metre of diameter (60 us at 8 mm), 15 for a thick block",
            1e-9,
            1.0,
        ),
    ] = None
    eos_form: Annotated[
        str,
        Choice(eos_forms),
        Described(
            "Mie-Grueneisen about the exact Hugoniot, the thesis' cubic truncation of it, or linear elasticity without "
            "an equation of state, by the stated bulk modulus; other equations of state have the first or the last"
        ),
    ] = "hugoniot"
    thermal_softening: ThermalSoftening = True
    debris: Annotated[
        DebrisName | None,
        Described(
            "debris that is free of the target and on a clear way out of the grid is followed to the edge, or retired: "
            f"it leaves a record and flies straight from there; {BY_RECIPE}"
        ),
    ] = None
    uprange: Annotated[
        Dimensionless | None, Described(f"grid in front of the target, in projectile diameters; {BY_RECIPE}", 0.5, 50.0)
    ] = None
    downrange: Annotated[
        Dimensionless | None, Described(f"grid behind the target, in projectile diameters; {BY_RECIPE}", 0.5, 50.0)
    ] = None
    beyond_edge: Annotated[
        Dimensionless | None, Described("grid outside a rim that is not fixed, in projectile diameters", 0.1, 50.0)
    ] = 0.5
    offset: GridOffset = 0.0

    @property
    def cell(self) -> float:
        """Size of a cell, m."""
        return self.projectile_diameter / self.cells_per_diameter

    @property
    def length(self) -> float:
        """Length of the projectile, m."""
        return self.projectile_length or self.projectile_diameter

    def filled(
        self, materials: Materials, numerics: Numerics, method: MethodChoice = ON_GRID, *, end_time: float
    ) -> Self:
        """The shot with all that its recipe chooses, and its latest end (s) where none is stated."""
        preset = IMPACT_RECIPES[numerics.recipe]
        if method.is_smoothed:  # which does not retire any
            preset = replace(preset, debris="follow")
        return replace(
            filled_from(self, preset),
            end_time=round_quantity(self.end_time or end_time),
            beyond_edge=None if self.edges == "fixed" else self.beyond_edge,
            thermal_softening=softens(self.thermal_softening, materials.values()),
        )

    def check(self) -> list[Finding]:
        """A cylinder has a length and a sphere has none."""
        name, length = "projectile_length", self.projectile_length
        if self.projectile_shape == "cylinder" and length is None:
            return [Finding(name, "nothing", "the length of the cylinder", f"give {name}")]
        if self.projectile_shape == "sphere" and length is not None:
            cure = f"leave {name} out, or set projectile_shape to cylinder"
            return [Finding(name, f"{length:g} m", "a sphere without a length", cure)]
        return []


@dataclass(frozen=True, kw_only=True)
class ImpactShot(Shot):
    """A shot at a plate or block."""

    target: TargetName


@dataclass(frozen=True, kw_only=True)
class Settling:
    """When an impact ends: once what is measured has settled, or its outcome is decided."""

    stop: Annotated[
        Literal["settled", "decided", "end_time"],
        Described(
            "end when the measurement has settled; decided: as well once the wall has had a hole for settled_window, "
            "which is all that a search for its limit asks; or only at end_time"
        ),
    ] = "settled"
    settled_growth: Annotated[
        Dimensionless, Described("relative growth within settled_window that counts as settled", 0.0, 0.5)
    ] = 0.005
    settled_window: Annotated[
        Second | None,
        Described(
            "time over which growth is judged; by default 5 us at 8 mm, in proportion to the diameter; a tenth of "
            "that at least",
            1e-9,
            1.0,
        ),
    ] = None

    def filled(self, diameter: float) -> Self:
        """With the window over which growth is judged, for a projectile of a diameter (m)."""
        window = round_quantity(self.settled_window or WINDOW_PER_DIAMETER * diameter)
        return replace(self, settled_window=window)

    def check(self, diameter: float) -> list[Finding]:
        """Growth is judged over long enough a time to be seen."""
        assert self.settled_window is not None
        default = round_quantity(WINDOW_PER_DIAMETER * diameter)
        least = round_quantity(LEAST_WINDOW * default)
        if self.settled_window >= least:
            return []
        limit = f"at least {LEAST_WINDOW:g} of its default at this diameter, {readable(least, 's')}"
        cure = f"leave it out: the default is {readable(default, 's')}"
        return [Finding("settled_window", readable(self.settled_window, "s"), limit, cure)]

    @property
    def rate(self) -> ObservationRate:
        """The rate at which growth is judged."""
        assert self.settled_window is not None
        return ObservationRate.settling(self.settled_window, growth=self.settled_growth, stop=self.stop)


@dataclass(frozen=True, kw_only=True)
class Growing(Settling):
    """When an impact on a plate or a block ends: these have no outcome that decides them."""

    stop: Annotated[
        Literal["settled", "end_time"], Described("end when the measurement has settled, or only at end_time")
    ] = "settled"


@dataclass(frozen=True, kw_only=True)
class Angles:
    """Directions of a projectile's flight and axis in the plane of symmetry of a half model."""

    obliquity: Annotated[
        Radian, Described("angle between the flight and the target's normal; needs geometry half", 0.0, STEEPEST)
    ] = 0.0
    yaw: Annotated[
        Radian,
        Described(
            "angle between the axis of a cylinder and its flight, positive where its nose is ahead along the target; "
            "needs geometry half",
            -0.5 * math.pi,
            0.5 * math.pi,
        ),
    ] = 0.0

    def check(self, shot: Shot) -> list[Finding]:
        """Angles need a model that has no other symmetry than theirs, and yaw needs an axis."""
        findings = []
        for name, angle in (("obliquity", self.obliquity), ("yaw", self.yaw)):
            text = f"{math.degrees(angle):g} deg"
            if angle and shot.geometry != "half":
                limit = "0 deg in a body of revolution or a quarter model"
                findings.append(Finding(name, text, limit, "set geometry to half"))
            if name == "yaw" and angle and shot.projectile_shape != "cylinder":
                findings.append(Finding(name, text, "0 deg for a sphere", "use a cylinder"))
        return findings


UPRIGHT = Angles()


@dataclass(frozen=True, kw_only=True)
class Plate:
    """The plate of an impact."""

    plate_thickness: Annotated[Metre, Described("thickness of the plate", 1e-6, 1.0)]
    plate_radius: Annotated[
        Metre | None,
        Described("radius of a round plate, half the width of a square one; by default 3.5 diameters", 1e-5, 10.0),
    ] = None

    @property
    def radius(self) -> float:
        """Radius of the filled plate, m."""
        assert self.plate_radius is not None
        return self.plate_radius

    def filled(self, diameter: float) -> Self:
        """With its radius, for a projectile of a diameter (m)."""
        return replace(self, plate_radius=round_quantity(self.plate_radius or RADIUS * diameter))

    def check(self, shot: Shot) -> list[Finding]:
        """The plate is wider than the projectile, and no thinner than half a cell."""
        findings = []
        if self.radius < shot.projectile_diameter:
            limit = f"at least the projectile's diameter, {shot.projectile_diameter:g} m"
            cure = "enlarge the plate; 3.5 diameters is the default"
            findings.append(Finding("plate_radius", f"{self.radius:g} m", limit, cure))
        if self.plate_thickness < 0.5 * shot.cell:
            limit = f"at least half a cell, {0.5 * shot.cell:g} m"
            cure = "raise the resolution (cells per diameter)"
            findings.append(Finding("plate_thickness", f"{self.plate_thickness:g} m", limit, cure))
        return findings
