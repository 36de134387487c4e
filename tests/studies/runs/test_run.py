"""A run: its identity, its refusals, and the files and numbers of its computation."""

import dataclasses
import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from solver.state import Departed, Particles, Snapshot
from studies import materials, measurements, scenarios
from studies.materials import Material
from studies.materials.schema import MEASURED_WITH, NOT_SIMULATED
from studies.measurements._impact import view
from studies.runs import run
from studies.runs.execution import execute
from studies.runs.run import PHYSICS_VERSION, Run, estimate, materials_of, resolve
from studies.scenarios import OBSERVATIONS_PER_WINDOW
from studies.scenarios._settling import WINDOW_PER_DIAMETER
from studies.values.errors import InvalidInput
from studies.values.parameters import Parameter, declared
from studies.values.recipes import RECIPES
from studies.values.results import Progress, RunControl, RunResult

COPPER = materials.load("copper-ofhc")
PARAMETERS: dict[str, Any] = {
    "speed": 3000.0,
    "projectile_diameter": 8e-3,
    "plate_thickness": 2e-3,
    "plate_radius": 16e-3,
    "projectile": "copper-ofhc",
    "target": "copper-ofhc",
    "cells_per_diameter": 4.0,
    "end_time": 2e-6,
}
BLOCK: dict[str, Any] = {
    **{name: value for name, value in PARAMETERS.items() if not name.startswith("plate")},
    "target_depth": 24e-3,
    "target_radius": 24e-3,
}
THIN = declared(scenarios.load("thin_plate").parameters)


def asked(
    parameters: Mapping[str, Any] = PARAMETERS,
    *,
    scenario: str = "thin_plate",
    projectile: Material = COPPER,
    target: Material = COPPER,
    **changes: Any,
) -> Run:
    """A small run, with some parameters changed; a parameter that is ``...`` is left out."""
    values = {name: value for name, value in {**parameters, **changes}.items() if value is not ...}
    return resolve(scenario, values, {"projectile": projectile, "target": target})


def refused(*arguments: Any, **changes: Any) -> list[str]:
    """The fields of the findings."""
    with pytest.raises(InvalidInput) as caught:
        asked(*arguments, **changes)
    return [finding.field for finding in caught.value.findings]


# Identity


@pytest.mark.parametrize(
    "same",
    [
        lambda: asked(dict(reversed(PARAMETERS.items()))),
        lambda: Run.from_json(json.loads(json.dumps(asked().as_json(), allow_nan=False))),
        lambda: asked(courant=RECIPES["whipple"].courant, geometry="axisymmetric", stop="settled"),
        lambda: asked(speed=3000),
        lambda: asked(speed=3000.0 * (1.0 + 1e-14)),
        lambda: asked(target=COPPER.with_value("strength.A", 90e6 * (1.0 + 1e-14))),
        lambda: asked(target=dataclasses.replace(COPPER, name="cu", title="My", family="red")),
        lambda: asked({**PARAMETERS, "projectile": "cu", "target": "cu"}),
        lambda: asked(target=dataclasses.replace(COPPER, yield_stresses=(), brinell_hardness=40.0)),
    ],
    ids=[
        "order",
        "JSON",
        "defaults spelled out",
        "whole number",
        "beyond 12 digits",
        "constant beyond 12 digits",
        "name of a material",
        "name in a parameter",
        "numbers for laws alone",
    ],
)
def test_identity__of_the_same_problem_is_the_same(same: Callable[[], Run]) -> None:
    assert same().id == asked().id
    assert len(asked().id) == 32
    assert int(asked().id, 16) >= 0


def test_identity__sees_the_12th_digit() -> None:
    assert asked(speed=3000.00000001).id != asked().id
    assert asked(speed=3000.0 * (1.0 + 1e-14)).parameters["speed"] == 3000.0


STATED = {path for path in COPPER.paths() if COPPER.value_at(path) is not None}


@pytest.mark.parametrize("path", sorted(STATED - {*NOT_SIMULATED, *MEASURED_WITH}))
@pytest.mark.parametrize("role", ["projectile", "target"])
def test_identity__is_changed_by_every_physical_constant(role: str, path: str) -> None:
    value = COPPER.value_at(path)
    assert value is not None
    changed: dict[str, Any] = {role: COPPER.with_value(path, value * (1.0 + 1e-9))}
    assert asked(**changed).id != asked().id


def changed_value(parameter: Parameter, value: Any) -> Any:
    """Another value that the parameter allows."""
    if parameter.kind == "boolean":
        return not value
    if parameter.choices:
        return next(choice for choice in parameter.choices if choice != value)
    if value is None:
        assert parameter.minimum is not None
        assert parameter.maximum is not None
        return math.sqrt(parameter.minimum * parameter.maximum)
    if parameter.kind == "integer":
        return value + 1
    return value * 1.01 or 0.01


# Where a parameter means something, and what must change with it.
SETTING: dict[str, dict[str, Any]] = {
    "projectile_length": {"projectile_shape": "cylinder", "projectile_length": 4e-3},
    "obliquity": {"geometry": "half"},
    "yaw": {"geometry": "half", "projectile_shape": "cylinder", "projectile_length": 4e-3},
    "friction": {"contact": "bardenhagen"},
    "failure_strain": {"failure": "plastic-strain", "failure_strain": 1.0},
    "failure_time": {"failure": "spall", "failure_time": 1e-7},
    "method": {"geometry": "quarter"},
    "artificial_stress": {"geometry": "quarter", "method": "sph"},
    "damping_order": {"damping_rate": 1e5},
    "beyond_edge": {"edges": "free"},
}
FOLLOWS: dict[str, dict[str, Any]] = {
    "projectile_shape": {"projectile_length": 8e-3},
    "failure": {"failure": "plastic-strain", "failure_strain": 1.0},
}


NO_CONTENT = ("film_interval",)  # a film shows a run and does not change it


@pytest.mark.parametrize(
    "name", [name for name, parameter in THIN.items() if parameter.kind != "material" and name not in NO_CONTENT]
)
def test_identity__is_changed_by_every_parameter(name: str) -> None:
    before = asked(**SETTING.get(name, {}))
    change = {name: changed_value(THIN[name], before.parameters[name]), **FOLLOWS.get(name, {})}
    assert asked(**{**SETTING.get(name, {}), **change}).id != before.id


def test_identity__is_changed_by_the_scenario() -> None:
    assert asked(BLOCK, scenario="thick_plate").id != asked().id


def test_identity__is_changed_by_the_version_of_the_physics(monkeypatch: pytest.MonkeyPatch) -> None:
    before = asked().id
    monkeypatch.setattr(run, "PHYSICS_VERSION", PHYSICS_VERSION + 1)
    assert asked().id != before


def test_identity__tells_projectile_from_target() -> None:
    soft = COPPER.with_value("strength.A", 60e6)
    assert asked(projectile=soft).id != asked(target=soft).id


# Refusals


def test_resolve__refuses_unknown_names_with_the_nearest() -> None:
    with pytest.raises(InvalidInput, match="speed"):
        asked(sped=3000.0)
    with pytest.raises(InvalidInput, match="thin_plate"):
        resolve("thin_plat", PARAMETERS, {"projectile": COPPER, "target": COPPER})


@pytest.mark.parametrize("value", [-3000.0, 0.0, math.nan, 1e9, "fast", None, True, ...])
def test_resolve__refuses_an_invalid_speed(value: Any) -> None:
    assert refused(speed=value) == ["parameters.speed"]


def test_resolve__refuses_a_missing_material() -> None:
    with pytest.raises(InvalidInput) as caught:
        resolve("thin_plate", PARAMETERS, {"projectile": COPPER})
    assert [finding.field for finding in caught.value.findings] == ["target"]


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"projectile_shape": "cylinder"}, "projectile_length"),
        ({"projectile_length": 4e-3}, "projectile_length"),
        ({"plate_radius": 7e-3}, "plate_radius"),
        ({"plate_thickness": 0.9e-3}, "plate_thickness"),
    ],
)
def test_resolve__refuses_parameters_that_contradict_each_other(changes: dict[str, Any], field: str) -> None:
    assert refused(**changes) == [field]


@pytest.mark.parametrize("scenario", ["thin_plate", "thick_plate"])
@pytest.mark.parametrize("diameter", [1e-3, 8e-3])
def test_resolve__refuses_a_window_below_a_tenth_of_its_default(scenario: str, diameter: float) -> None:
    least = 0.1 * WINDOW_PER_DIAMETER * diameter
    parameters = PARAMETERS if scenario == "thin_plate" else BLOCK
    at: dict[str, Any] = {"scenario": scenario, "projectile_diameter": diameter}
    allowed = asked(parameters, settled_window=least, **at).parameters["settled_window"]
    assert allowed == pytest.approx(least)
    for window in (1e-9, 5e-9, 0.99 * least):
        assert refused(parameters, settled_window=window, **at) == ["settled_window"]


def test_resolve__says_value_limit_and_default_of_a_window_that_is_too_short() -> None:
    with pytest.raises(InvalidInput) as caught:
        asked(settled_window=5e-9)
    (finding,) = caught.value.findings
    assert finding.value == "5 ns"
    assert "0.5 us" in finding.limit
    assert finding.cure.endswith(" 5 us")


@pytest.mark.parametrize("field", ["target_depth", "target_radius"])
def test_resolve__refuses_a_block_smaller_than_the_projectile(field: str) -> None:
    assert refused(BLOCK, scenario="thick_plate", **{field: 7e-3}) == [field]


def test_resolve__finds_everything_at_once() -> None:
    fields_refused = refused(speed=-1.0, courant=2.0, geometry="cube", sped=1.0)
    assert sorted(fields_refused) == [f"parameters.{name}" for name in ("courant", "geometry", "sped", "speed")]


def test_resolve__fills_in_every_default() -> None:
    assert list(asked().parameters) == list(THIN)
    assert asked().parameters["viscosity_quadratic"] == RECIPES["whipple"].viscosity_quadratic


# Cost


def test_estimate__grows_with_the_work() -> None:
    small, large = estimate(asked()), estimate(asked(cells_per_diameter=8.0))
    assert 0 < small.particles < large.particles
    assert 0.0 < small.core_seconds < large.core_seconds
    assert 0 < small.bytes < large.bytes


# Computation


@pytest.fixture(scope="module")
def computed(tmp_path_factory: pytest.TempPathFactory) -> tuple[RunResult, Path, list[Progress]]:
    """A small run: its result, its directory and the progress that it reported."""
    directory = tmp_path_factory.mktemp("run") / "made by execute"
    reports: list[Progress] = []
    return (execute(asked(), directory, RunControl(progress=reports.append), threads=1), directory, reports)


Computed = tuple[RunResult, Path, list[Progress]]


def plain_result(directory: Path) -> dict[str, Any]:
    def refuse(constant: str) -> None:
        raise AssertionError(f"result.json holds {constant}")

    text = (directory / "result.json").read_text(encoding="utf-8")
    plain: dict[str, Any] = json.loads(text, parse_constant=refuse)
    return plain


def test_execute__leaves_a_result_and_a_state(computed: Computed) -> None:
    result, directory, _ = computed
    assert (result.state, result.reason, result.failure) == ("succeeded", None, None)
    assert (result.run_id, result.stop) == (asked().id, "end_time")
    assert set(result.measurements) == set(scenarios.load("thin_plate").measurements)
    assert sorted(file.name for file in directory.iterdir()) == ["result.json", "sections.npz", "state.npz"]
    plain = plain_result(directory)
    assert plain == result.as_json()
    assert RunResult.from_json(plain).as_json() == plain


def test_execute__a_number_that_is_none_is_null_with_a_flag(tmp_path: Path) -> None:
    """A fifth of a microsecond is too short for a hole."""
    hole = execute(asked(end_time=2e-7), tmp_path, threads=1).measurements["hole_diameter"]
    assert (hole.value, hole.uncertainty, hole.flags) == (None, None, ("not_perforated",))
    assert plain_result(tmp_path)["measurements"]["hole_diameter"]["value"] is None


def test_execute__says_how_good_it_is(computed: Computed) -> None:
    numbers = computed[0].numbers
    assert numbers["cells_per_diameter"] == 4.0
    assert numbers["cells_per_thickness"] == 1.0
    assert abs(numbers["largest_energy_drift"]) < 0.01
    assert numbers["momentum_error"] < 1e-10
    assert numbers["mass_error"] < 1e-12
    assert numbers["end_time"] >= 2e-6
    assert all(math.isfinite(number) for number in numbers.values())


def test_execute__says_what_computed(computed: Computed) -> None:
    provenance = computed[0].provenance
    assert provenance["physics_version"] == str(PHYSICS_VERSION)
    assert {"whipple", "python", "numpy", "numba", "cpu", "started", "seconds"} <= set(provenance)
    assert provenance["threads"] == 1


def test_execute__reports_progress(computed: Computed) -> None:
    _, _, reports = computed
    fractions = [progress.fraction for progress in reports]
    # Five observations in each window of 5 us: in 2 us two, and the start.
    assert len(reports) == 1 + round(2e-6 / (5e-6 / OBSERVATIONS_PER_WINDOW))
    assert fractions[0] == 0.0
    assert fractions[-1] == 1.0
    assert fractions == sorted(fractions)
    assert reports[-1].end_time == 2e-6
    assert all(json.dumps(dataclasses.asdict(progress), allow_nan=False) for progress in reports)
    for measured in computed[0].measurements.values():
        assert measured.history["time"] == [progress.time for progress in reports]
        assert len(measured.history["value"]) == len(reports)


def test_execute__histories_sum_to_the_audited_energy_and_momentum(computed: Computed) -> None:
    result, directory, reports = computed
    histories, whole = result.histories, 2.0 * math.pi
    assert histories["time"] == [progress.time for progress in reports]
    assert histories["bodies"] == ["projectile", "target"]
    energy = sum(np.sum(histories[f"{kind}_energy"], axis=0) for kind in ("kinetic", "internal", "departed"))
    energy = energy + histories["contact_energy"] + histories["otherwise_removed_energy"]
    drift = result.numbers["energy_drift"]
    assert energy[-1] == pytest.approx(energy[0] * (1.0 + drift), rel=1e-12)
    with np.load(directory / "state.npz") as state:
        on_grid = whole * 0.5 * (state["mass"] * (state["velocity"] ** 2).sum(axis=1)).sum()
    assert np.sum(histories["kinetic_energy"], axis=0)[-1] == pytest.approx(on_grid, rel=1e-12)
    momentum = np.sum(histories["axial_momentum"], axis=0) - histories["axial_impulse"]
    momentum += np.sum(histories["departed_axial_momentum"], axis=0)
    assert momentum == pytest.approx(momentum[0], rel=1e-9)


def test_execute__state_holds_the_living_particles(computed: Computed) -> None:
    result, directory, _ = computed
    state = np.load(directory / "state.npz", allow_pickle=False)
    records = {f"departed_{name}" for name in Departed._fields}
    assert set(state.files) == {"body", "time", *Particles._fields, *records} - {"alive"}
    assert float(state["time"]) == result.numbers["end_time"]
    assert state["mass"].size == state["body"].size <= result.numbers["particles"]
    assert all(np.isfinite(state[name]).all() for name in state.files)


def test_execute__state_can_be_measured_again(tmp_path: Path) -> None:
    """A stored state gives the numbers of the result without solving."""
    asking = asked(BLOCK, scenario="thick_plate", end_time=8e-6)
    result = execute(asking, tmp_path, threads=1)
    scenario = scenarios.load("thick_plate")
    setting = scenario.build(scenario.parameters(**asking.parameters), materials_of(asking))
    state = np.load(tmp_path / "state.npz")
    particles = Particles(
        **{name: state[name] for name in Particles._fields if name != "alive"},
        alive=np.ones(state["mass"].size, np.uint8),
    )
    state_view = view(setting, Snapshot(float(state["time"]), 0, particles, state["body"]))
    for name, measured in result.measurements.items():
        measurement = measurements.load(name)
        if measurement.follows:
            continue
        reading = measurement.read(state_view)
        if measured.value is None:
            assert math.isnan(reading.value)
        else:
            assert reading.value == measured.value


def test_execute__twice_gives_the_same_numbers(computed: Computed, tmp_path: Path) -> None:
    again = execute(asked(), tmp_path, threads=1)
    assert again.numbers == computed[0].numbers
    assert again.measurements == computed[0].measurements


def test_execute__of_an_unphysical_run_leaves_a_failed_result_with_its_reason(tmp_path: Path) -> None:
    """A constant step that is twenty times too long."""
    result = execute(asked(fixed_dt=1e-6, end_time=1e-4), tmp_path, threads=1)
    assert (result.state, result.failure) == ("failed", "UnphysicalState")
    assert result.reason is not None
    assert "particle" in result.reason
    assert "t = " in result.reason
    assert result.measurements == {}
    assert [file.name for file in tmp_path.iterdir()] == ["result.json"]
    assert RunResult.from_json(plain_result(tmp_path)).as_json() == result.as_json()


def test_execute__returns_whatever_limit_the_solver_finds_crossed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("solver.simulation.SPEED_FACTOR", 0.5)
    result = execute(asked(), tmp_path, threads=1)
    assert result.state == "failed"
    assert result.reason is not None
    assert result.reason.startswith("speed = 3000 at particle ")


def test_execute__does_not_hide_a_mistake_in_the_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*arguments: Any) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("studies.measurements._impact.view", broken)
    with pytest.raises(ZeroDivisionError):
        execute(asked(), tmp_path, threads=1)
    assert not (tmp_path / "result.json").exists()


@pytest.mark.parametrize(
    ("changes", "under_resolved"),
    [
        ({"cells_per_diameter": 15.0, "plate_thickness": 4e-3}, True),
        ({"cells_per_diameter": 16.0, "plate_thickness": 1.9e-3}, True),
        ({"cells_per_diameter": 16.0, "plate_thickness": 2e-3}, False),
    ],
)
def test_flags__under_resolved_below_16_cells_a_diameter_and_4_a_thickness(
    tmp_path: Path, changes: dict[str, Any], under_resolved: bool
) -> None:
    result = execute(asked(end_time=1e-7, **changes), tmp_path, threads=1)
    assert ("under_resolved" in result.flags) == under_resolved


def settling(**changes: Any) -> Run:
    """A crater that is judged by a generous measure of growth."""
    return asked(
        BLOCK,
        **{"scenario": "thick_plate", "end_time": 40e-6, "settled_window": 3e-6, "settled_growth": 0.2, **changes},
    )


def test_stop__says_settled_where_growth_has_ended(tmp_path: Path) -> None:
    result = execute(settling(), tmp_path, threads=1)
    assert result.stop == "settled"
    assert 6e-6 <= result.numbers["end_time"] < 40e-6
    for name in ("crater_depth", "crater_diameter"):
        measured = result.measurements[name]
        assert measured.value is not None
        assert "still_growing" not in measured.flags
        assert measured.parts["growth"] < 0.2 * measured.value
    assert set(measured.parts) == {"resolution", "azimuth", "growth"}
    assert measured.uncertainty == pytest.approx(math.hypot(*measured.parts.values()))


def test_stop__waits_for_two_windows_even_where_growth_is_slow_before(tmp_path: Path) -> None:
    result = execute(settling(settled_window=10e-6, settled_growth=0.5), tmp_path, threads=1)
    assert result.stop == "settled"
    assert result.numbers["end_time"] >= 20e-6


def test_stop__at_the_end_of_time_flags_what_still_grows(tmp_path: Path) -> None:
    run = settling(stop="end_time", end_time=8e-6, settled_growth=1e-9, settled_window=2e-6)
    result = execute(run, tmp_path, threads=1)
    assert result.stop == "end_time"
    assert result.numbers["end_time"] >= 8e-6
    assert "still_growing" in result.measurements["crater_depth"].flags
