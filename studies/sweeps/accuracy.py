"""Accuracies: the mesh error that a user allows, and the grid of a run that holds it, from experience."""

import math
from collections.abc import Mapping
from types import MappingProxyType

from studies import scenarios
from studies.convergence import experience
from studies.quantities.findings import nearest_cure, refusal
from studies.quantities.parameters import Plain
from studies.quantities.units import exact_share, round_quantity
from studies.runs.run import Run

# Half-width of 95 % of the relative mesh error of what is measured.
ACCURACY: Mapping[str, float] = MappingProxyType({"draft": 0.10, "standard": 0.05, "fine": 0.02})
USUAL = ACCURACY["standard"]  # of a sweep that names neither an accuracy nor a resolution
LEAST, MOST = 0.01, 0.30


def in_percent(error: float) -> str:
    """An error as a person writes it, and as ``read_accuracy`` reads it.

    >>> in_percent(0.03), in_percent(0.025)
    ('3 %', '2.5 %')
    """
    return f"{round_quantity(100.0 * error):.12g} %"


def read_accuracy(raw: Plain) -> float:
    """An error by its name, in per cent or as a part of one; raises InvalidInput.

    >>> read_accuracy("3 %"), read_accuracy(0.03), read_accuracy("draft")
    (0.03, 0.03, 0.1)
    """
    limit = f"{', '.join(ACCURACY)}, or an error from {in_percent(LEAST)} to {in_percent(MOST)}"
    if isinstance(raw, str) and raw.strip() in ACCURACY:
        return ACCURACY[raw.strip()]
    if isinstance(raw, str) and not any(letter.isdigit() for letter in raw):
        raise refusal("accuracy", raw, limit, nearest_cure(raw, ACCURACY))
    error = exact_share(raw, "accuracy", "3 %")
    if not LEAST <= error <= MOST:
        meant = error if "%" in str(raw) else error / 100.0  # 3 is hardly 300 %
        raise refusal("accuracy", raw, limit, f"write {in_percent(min(max(meant, LEAST), MOST))}")
    return error


def tells_errors(scenario: scenarios.Scenario) -> bool:
    """Whether experience tells the mesh error of some measurement of a scenario that counts for its accuracy."""
    return any(scenario.parameters.experienced.get(name) in experience.stored() for name in scenario.accurate)


def cells_of(run: Run, error: float) -> float:
    """The fewest cells across on which the measurements of a run have at most a mesh error; raises InvalidInput.

    Those that count are the scenario's ``accurate`` ones of which experience tells anything; ``run`` may be on any
    grid.
    """
    wanted = scenarios.load(run.scenario).accurate
    grids = [grid for name, grid in run.mesh_grids.items() if name in wanted]
    known = [grid for grid in grids if grid.quantity in experience.stored()]
    cells = experience.cells_for(error, known)
    if cells is not None:
        return cells
    finest: list[experience.MeshGrid | None] = [grid.refined(experience.MOST_CELLS) for grid in known or grids[:1]]
    reasons = dict.fromkeys(filter(None, map(experience.why_unknown, finest or [None])))
    errors = map(experience.mesh_error, finest)
    resolution = "give the cells across the diameter: resolution: 32"
    if reasons:
        limit = f"a resolution, since the mesh error is unknown: {'; '.join(reasons)}"
        raise refusal("accuracy", in_percent(error), limit, resolution)
    smallest = math.ceil(1e3 * max(error.bar for error in errors if error is not None)) / 1e3
    cure = f"write accuracy: {in_percent(smallest)}" if smallest <= MOST else resolution
    raise refusal("accuracy", in_percent(error), f"at least {in_percent(smallest)}, on the finest grid", cure)
