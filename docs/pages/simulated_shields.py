"""simulated-shields.md: how often the simulation judges published shots on Whipple shields right.

``python -m docs.pages compute simulated-shields [DIRECTORY]`` computes the runs and stores them in the end; a directory
keeps results, and the states of those that are cut. The shots, the grids and the models were written down before any of
them was run. An outcome is open where two runs disagree, so that the finer grid is for shots on which those of the
first agree.
"""

import math
import random
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import product
from pathlib import Path
from typing import Any

from docs.pages import RESULTS, computed_once, computed_rows, in_markdown, keep, read_json, table
from solver import PHYSICS_VERSION
from studies import materials
from studies.outcomes.found import Share
from studies.quantities.findings import InvalidInput
from studies.runs.run import Run, resolve
from studies.shields.shots import joined
from studies.shields.shots.answers import shown
from studies.shields.shots.drawn import Simulated, SimulationKind, failures_found
from studies.shields.shots.joined import (
    LEAST_CELLS,
    MOST_CELLS,
    THROUGH_BUMPER,
    THROUGH_WALL,
    SimulatedShot,
    cells_across,
    cells_through,
)
from studies.shields.shots.judged import ALL, RANGES, Judged, counted, equations, judge, range_of
from studies.shields.shots.table import IN_DOUBT, OUTCOMES, ShieldShot, WallOutcome, collected, published
from studies.sweeps.search import outcome_in

STORED = RESULTS / "simulated-shields.json"
COMMAND = "python -m docs.pages compute simulated-shields"

SEED = 20261125
EACH = 10  # shots of each outcome in each range of the speed
# Alloys of the collection that ship; 99.9 % aluminium has no strength in any file.
SHIPPED = {
    **{"AA1100-O": "al-1100-o", "AA2017-T4": "al-2017-t4", "AA2024-T3": "al-2024-t3", "AA2024-T351": "al-2024-t351"},
    **{"AA2219-T87": "al-2219-t87", "AA5456-H116": "al-5456-h116", "AA6061-T6": "al-6061-t6"},
    **{"AA6061-T651": "al-6061-t6", "AA7075-T6": "al-7075-t6", "Alclad 7075-T6": "al-7075-t6"},
}
# Matter that never breaks by itself, and matter with the fracture strains of its file: an outcome is open where they
# disagree. A projectile without such constants never breaks.
FAILURES = ("none", "johnson-cook")
# The default failure of plates, a simulation of its own on the first grid: it was added when the outcomes of the others
# were known, and before any of its own. None of these shots had a part in making it the default (docs/failure.md).
OF_PLATES = "void-growth"
GRIDS: tuple[float, ...] = (1.0, 1.5)  # times the cells below
# The models of all these runs, which were the defaults then.
EVEN: Mapping[str, str | int] = {"tension": "recoverable", "pieces_seed": 0}


@cache
def drawn() -> Mapping[int, ShieldShot]:
    """The shots that are simulated: normal ones on alloys that ship and can break, by a seed, alike in each stratum.

    By their numbers in the draw, which was before one of the sources was seen to be in doubt: its shots are left out.
    """
    chance, strata = random.Random(SEED), _strata(collected().shots).values()
    shots = [shot for stratum in strata for shot in chance.sample(stratum, min(EACH, len(stratum)))]
    return {number: shot for number, shot in enumerate(shots) if shot.source != IN_DOUBT}


def _strata(shots: Sequence[ShieldShot]) -> dict[tuple[int, WallOutcome], list[ShieldShot]]:
    """Those of the shots that can be simulated, by the range of the speed and the outcome."""
    able = [shot for shot in shots if shot.obliquity == 0.0 and _breaks(shot)]
    return {
        (place, outcome): [shot for shot in able if (range_of(shot.speed), shot.outcome) == (place, outcome)]
        for place, outcome in product(range(len(RANGES)), OUTCOMES)
    }


def materials_of(shot: ShieldShot) -> dict[str, str | None]:
    """The material of each body of a shot that ships; None where it does not."""
    names = {"projectile": shot.projectile, "bumper": shot.bumper, "wall": shot.wall}
    return {role: SHIPPED.get(name) for role, name in names.items()}


def _breaks(shot: ShieldShot) -> bool:
    """Whether all materials of a shot ship, and those of its sheets with the fracture strains of Johnson and Cook."""
    names = materials_of(shot)
    sheets = [names["bumper"], names["wall"]]
    return None not in names.values() and all(
        materials.load(str(name)).value_at("fracture.D1") is not None for name in sheets
    )


def parameters_of(shot: ShieldShot, failure: str, grid: float) -> dict[str, Any]:
    """The parameters of a run of a shot, by the rule of the cells."""
    cells = cells_across(shot.projectile_diameter, shot.bumper_thickness)
    return {
        **materials_of(shot),
        "projectile_diameter": shot.projectile_diameter,
        "bumper_thickness": shot.bumper_thickness,
        "stand_off": shot.stand_off,
        "wall_thickness": shot.wall_thickness,
        "speed": shot.speed,
        "failure": failure,
        **EVEN,
        "cells_per_diameter": grid * cells,
        "cells_per_wall": grid * cells_through(shot.wall_thickness, shot.projectile_diameter, cells),
    }


# ---- computed ------------------------------------------------------------------------------------


def compute(directory: Path | None = None) -> None:
    """Compute all runs, and store them and what they add to the probability; a directory that is kept resumes.

    On the finer grid those of the shots that the first one decides.
    """
    runs: list[Mapping[str, Any]] = []
    asked = [*product(GRIDS[:1], (*FAILURES, OF_PLATES)), *product(GRIDS[1:], FAILURES)]
    for grid, failure in asked:
        shots = [shot for shot in drawn() if grid == GRIDS[0] or simulated(_of(shot, runs)) != "open"]
        runs += computed_rows(computed_row, [(grid, failure, shot) for shot in shots], directory)
    runs.sort(key=lambda run: (run["grid"], run["failure"], run["shot"]))
    keep({"physics": PHYSICS_VERSION, "command": COMMAND, "seed": SEED, "runs": runs}, STORED)
    joined.store(simulations(runs))


def _of(shot: int, runs: Iterable[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """The runs of a shot that decide its outcome."""
    return [run for run in runs if run["shot"] == shot and run["failure"] in FAILURES]


def computed_row(place: tuple[float, str, int], folder: Path) -> Mapping[str, Any]:
    """What the run of a grid, a failure and the number of a shot says; computed where the folder does not have it."""
    grid, failure, number = place
    shot = drawn()[number]
    roles = {role: materials.load(str(name)) for role, name in materials_of(shot).items()}
    asked = partial(resolve, "whipple_shield", parameters_of(shot, failure, grid), roles)
    return computed_wall({"shot": number, "failure": failure, "grid": grid}, asked, folder)


def computed_wall(about: Mapping[str, Any], asked: Callable[[], Run], folder: Path) -> Mapping[str, Any]:
    """The row of a wall: outcome, crater and flags of its run; "refused" where the space is too short for two grids."""
    try:
        run = asked()
    except InvalidInput:
        return {**about, "id": "", "state": "refused", "perforated": None, "crater": None, "flags": [], "seconds": 0.0}
    result = computed_once(run, folder / run.id)
    outcome = outcome_in(result.as_json(), "wall_perforated")
    crater = result.measurements.get("wall_crater_depth_over_thickness")
    print(*about.values(), result.state, outcome, flush=True)
    return {
        **about,
        "id": run.id,
        "state": result.state,
        "perforated": None if outcome is None else float(outcome),
        "crater": None if crater is None or crater.value is None else round(float(crater.value), 3),
        "flags": list(result.flags),
        "seconds": round(float(result.provenance.get("seconds", math.nan)), 1),
    }


# ---- judged --------------------------------------------------------------------------------------


def simulated(runs: Sequence[Mapping[str, Any]]) -> Simulated:
    """What the runs of a shot say together: an outcome where grids and failures agree, else open."""
    answers = {run["perforated"] for run in runs}
    if answers == {1.0}:
        return "perforated"
    return "held" if answers == {0.0} else "open"


def outcomes(
    runs: Sequence[Mapping[str, Any]], failures: Sequence[str] = FAILURES
) -> list[tuple[ShieldShot, Simulated]]:
    """Each shot that was drawn, with what its runs with these failures say."""
    mine = [run for run in runs if run["failure"] in failures]
    return [(shot, simulated([run for run in mine if run["shot"] == number])) for number, shot in drawn().items()]


def _ended(runs: Sequence[Mapping[str, Any]]) -> dict[int, Simulated]:
    """What the runs of a shot on all grids say together, of the shots that have all that the rule asks for."""
    every = len(GRIDS) * len(FAILURES)
    mine = {shot: _of(shot, runs) for shot in drawn()}
    said = {shot: simulated(of_shot) for shot, of_shot in mine.items()}
    return {shot: outcome for shot, outcome in said.items() if outcome == "open" or len(mine[shot]) == every}


def _is_whole(runs: Sequence[Mapping[str, Any]]) -> bool:
    """Whether every shot has all runs that the rule asks for."""
    return len(_ended(runs)) == len(drawn())


def simulation(runs: Sequence[Mapping[str, Any]]) -> list[tuple[ShieldShot, Simulated]]:
    """What the simulation of the rule says of each shot: on all grids, or on the first until every shot has them."""
    return outcomes(runs if _is_whole(runs) else [run for run in runs if run["grid"] == GRIDS[0]])


def simulations(runs: Sequence[Mapping[str, Any]]) -> dict[SimulationKind, list[SimulatedShot]]:
    """The shots that were drawn with what their runs of each kind say."""
    of_draw = _strata([*drawn().values()])
    shares = {key: len(of_draw[key]) / len(shots) for key, shots in _strata(published().shots).items()}
    kinds = {}
    kinds_of_failures = [*((failure,) for failure in FAILURES), FAILURES, (OF_PLATES,)]
    computed = [(failures, GRIDS[:1]) for failures in kinds_of_failures]
    if _is_whole(runs):
        computed.append((FAILURES, GRIDS))
    for failures, grids in computed:
        kind = SimulationKind(tuple(sorted(failures)), "one" if len(grids) == 1 else "several")
        mine = [run for run in runs if run["grid"] in grids]
        kinds[kind] = [
            SimulatedShot(
                shot,
                shares[range_of(shot.speed), shot.outcome],
                shares[range_of(shot.speed), "perforated"] / shares[range_of(shot.speed), "held"],
                told,
            )
            for shot, told in outcomes(mine, failures)
        ]
    return kinds


def rated(pairs: Sequence[tuple[WallOutcome, Simulated]]) -> tuple[Judged, int]:
    """Of outcomes (measured, told): how often those that were decided are right, and how many are open.

    >>> judged, undecided = rated([("held", "held"), ("perforated", "held"), ("held", "open")])
    >>> judged.right, judged.unsafe, undecided
    (Share(count=1, of=2), Share(count=1, of=2), 1)
    """
    decided = [(told == "perforated", measured == "perforated") for measured, told in pairs if told != "open"]
    return counted("simulation", ALL, decided), len(pairs) - len(decided)


def pages() -> dict[str, str]:
    """simulated-shields.md."""
    runs = read_json(STORED)["runs"]
    first = [run for run in runs if run["grid"] == GRIDS[0]]
    told = simulation(runs)
    decided = [shot for shot, outcome in told if outcome != "open"]
    judged, _ = of_rule = rated([(shot.outcome, outcome) for shot, outcome in told])
    failures = (OF_PLATES, *FAILURES)
    right = {law.name: judge(law, decided).right for law in equations()}
    kinds = simulations(runs)
    scores = joined.validated(kinds[SimulationKind(tuple(sorted(FAILURES)), "several" if _is_whole(runs) else "one")])
    held = [
        outcome
        for shot, outcome in outcomes(first, [FAILURES[1]])
        if shot.speed >= RANGES[1][1] and not shot.is_perforated
    ]
    text = in_markdown(
        "simulated_shields",
        told=told,
        failures=failures,
        found=[failures_found(failure, RANGES[1][1]) for failure in failures],
        careful=Share(held.count("perforated"), len(held)),
        of_plates=OF_PLATES,
        seed=SEED,
        each_outcome=EACH,
        in_doubt=IN_DOUBT,
        cells=(LEAST_CELLS, THROUGH_BUMPER, MOST_CELLS, THROUGH_WALL),
        finer=GRIDS[1],
        command=COMMAND,
        mesh=_of_the_mesh(first, runs),
        decided=decided,
        right=judged.right,
        always=[name for name, share in right.items() if share.count == share.of],
        tables={
            "what_tells": _what_tells(first, told, decided, of_rule),
            "by_speed": table(["speed", *OUTCOMES], list(_by_speed(told))),
            "joined": _joined(kinds),
            "shots": table(
                ["shot", "speed", "d, t_b, S, t_w (mm)", "measured", "simulated", "P without simulation", "P joined"],
                [
                    [*_of_shot(shot, outcome), shown(before), shown(after)]
                    for (shot, outcome), before, after in zip(told, scores.before, scores.after, strict=True)
                ],
            ),
        },
    )
    return {"simulated-shields.md": text}


def _what_tells(
    first: Sequence[Mapping[str, Any]],
    told: Sequence[tuple[ShieldShot, Simulated]],
    decided: Sequence[ShieldShot],
    of_rule: tuple[Judged, int],
) -> str:
    """How often simulations and equations are right, and these on the shots that all runs decide alike."""
    rows = []
    for failure in (*FAILURES, OF_PLATES):
        alone = [(shot.outcome, outcome) for shot, outcome in outcomes(first, [failure])]
        rows.append(_row(f"simulation, failure {failure}, cells × {GRIDS[0]:g} alone", *rated(alone)))
    for asked, words in (([shot for shot, _ in told], ""), (decided, ", on the shots that all runs decide alike")):
        if words:
            rows.append(_row("simulation, all runs together", *of_rule))
        for law in equations():
            judged = judge(law, asked)
            rows.append(_row(f"`{law.name}`{words}", judged, len(asked) - judged.right.of))
    return table(["what tells", "right of those decided", "95 %", "unsafe", "too careful", "open"], rows)


def _of_the_mesh(first: Sequence[Mapping[str, Any]], runs: Sequence[Mapping[str, Any]]) -> Mapping[str, int]:
    """Shots that the first grid decides; of these with all runs of the rule; that keep their outcome; that turn it."""
    before = {shot for shot in drawn() if simulated(_of(shot, first)) != "open"}
    after = {shot: outcome for shot, outcome in _ended(runs).items() if shot in before}
    kept = sum(outcome != "open" for outcome in after.values())
    turned = sum({run["perforated"] for run in _of(shot, runs)} >= {0.0, 1.0} for shot in after)
    return {"decided": len(before), "ended": len(after), "kept": kept, "turned": turned}


def _joined(kinds: Mapping[SimulationKind, Sequence[SimulatedShot]]) -> str:
    """What the simulation adds to the probability from equations and shots, by kind of runs."""
    rows = []
    for kind, mine in kinds.items():
        scores, constants = joined.validated(mine), joined.joint_of(joined.unseen(mine), mine)
        deviations = [constants.covariance[place][place] ** 0.5 for place in (0, 1)]
        falls = [scores.gained(), *((each.gained, each.within) for each in joined.drawn_shots(mine, scores))]
        rows.append(
            [
                f"failure {kind.name}",
                f"{constants.perforated:.2f} ± {deviations[0]:.2f}",
                f"{constants.held:.2f} ± {deviations[1]:.2f}",
                *(f"{score:.3f}" for score in scores.brier()),
                *(f"{fall:.3f} ± {error:.3f}" for fall, error in falls),
                *(f"{score:.3f}" for score in scores.brier(weighted=True)),
            ]
        )
    ranges = [where for where, *_ in RANGES]
    return table(
        ["simulation", "a", "b", "Brier score without", "with", "gained", *ranges, "of all: without", "with"], rows
    )


def _row(name: str, judged: Judged, undecided: int) -> list[str]:
    right = judged.right
    low, high = right.interval
    share = f"{100 * right.value:.0f} % ({right.count} of {right.of})" if right.of else "none"
    interval = f"{100 * low:.0f} to {100 * high:.0f} %" if right.of else ""
    return [name, share, interval, str(judged.unsafe.count), str(judged.careful.count), str(undecided)]


def _by_speed(told: Sequence[tuple[ShieldShot, Simulated]]) -> Iterator[list[str]]:
    for where, low, high in RANGES:
        cells = []
        for outcome in OUTCOMES:
            mine = [(s.outcome, says) for s, says in told if low <= s.speed < high and s.outcome == outcome]
            judged, undecided = rated(mine)
            cells.append(f"{judged.right.count} / {judged.right.of} / {undecided}")
        yield [where, *cells]


def _of_shot(shot: ShieldShot, told: Simulated) -> list[str]:
    sizes = (shot.projectile_diameter, shot.bumper_thickness, shot.stand_off, shot.wall_thickness)
    mark = told if told == shot.outcome else f"**{told}**"
    lengths = ", ".join(f"{1e3 * size:.3g}" for size in sizes)
    return [f"{shot.source} {shot.shot}", f"{shot.speed / 1e3:.2f} km/s", lengths, shot.outcome, mark]
