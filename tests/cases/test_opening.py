"""Matter that opens: pulled apart it takes the work of its spall, and melting takes its strength."""

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from solver.matter.eos import density_at_rest, pressure_terms
from solver.matter.eos.mie_grueneisen import MieGrueneisen
from solver.matter.laws import Matter
from solver.matter.melting import LEAST_SPAN, SKELETON
from solver.matter.strength.perfectly_plastic import PerfectlyPlastic
from solver.matter.stress import PointState, advance
from solver.matter.tension.opening import DILUTE, LINKING, NOTCHED, RICE_TRACEY, OpeningTension
from solver.problem import ArtificialViscosity
from studies import materials
from studies.scenarios.parts.matter import Fracture, matter
from tests.claims.rows import Row, at_least, at_most, equal, relative

METALS = ("al-2017-t4", "al-6061-t6", "copper-ofhc")
RATE = 1e6  # 1/s, as in debris
STEPS = 2000  # of a path
STEP_ERROR = 0.01  # of an energy or a strain along it
EXACT = 1e-9
COLD_ENERGY = 0.03  # of a temperature
THIRD = 0.35  # of the density: that of debris behind a bumper
STILL = ArtificialViscosity(0.0, 0.0)


def opening(name: str, failure: str = "none") -> Matter:
    return matter(materials.load(name), tension="opening", fracture=Fracture(failure=failure))


def at_rest(of: Matter) -> PointState:
    return PointState(of.eos.density, 0.0, 0.0, 0.0, (0.0,) * 6, 0.0, of.room_temperature)


def path(of: Matter, gradient: np.ndarray, time: float, first: PointState | None = None) -> list[PointState]:
    """States of a point that deforms at a gradient (1/s) for a time, each with its energy at its own time."""
    states, dt = [first or at_rest(of)], time / STEPS
    for _ in range(STEPS):
        new, present, _ = advance(of, STILL, 1.0, dt, gradient, states[-1])
        states.append(new._replace(energy=present))
    return states


def pulled(of: Matter) -> list[PointState]:
    """A point that grows evenly to a third of its density."""
    return path(of, np.eye(3) * RATE / 3.0, math.log(1.0 / THIRD) / RATE)


@pytest.mark.claim("debris", "pulled-apart")
@pytest.mark.parametrize("failure", ["none", "void-growth"])
@pytest.mark.parametrize("name", METALS)
def test_matter__that_is_pulled_apart_takes_no_more_than_the_work_of_its_spall(
    name: str, failure: str, compared: Callable[[Row], None]
) -> None:
    """A point that grows to a third of its density takes the largest tension that it bore over the voids that link."""
    of = opening(name, failure)
    assert isinstance(of.eos, MieGrueneisen)
    states = pulled(of)
    largest = max(-state.pressure for state in states)
    spall = largest * (1.0 / (1.0 - LINKING) - 1.0) / of.eos.density
    elastic = largest**2 / (2.0 * of.eos.density * of.eos.density * of.eos.c0**2)
    compared(at_most(f"{name}, {failure}: energy (J/kg)", limit=spall + 2.0 * elastic, got=states[-1].energy))
    compared(equal(f"{name}, {failure}: it has parted", expected=True, got=bool(states[-1].parted > 0.0)))
    compared(equal(f"{name}, {failure}: tension afterwards", expected=0.0, got=float(-states[-1].pressure)))
    parted = next(state for state in states if state.parted > 0.0)
    voids = 1.0 - parted.density / density_at_rest(of.eos, parted.energy)
    compared(relative(f"{name}, {failure}: void fraction", expected=LINKING, got=voids, within=STEP_ERROR))
    compared(relative(f"{name}, {failure}: rate (1/s)", expected=RATE, got=parted.parted, within=EXACT))
    unopened = matter(materials.load(name), tension="recoverable")
    energy = pulled(unopened)[-1].energy
    compared(at_least(f"{name}: energy without opening (J/kg)", limit=2.0 * states[-1].energy, got=energy))


def test_parted_matter__bears_nothing_until_it_is_pressed_and_is_whole_then() -> None:
    of = opening("al-6061-t6")
    thin = pulled(of)[-1]
    sheared = path(of, np.array([[0.0, RATE, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]), 1e-7, thin)[-1]
    assert max(map(abs, sheared.deviator)) <= EXACT * of.shear_modulus
    pressed = path(of, -np.eye(3) * RATE / 3.0, 1.02 * math.log(1.0 / THIRD) / RATE, thin)
    porous = [state for state in pressed[1:] if state.density < 0.95 * density_at_rest(of.eos, state.energy)]
    assert all(state.pressure == 0.0 and state.parted > 0.0 for state in porous)
    assert pressed[-1].pressure > 0.0
    assert pressed[-1].parted == 0.0
    again = path(of, np.eye(3) * RATE / 3.0, 0.05 / RATE, pressed[-1])[-1]
    assert again.pressure < 0.0


@pytest.mark.claim("debris", "stretched")
def test_matter__that_is_stretched_to_a_sheet_parts_without_growing(compared: Callable[[Row], None]) -> None:
    """A bar that is stretched at constant volume parts at the strain at which Rice and Tracey's voids link."""
    of = opening("al-6061-t6")
    first = at_rest(of)._replace(density=0.97 * of.eos.density)  # under tension
    states = path(of, np.diag([RATE, -0.5 * RATE, -0.5 * RATE]), 1.5 / RATE, first)
    grown = [
        RICE_TRACEY * math.exp(1.5 * min(_triaxiality(new), NOTCHED)) * (new.plastic_strain - old.plastic_strain)
        for old, new in pairwise(states)
        if new.pressure < 0.0 and not old.parted
    ]
    count = next(number for number, state in enumerate(states) if state.parted > 0.0)
    compared(
        relative("logarithm of the growth", expected=math.log(LINKING / DILUTE), got=sum(grown), within=STEP_ERROR)
    )
    compared(relative("rate (1/s)", expected=RATE, got=states[count].parted, within=EXACT))
    sheet = states[-1].density / of.eos.density
    compared(at_least("density afterwards, of that at rest", limit=0.96, got=float(sheet)))


def _triaxiality(state: PointState) -> float:
    a, b, c, d, e, f = state.deviator
    return float(-state.pressure / math.sqrt(1.5 * (a * a + b * b + c * c + 2.0 * (d * d + e * e + f * f))))


@pytest.mark.claim("debris", "melting-range")
@pytest.mark.parametrize("name", METALS)
def test_melting__takes_the_latent_heat_between_solidus_and_liquidus(
    name: str, compared: Callable[[Row], None]
) -> None:
    """A point at 1 bar with the heat to its solidus, and parts of the heat from there on, has the temperatures between.

    The equation of state keeps a part of the heat as cold energy of stretched matter, which is the difference.
    """
    of, thermal = opening(name), materials.load(name).thermal
    sourced = thermal.solidus, thermal.liquidus, thermal.heat_to_solidus, thermal.latent_heat_of_fusion
    solidus, liquidus, to_solidus, latent = (value or math.nan for value in sourced)
    span = max(liquidus - solidus, LEAST_SPAN)
    for part in (0.0, 0.1, 0.5, 1.0):
        energy = to_solidus + part * (latent + of.eos.heat_capacity * span)
        density = density_at_rest(of.eos, energy)
        cold, heat = pressure_terms(of.eos, density, energy)
        point = at_rest(of)._replace(density=density, energy=energy, pressure=cold + heat * energy)
        new = advance(of, STILL, 1.0, 1e-12, np.zeros((3, 3)), point)[0]
        where = f"{name}, {part:g} of the heat of melting: temperature (K)"
        compared(relative(where, expected=solidus + part * span, got=new.temperature, within=COLD_ENERGY))


@pytest.mark.parametrize("solid", [1.0, 0.9, SKELETON, 0.5])
def test_strength_and_tension__fall_with_the_solid_share(solid: float) -> None:
    of = opening("al-2017-t4")
    assert isinstance(of.strength, PerfectlyPlastic)
    assert isinstance(of.tension, OpeningTension)
    kelvin = of.melting.solidus + (1.0 - solid) * of.melting.span
    left = max(0.0, (solid - SKELETON) / (1.0 - SKELETON))
    point = at_rest(of)._replace(temperature=kelvin, density=0.96 * of.eos.density)
    sheared = advance(of, STILL, 1.0, 1e-7, np.array([[0.0, RATE, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]), point)[0]
    equivalent = math.sqrt(3.0) * abs(sheared.deviator[3])
    assert equivalent == pytest.approx(left * of.strength.yield_stress, rel=1e-6, abs=1.0)
    assert -sheared.pressure == pytest.approx(left * of.tension.cutoff, rel=1e-6, abs=1.0)
