"""How fine a cloud would break, beside the pieces that the mesh made of it: known expansions and known pieces."""

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from solver.simulation import start
from studies.clouds.fragments import SIZES
from studies.debris.cloud import CloudView, view
from studies.measurements import distributions
from studies.quantities.measured import COARSER_THAN_FRAGMENTS
from tests.claims.rows import Row, absolute, equal, relative
from tests.contracts.test_scenarios import asked, built
from tests.studies.clouds.samples import BALLS, two_balls
from tests.studies.clouds.test_clouds import through
from tests.studies.debris.made import TOUGH, ball, cloud
from tests.studies.measurements.states import DENSITY, THICKNESS, read, reordered, value

Compared = Callable[[Row], None]
RATE = 3e5  # 1/s, along each direction
EXACT = 1e-12
PROJECTILE = 9e-3  # m: spheres of 4 and 5 mm are then in the middle of two bins
# Of a cloud with the volume growing at 3 RATE, by hand.
VOLUME = 3.0 * RATE
SIZES_BY_HAND = {
    "brittle": (math.sqrt(24.0) * 3e7 / (DENSITY * 4000.0 * VOLUME)) ** (2.0 / 3.0),
    "ductile": math.sqrt(8.0 * 3e8 * 0.15 / (DENSITY * VOLUME**2)),
    "liquid": (48.0 * 1.0 / (DENSITY * VOLUME**2)) ** (1.0 / 3.0),
}


def expanding(**changes: Any) -> CloudView:
    """A ball of the target that has flown behind the plate, each velocity that of its first place."""
    places = ball(3e-3, 0.5 * THICKNESS)
    velocity = RATE * places + np.array([0.0, 0.0, 4000.0])
    flown = 10e-6
    return cloud(places + flown * velocity + np.array([0.0, 0.0, THICKNESS]), velocity, initial=places, **changes)


@pytest.mark.claim("breaking", "grady-size")
def test_sizes__of_an_even_expansion_are_those_of_the_closed_form(compared: Compared) -> None:
    """A cloud whose velocities are those of its places before the impact has Grady's sizes to twelve digits."""
    state = expanding()
    got = read("expansion_rate", state).value
    compared(relative("rate at which the volume grows (1/s)", expected=VOLUME, got=got, within=EXACT))
    for way, size in SIZES_BY_HAND.items():
        got = read(f"fragment_size_{way}", state).value
        compared(relative(f"{way} size (m)", expected=size, got=got, within=EXACT))
    got = read("fragment_size_grady", state).value
    least = min(SIZES_BY_HAND["brittle"], SIZES_BY_HAND["ductile"])
    compared(relative("size of solid fragments (m)", expected=least, got=got, within=EXACT))


@pytest.mark.claim("breaking", "grady-size")
@pytest.mark.parametrize("geometry", ["axisymmetric", "quarter", "half"])
def test_rate__of_a_cloud_is_that_of_its_whole_body_in_every_geometry(geometry: str, compared: Compared) -> None:
    """The rate of expansion of a projectile that flies apart evenly is the same in every geometry and at every time."""
    setting = built(asked("debris_cloud", geometry=geometry))
    snapshot = start(setting.problem).snapshot()
    snapshot.particles.velocity[:] = RATE * snapshot.particles.position
    along = 1 if geometry == "axisymmetric" else 2
    snapshot.particles.velocity[:, along] += setting.speed
    for flights in (20.0, 200.0):
        time = flights * setting.projectile_diameter / setting.speed
        got = read("expansion_rate", view(setting, through(setting, snapshot, time))).value
        text = f"{geometry}, {flights:g} diameters of flight: rate (1/s)"
        compared(relative(text, expected=VOLUME, got=got, within=EXACT))


@pytest.mark.parametrize(
    ("constant", "flag", "lost"),
    [
        ("fracture_toughness", "no_fracture_toughness", ("brittle", "grady")),
        ("yield_stress", "no_yield_stress", ("ductile", "grady")),
        ("surface_tension", "no_surface_tension", ("liquid",)),
    ],
)
def test_size__without_its_constant_is_refused_by_name(constant: str, flag: str, lost: tuple[str, ...]) -> None:
    without = dataclasses.replace(TOUGH, **{constant: None})  # type: ignore[arg-type]
    state = expanding(breakup=(TOUGH, without))
    for way in ("brittle", "ductile", "grady", "liquid"):
        reading = read(f"fragment_size_{way}", state)
        assert math.isnan(reading.value) == (way in lost)
        assert reading.flags == ((flag,) if way in lost else ())
    # No matter of the projectile flies there.
    assert read("fragment_size_grady", expanding(breakup=(without, TOUGH))).flags == ()


def test_size__of_what_flies_as_one_is_none() -> None:
    state = expanding()
    state = dataclasses.replace(
        state, transverse_velocity=0.0 * state.mass, axial_velocity=np.full_like(state.mass, 4e3)
    )
    assert read("fragment_size_grady", state).flags == ("not_expanding",)
    assert read("expansion_rate", state).value == 0.0


@pytest.mark.claim("breaking", "coarse-mesh")
@pytest.mark.parametrize("name", ["fragments", "largest_fragment"])
def test_pieces__of_a_mesh_coarser_than_fragments_are_flagged(name: str, compared: Compared) -> None:
    """Pieces are flagged where a cell is larger than the nominal fragment, and not where it is smaller."""
    solid = min(SIZES_BY_HAND["brittle"], SIZES_BY_HAND["ductile"])
    soft = dataclasses.replace(TOUGH, fracture_toughness=None)
    ductile = SIZES_BY_HAND["ductile"]
    for text, cell, breakup, flags in (
        ("larger", 1.01 * solid, TOUGH, (COARSER_THAN_FRAGMENTS,)),
        ("smaller", 0.99 * solid, TOUGH, ()),
        ("larger than ductile, toughness unknown", 1.01 * ductile, soft, (COARSER_THAN_FRAGMENTS,)),
        ("smaller than ductile, toughness unknown", 0.99 * ductile, soft, ("fragment_size_unknown",)),
    ):
        got = read(name, expanding(cell=cell, breakup=(breakup, breakup))).flags
        compared(equal(f"{name}, cell {text}: flags", expected=flags, got=got))
    # Drops are finer than solid fragments: a cloud that is mostly liquid is held against them.
    hot = np.full(expanding().mass.size, 5e6)  # J/kg
    drop = SIZES_BY_HAND["liquid"]
    for cell, flags in ((1.01 * drop, (COARSER_THAN_FRAGMENTS,)), (0.99 * drop, ())):
        got = read(name, expanding(cell=cell, residual=hot)).flags
        compared(equal(f"{name}, liquid, cell {cell / drop:.2f} drops: flags", expected=flags, got=got))


@pytest.mark.claim("breaking", "sizes")
def test_distribution__has_the_known_pieces_in_the_bins_of_their_sizes(compared: Compared) -> None:
    """Two spheres of known mass, and four of each in a quarter model, stand in the bins of their sizes."""
    state = dataclasses.replace(two_balls(), diameter=PROJECTILE)
    masses = [float(state.mass[state.projectile == first].sum()) for first in (True, False)]
    for copies in (1.0, 4.0):
        several = dataclasses.replace(state, copies=np.full(state.mass.size, copies), mass=copies * state.mass)
        number, mass = (
            distributions.load(f"{name}_over_size").read(several) for name in ("fragments", "fragment_mass")
        )
        for each, (radius, _, _) in zip(masses, BALLS, strict=True):
            size = math.cbrt(6.0 / math.pi * each / DENSITY)
            assert size == pytest.approx(2.0 * radius, rel=0.02)
            place = math.floor((math.log10(size / PROJECTILE) - SIZES.begin) / SIZES.width)
            text = f"{copies:g} spheres of {1e3 * size:.1f} mm"
            compared(equal(f"{text}: pieces", expected=copies, got=float(number[place])))
            compared(relative(f"{text}: mass (kg)", expected=copies * each, got=float(mass[place]), within=EXACT))
        text = "mass in all bins over that behind the plate, less 1"
        got = mass.sum() / value("mass_behind", several) - 1.0
        compared(absolute(text, expected=0.0, got=got, within=EXACT))
        assert number.sum() == 2.0 * copies
        shuffled = distributions.load("fragments_over_size").read(reordered(several))
        np.testing.assert_array_equal(shuffled, number)


def test_distribution__takes_the_volume_of_a_piece_at_the_density_of_its_own_matter() -> None:
    """The projectile's sphere is of matter eight times lighter: with the same mass it is twice as large."""
    light = dataclasses.replace(TOUGH, density=DENSITY / 8.0)
    state = dataclasses.replace(two_balls(), diameter=PROJECTILE, breakup=(light, TOUGH))
    number = distributions.load("fragments_over_size").read(state)
    sizes = np.array([2.0 * 2.0 * BALLS[0][0], 2.0 * BALLS[1][0]])  # the first ball is the projectile's
    expected = np.floor((np.log10(sizes / PROJECTILE) - SIZES.begin) / SIZES.width)
    np.testing.assert_array_equal(np.flatnonzero(number), np.sort(expected))
