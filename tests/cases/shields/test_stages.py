"""Shields by stages: what is kept over both and the flight between, and the same shot computed wholly on one grid."""

import cProfile
import hashlib
import json
import math
import pstats
import resource
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from solver.errors import Interrupted
from solver.problem import Problem
from solver.simulation import Outcome, simulate
from solver.state import MASS
from studies import materials, measurements
from studies.cubes import cube
from studies.outcomes.shots import outcomes_of
from studies.quantities.findings import InvalidInput
from studies.runs.execution import execute
from studies.runs.remeasure import remeasure
from studies.runs.results import RunControl, RunResult
from studies.runs.run import Run, resolve
from studies.scenarios import load
from studies.scenarios.parts.impact import ImpactSetting
from studies.shields.measurements.wall import wall_of
from studies.shields.scenario import WhippleShield
from studies.sweeps.search import outcome_in
from studies.sweeps.sweep import Sweep
from tests.claims.rows import Row, absolute, at_least, at_most, equal, relative, reported
from tests.studies.runs.solved import after

# A sphere of aluminium at a shield like those of the published shots.
SHOT: dict[str, Any] = {
    "speed": 6500.0,
    "projectile_diameter": 5e-3,
    "projectile": "al-2017-t4",
    "bumper": "al-6061-t6",
    "wall": "al-6061-t6",
    "bumper_thickness": 1e-3,
    "stand_off": 100e-3,
    "wall_thickness": 2e-3,
}
# Few particles, and a short way.
SMALL: dict[str, Any] = {
    **SHOT,
    "cells_per_diameter": 8.0,
    "stand_off": 15e-3,
    "uprange": 1.0,
    "bumper_radius": 12e-3,
    "wall_radius": 12e-3,
    "end_time": 3e-6,
    "wall_time": 8e-6,
    "stop": "end_time",
}
# At an angle, with sheets as wide as by default.
OBLIQUE: dict[str, Any] = {
    **{name: value for name, value in SMALL.items() if name not in ("bumper_radius", "wall_radius")},
    "geometry": "half",
    "stand_off": 30e-3,
    "downrange": 1.0,
    "obliquity": math.radians(45.0),
}
# With a second bumper.
DOUBLE: dict[str, Any] = {**SMALL, "bumper_2": "al-6061-t6", "bumper_2_thickness": 0.5e-3, "bumper_2_stand_off": 15e-3}
BROKEN = 0.1  # of the momentum of a wall, that pieces and rings may differ by
BEHIND = ("shield_momentum_behind", "shield_kinetic_energy_behind")
OUTCOME = "wall_perforated"
PROFILED = 5  # functions that take the most time
# Of two geometries on 8 cells across, which leave a bumper of 1.6 cells: they differ in the rim and in the lattice.
ALIKE = 0.1
MASS_ERROR, ENERGY = 1e-12, 1e-10  # of the initial mass and momentum, of the initial energy
HALVES = 1e-9  # of two models of the same body: they sum in another order, and a step multiplies what that changes
Compared = Callable[..., None]


def asked(**parameters: Any) -> Run:
    return resolve("whipple_shield", parameters)


def wall_momentum(result: RunResult) -> float:
    """Axial momentum of the wall's matter in the end, wherever it is, N s."""
    history = result.histories
    wall = history["bodies"].index("wall")
    return float(history["axial_momentum"][wall][-1] + history["departed_axial_momentum"][wall][-1])


def value_of(name: str) -> Callable[[RunResult], float]:
    return lambda result: result.measurements[name].value or math.nan


def balances(result: RunResult) -> list[Row]:
    """What is kept from the first touch to the end of the last stage, by the audits and by the sums of all bodies."""
    history, numbers = result.histories, result.numbers
    energy = sum(np.sum(history[f"{kind}_energy"], axis=0) for kind in ("kinetic", "internal", "departed"))
    energy = energy + history["contact_energy"] + history["otherwise_removed_energy"]
    momentum = np.sum(history["axial_momentum"], axis=0) + np.sum(history["departed_axial_momentum"], axis=0)
    momentum = momentum - history["axial_impulse"]
    return [
        absolute("mass unaccounted for, of all", expected=0.0, got=numbers["mass_error"], within=MASS_ERROR),
        absolute("momentum unaccounted for", expected=0.0, got=numbers["momentum_error"], within=MASS_ERROR),
        absolute("energy unaccounted for", expected=0.0, got=numbers["largest_energy_drift"], within=ENERGY),
        at_most(
            "range of the axial momentum of all bodies over all stages, of its start",
            limit=MASS_ERROR,
            got=float(np.ptp(momentum)) / abs(momentum[0]),
        ),
        at_most(
            "range of the energy of all bodies over all stages, of its start",
            limit=ENERGY,
            got=float(np.ptp(energy)) / energy[0],
        ),
    ]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[RunResult, Path]:
    """A shield of two bumpers that never stopped, and its folder."""
    folder = tmp_path_factory.mktemp("whole")
    return execute(asked(**DOUBLE), folder, threads=1), folder


@pytest.mark.claim("shields", "shield-balance")
def test_stages__keep_mass_momentum_and_energy_with_the_flights(
    whole: tuple[RunResult, Path], compared: Compared
) -> None:
    """Mass, momentum and energy are kept over all stages of a shield and the flights between them."""
    result, _ = whole
    hit = wall_momentum(result)
    behind = result.measurements["shield_momentum_behind"].value or math.nan
    compared(at_least("momentum on the wall, of what flies to it", limit=0.1, got=hit / behind), *balances(result))


@pytest.mark.claim("debris", "pieces-on-a-wall", minutes=0.2)
def test_pieces__keep_them_and_bring_the_wall_the_momentum_of_rings(compared: Compared, tmp_path: Path) -> None:
    """Debris that comes as pieces keeps mass, momentum and energy, and its wall takes the momentum that rings give."""
    opening = {**SMALL, "tension": "opening", "cells_per_wall": 4.0}
    even = execute(asked(**opening), tmp_path / "even", threads=1)
    pieces = execute(asked(**opening, pieces_seed=1), tmp_path / "pieces", threads=1)
    compared(
        *balances(pieces),
        *(
            relative(name, expected=value_of(name)(even), got=value_of(name)(pieces), within=MASS_ERROR)
            for name in BEHIND
        ),
        relative("momentum of the wall", expected=wall_momentum(even), got=wall_momentum(pieces), within=BROKEN),
        reported("cells across the median piece", pieces.numbers["cells_per_piece"]),
    )
    assert "cells_per_piece" not in even.numbers


@pytest.mark.claim("shields", "shield-quarter", minutes=0.1)
def test_quarter__keeps_them_and_hits_as_the_body_of_revolution(compared: Compared, tmp_path: Path) -> None:
    """A quarter in three dimensions keeps mass, momentum and energy, and hits its wall as a body of revolution does."""
    flat = execute(asked(**SMALL), tmp_path / "flat", threads=1)
    box = execute(asked(**{**SMALL, "geometry": "quarter"}), tmp_path / "box", threads=1)
    compared(
        *balances(box),
        *(
            relative(f"{name} in three dimensions", expected=of(flat), got=of(box), within=ALIKE)
            for name, of in (("momentum of the wall", wall_momentum), *((name, value_of(name)) for name in BEHIND))
        ),
    )


@pytest.mark.claim("shields", "shield-half", minutes=0.1)
def test_half__measures_as_a_quarter(compared: Compared, tmp_path: Path) -> None:
    """Half of a shield that is hit at right angles measures what a quarter does."""
    half = execute(asked(**{**SMALL, "geometry": "half"}), tmp_path / "half", threads=1)
    quarter = execute(asked(**{**SMALL, "geometry": "quarter"}), tmp_path / "quarter", threads=1)
    # The tip is one particle that the model has once or twice.
    alike = [name for name in half.measurements if name != "shield_tip_velocity"]
    values = {
        name: (quarter.measurements[name].value, half.measurements[name].value)
        for name in alike
        if quarter.measurements[name].value or half.measurements[name].value
    }
    assert {"wall_momentum", "wall_bulge", "bumper_hole_diameter"} <= set(values)
    compared(
        *(
            relative(f"half: {name}", expected=expected or math.nan, got=got or math.nan, within=HALVES)
            for name, (expected, got) in values.items()
        )
    )


@pytest.mark.claim("shields", "shield-oblique", minutes=0.1)
def test_oblique__shield_keeps_all_and_its_debris_comes_to_the_wall(compared: Compared, tmp_path: Path) -> None:
    """At 45 degrees a shield keeps mass, momentum, energy and in flight angular momentum; its wall meets its debris."""
    result = execute(asked(**OBLIQUE), tmp_path, threads=1)
    behind, numbers = result.measurements["shield_momentum_behind"].value or math.nan, result.numbers
    compared(
        *balances(result),
        absolute(
            "angular momentum unaccounted for in flight",
            expected=0.0,
            got=numbers["flight_angular_momentum_error"],
            within=MASS_ERROR,
        ),
        at_most("mass that flies past the wall, of all", limit=0.01, got=numbers["missed_mass_fraction"]),
        at_least("momentum on the wall, of what flies to it", limit=0.5, got=wall_momentum(result) / behind),
        *(
            reported(f"{name} ({measurements.load(name).unit})", each.value)
            for name, each in result.measurements.items()
            if each.value is not None
        ),
    )


@pytest.mark.claim("shields", "shield-slow", minutes=0.2)
def test_stages__end_when_a_slow_projectile_has_come_off_the_bumper_and_to_the_wall(
    compared: Compared, tmp_path: Path
) -> None:
    """At 1.2 km/s the hole of the bumper settles before the sphere is free; it comes to the wall all the same.

    At 0.86 km/s it still hangs on the bumper at the latest end: whether the wall holds is then undecided. A wall that
    nothing has touched yet is at rest, and has not settled. One that still bulges at the end is undecided.
    """
    slow = {name: each for name, each in SMALL.items() if name not in ("end_time", "wall_time", "stop")}
    slow |= {"failure": "none", "stand_off": 30e-3}
    free = execute(asked(**{**slow, "speed": 1200.0}), tmp_path / "free", threads=1)
    share = value_of("wall_momentum")(free) / value_of("shield_momentum_behind")(free)
    compared(at_least("momentum on the wall over that behind the bumper, its rim included", limit=0.5, got=share))
    hanging = execute(asked(**{**slow, "speed": 860.0}), tmp_path / "hanging", threads=1)
    flags = hanging.measurements[OUTCOME].flags
    compared(equal("still attached in the end", expected=True, got="still_attached" in flags))
    compared(equal("outcome", expected=None, got=outcome_in(hanging.as_json(), OUTCOME)))
    slow |= {"speed": 1000.0, "projectile": "steel-4340", "cells_per_diameter": 16.0}
    slow |= {"bumper_thickness": 0.64e-3, "wall_thickness": 0.8e-3}
    late = execute(asked(**{**slow, "uprange": 2.5}), tmp_path / "late", threads=1)
    what = "steel that flies 13 mm on the grid of the wall goes through"
    compared(equal(what, expected=True, got=outcome_in(late.as_json(), OUTCOME)))
    slow |= {"stop": "end_time", "end_time": 20e-6, "wall_time": 15e-6}
    cut = execute(asked(**slow), tmp_path / "cut", threads=1)
    compared(equal("wall that still bulges at the end", expected=None, got=outcome_in(cut.as_json(), OUTCOME)))
    compared(equal("it has no hole yet", expected=0.0, got=cut.measurements[OUTCOME].value))


LONG = pytest.mark.claim("shields", "shield-restart", minutes=0.1)


@pytest.mark.parametrize(
    ("part", "ended"),
    [
        pytest.param(0.05, 0, id="bumper", marks=LONG),
        pytest.param(0.4, 1, id="second", marks=pytest.mark.claim("shields", "shield-restart")),
        pytest.param(0.9, 2, id="wall", marks=LONG),
    ],
)
def test_stages__go_on_with_the_same_bits(
    part: float, ended: int, whole: tuple[RunResult, Path], compared: Compared, tmp_path: Path
) -> None:
    """A shield of two bumpers that is stopped in any stage goes on with the bits of one that never stopped."""
    lines: list[str] = []
    run, checkpoint = asked(**DOUBLE), tmp_path / "checkpoint.npz"
    expected, folder = whole
    steps = int(part * expected.numbers["steps"])
    written: list[int] = []
    control = RunControl(must_stop=after(steps), checkpointed=written.append)
    with pytest.raises(Interrupted):
        execute(run, tmp_path / "later", control, threads=1, checkpoint=checkpoint)
    later = execute(run, tmp_path / "later", RunControl(log=lines.append), threads=1, checkpoint=checkpoint)
    said = "; ".join(line for line in lines if line.startswith("from the "))
    compared(
        equal("step of the checkpoint, over all stages", expected=[steps], got=written),
        equal("continues", expected=True, got="from the checkpoint at t = " in said and "from the start" not in said),
        equal("stages whose stored end it reads", expected=ended, got=said.count("from the end of stage")),
        equal("the result, without provenance", expected=plain(expected), got=plain(later)),
        equal("the final state", expected=state(folder), got=state(tmp_path / "later")),
    )


def test_flight__books_debris_that_comes_after_the_end_of_its_stage() -> None:
    run = asked(**DOUBLE)
    shield, found = load(run.scenario).record(run.parameters), run.materials
    first = shield.build(found)
    second: Any = shield.next_stage(first, simulate(first.problem, threads=1), found)
    begin, last = second.problem.start_time, second.problem.arrivals.time[-1]
    ended = simulate(replace(second.problem, end_time=0.5 * (begin + last)), threads=1)
    assert ended.snapshot.waiting > 0.0
    third: Any = shield.next_stage(second, ended, found)
    problem, books = third.problem, third.problem.books
    kept = books.ledger.mass + problem.arrivals.table[MASS].sum()
    assert kept == pytest.approx(books.start.mass, rel=MASS_ERROR, abs=0.0)
    assert third.before[-1].missed >= ended.snapshot.waiting


def test_stored_state__is_measured_again_in_all_stages(whole: tuple[RunResult, Path]) -> None:
    run, (result, folder) = asked(**DOUBLE), whole
    old = {name: replace(each, version=0) for name, each in result.measurements.items()}
    again = remeasure(run, replace(result, measurements=old), folder / "state.npz", by="a test").measurements
    for name, measured in result.measurements.items():
        assert again[name].value == measured.value, name
        assert again[name].version == measured.version


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"obliquity": 0.5}, "obliquity"),
        ({"geometry": "half", "yaw": 0.1}, "yaw"),
        ({"debris": "follow"}, "debris"),
        ({"stand_off": 7e-3}, "stand_off"),
        ({"wall_radius": 4e-3}, "wall_radius"),
        ({"wall_radius": 5e-3, "cells_per_wall": 1.0, "stand_off": 60e-3}, "wall_radius"),
        ({"bumper_2_thickness": 1e-3, "bumper_2_stand_off": 15e-3}, "bumper_2"),
        ({"bumper_2": "al-6061-t6", "bumper_2_thickness": 1e-3}, "bumper_2_stand_off"),
        ({**DOUBLE, "bumper_2_stand_off": 7e-3}, "bumper_2_stand_off"),
        ({"bumper_3": "al-6061-t6", "bumper_3_thickness": 1e-3}, "bumper_3_thickness"),
    ],
)
def test_door__refuses_what_stages_do_not_compute(changes: dict[str, Any], field: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        asked(**{**SMALL, **changes})
    assert [finding.field for finding in caught.value.findings] == [field]


def test_bumper__of_no_thickness_is_none() -> None:
    assert asked(**{**DOUBLE, "bumper_2_thickness": 0.0}).id == asked(**SMALL).id != asked(**DOUBLE).id


def test_outline__has_each_sheet_where_its_grid_stands() -> None:
    further = {name: value for name, value in DOUBLE.items() if name.startswith("bumper_2")}
    run = asked(**{**OBLIQUE, **further})
    shield, place = cast(WhippleShield, load(run.scenario).record(run.parameters)), 0.0
    drawn = shield.outline(run.parameters)
    assert drawn is not None
    for shape, sheet in zip(drawn.shapes[1:], shield.sheets, strict=True):
        expected = (sheet.aside - sheet.radius, sheet.aside + sheet.radius, place, place + sheet.thickness)
        assert shape.body == sheet.name
        assert (shape.left, shape.right, shape.top, shape.bottom) == pytest.approx(expected, abs=1e-12)
        place += sheet.thickness + sheet.stand_off
    assert "bumper_2_stand_off" in [each.parameter for each in drawn.dimensions]


def plain(result: RunResult) -> str:
    """The digest of a result without its provenance."""
    text = json.dumps({name: value for name, value in result.as_json().items() if name != "provenance"})
    return hashlib.sha256(text.encode()).hexdigest()


def state(folder: Path) -> str:
    """The digest of all arrays of a stored final state."""
    digest = hashlib.sha256()
    with np.load(folder / "state.npz") as saved:
        for name in sorted(saved):
            digest.update(name.encode() + saved[name].tobytes())
    return digest.hexdigest()


# ---- the same shot on one grid ---------------------------------------------------------------------

# Four diameters from bumper to wall, and the same cells everywhere. Nothing holds the rims, so that what the wall's
# matter has in the end is what came to it.
NEAR: dict[str, Any] = {
    **SHOT,
    "cells_per_diameter": 16.0,
    "stand_off": 20e-3,
    "uprange": 1.0,
    "bumper_radius": 20e-3,
    "wall_radius": 20e-3,
    "edges": "free",
    "stop": "end_time",
}
CELL = NEAR["projectile_diameter"] / NEAR["cells_per_diameter"]
PASSED = 25e-6  # s, from the first touch: the projectile would have flown 160 mm
MOMENTUM = 0.03  # of the momentum on the wall


def whole_of(run: Run) -> ImpactSetting:
    """Projectile, bumper and wall on one grid, whose origin is the front of the wall; all debris is followed."""
    shield, found = cast(WhippleShield, load(run.scenario).record(run.parameters)), run.materials
    first, rear, shift = shield.impact, shield.target(1), shield.walls.bumper_thickness + shield.walls.stand_off
    room = (shift + rear.thickness) / shield.shot.projectile_diameter + 4.0
    long = replace(first, parameters=replace(shield, shot=replace(shield.shot, downrange=room)))
    problem = long.build(found).problem
    axis = np.array([0.0, shift, 0.0])
    wall = rear.body("wall", found["wall"], problem.geometry, *rear.points(), np.zeros(3))
    moved = tuple(replace(body, position=body.position - axis) for body in problem.bodies)
    geometry = problem.geometry._replace(lower=problem.geometry.lower - axis)
    problem = replace(problem, geometry=geometry, bodies=(*moved, wall), retirement=None, end_time=PASSED)
    return ImpactSetting(problem, 1.0, "wall", SHOT["projectile_diameter"], rear.thickness, rear.radius, SHOT["speed"])


def on_wall(problem: Problem, outcome: Outcome) -> float:
    """Axial momentum of the wall's matter, wherever it is, over that of the projectile."""
    wall = outcome.audit.bodies[[body.name for body in problem.bodies].index("wall")]
    mass = math.pi / 6.0 * SHOT["projectile_diameter"] ** 3 * materials.load(SHOT["projectile"]).density
    return 2.0 * math.pi * (wall.momentum + wall.departed_momentum) / (mass * SHOT["speed"])


@pytest.mark.claim("shields", "shield-one-grid", minutes=0.5)
@pytest.mark.parametrize("thickness", [2e-3, 8e-3])
def test_stages__agree_with_one_grid(thickness: float, compared: Compared) -> None:
    """A shield by stages puts the momentum on its wall that it puts there on one grid, within 3 %, with its outcome."""
    run = asked(**{**NEAR, "wall_thickness": thickness, "cells_per_wall": thickness / CELL})
    together = whole_of(run)
    alone = simulate(together.problem, threads=1)
    shield, found = load(run.scenario).record(run.parameters), run.materials
    bumper = shield.build(found)
    ended = simulate(bumper.problem, threads=1)
    wall: Any = shield.next_stage(bumper, ended, found)
    # From the first arrival on as long as the one grid has from then on.
    left = PASSED + wall.before[-1].clock_ahead - wall.problem.start_time
    problem = replace(wall.problem, end_time=wall.problem.start_time + left)
    outcome = simulate(problem, threads=1)
    perforated = [
        wall_of(setting, each.snapshot).is_perforated
        for setting, each in ((together, alone), (replace(wall, problem=problem), outcome))
    ]
    expected = on_wall(together.problem, alone)
    where = f"wall of {1e3 * thickness:g} mm"
    compared(
        relative(
            f"{where}: momentum on it, of the projectile's",
            expected=expected,
            got=on_wall(problem, outcome),
            within=MOMENTUM,
        ),
        equal(f"{where}: perforated", expected=perforated[0], got=perforated[1]),
        reported(f"{where}: mass that still expanded when it left, of all", outcome.audit.expanding_mass),
    )


# ---- its limit, and what it costs ------------------------------------------------------------------

LIMIT: dict[str, Any] = {
    "scenario": "whipple_shield",
    "fixed": {
        "speed": "6.5 km/s",
        "projectile": "al-2017-t4",
        "bumper": "al-6061-t6",
        "wall": "al-6061-t6",
        "bumper_thickness": "1 mm",
        "stand_off": "20 mm",
        "wall_thickness": "2 mm",
        "uprange": 1.0,
    },
    "axes": {
        "projectile_diameter": {"limit_of": "wall_perforated", "between": ["1 mm", "6 mm"], "tolerance": "1.3 mm"}
    },
    "resolution": 8,
}


@pytest.mark.claim("shields", "shield-limit", minutes=0.2)
def test_limit__of_a_shield_is_found_by_a_sweep(compared: Compared, tmp_path: Path) -> None:
    """A sweep finds the diameter from which on a shield is perforated."""
    sweep = Sweep.parse(LIMIT)
    outcomes: dict[float, bool | None] = {}

    def outcome_of(run: Run) -> bool | None:
        diameter = float(run.parameters["projectile_diameter"] or 0.0)
        if diameter not in outcomes:
            outcomes[diameter] = outcome_in(execute(run, tmp_path / run.id, threads=1).as_json(), OUTCOME)
        return outcomes[diameter]

    [(_, limit)] = sweep.limits(outcome_of)
    tried = ", ".join(f"{1e3 * each:g} mm {outcome}" for each, outcome in sorted(outcomes.items()))
    compared(
        equal(f"where the search stands, of {tried}", expected="bracketed", got=limit.verdict.value),
        reported("diameter from which on the wall is perforated (mm)", 1e3 * limit.value),
    )


# Six diameters from bumper to wall, on as many cells as are not under-resolved.
RINGS: dict[str, Any] = {
    "scenario": "whipple_shield",
    "fixed": {
        **{name: value for name, value in LIMIT["fixed"].items() if name != "uprange"},
        "projectile_diameter": "5 mm",
        "stand_off": "30 mm",
    },
    "axes": {"geometry": ["axisymmetric", "quarter"]},
    "resolution": 16,
}


@pytest.mark.claim("shields", "shield-rings", minutes=4.0)
@pytest.mark.parametrize("thickness", ["2 mm", "4 mm"])
def test_rings__load_the_wall_as_a_quarter_or_leave_its_outcome_open(
    thickness: str, compared: Compared, tmp_path: Path
) -> None:
    """Rings of debris put the momentum of three dimensions on a wall, and where they differ its outcome is open."""
    sweep = Sweep.parse({**RINGS, "fixed": {**RINGS["fixed"], "wall_thickness": thickness}})
    runs = {str(point.coordinates["geometry"]): point.run for point in sweep.runs()}
    results = {name: execute(run, tmp_path / name, threads=1) for name, run in runs.items()}
    dataset = cube.build(sweep, {run.id: results[name] for name, run in runs.items()})
    [[shot]] = [each.shots for each in outcomes_of(dataset) if each.quantity == OUTCOME]
    flat, box = results["axisymmetric"], results["quarter"]
    said = [outcome_in(each.as_json(), OUTCOME) for each in (flat, box)]
    agreed = said[0] if said[0] == said[1] else None
    where = f"wall of {thickness}"
    compared(
        equal(
            f"{where}: outcome in the report, of {said[0]} in rings and {said[1]} in three dimensions",
            expected=agreed,
            got=shot.outcome,
        ),
        *(
            relative(f"{where}: {name}", expected=value_of(name)(flat), got=value_of(name)(box), within=ALIKE)
            for name in ("wall_momentum", "bumper_hole_diameter", *BEHIND)
        ),
        *(
            reported(f"{where}: {name} in {kind}", value)
            for name in ("wall_hole_diameter", "wall_crater_depth_over_thickness", "wall_bulge", "wall_detached_spall")
            for kind, each in (("rings", flat), ("three dimensions", box))
            if (value := each.measurements[name].value) is not None
        ),
    )


# The shield of the shots on 32 cells, until its bumper has a hole and the first debris is on the grid of its wall.
MILLIONS: dict[str, Any] = {**SHOT, "geometry": "quarter", "stop": "end_time", "end_time": 4e-6, "wall_time": 2e-6}


@pytest.mark.claim("shields", "shield-millions", minutes=13.0)
def test_quarter__of_four_million_particles_balances_with_two_threads(compared: Compared, tmp_path: Path) -> None:
    """A quarter of four million particles runs with two threads and keeps mass, momentum and energy."""
    begin, used = time.monotonic(), time.process_time()
    result = execute(asked(**MILLIONS), tmp_path, threads=2)
    numbers = result.numbers
    compared(
        at_least("particles, in millions", limit=4.0, got=1e-6 * numbers["particles"]),
        *balances(result),
        reported("minutes", (time.monotonic() - begin) / 60.0),
        reported("minutes of a core", (time.process_time() - used) / 60.0),
        reported("memory (GB)", 1e-6 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss),
        reported("particle-steps, in millions", 1e-6 * numbers["particle_steps"]),
    )


@pytest.mark.parametrize(
    ("cells", "limit"),
    [
        pytest.param(32.0, 3.0, marks=pytest.mark.claim("shields", "shield-speed", minutes=1.0)),
        pytest.param(64.0, 15.0, marks=pytest.mark.claim("shields", "shield-speed", minutes=8.0)),
    ],
)
def test_shield__takes_minutes_of_a_core(cells: float, limit: float, compared: Compared, tmp_path: Path) -> None:
    """A body of revolution on 32 cells across the projectile takes at most 3 minutes of a core, on 64 at most 15."""
    run = asked(**SHOT, cells_per_diameter=cells)
    short = replace(run, parameters={**run.parameters, "end_time": 1e-7, "wall_time": 1e-7})
    execute(short, tmp_path / "warm", threads=1)  # kernels
    profile, begin = cProfile.Profile(), time.process_time()
    result = profile.runcall(execute, run, tmp_path, threads=1)
    minutes = (time.process_time() - begin) / 60.0
    stats = pstats.Stats(profile).get_stats_profile()
    busiest = sorted(stats.func_profiles.items(), key=lambda each: -each[1].tottime)[:PROFILED]
    compared(
        at_most(f"{cells:g} cells: minutes of a core", limit=limit, got=minutes),
        *balances(result),
        *(reported(f"{name}, part of the time", each.tottime / stats.total_tt) for name, each in busiest),
        *(
            reported(f"{name} ({measurements.load(name).unit})", each.value)
            for name, each in result.measurements.items()
            if each.value is not None
        ),
    )
