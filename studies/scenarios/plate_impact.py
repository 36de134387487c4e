"""A plate hits a plate, face to face: a plane shock in uniaxial strain, whose state the Hugoniots give exactly.

The model is a column through both plates with symmetric sides, in the laboratory's frame: the target rests, the flyer
flies towards +z and touches it at z = 0 at time zero.
"""

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

from solver.units import Described, Dimensionless, Metre, MetrePerSecond, Second
from studies.scenarios import Materials, ObservationRate, ObserverOptions, Scenario, Setting, Size
from studies.scenarios._lattice import SECTORS, body, line, mesh, points
from studies.scenarios._matter import check_constants, eos_forms, matter
from studies.scenarios._numerics import (
    Numerics,
    check_numerics,
    filled_numerics,
    mean_step,
    numerics,
    particles_per_cell,
    recipe_of,
)
from studies.values.errors import Finding
from studies.values.parameters import Choice, MaterialName
from studies.values.quantities import round_quantity

if TYPE_CHECKING:
    import numpy as np

    from solver.problem import Body, Matter
    from studies.materials import Material

BODIES = ("flyer", "target")
CROSSED = 0.9  # of its plate that the first shock to cross has passed at the end: no reflection yet
OBSERVATIONS = 20
BEYOND = 2  # cells of grid outside the plates
HALVINGS = 60  # of the interval in which the interface velocity lies: to round-off


@dataclass(frozen=True, kw_only=True)
class _PlateImpactShot:
    """The plates and their flight."""

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
        Described("end of the run; by default when the first shock has crossed 0.9 of its plate", 1e-12, 1.0),
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


@dataclass(frozen=True, kw_only=True)
class PlateImpact(Numerics, _PlateImpactShot):
    """Parameters of a plate impact."""

    # A plane shock is of one dimension, whatever the section of the column.
    keeps_particles = True


@dataclass(frozen=True, kw_only=True)
class PlateSetting(Setting):
    """Two plates as their observer needs to know them."""

    speed: float  # m/s
    thicknesses: tuple[float, float]  # flyer, target; m
    section: float  # area of the column, m2 (m2 per radian)
    layer: "np.ndarray"  # (n,) of each particle, counted from the interface


@dataclass(frozen=True)
class Shocks:
    """The exact state behind the shocks, from the Hugoniots us = c0 + s up of both plates."""

    interface: float  # velocity, m/s
    pressure: float  # Pa
    speeds: tuple[float, float]  # of the shocks into flyer and target at rest, m/s
    densities: tuple[float, float]  # behind them, kg/m3


def shocks(flyer: "Material", target: "Material", speed: float) -> Shocks:
    """Impedance match: the interface velocity at which both plates have the same pressure."""

    def pressure(material: "Material", jump: float) -> float:
        return material.density * _shock_speed(material, jump) * jump

    low, high = 0.0, speed
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if pressure(target, middle) < pressure(flyer, speed - middle):
            low = middle
        else:
            high = middle
    jumps = (speed - low, low)
    speeds = (_shock_speed(flyer, jumps[0]), _shock_speed(target, jumps[1]))
    densities = (
        flyer.density * speeds[0] / (speeds[0] - jumps[0]),
        target.density * speeds[1] / (speeds[1] - jumps[1]),
    )
    return Shocks(low, pressure(target, low), speeds, densities)


def _shock_speed(material: "Material", jump: float) -> float:
    c0, s = material.value_at("eos.c0"), material.value_at("eos.s")
    assert c0 is not None
    assert s is not None
    return c0 + s * jump


def _cell(parameters: PlateImpact) -> float:
    return parameters.flyer_thickness / parameters.cells_per_thickness


def _thicknesses(parameters: PlateImpact) -> tuple[float, float]:
    return parameters.flyer_thickness, parameters.target_thickness or parameters.flyer_thickness


def _end_time(parameters: PlateImpact, materials: Materials) -> float:
    if parameters.end_time:
        return parameters.end_time
    flyer, target = materials["flyer"], materials["target"]
    pairs = zip(shocks(flyer, target, parameters.speed).speeds, (flyer, target), _thicknesses(parameters), strict=True)
    return CROSSED * min(thick / max(us, _elastic(parameters, material)) for us, material, thick in pairs)


def _elastic(parameters: PlateImpact, material: "Material") -> float:
    """Speed of an elastic precursor, m/s; a fluid has none."""
    if parameters.strength == "none":
        return 0.0
    stiffness = material.elastic.bulk_modulus + 4.0 / 3.0 * material.elastic.shear_modulus
    return math.sqrt(stiffness / material.density)


def _fill(parameters: PlateImpact) -> PlateImpact:
    return replace(filled_numerics(parameters), target_thickness=round_quantity(_thicknesses(parameters)[1]))


def _check(parameters: PlateImpact, materials: Materials) -> list[Finding]:
    findings = check_numerics(parameters) + check_constants(materials)
    for role in BODIES:
        if materials[role].eos.kind != "mie-grueneisen":
            limit = "a material whose equation of state is a Hugoniot"
            findings.append(Finding(role, materials[role].name, limit, "use mie-grueneisen"))
    if _thicknesses(parameters)[1] < 10.0 * _cell(parameters):
        limit = f"at least ten cells, {10.0 * _cell(parameters):g} m"
        cure = "raise cells_per_thickness, or thicken the target"
        findings.append(Finding("target_thickness", f"{_thicknesses(parameters)[1]:g} m", limit, cure))
    return findings


def _build(parameters: PlateImpact, materials: Materials) -> Setting:
    import numpy as np

    from solver.problem import Problem

    geometry, faces = _grid(parameters)
    flyer, target = _thicknesses(parameters)
    plates = [
        _plate(parameters, "flyer", materials, geometry, (-flyer, 0.0)),
        _plate(parameters, "target", materials, geometry, (0.0, target)),
    ]
    return PlateSetting(
        problem=Problem(
            geometry=geometry,
            bodies=tuple(plate for plate, _ in plates),
            faces=faces,
            end_time=_end_time(parameters, materials),
            **numerics(parameters),
        ),
        sector=SECTORS[parameters.geometry],
        speed=parameters.speed,
        thicknesses=(flyer, target),
        section=_section(parameters),
        layer=np.concatenate([layer for _, layer in plates]),
    )


def _section(parameters: PlateImpact) -> float:
    width = parameters.cells_across * _cell(parameters)
    return 0.5 * width**2 if parameters.geometry == "axisymmetric" else width**2


def _grid(parameters: PlateImpact) -> tuple[Any, tuple[Any, ...]]:
    from solver.problem import Face

    cell = _cell(parameters)
    before, behind = (math.ceil(thick / cell - 1e-9) + BEYOND for thick in _thicknesses(parameters))
    return mesh(
        parameters.geometry,
        across=parameters.cells_across,
        along=before + behind,
        front=-before * cell,
        cell=cell,
        side=(Face.SYMMETRIC, Face.SYMMETRIC),
        flight=(Face.FREE, Face.FREE),
    )


def _plate(
    parameters: PlateImpact, name: str, materials: Materials, geometry: Any, ends: tuple[float, float]
) -> tuple["Body", "np.ndarray"]:
    """A plate, and the layer of each of its particles."""
    import numpy as np

    material = materials[name]
    step = _cell(parameters) / particles_per_cell(parameters)
    across, wide = line(0.0, parameters.cells_across * _cell(parameters), step)
    along, high = line(*ends, step)
    flat = parameters.geometry == "axisymmetric"
    columns = (across, along, np.zeros(1)) if flat else (across, across, along)
    position = points(*columns)
    axis = 1 if flat else 2
    velocity = np.zeros(3)
    velocity[axis] = parameters.speed if name == "flyer" else 0.0
    made = body(
        name,
        _matter(parameters, material),
        geometry,
        position=position,
        spacing=(wide, high, 0.0) if flat else (wide, wide, high),
        velocity=velocity,
        density=material.density,
        volume=_section(parameters) * (ends[1] - ends[0]),
    )
    layer = np.floor(np.abs(position[:, axis]) / high).astype(np.int64)
    return made, layer


def _matter(parameters: PlateImpact, material: "Material") -> "Matter":
    tension = recipe_of(parameters).tension
    made = matter(material, eos_form=parameters.eos_form, tension=tension)
    return made if parameters.strength == "material" else made._replace(shear_modulus=0.0)


def _size(parameters: PlateImpact, materials: Materials) -> Size:
    parameters = filled_numerics(parameters)
    layers = sum(_thicknesses(parameters)) / _cell(parameters) * particles_per_cell(parameters)
    across = parameters.cells_across * particles_per_cell(parameters)
    flat = parameters.geometry == "axisymmetric"
    behind = max(shocks(materials["flyer"], materials["target"], parameters.speed).speeds)
    step = mean_step(parameters, _cell(parameters), sound=behind, speed=parameters.speed)
    return Size(
        particles=round(layers * (across if flat else across**2)),
        steps=math.ceil(_end_time(parameters, materials) / step),
    )


def _cells(parameters: PlateImpact) -> dict[str, float]:
    return {"cells_per_thickness": parameters.cells_per_thickness}


def _rate(parameters: Any, setting: Setting) -> ObservationRate:
    return ObservationRate(interval=setting.problem.end_time / OBSERVATIONS)


def _view(setting: Any, snapshot: Any) -> Any:
    from studies.measurements import _plates

    return _plates.view(setting, snapshot)


SCENARIO = Scenario(
    name="plate_impact",
    title="Plate on plate",
    description="A plate hits a plate face to face; the state behind the plane shocks is measured.",
    parameters=PlateImpact,
    materials=BODIES,
    measurements=(
        "plateau_pressure",
        "plateau_scatter",
        "plateau_velocity",
        "flyer_density",
        "target_density",
        "flyer_density_from_spacing",
        "target_density_from_spacing",
        "flyer_shock_front",
        "target_shock_front",
        "flyer_shock_speed",
        "target_shock_speed",
    ),
    settles=(),
    unused=("jaumann",),  # of strain along one axis, which turns nothing
    fill=_fill,
    check=_check,
    build=_build,
    estimate=_size,
    cells=_cells,
    observer=ObserverOptions(rate=_rate, view=_view),
)
