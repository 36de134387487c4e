"""Melting under pressure: exact answers at a point and on release."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from solver.matter.eos import pressure_terms, sound_speed_squared, temperature_at
from solver.matter.eos.mie_grueneisen import MieGrueneisen
from solver.matter.laws import Matter
from solver.matter.melting import melted_share, melting_point, onset_of_melting, residual_energy
from solver.matter.stress import PointState, advance
from solver.matter.tension.unlimited import UnlimitedTension
from solver.problem import ArtificialViscosity
from studies import materials
from studies.scenarios.parts.matter import matter
from tests.cases.verification.solutions.hugoniot import Solid, shocked
from tests.claims.rows import Row, absolute, at_most, equal, relative
from tests.contracts.test_scenarios import asked, built
from tests.solver.bodies import after

METALS = ("al-2024-t3", "al-6061-t6", "al-7075-t6", "copper-ofhc", "lead", "ti-6al-4v", "tungsten")
EXACT = 1e-10
RATIOS = (0.9, 1.0, 1.1, 1.3)  # densities over that at rest
STEPS = 2000  # of a release at a point
RELEASED = 1e-5  # of the residual energy: the slope of the isentrope has a kink at rest
# Pressures of incipient and of complete melting on release (GPa), computed with other constants of the same form:
# constant gamma rho and c_v, melting points of the pure metals.
THRESHOLDS = {"al-6061-t6": ("60 to 63", "84"), "copper-ofhc": ("127 to 135", "167")}
DRIFT = 1e-10


def _fluid(name: str) -> Matter:
    """The matter of a material without shear, under any tension."""
    return matter(materials.load(name))._replace(shear_modulus=0.0, tension=UnlimitedTension())


def _form(of: Matter) -> MieGrueneisen:
    """The equation of state, which is that of all materials here."""
    assert isinstance(of.eos, MieGrueneisen)
    return of.eos


def _stretched(of: Matter) -> float:
    """The density ratio at 1 bar of matter at its melting point: rho0 c0^2 mu + gamma0 rho e = 0."""
    heat = _form(of).gamma0 * of.eos.heat_capacity * (of.melt_temperature - of.eos.temperature)
    return float(_form(of).c0 ** 2 / (_form(of).c0 ** 2 + heat))


def _lindemann(name: str, of: Matter, ratio: float) -> float:
    """The melting point of the closed formula, K, through the given one at 1 bar."""
    a = materials.load(name).thermal.melting_slope
    assert a is not None
    least = _stretched(of)
    ratio = max(ratio, least)
    rise = math.exp(2.0 * a * (1.0 / least - 1.0 / ratio))
    return float(of.melt_temperature * rise * (ratio / least) ** (2.0 * (_form(of).gamma0 - a - 1.0 / 3.0)))


def _heated(of: Matter, ratio: float, kelvin: float) -> float:
    """The energy (J/kg) to which the equation of state gives a temperature at a density ratio."""
    return float(of.eos.heat_capacity * (kelvin - temperature_at(of.eos, ratio * of.eos.density, 0.0)))


def _held(of: Matter, ratio: float, energy: float) -> tuple[PointState, bool]:
    """A point held at a density and an energy, and whether it counts as molten in the step after."""
    point = PointState(ratio * of.eos.density, energy, 0.0, 0.0, (0.0,) * 6, 0.0, of.room_temperature)
    still = np.zeros((3, 3))
    point = advance(of, ArtificialViscosity(), 1.0, 1e-9, still, point)[0]
    return point, bool(advance(of, ArtificialViscosity(), 1.0, 1e-9, still, point)[2].molten)


@pytest.mark.claim("breaking", "melting-at-a-point")
@pytest.mark.parametrize("name", METALS)
def test_melting__has_the_pressure_the_plateau_and_the_heat_of_the_formula(
    name: str, compared: Callable[[Row], None]
) -> None:
    """A point heated at a density melts at the pressure of the formula, and stays so hot for its latent heat."""
    of, latent = _fluid(name), materials.load(name).thermal.latent_heat_of_fusion
    assert latent is not None
    eos = _form(of)
    for ratio in RATIOS:
        melt = _lindemann(name, of, ratio)
        onset = _heated(of, ratio, melt)
        mu = ratio - 1.0
        pole = 1.0 - (eos.s - 1.0) * max(mu, 0.0)
        cold = eos.density * eos.c0**2 * mu * ((1.0 + mu) / pole**2 if mu > 0.0 else 1.0)
        cold *= 1.0 - 0.5 * eos.gamma0 * max(mu, 0.0) / ratio
        pressure = cold + eos.gamma0 * eos.density * min(ratio, 1.0) * onset
        where = f"{name}, {ratio:g} of the density"
        point, _ = _held(of, ratio, onset)
        compared(relative(f"{where}: pressure of melting (Pa)", expected=pressure, got=point.pressure, within=EXACT))
        for part, hotter in ((-1e-6, -1e-6), (0.0, 0.0), (1e-6, 0.0), (0.5, 0.0), (1.0, 0.0), (1.5, 0.5)):
            point, molten = _held(of, ratio, onset + part * latent)
            expected = melt + hotter * latent / eos.heat_capacity
            claim = f"{where}, {part:g} of the latent heat"
            compared(relative(f"{claim}: temperature (K)", expected=expected, got=point.temperature, within=EXACT))
            if part != 0.0:  # the onset itself belongs to either
                compared(equal(f"{claim}: molten", expected=part > 0.0, got=molten))


@pytest.mark.claim("breaking", "melting-on-a-path")
@pytest.mark.parametrize("name", ["al-6061-t6", "copper-ofhc"])
def test_melting__comes_where_an_isentrope_meets_the_curve(name: str, compared: Callable[[Row], None]) -> None:
    """A hot point that expands at constant entropy melts at the pressure at which its isentrope meets the curve."""
    of = _fluid(name)
    eos, dense, thin = _form(of), 1.3, 1.05

    def kelvin(ratio: float) -> float:
        """T on the isentrope through a point just solid at 1.15 of the density: gamma rho is constant."""
        return _lindemann(name, of, 1.15) * math.exp(eos.gamma0 * (1.0 / 1.15 - 1.0 / ratio))

    meets = brentq(lambda ratio: kelvin(ratio) - _lindemann(name, of, ratio), 1.05, 1.3)
    cold, thermal = pressure_terms(eos, meets * eos.density, 0.0)
    expected = cold + thermal * _heated(of, meets, kelvin(meets))
    step = (dense / thin) ** (1.0 / STEPS) - 1.0
    energy = _heated(of, dense, kelvin(dense))
    cold, thermal = pressure_terms(eos, dense * eos.density, energy)
    first = PointState(dense * eos.density, energy, cold + thermal * energy, 0.0, (0.0,) * 6, 0.0, kelvin(dense))
    point, before, molten = first, first, False
    while not molten and point.density > thin * eos.density:
        before = point
        new, present, acts = advance(of, ArtificialViscosity(), 1.0, 1.0, np.diag([step, 0.0, 0.0]), point)
        point, molten = new._replace(energy=present), acts.molten
    compared(equal(f"{name}: it melts", expected=True, got=molten))
    slope = float(sound_speed_squared(eos, before.density, before.energy, before.pressure)) * before.density
    within = 2.0 * step * slope / expected  # two steps: it counts as molten in the one after
    compared(relative(f"{name}: pressure (Pa)", expected=expected, got=before.pressure, within=within))


@pytest.mark.claim("breaking", "melting-on-release")
@pytest.mark.parametrize("name", THRESHOLDS)
def test_residual_energy__is_that_of_the_isentrope(name: str, compared: Callable[[Row], None]) -> None:
    """Pressed matter keeps the energy of the closed isentrope on release; thresholds of melting beside a table."""
    of = _fluid(name)
    eos = _form(of)
    gamma, c0 = eos.gamma0, eos.c0

    def energy_at(ratio: float, warm: float) -> float:
        """On the isentrope in expansion from an energy at rest: de / dx = c0^2 (x - 1) / x^2 + gamma0 e / x."""
        start = warm + c0**2 * (1.0 / gamma - 1.0 / (1.0 + gamma))
        return float(start * ratio**gamma + c0**2 * (1.0 / ((1.0 + gamma) * ratio) - 1.0 / gamma))

    def slope(ratio: float, state: np.ndarray) -> list[float]:
        cold, thermal = pressure_terms(eos, ratio * eos.density, state[0])
        return [float(cold + thermal * state[0]) / (eos.density * ratio**2)]

    for warm, dense in ((0.2e6, 1.2), (0.5e6, 1.4), (1e6, 1.6)):
        released = brentq(lambda x, warm=warm: c0**2 * (x - 1.0) + gamma * x * energy_at(x, warm), 0.5, 1.0)
        pressed = solve_ivp(slope, (1.0, dense), [warm], rtol=1e-11, atol=1e-3).y[0, -1]
        cold, thermal = pressure_terms(eos, dense * eos.density, pressed)
        got = float(residual_energy(eos, dense * eos.density, pressed, cold + thermal * pressed))
        where = f"{name}, {dense:g} of the density, {warm / 1e6:g} MJ/kg at rest"
        expected = energy_at(released, warm)
        compared(relative(f"{where}: residual energy (J/kg)", expected=expected, got=got, within=RELEASED))

    solid = Solid(name, eos.density, c0, eos.s, gamma)
    onset, latent = onset_of_melting(of), of.melting.fusion * eos.heat_capacity

    def left(speed: float) -> float:
        shock = shocked(solid, speed)
        return float(residual_energy(eos, shock.density, shock.energy, shock.pressure))

    for share, kind, others in zip((0.0, 1.0), ("incipient", "complete"), THRESHOLDS[name], strict=True):
        speed = brentq(lambda u, share=share: left(u) - onset - share * latent, 500.0, 9e3)
        pressure = shocked(solid, speed).pressure / 1e9
        claim = f"{name}: pressure of {kind} melting on release (GPa), like on like at {2e-3 * speed:.3g} km/s"
        compared(Row(claim, others, pressure, None))
        below, above = (melted_share(np.array(left(speed * side)), onset, latent) for side in (0.999, 1.001))
        compared(equal(f"{name}: {kind} there", expected=True, got=bool(below < above)))


@pytest.mark.claim("breaking", "melting-curves")
def test_melting_point__rises_with_density_from_the_given_one(compared: Callable[[Row], None]) -> None:
    """The melting point of every material is the given one at its density, never falls with it, and stays below."""
    ratios = np.linspace(0.2, 2.5, 231)
    for name in materials.names():
        of = matter(materials.load(name))
        if math.isinf(of.melt_temperature):
            continue
        curve = melting_point(of, ratios)
        given = float(melting_point(of, of.melting.anchor))
        compared(relative(f"{name}: melting point (K)", expected=of.melt_temperature, got=given, within=EXACT))
        compared(equal(f"{name}: never falls", expected=True, got=bool((np.diff(curve) >= 0.0).all())))
        lowest = float(melting_point(of, of.melting.thinnest))
        compared(absolute(f"{name}: thinned to a fifth (K)", expected=lowest, got=float(curve[0]), within=0.0))


@pytest.mark.claim("breaking", "melting-keeps-energy", minutes=0.2)
def test_melting__keeps_the_energy(compared: Callable[[Row], None]) -> None:
    """An impact in which matter melts keeps its energy, and none of it is hotter than its equation of state says."""
    metals = {"projectile": "al-2024-t3", "target": "al-6061-t6"}
    simulation = after(built(asked("debris_cloud", speed=8000.0, cells_per_diameter=8.0, **metals)).problem, 120)
    particles, lower, melting = simulation.particles, 0.0, 0
    for number, body in enumerate(simulation.problem.bodies):
        mine = (simulation.snapshot().body == number) & (particles.alive == 1)
        eos = body.matter.eos
        point = melting_point(body.matter, particles.density[mine] / eos.density)
        on_plateau = np.abs(particles.temperature[mine] / point - 1.0) < EXACT
        melting += int(on_plateau.sum())
        felt = particles.temperature[mine] - temperature_at(eos, particles.density[mine], particles.energy[mine])
        lower = min(lower, float(felt.min()))
    compared(equal("some matter is melting", expected=True, got=melting > 0))
    compared(equal("and cooler for it", expected=True, got=lower < -1.0))
    compared(at_most("drift of the energy", limit=DRIFT, got=abs(simulation.audit().energy_drift)))
