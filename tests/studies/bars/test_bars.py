"""Bars as they are built: masses, places, sizes of the thesis, loads on them, and their methods."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from solver.matter.eos import reference_sound_speed
from solver.problem import Face
from solver.problem.geometry import impact_axis
from solver.simulation import simulate, start
from solver.state import Snapshot
from solver.steppers import methods
from studies import measurements, scenarios
from studies.bars.loading import read_pulse
from studies.bars.measured import view as view_of_bar
from studies.observations.compared import stored
from studies.quantities.measured import LOST_PARTICLES
from studies.runs.execution import execute
from studies.runs.run import resolve
from tests.claims.rows import Row, absolute, at_least, equal, relative
from tests.contracts.test_scenarios import ROUND_OFF, asked, built
from tests.samples import DIAMETER, needs
from tests.studies.bars.samples import BARS, PULSE, SQUARE


@pytest.mark.parametrize("geometry", ["axisymmetric", "quarter"])
@pytest.mark.parametrize("name", BARS)
def test_bar__weighs_what_it_weighs_and_flies_into_its_wall(name: str, geometry: str) -> None:
    run = asked(name, geometry=geometry)
    problem = built(run).problem
    axis, (bar,) = impact_axis(problem.geometry), problem.bodies
    length, diameter = (float(str(run.parameters[f"bar_{x}"])) for x in ("length", "diameter"))
    part = 1.0 / (2.0 * math.pi) if geometry == "axisymmetric" else 0.25
    mass = bar.density * 0.25 * math.pi * diameter**2 * length * part
    assert math.isclose(bar.mass.sum(), mass, rel_tol=ROUND_OFF)
    assert problem.geometry.lower[axis] == 0.0
    assert problem.faces[axis][0] == Face.WALL
    assert math.isclose(bar.position[:, axis].min(), 0.5 * bar.spacing[axis], rel_tol=1e-9)
    assert np.flatnonzero(bar.velocity).tolist() == [axis]
    assert bar.velocity[axis] == -float(str(run.parameters["speed"]))


def check_sizes(scenario: str, setting: Any, length: float, width: float) -> None:
    """Its measurements give the size that was asked for, whatever the lattice: the final size is compared with it."""
    view = scenarios.load(scenario).parameters.view(setting, start(setting.problem, threads=1).snapshot())
    for name, size in (("final_length", length), ("mushroom_diameter", width), ("width_at_fifth", width)):
        assert math.isclose(measurements.load(name).read(view).value, size, rel_tol=1e-9)


@pytest.mark.parametrize("geometry", ["axisymmetric", "quarter"])
def test_taylor_bar__has_at_the_start_the_size_that_was_asked_for(geometry: str) -> None:
    setting = built(asked("taylor_bar", geometry=geometry, bar_length=11.1e-3))
    check_sizes("taylor_bar", setting, 11.1e-3, DIAMETER)


# Ma (2005): 4 particles across the radius and 20 along (section 2.3.1), 10 and 67 in 72 us (section 2.3.2).
@pytest.mark.parametrize(("name", "particles", "spacing"), [("elastic_bar", 260, 1e-3), ("taylor_bar", 5293, 0.76e-3)])
def test_bar__is_by_default_the_one_of_the_thesis(name: str, particles: int, spacing: float) -> None:
    problem = built(resolve(name, {"geometry": "quarter", "recipe": "thesis"})).problem
    assert problem.bodies[0].mass.size == particles
    assert math.isclose(problem.geometry.spacing, spacing)
    if name == "taylor_bar":
        assert math.isclose(problem.end_time, 72e-6)


@pytest.mark.parametrize(
    "text", [PULSE, "0 s 0\n500 ns 1.0\n\n0.01 ms 1\n 1.05e-5 s   0\n", "0us 0; 0.5us 1; 10us 1; 10.5us 0"]
)
def test_pulse__is_one_table_in_every_spelling(text: str) -> None:
    pulse = read_pulse(text)
    assert pulse.time == (0.0, 5e-7, 1e-5, 1.05e-5)
    assert pulse.share == (0.0, 1.0, 1.0, 0.0)
    assert read_pulse(pulse.text) == pulse
    same = asked("elastic_bar", pressure=1e8, pulse=PULSE)
    assert asked("elastic_bar", pressure=1e8, pulse=text).id == same.id


@pytest.mark.parametrize("name", BARS)
def test_square_bar__weighs_and_measures_what_was_asked_for(name: str) -> None:
    run = asked(name, **SQUARE, bar_length=11.1e-3)
    setting = built(run)
    [bar] = setting.problem.bodies
    side = float(str(run.parameters["bar_diameter"]))
    quarter = 0.25 * bar.density * side**2 * 11.1e-3
    assert math.isclose(bar.mass.sum(), quarter, rel_tol=ROUND_OFF)
    # Every particle has the mass of its own box, which the lattice fills without a rest.
    assert np.allclose(bar.mass, bar.density * math.prod(bar.spacing), rtol=ROUND_OFF)
    check_sizes(name, setting, 11.1e-3, side)


def test_histories__of_a_loaded_bar_sum_to_the_audited_energy_and_momentum(tmp_path: Any) -> None:
    run = asked("elastic_bar", speed=100.0, pressure=3e8, pulse=PULSE, gravity=1e6)
    result = execute(run, tmp_path, threads=1)
    histories = result.histories
    energy = sum(np.sum(histories[f"{kind}_energy"], axis=0) for kind in ("kinetic", "internal"))
    energy = energy + histories["otherwise_removed_energy"] - histories["load_work"]
    work, drift = histories["load_work"][-1], result.numbers["energy_drift"]
    assert work == result.numbers["load_work"]
    assert abs(work) > 0.1 * energy[0]
    assert energy[-1] - energy[0] == pytest.approx(drift * (energy[0] + abs(work)), abs=1e-12 * energy[0])
    assert abs(drift) < 1e-10
    momentum = np.sum(histories["axial_momentum"], axis=0) - histories["axial_impulse"]
    assert momentum == pytest.approx(momentum[0], rel=1e-9)
    assert result.measurements["lost_energy"].flags == ("loaded",)
    assert result.measurements["contact_time"].flags == ("loaded",)


METHODS = [name for name in ("mpm", "sph", "fem", "sph-fem") if name in methods()]
PRESSED: dict[str, Any] = {
    **SQUARE,
    "wall": "symmetric",
    "speed": 0.0,
    "bar_length": 20e-3,
    "poisson_ratio": 0.0,
    "pressure": 1e8,
    "pulse": "0 us 0, 1 us 1, 4 us 1, 5 us 0",
    "end_time": 6.5e-6,
    "cells_per_diameter": 4.0,
}


def mean_of(history: Any) -> float:
    """Mean of what was read from 4.5 us on, when the plateau has come to the middle."""
    times, values = (np.array(history[name]) for name in ("time", "value"))
    return float(values[times >= 4.5e-6].mean())


def test_pressed_bar__has_the_wave_of_one_dimension_by_every_method(tmp_path: Any) -> None:
    stress = -PRESSED["pressure"]
    velocity = stress / math.sqrt(100e9 * 8900.0)  # p / (rho c) of the default matter
    for method in METHODS:
        result = execute(asked("elastic_bar", method=method, **PRESSED), tmp_path / method, threads=1)
        # The mean of the plateau while it passes: coarse grids ring about it.
        passing = {name: mean_of(result.measurements[f"middle_{name}"].history) for name in ("velocity", "stress")}
        assert passing == pytest.approx({"velocity": velocity, "stress": stress}, rel=0.05), method
        # Mesh and particles in one body's place book one impulse.
        assert result.numbers["momentum_error"] < 1e-9, method


@needs("sph-fem")
def test_coupled_bar__has_the_mass_of_the_bar_and_is_one_in_its_measurements() -> None:
    setting = built(asked("elastic_bar", method="sph-fem", **PRESSED))
    elements, particles = setting.problem.bodies
    whole = 8900.0 * 2e-3**2 * 20e-3
    assert elements.mass.sum() + particles.mass.sum() == pytest.approx(whole, rel=ROUND_OFF)
    view = scenarios.load("elastic_bar").parameters.view(setting, start(setting.problem, threads=1).snapshot())
    assert measurements.load("rear_face_place").read(view).value == pytest.approx(20e-3)
    assert measurements.load("middle_stress").read(view).value == 0.0


# The grid of a Taylor bar

SHIPPED = ("taylor-bars-al-6061-t6", "taylor-bars-copper-etp", "taylor-bars-copper-ofhc", "taylor-bars-steel-4340")


@pytest.mark.claim("breaking", "bar-room")
def test_grid__of_a_bar_grows_with_its_spread_and_an_empty_node_changes_no_number(
    compared: Callable[[Row], None],
) -> None:
    """The grid of a bar grows with its spread, and a wider one than it takes changes its length by round-off alone."""
    (slow, fast) = (built(asked("taylor_bar", speed=speed)).problem.geometry for speed in (20.0, 500.0))
    radius = 0.5 * DIAMETER
    got = float(slow.cells[0] * slow.spacing / radius)
    compared(absolute("radius of the grid over that of a bar at 20 m/s", expected=3.0, got=got, within=1e-9))
    got = float(fast.cells[0] * fast.spacing / radius)
    compared(at_least("radius of the grid over that of a bar at 500 m/s", limit=3.5, got=got))
    run = asked("taylor_bar", speed=100.0)
    taylor: Any = scenarios.load("taylor_bar").record(run.parameters)
    bar = taylor.at_wall(run.materials["bar"])
    lengths = []
    for wider in (1.0, 2.0):
        roomy = replace(bar, radius=wider * bar.radius)
        setting = roomy.build(built(run).problem.bodies[0].matter)
        outcome = simulate(setting.problem, lambda snapshot: None, interval=setting.problem.end_time, threads=1)
        seen = scenarios.load("taylor_bar").parameters.view(setting, outcome.snapshot)
        lengths.append(measurements.load("final_length").read(seen).value)
    compared(relative("length in a grid twice as wide (m)", expected=lengths[0], got=lengths[1], within=1e-12))


@pytest.mark.claim("breaking", "bar-room")
@pytest.mark.parametrize("table", SHIPPED)
def test_shots__of_bars_have_a_length_or_the_flag_of_the_run(table: str, compared: Callable[[Row], None]) -> None:
    """Every shipped bar has, in the stored comparison, a length, or the flag of a run that lost it."""
    rows = [row for row in stored()["shots"] if row["table"] == table and row["quantity"] == "final_length"]
    lost = [row for row in rows if row["simulated"] is None]
    silent = [row["parameters"]["speed"] for row in lost if LOST_PARTICLES not in row["flags"]]
    compared(equal(f"{table}: bars without length and without flag, of {len(rows)}", expected=[], got=silent))


@pytest.mark.claim("breaking", "bars-that-spread", minutes=1.0)
@pytest.mark.parametrize(("table", "fastest"), [("taylor-bars-al-6061-t6", 500.0), ("taylor-bars-copper-etp", 300.0)])
def test_shots__of_bars_that_spread_beyond_three_diameters_have_a_length(
    table: str, fastest: float, tmp_path: Path, compared: Callable[[Row], None]
) -> None:
    """Bars that spread beyond three diameters have the length that is stored, and no flag."""
    from docs.pages.shots import computed, published

    shots = [shot for shot in published(table) if float(str(shot.parameters["speed"])) > fastest]
    known = {(row["quantity"], row["parameters"]["speed"]): row for row in stored()["shots"] if row["table"] == table}
    for row in computed(table, tmp_path, shots):
        speed = row["parameters"]["speed"]
        expected = known[row["quantity"], speed]["simulated"]
        text = f"{table}, {speed:g} m/s: {row['quantity']} (m)"
        compared(relative(text, expected=expected or math.nan, got=row["simulated"] or math.nan, within=1e-6))
        compared(equal(f"{text}: flags", expected=[], got=row["flags"]))


# Its view


def bar_at_start(geometry: str, **changes: Any) -> tuple[Any, Snapshot]:
    setting = built(asked("elastic_bar", geometry=geometry, **changes))
    return setting, start(setting.problem, threads=1).snapshot()


def test_view_of_a_bar__has_the_elastic_energy_of_uniaxial_stress() -> None:
    """sigma^2 / 2 E per volume, where strain is small: the terms left out are of the order of the strain."""
    setting, snapshot = bar_at_start("quarter")
    (body,) = setting.problem.bodies
    shear, bulk = body.matter.shear_modulus, reference_sound_speed(body.matter.eos) ** 2 * body.density
    young = 9.0 * bulk * shear / (3.0 * bulk + shear)
    stress = 1e-5 * young
    snapshot.particles.density[:] = body.density * (1.0 - stress / 3.0 / bulk)
    snapshot.particles.deviator[:, 2] = 2.0 / 3.0 * stress
    snapshot.particles.deviator[:, :2] = -stress / 3.0
    expected = 0.5 * stress**2 / young / body.density
    assert np.allclose(view_of_bar(setting, snapshot).strain_energy, expected, rtol=1e-4, atol=0.0)
