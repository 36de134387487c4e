"""Johnson and Cook's damage at a point against its integral in closed form, and the heat of plastic work."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from solver.matter.eos.linear_elastic import LinearElastic
from solver.matter.failure.johnson_cook import JohnsonCookDamage, ModifiedJohnsonCookDamage, fracture_strain
from solver.matter.failure.none import NoFailure
from solver.matter.laws import Matter
from solver.matter.strength.johnson_cook import ModifiedJohnsonCook
from solver.matter.stress import PointState, advance
from solver.matter.tension.unlimited import UnlimitedTension
from solver.matter.tensor import equivalent_stress
from solver.problem import ArtificialViscosity
from solver.simulation import simulate
from studies import materials
from studies.runs.execution import execute
from studies.runs.stages import setting_of
from studies.scenarios.parts.matter import matter
from studies.sweeps.sweep import Sweep
from tests.cases.verification import bits
from tests.claims.rows import Row, absolute, at_least, at_most, equal, relative

WELDOX = materials.load("weldox-460-e")
HALF_DIGIT = 0.5e-3  # of the published fracture strains, 1.504 and 1.517

# Constant conditions: damage is linear in the plastic strain, and each step adds its part without an error of its own.
DAMAGE_ROUND_OFF = 1e-9
STEPS = (200, 400)  # up to failure
STRESS = 5e-3  # of the exact stress, with the fewer steps
ORDER = 0.15  # about 1
HEAT = 1e-3  # of the exact rise of the temperature
TRIES = 3
STRETCH = np.diag([1.0, -0.5, -0.5])


@dataclass(frozen=True)
class Held:
    """What a point is held at while it is sheared; the last two change a constant of Weldox."""

    triaxiality: float
    rate: float  # 1/s
    homologous: float
    threshold: float = 0.0
    D5: float = 0.0

    def __str__(self) -> str:
        return f"triaxiality {self.triaxiality:.3g}, {self.rate:g}/s, T* {self.homologous:g}, p_d {self.threshold:g}"


CASES = (Held(1.0 / 3.0, 5e-4, 0.0), Held(1.0, 1e4, 0.3, 0.05, 1.5), Held(-0.2, 10.0, 0.1))


def _damage(record: Any, held: Held) -> Any:
    constants = dict(WELDOX.taken(record))
    return record(**constants | {"threshold": held.threshold, "D5": held.D5})


def _ductility(failure: Any, held: Held) -> float:
    """The fracture strain itself, by its equation."""
    rate = held.rate / failure.reference_rate
    power = isinstance(failure, ModifiedJohnsonCookDamage)
    rated = (1.0 + rate) ** failure.D4 if power else 1.0 + failure.D4 * math.log(max(rate, 1.0))
    ductility = failure.D1 + failure.D2 * math.exp(failure.D3 * held.triaxiality)
    return ductility * rated * (1.0 + failure.D5 * held.homologous)


def _stress(failure: Any, held: Held, strain: float, limit: float) -> float:
    """(1 - D) [A + B r^n] (1 + rate*)^C (1 - T*^m), Pa: D and r integrated over the strain."""
    law = matter(WELDOX).strength
    assert isinstance(law, ModifiedJohnsonCook)
    assert law.m is not None
    grown = max(strain - failure.threshold, 0.0)
    slope = failure.critical_damage / (limit - failure.threshold)
    hardened = strain - 0.5 * slope * grown * grown
    rated = (1.0 + held.rate / law.reference_rate) ** law.C
    warm = 1.0 - held.homologous**law.m
    return float((1.0 - slope * grown) * (law.A + law.B * hardened**law.n) * rated * warm)


def _sheared(of: Matter, held: Held, end: float, steps: int) -> tuple[list[PointState], float]:
    """States of a whole point at constant triaxiality, rate and temperature, and the strain of a step.

    A try gives the stress of a step, and the density of the next one the pressure that belongs to it; thinner matter is
    softer, so that the stress changes with it by some 1e-8.
    """
    solid = of.eos
    assert isinstance(solid, LinearElastic)
    kelvin = of.room_temperature + held.homologous * (of.melt_temperature - of.room_temperature)
    gradient, dt = held.rate * STRETCH, end / held.rate / steps
    states = [PointState(solid.density, 0.0, 0.0, 0.0, (0.0,) * 6, 0.0, kelvin)]
    begin = solid.density
    for _ in range(steps):
        # The first try has the density of the step before: without its pressure matter could fail in a try.
        old = states[-1]._replace(density=begin, energy=0.0, temperature=kelvin)
        for _ in range(TRIES):
            new = advance(of, ArtificialViscosity(), 1.0, dt, gradient, old)[0]
            if new.damage >= 1.0:
                return states, end / steps
            pressure = -held.triaxiality * equivalent_stress(new.deviator)
            density = solid.density * (1.0 + pressure / solid.bulk_modulus)
            old = old._replace(density=density * old.density / new.density)
        states.append(new)
        begin = old.density
    return states, end / steps


def _steel(failure: Any) -> Matter:
    solid = LinearElastic(
        density=WELDOX.density,
        bulk_modulus=WELDOX.elastic.bulk_modulus,
        temperature=WELDOX.thermal.room_temperature,
        heat_capacity=WELDOX.thermal.heat_capacity,
    )
    return matter(WELDOX)._replace(eos=solid, tension=UnlimitedTension(), failure=failure)


@pytest.mark.claim("methods", "fracture-strain")
def test_fracture_strain__is_the_published_one(compared: Callable[[Row], None]) -> None:
    """The fracture strain of Weldox 460 E at a triaxiality of 1/3 is 1.504 at rate* = 1 and 1.517 at rate* = 0."""
    weldox = _damage(ModifiedJohnsonCookDamage, CASES[0])
    for rate, expected in ((weldox.reference_rate, 1.504), (0.0, 1.517)):
        compared(
            absolute(
                f"rate* = {rate / weldox.reference_rate:g}",
                expected=expected,
                got=fracture_strain(weldox, 1.0 / 3.0, rate, 0.0),
                within=HALF_DIGIT,
            )
        )


@pytest.mark.claim("methods", "damage-at-a-point")
def test_damage__is_its_integral(compared: Callable[[Row], None]) -> None:
    """At constant triaxiality, rate and temperature damage is its integral, and its stress comes with the order 1.

    Matter fails at the fracture strain; the weakened stress is (1 - D) [A + B r^n] (1 + rate*)^C (1 - T*^m).
    """
    for record in (ModifiedJohnsonCookDamage, JohnsonCookDamage):
        form = "power" if record is ModifiedJohnsonCookDamage else "logarithm"
        for held in CASES if form == "power" else CASES[1:2]:
            failure = _damage(record, held)
            limit = _ductility(failure, held)
            missed: list[float] = []
            for steps in STEPS:
                whole, step = _sheared(_steel(failure), held, limit + 0.05, steps)
                middle = whole[len(whole) // 2]
                exact = _stress(failure, held, middle.plastic_strain, limit)
                missed.append(abs(equivalent_stress(middle.deviator) / exact - 1.0))
            where = f"{form}, {held}"
            used = (middle.plastic_strain - failure.threshold) / (limit - failure.threshold)
            compared(
                relative(
                    f"{where}: damage at half of the way", expected=used, got=middle.damage, within=DAMAGE_ROUND_OFF
                )
            )
            compared(
                absolute(
                    f"{where}: plastic strain in the last step before failure",
                    expected=limit - 0.5 * step,
                    got=whole[-1].plastic_strain,
                    within=0.5 * step,
                )
            )
            compared(
                absolute(
                    f"{where}: distance of the stress ({STEPS[0]} steps)", expected=0.0, got=missed[0], within=STRESS
                )
            )
            order = math.log2(missed[0] / missed[1])
            compared(absolute(f"{where}: its order", expected=1.0, got=order, within=ORDER))


@pytest.mark.claim("methods", "heat-of-plastic-work")
def test_plastic_work__warms_matter_by_its_share(compared: Callable[[Row], None]) -> None:
    """Sheared without heat flow matter warms by alpha times its plastic work, and by its elastic energy."""
    # Without thermal softening: the plastic work has a closed form.
    steel = _steel(NoFailure())._replace(melt_temperature=math.inf)
    law, rate, steps = steel.strength, 1e3, STEPS[1]
    assert isinstance(law, ModifiedJohnsonCook)
    point = PointState(WELDOX.density, 0.0, 0.0, 0.0, (0.0,) * 6, 0.0, steel.room_temperature)
    for _ in range(steps):
        point, energy, _ = advance(steel, ArtificialViscosity(), 1.0, 1.0 / rate / steps, rate * STRETCH, point)
        point = point._replace(density=WELDOX.density, energy=energy)
    strain, rated = point.plastic_strain, (1.0 + rate / law.reference_rate) ** law.C
    plastic = rated * (law.A * strain + law.B * strain ** (law.n + 1.0) / (law.n + 1.0))
    elastic = equivalent_stress(point.deviator) ** 2 / (6.0 * steel.shear_modulus)
    capacity = WELDOX.density * WELDOX.thermal.heat_capacity
    compared(
        relative(
            "rise of the temperature at a strain of 1 (K)",
            expected=(law.alpha * plastic + elastic) / capacity,
            got=point.temperature - steel.room_temperature,
            within=HEAT,
        )
    )


# Fast enough that damage breaks matter within 20 us.
SWEEP = {
    "scenario": "thin_plate",
    "fixed": {
        "projectile": "arne-bilinear",
        "target": "weldox-460-e",
        "speed": "600 m/s",
        "projectile_shape": "cylinder",
        "projectile_length": "20 mm",
        "projectile_diameter": "20 mm",
        "plate_thickness": "6 mm",
        "plate_radius": "40 mm",
        "cells_per_diameter": 10,
        "end_time": "20 us",
    },
    "axes": {"failure": ["none", "modified-johnson-cook"]},
}
STEPS_OF_RESTART, STOPPED_AFTER = 220, 120  # across two reorderings of the particles
DRIFT = 1e-12  # of the energy, round-off


@pytest.mark.claim("methods", "damage-from-a-sweep", minutes=1.0)
def test_damage__of_a_sweep_breaks_matter_and_keeps_bits_and_energy(
    compared: Callable[[Row], None], tmp_path: Path
) -> None:
    """A sweep computes a plate of Weldox 460 E with damage and without; damage breaks matter.

    It keeps the balance of energy, and neither threads nor a restart change a bit of it.
    """
    for run in (point.run for point in Sweep.parse(SWEEP).runs()):
        where, problem = str(run.parameters["failure"]), setting_of(run).problem
        compared(equal(f"{where}: state of the run", expected="succeeded", got=execute(run, tmp_path / run.id).state))
        outcome = simulate(problem, threads=1)
        limit, judge = (0, at_most) if where == "none" else (1, at_least)
        compared(judge(f"{where}: particles that failed", limit=limit, got=outcome.counters.failed))
        drift = abs(outcome.audit.energy_drift)
        compared(at_most(f"{where}: drift of the energy", limit=DRIFT, got=drift))
    for row in bits.rows_of("damage", problem, STEPS_OF_RESTART, STOPPED_AFTER):
        compared(row)
