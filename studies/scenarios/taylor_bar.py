"""A metal bar flattens against a rigid wall: Taylor (1948), Ma (2005), section 2.3.2."""

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Literal

from solver.units import Described, Dimensionless, Metre, MetrePerSecond, Second
from studies.scenarios import Materials, ObservationRate, ObserverOptions, Scenario, Setting, Size
from studies.scenarios import _bar as bars
from studies.scenarios._bar import AtWall, Bar, Extent
from studies.scenarios._loading import filled_loading
from studies.scenarios._matter import HUGONIOT, check_boiling, check_constants, check_eos, eos_forms, matter
from studies.scenarios._numerics import check_numerics, filled_numerics, has_melting, recipe_of
from studies.values.errors import Finding
from studies.values.parameters import Choice, MaterialName
from studies.values.quantities import round_quantity

if TYPE_CHECKING:
    from studies.materials import Material

# Ma (2005), section 2.3.2: until the kinetic energy no longer changes, 72 us for 25.4 mm.
END_PER_LENGTH = 72e-6 / 25.4e-3  # s/m
WINDOW = 1.0 / 12.0  # of the end time, over which growth is judged: 6 us of 72

SPREAD = 3.0  # radius of the grid over that of the bar: copper at 190 m/s widens to 1.8


@dataclass(frozen=True, kw_only=True)
class _TaylorBarShot(AtWall):
    """The bar and its flight."""

    bar: Annotated[MaterialName, Described("material of the bar")] = "copper-thesis-taylor"
    speed: Annotated[
        MetrePerSecond,
        Described("impact speed, normal to the wall; 0 for a bar that loads alone set in motion", 0.0, 1e3),
    ] = 190.0
    bar_length: Annotated[Metre, Described("length of the bar", 1e-5, 1.0)] = 25.4e-3
    bar_diameter: Annotated[Metre, Described("diameter of the bar, or side of a square one", 1e-5, 1.0)] = 7.6e-3
    cells_per_diameter: Annotated[Dimensionless, Described("grid cells across the bar's diameter", 2.0, 512.0)] = 10.0
    end_time: Annotated[
        Second | None,
        Described("latest end of the run; by default 2.83 ms per metre of length, 72 us at 25.4 mm", 1e-9, 1.0),
    ] = None
    stop: Annotated[
        Literal["settled", "end_time"], Described("end once length and mushroom have settled, or at end_time only")
    ] = "end_time"
    settled_growth: Annotated[
        Dimensionless, Described("relative growth within a twelfth of end_time that counts as settled", 0.0, 0.5)
    ] = 0.005
    thermal_softening: Annotated[
        bool, Described("whether temperature softens and melting takes all strength", acts=has_melting)
    ] = True
    eos_form: Annotated[
        str,
        Choice(eos_forms),
        Described("the material's own equation of state, the thesis' cubic form, or linear elasticity", neutral=True),
    ] = HUGONIOT
    reference_length: Annotated[Metre | None, Described("final length to compare with", 1e-5, 1.0)] = None
    reference_diameter: Annotated[Metre | None, Described("mushroom diameter to compare with", 1e-5, 1.0)] = None
    reference_width: Annotated[Metre | None, Described("width at a fifth of the length to compare with", 1e-5, 1.0)] = (
        None
    )


@dataclass(frozen=True, kw_only=True)
class TaylorBar(Bar, _TaylorBarShot):
    """Parameters of a Taylor bar."""

    # A bar is cheap, and its verification is that of three (docs/recipe.md).
    keeps_particles = True


def _end_time(parameters: TaylorBar) -> float:
    return parameters.end_time or END_PER_LENGTH * parameters.bar_length


def _cell(parameters: TaylorBar) -> float:
    return parameters.bar_diameter / parameters.cells_per_diameter


def _extent(parameters: TaylorBar, material: "Material") -> Extent:
    end_time = _end_time(parameters)
    impedance = material.density * _sound_speed(material)
    fastest = bars.fastest(parameters, impedance=impedance, time=end_time)
    flight = (fastest - parameters.speed) * end_time
    return Extent(
        length=parameters.bar_length,
        diameter=parameters.bar_diameter,
        speed=parameters.speed,
        fastest=fastest,
        cell=_cell(parameters),
        height=parameters.bar_length + flight + 2.0 * _cell(parameters),
        radius=0.5 * SPREAD * parameters.bar_diameter,
        end_time=end_time,
    )


def _sound_speed(material: "Material") -> float:
    elastic = material.elastic
    return bars.longitudinal_speed(elastic.bulk_modulus, elastic.shear_modulus, material.density)


def _fill(parameters: TaylorBar) -> TaylorBar:
    filled = filled_loading(filled_numerics(parameters))
    return replace(filled, end_time=round_quantity(_end_time(parameters)))


def _check(parameters: TaylorBar, materials: Materials) -> list[Finding]:
    findings = (
        check_numerics(parameters)
        + check_constants(materials)
        + check_eos(parameters.eos_form, materials)
        + check_boiling(parameters, materials)
    )
    material = materials["bar"]
    return findings + bars.check_bar(
        parameters, _extent(parameters, material), density=material.density, sound=_sound_speed(material)
    )


def _build(parameters: TaylorBar, materials: Materials) -> Setting:
    material = materials["bar"]
    tension = recipe_of(parameters).tension
    made = matter(
        material, eos_form=parameters.eos_form, thermal_softening=parameters.thermal_softening, tension=tension
    )
    references = (parameters.reference_length, parameters.reference_diameter, parameters.reference_width)
    extent = _extent(parameters, material)
    return bars.assemble(parameters, extent, made, material.density, references)


def _size(parameters: TaylorBar, materials: Materials) -> Size:
    material = materials["bar"]
    return bars.size(parameters, _extent(parameters, material), _sound_speed(material))


def _cells(parameters: TaylorBar) -> dict[str, float]:
    return {"cells_per_diameter": parameters.cells_per_diameter}


def _rate(parameters: Any, setting: Setting) -> ObservationRate:
    return ObservationRate.settling(parameters, WINDOW * _end_time(parameters))


SCENARIO = Scenario(
    name="taylor_bar",
    title="Taylor bar",
    description="A bar hits a rigid frictionless wall end-on, or is pressed on it by loads, and flattens; its final "
    "shape is measured.",
    parameters=TaylorBar,
    materials=("bar",),
    measurements=("final_length", "mushroom_diameter", "width_at_fifth", "taylor_error"),
    unused=("contact", "friction"),  # of one body
    settles=("final_length", "mushroom_diameter"),
    fill=_fill,
    check=_check,
    build=_build,
    estimate=_size,
    cells=_cells,
    observer=ObserverOptions(rate=_rate, view=bars.view),
    outline=partial(bars.outline, length="bar_length", diameter="bar_diameter"),
)
