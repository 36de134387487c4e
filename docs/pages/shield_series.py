"""Two published series of shots on shields that bracket a limit, simulated on three grids: shield-series.md.

``python -m docs.pages compute shield-series [DIRECTORY [SERIES]]`` computes the runs that the file of results does not
have, by their identities. The rule was written down before any of the shots was run. Cells and models are those of
``simulated_shields``, with a third grid between its two, and the outcome is that of reports: open where a grid, an
offset or a failure says otherwise, and where the finest grid holds with a flag by which it may still be perforated.
The default failure of plates is a simulation of its own, which was added when the outcomes of the others were known.

- Piekutowski and Poorman (2013), shots near 7 km/s on the shield of full scale; of that of 5.81 mm, which is not in the
  collection, the speed is stated as 6.9 to 7.0 km/s, and the middle is taken. The wall of 2219-T87 has no published
  fracture strains, so that failure johnson-cook is refused, and failure none stands alone.
- Reimerdes, Noelke and Schaefer (2006), Table 2, shots near 7 km/s: 3.0 and 3.5 mm behind a bumper of 0.46 mm, 4.5 and
  5.0 mm behind one of 1 mm. Their spheres of 99.9 % aluminium are computed as 1100-O, the purest aluminium that ships.
"""

import math
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

from docs.pages import RESULTS, computed_once, keep, read_json, table
from docs.pages.simulated_shields import FAILURES, GRIDS, OF_PLATES, parameters_of
from solver import PHYSICS_VERSION
from studies import materials
from studies.convergence.outcomes import agree
from studies.convergence.richardson import Sample
from studies.runs.run import resolve
from studies.shields.shots.joined import Simulated
from studies.shields.shots.table import ShieldShot, published

STORED = RESULTS / "shield-series.json"
COMMAND = "python -m docs.pages compute shield-series"
THREE = (GRIDS[0], 0.5 * sum(GRIDS), GRIDS[1])  # times the cells of the rule
WORDS: tuple[Simulated, Simulated] = ("held", "perforated")  # of 0 and 1


@dataclass(frozen=True)
class Series:
    """Shots of one publication, and the failures with which they are computed."""

    title: str
    shots: tuple[ShieldShot, ...]
    failures: tuple[str, ...]


def series() -> dict[str, Series]:
    """The two series by the names of their claims."""
    sources = ("Piekutowski_2013", "Reimerdes_2006")
    collected = {shot.shot: shot for shot in published().shots if shot.source in sources}
    dayton = [collected[number] for number in ("4-2110", "4-2109", "4-2108", "4-2106")]
    dayton.append(replace(dayton[-1], shot="", projectile_diameter=5.81e-3, speed=6950.0))
    thick = replace(collected["EMI-4443"], projectile="AA1100-O")
    thin = replace(thick, shot="", bumper_thickness=collected["EMI-4438"].bumper_thickness)
    freiburg = (
        replace(thin, projectile_diameter=3.0e-3, speed=7000.0),
        replace(thin, projectile_diameter=3.5e-3, speed=6890.0, outcome="perforated"),
        thick,
        replace(thick, shot="", projectile_diameter=5.0e-3, speed=7070.0, outcome="perforated"),
    )
    return {
        "piekutowski": Series("Piekutowski and Poorman (2013)", tuple(dayton), FAILURES[:1]),
        "reimerdes": Series("Reimerdes, Noelke and Schaefer (2006)", freiburg, FAILURES),
    }


# ---- computed ------------------------------------------------------------------------------------


def compute(directory: Path | None = None, *names: Path) -> None:
    """Compute the runs of the named series, or of all, that neither the stored results nor a directory have."""
    runs = read_json(STORED)["runs"]
    known = {run["id"]: run for shots in runs.values() for of_shot in shots for run in of_shot}
    with tempfile.TemporaryDirectory() as temporary:
        folder = (directory or Path(temporary)).resolve()
        for name, each in series().items():
            for place, shot in enumerate(each.shots if not names or Path(name) in names else ()):
                runs[name][place] = list(runs_of(shot, (*each.failures, OF_PLATES), folder, known))
                keep({"physics": PHYSICS_VERSION, "command": COMMAND, "runs": runs}, STORED)


def runs_of(
    shot: ShieldShot, failures: Sequence[str], folder: Path, known: Mapping[str, Mapping[str, Any]]
) -> Iterator[Mapping[str, Any]]:
    """The runs of a shot: what each says of the wall, with its flags and the seconds that it took.

    One that is not among the known ones, by its identity, is computed where the folder does not have it.
    """
    for grid, failure in product(THREE, failures):
        parameters = parameters_of(shot, failure, grid)
        roles = {role: materials.load(parameters[role]) for role in ("projectile", "bumper", "wall")}
        run = resolve("whipple_shield", parameters, roles)
        if run.id in known:
            yield known[run.id]
            continue
        result = computed_once(run, folder / run.id)
        wall = result.measurements.get("wall_perforated")
        yield {
            "failure": failure,
            "grid": grid,
            "id": run.id,
            "cells": round(parameters["cells_per_diameter"], 1),  # across the projectile
            "state": result.state,
            "perforated": None if wall is None else wall.value,
            "flags": [] if wall is None else list(wall.flags),
            "seconds": round(float(result.provenance.get("seconds", math.nan)), 1),
        }


# ---- judged --------------------------------------------------------------------------------------


def told(runs: Sequence[Mapping[str, Any]]) -> tuple[Simulated, str]:
    """What the runs of a shot say together, and why it is open.

    >>> coarse, fine = ({"failure": "none", "cells": cells, "state": "succeeded", "flags": []} for cells in (20, 30))
    >>> told([{**coarse, "perforated": 1.0}, {**fine, "perforated": 1.0}])
    ('perforated', '')
    >>> told([{**coarse, "perforated": 1.0}, {**fine, "perforated": 0.0}])
    ('open', 'failure none: held with 30 cells; perforated with 20 cells')
    """
    by_failure: dict[str, list[Sample]] = {}
    for run in runs:
        value, nothing = run["perforated"], run["perforated"] is None and run["state"] == "succeeded"
        sample = Sample(
            1.0 / run["cells"], math.nan if value is None else value, 0.0, 0.0, nothing, tuple(run["flags"])
        )
        by_failure.setdefault(run["failure"], []).append(sample)
    said = {failure: agree(samples, WORDS) for failure, samples in by_failure.items()}
    values = {each.value for each in said.values()}
    if values in ({0.0}, {1.0}):
        return WORDS[int(values.pop())], ""
    return "open", "; ".join(
        f"failure {failure}: {WORDS[int(each.value)] if math.isfinite(each.value) else each.reason}"
        for failure, each in said.items()
    )


def pages() -> dict[str, str]:
    """shield-series.md."""
    stored = read_json(STORED)["runs"]
    grids = ", ".join(f"{grid:g}" for grid in THREE)
    computed = [
        (each, shot, runs)
        for name, each in series().items()
        for shot, runs in zip(each.shots, stored[name], strict=True)
    ]
    right = sum(told(_with(each.failures, runs))[0] == shot.outcome for each, shot, runs in computed)
    of_plates = sum(told(_with([OF_PLATES], runs))[0] == shot.outcome for _, shot, runs in computed)
    failed = [told(_with([OF_PLATES], runs))[0] for _, shot, runs in computed if shot.is_perforated]
    parts = [
        "# Two series that bracket a limit\n",
        "Shots near 7 km/s, simulated by the rule of `docs/pages/simulated_shields.py`, written down before any was "
        f"run: its cells times {grids}, without failure and with Johnson and Cook's. The wall of 2219-T87 has no "
        "fracture strains, so that its shots are computed without failure alone; spheres of 99.9 % aluminium are "
        "computed as 1100-O; the speed of 5.81 mm is the middle of 6.9 to 7.0 km/s. "
        f"**Right: {right} of {len(computed)}**; open counts as not right. With `{OF_PLATES}`, the default failure of "
        "plates, which was added when these outcomes were known, and for which the wall was given the spall strength "
        f"of its toughness before any such run: {of_plates} of {len(computed)}; of the {len(failed)} walls that were "
        f"perforated it found {failed.count('perforated')}. Recomputed by `{COMMAND}`.\n",
        table(
            ["series", "sphere and shield", "speed", "measured", "simulated", "why open", OF_PLATES, "why open"],
            [_row(*each) for each in computed],
        ),
    ]
    return {"shield-series.md": "\n".join(parts)}


def _with(failures: Sequence[str], runs: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    return [run for run in runs if run["failure"] in failures]


def _row(each: Series, shot: ShieldShot, runs: Sequence[Mapping[str, Any]]) -> list[str]:
    sizes = (
        f"{1e3 * shot.projectile_diameter:.2f} mm on {1e3 * shot.bumper_thickness:.2f} mm, "
        f"{1e3 * shot.stand_off:.3g} mm before {1e3 * shot.wall_thickness:.2f} mm"
    )
    cells = []
    for failures in (each.failures, (OF_PLATES,)):
        says, why = told(_with(failures, runs))
        cells += [says if says == shot.outcome else f"**{says}**", why]
    return [each.title, sizes, f"{shot.speed / 1e3:.2f} km/s", shot.outcome, *cells]
