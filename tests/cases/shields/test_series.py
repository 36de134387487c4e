"""Published shots on shields: two series that bracket a limit, on three grids, and shots that were drawn by a seed."""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from itertools import product
from pathlib import Path

import pytest

from docs.pages import debris_shots, simulated_shields
from docs.pages.debris_shots import asked, series
from docs.pages.simulated_shields import FAILURES, GRIDS, parameters_of
from solver.grid.strays import MOST_DISCARDED
from studies import materials
from studies.convergence.outcomes import agree
from studies.convergence.richardson import Sample
from studies.runs.execution import execute
from studies.runs.results import RunResult
from studies.runs.run import resolve
from studies.shields.shots import joined
from studies.shields.shots.drawn import Simulated
from studies.shields.shots.table import ShieldShot
from tests.claims.rows import Row, at_most, equal, reported

QUICK = 20.0  # s, of a run: those that are computed anew
ENERGY_DRIFT = 1e-12  # relative: kept to round-off
THREE = (GRIDS[0], 0.5 * sum(GRIDS), GRIDS[1])  # times the cells of the rule
WORDS: tuple[Simulated, Simulated] = ("held", "perforated")  # of 0 and 1
FAILURES_OF = {"piekutowski": FAILURES[:1], "reimerdes": FAILURES}


def sample_of(shot: ShieldShot, failure: str, grid: float, folder: Path) -> Sample:
    """What a run says of the wall: 1 for perforated, by its cells across the sphere."""
    parameters = parameters_of(shot, failure, grid)
    roles = {role: materials.load(parameters[role]) for role in ("projectile", "bumper", "wall")}
    run = resolve("whipple_shield", parameters, roles)
    result: RunResult = execute(run, folder / run.id, threads=1)
    wall = result.measurements.get("wall_perforated")
    value = None if wall is None else wall.value
    unsaid = value is None and result.state == "succeeded"
    size = 1.0 / parameters["cells_per_diameter"]
    return Sample(size, math.nan if value is None else value, 0.0, 0.0, unsaid, () if wall is None else wall.flags)


def told(samples: Mapping[str, Sequence[Sample]]) -> tuple[Simulated, str]:
    """What the runs of a shot say together, by failure, and why it is open."""
    said = {failure: agree(mine, WORDS) for failure, mine in samples.items()}
    values = {agreed.value for agreed in said.values()}
    if values in ({0.0}, {1.0}):
        return WORDS[int(values.pop())], ""
    return "open", "; ".join(
        f"failure {failure}: {WORDS[int(agreed.value)] if math.isfinite(agreed.value) else agreed.reason}"
        for failure, agreed in said.items()
    )


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("piekutowski", marks=pytest.mark.claim("shields", "piekutowski", minutes=10.0)),
        pytest.param("reimerdes", marks=pytest.mark.claim("shields", "reimerdes", minutes=100.0)),
    ],
)
def test_simulation__tells_the_outcome_of_each_shot(name: str, tmp_path: Path, compared: Callable[[Row], None]) -> None:
    """A series of shots around the limit of a shield has its outcomes on three grids.

    That of Piekutowski and Poorman has not: all walls hold on all grids, also the four that were perforated (4.77 to
    5.81 mm). Without a failure the deepest crater is 4 to 21 % of the wall, which bulges by 1.5 to 5.6 mm. Those of
    Reimerdes, Noelke and Schaefer are open: without failure their walls hold on the finer grids, with Johnson and
    Cook's they are perforated on every grid, those that held as well.

    With ``void-growth``, which is not computed here, all nine hold on three grids. The deepest crater of the
    first series is 17 to 25 % of the wall on the coarsest grid and 12 to 20 % on the finest, at equal momentum on the
    wall within 3 %.
    """
    for shot in series()[name]:
        size = f"{1e3 * shot.projectile_diameter:g} mm"
        samples: dict[str, list[Sample]] = {}
        for grid, failure in product(THREE, FAILURES_OF[name]):
            sample = sample_of(shot, failure, grid, tmp_path)
            samples.setdefault(failure, []).append(sample)
            if math.isfinite(sample.value):
                compared(reported(f"{size}, {failure}, {1.0 / sample.spacing:g} cells: perforated", sample.value))
        says, why = told(samples)
        behind = f"{size} behind {1e3 * shot.bumper_thickness:.3g} mm"
        compared(equal(f"{behind}: wall{f' ({why})' if why else ''}", expected=shot.outcome, got=says))


# Runs of drawn shots that ended by a single particle before such particles were discarded: grid, failure and number.
# Whether one is left depends on round-off: the second has none any more.
STRAYS = [(1.0, "johnson-cook", 17), (1.0, "johnson-cook", 44), (1.0, "void-growth", 48)]


@pytest.mark.claim("mend", "strays", minutes=3.0)
@pytest.mark.parametrize(("grid", "failure", "number"), STRAYS)
def test_strays__of_drawn_shots_end_no_run(
    grid: float, failure: str, number: int, tmp_path: Path, compared: Callable[[Row], None]
) -> None:
    """Drawn shots that died of single particles with 1e9 J/kg run to their ends, and flag the ones they discard."""
    shot = simulated_shields.drawn()[number]
    roles = {role: materials.load(str(name)) for role, name in simulated_shields.materials_of(shot).items()}
    run = resolve("whipple_shield", simulated_shields.parameters_of(shot, failure, grid), roles)
    result = execute(run, tmp_path, threads=1)
    where = f"shot {number}, failure {failure}"
    compared(equal(f"{where}: state", expected="succeeded", got=result.state))
    discarded = result.numbers["discarded"]
    compared(reported(f"{where}: discarded particles", discarded))
    compared(equal(f"{where}: flagged", expected=discarded > 0, got="discarded_particles" in result.flags))
    compared(
        at_most(f"{where}: discarded mass, of all", limit=MOST_DISCARDED, got=result.numbers["discarded_mass_fraction"])
    )
    compared(at_most(f"{where}: energy drift", limit=ENERGY_DRIFT, got=abs(result.numbers["largest_energy_drift"])))


@pytest.mark.claim("shields", "drawn-shots", minutes=6.0)
def test_simulation__of_drawn_shots_is_what_the_page_says(tmp_path: Path, compared: Callable[[Row], None]) -> None:
    """The quick ones of the drawn shots have the outcomes that are stored; what all of them say is reported."""
    runs = json.loads(simulated_shields.STORED.read_text(encoding="utf-8"))["runs"]
    for run in runs:
        if run["perforated"] is not None and run["seconds"] < QUICK:
            again = simulated_shields.computed_row((run["grid"], run["failure"], run["shot"]), tmp_path)
            where = f"shot {run['shot']}, failure {run['failure']}, cells times {run['grid']:g}: perforated"
            compared(equal(where, expected=run["perforated"], got=again["perforated"]))
    judged, undecided = simulated_shields.rated([(s.outcome, says) for s, says in simulated_shields.simulation(runs)])
    compared(reported("right of those decided", judged.right.value))
    compared(reported("undecided", undecided))
    for kind, shots in simulated_shields.simulations(runs).items():
        before, after = joined.validated(shots).brier()
        compared(reported(f"{kind.name}: Brier score, without simulation {before:.3f}", after))


@pytest.mark.claim("debris", "decisive", minutes=20.0)
def test_debris_that_breaks__tells_of_published_shots_what_the_page_says(
    tmp_path: Path, compared: Callable[[Row], None]
) -> None:
    """Under debris that breaks the quickest wall that holds and the quickest perforated one come out as stored.

    What all runs say together is reported: right ones of those decided (80 % were aimed at), perforated walls found
    (70 %), open ones of all (15 %), and how many more are unsafe than too careful (none).
    """
    runs = [run for run in debris_shots.stored() if run["perforated"] is not None]
    for outcome in (0.0, 1.0):
        run = min((run for run in runs if run["perforated"] == outcome), key=lambda run: run["seconds"])
        again = debris_shots.computed_row((run["shot"], run["seed"]), tmp_path)
        where = f"{run['shot']}, seed {run['seed']}"
        compared(equal(f"{where}: identity", expected=run["id"], got=again["id"]))
        compared(equal(f"{where}: perforated", expected=run["perforated"], got=again["perforated"]))
    said = debris_shots.told(debris_shots.stored())
    judged, undecided = simulated_shields.rated([(asked()[name].outcome, tells) for name, tells in said.items()])
    failures = sum(asked()[name].is_perforated for name in said)
    compared(reported("shots that both seeds were asked about", len(said)))
    compared(reported(f"right, of {judged.right.of} decided", judged.right.count))
    compared(reported(f"perforated walls found, of {failures}", judged.caught.count))
    compared(reported("open", undecided))
    compared(reported("unsafe less too careful", judged.unsafe.count - judged.careful.count))
