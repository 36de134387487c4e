"""An elastic bar rebounds from a rigid wall: Ma (2005), section 2.3.1.

A slender bar whose Poisson's ratio is 0 is one-dimensional: it leaves the wall after 2 L / c with all of its momentum.
"""

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from solver.units import Described, Dimensionless, KilogramPerCubicMetre, Metre, MetrePerSecond, Pascal, Second
from studies.scenarios import Materials, ObservationRate, ObserverOptions, Scenario, Setting, Size
from studies.scenarios import _bar as bars
from studies.scenarios._bar import AtWall, Bar, Extent
from studies.scenarios._loading import FASTEST, filled_loading
from studies.scenarios._method import ByBarMethod, check_method
from studies.scenarios._numerics import check_numerics, filled_numerics
from studies.values.errors import Finding
from studies.values.quantities import round_quantity

if TYPE_CHECKING:
    from solver.problem import Matter

TRANSITS = 2.0  # end of a run, in contact times 2 L / c: twice the time at the wall
OBSERVATIONS_PER_TRANSIT = 200  # contact time is read to 0.5 %
# Cells that a wave crosses between observations of a pressed bar, whose peaks are read, and observations at most.
OBSERVED, MOST_OBSERVED = 0.25, 2000
ROOM = 2.0  # cells of grid beside and behind the bar, besides its flight


@dataclass(frozen=True, kw_only=True)
class _ElasticBarShot(AtWall):
    """The bar and its flight."""

    speed: Annotated[
        MetrePerSecond,
        Described("impact speed, normal to the wall; 0 for a bar that loads alone set in motion", 0.0, 1e3),
    ] = 300.0
    bar_length: Annotated[Metre, Described("length of the bar", 1e-5, 1.0)] = 10e-3
    bar_diameter: Annotated[Metre, Described("diameter of the bar, or side of a square one", 1e-5, 1.0)] = 4e-3
    young_modulus: Annotated[Pascal, Described("Young's modulus of the bar", 1e5, 1e13)] = 100e9
    poisson_ratio: Annotated[Dimensionless, Described("Poisson's ratio of the bar", 0.0, 0.49)] = 0.3
    density: Annotated[KilogramPerCubicMetre, Described("density of the bar", 1.0, 3e4)] = 8900.0
    cells_per_diameter: Annotated[Dimensionless, Described("grid cells across the bar's diameter", 2.0, 512.0)] = 4.0
    end_time: Annotated[
        Second | None,
        Described(
            "end of the run; by default twice the contact time 2 L / sqrt(E / rho) of a slender bar", 1e-12, 10.0
        ),
    ] = None


@dataclass(frozen=True, kw_only=True)
class ElasticBar(ByBarMethod, Bar, _ElasticBarShot):
    """Parameters of an elastic bar."""


def transit(parameters: ElasticBar) -> float:
    """Contact time of a slender bar, 2 L / c with c = sqrt(E / rho), s."""
    return 2.0 * parameters.bar_length / _wave_speed(parameters)


def _end_time(parameters: ElasticBar) -> float:
    return parameters.end_time or TRANSITS * transit(parameters)


def _cell(parameters: ElasticBar) -> float:
    return parameters.bar_diameter / parameters.cells_per_diameter


def _shear(parameters: ElasticBar) -> float:
    return parameters.young_modulus / (2.0 * (1.0 + parameters.poisson_ratio))


def _bulk(parameters: ElasticBar) -> float:
    return parameters.young_modulus / (3.0 * (1.0 - 2.0 * parameters.poisson_ratio))


def _wave_speed(parameters: ElasticBar) -> float:
    """Speed of a wave in a slender bar, m/s."""
    return math.sqrt(parameters.young_modulus / parameters.density)


def _extent(parameters: ElasticBar) -> Extent:
    room, sound, end_time = (ROOM * _cell(parameters), _wave_speed(parameters), _end_time(parameters))
    fastest = bars.fastest(parameters, impedance=parameters.density * sound, time=end_time)
    # A bar that is stopped at once widens by the strain v / c at most.
    strain = fastest / sound
    return Extent(
        length=parameters.bar_length,
        diameter=parameters.bar_diameter,
        speed=parameters.speed,
        fastest=fastest,
        cell=_cell(parameters),
        height=parameters.bar_length + fastest * end_time + room,
        radius=0.5 * parameters.bar_diameter * (1.0 + strain) + room,
        end_time=end_time,
    )


def _fill(parameters: ElasticBar) -> ElasticBar:
    if parameters.method != "mpm":
        made = parameters.particles_per_cell or 1
        parameters = replace(parameters, particles_per_cell=made)
    filled = filled_loading(filled_numerics(parameters))
    return replace(filled, end_time=round_quantity(_end_time(parameters)))


def _check(parameters: ElasticBar, materials: Materials) -> list[Finding]:
    sound = _wave_speed(parameters)
    findings = check_method(parameters) + check_numerics(parameters)
    findings += bars.check_bar(parameters, _extent(parameters), density=parameters.density, sound=sound)
    fastest = FASTEST * sound
    if parameters.speed > fastest:
        limit = f"at most {fastest:g} m/s, {FASTEST:g} of the wave speed"
        cure = "choose a lower speed: linear elasticity holds only far below this limit"
        findings.append(Finding("speed", f"{parameters.speed:g} m/s", limit, cure))
    return findings


def _matter(parameters: ElasticBar) -> "Matter":
    from solver.eos.linear_elastic import LinearElastic
    from solver.problem import Matter
    from solver.strength.elastic import Elastic
    from solver.tension.unlimited import UnlimitedTension

    room = 293.0  # K; nothing depends on it
    return Matter(
        eos=LinearElastic(density=parameters.density, bulk_modulus=_bulk(parameters), temperature=room),
        strength=Elastic(),
        tension=UnlimitedTension(),
        shear_modulus=_shear(parameters),
        room_temperature=room,
        melt_temperature=math.inf,
    )


def _build(parameters: ElasticBar, materials: Materials) -> Setting:
    return bars.assemble(parameters, _extent(parameters), _matter(parameters), parameters.density)


def _size(parameters: ElasticBar, materials: Materials) -> Size:
    sound = bars.longitudinal_speed(_bulk(parameters), _shear(parameters), parameters.density)
    return bars.size(parameters, _extent(parameters), sound)


def _cells(parameters: ElasticBar) -> dict[str, float]:
    return {"cells_per_diameter": parameters.cells_per_diameter}


def _rate(parameters: Any, setting: Setting) -> ObservationRate:
    interval = transit(parameters) / OBSERVATIONS_PER_TRANSIT
    if parameters.pressure:
        crossing = OBSERVED * _cell(parameters) / _wave_speed(parameters)
        interval = min(interval, max(crossing, _end_time(parameters) / MOST_OBSERVED))
    return ObservationRate(interval=interval)


SCENARIO = Scenario(
    name="elastic_bar",
    title="Elastic bar on a wall",
    description="An elastic bar hits a rigid frictionless wall end-on and rebounds, or is pressed on it by loads; "
    "contact, momentum, energy, the motion of its free end, and velocity and stress in its middle are measured.",
    parameters=ElasticBar,
    materials=(),
    measurements=(
        "contact_time",
        "rebound_momentum",
        "wall_pull",
        "rigid_energy",
        "vibration_energy",
        "strain_energy",
        "lost_energy",
        "rear_face_place",
        "rear_face_velocity",
        "middle_velocity",
        "middle_stress",
        "middle_peak_velocity",
        "middle_peak_stress",
    ),
    # One body that bears any tension.
    unused=("contact", "friction", "tension"),
    settles=(),
    fill=_fill,
    check=_check,
    build=_build,
    estimate=_size,
    cells=_cells,
    observer=ObserverOptions(rate=_rate, view=bars.view),
    outline=partial(bars.outline, length="bar_length", diameter="bar_diameter"),
)
