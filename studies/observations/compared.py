"""What whipple gives for the published shots that ship, beside them: its bias by quantity and materials.

``python -m docs.pages compute shots`` computes ``compared.json``, from which docs/pages/shots.py is made too.
"""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

STORED = Path(__file__).with_name("compared.json")
ROLES = ("projectile", "target", "bar")  # parameters of a shot that name its materials
FEWEST = 5  # shots of the same materials and quantity that have a bias: the interval of fewer says next to nothing


@dataclass(frozen=True)
class ComparedShots:
    """The shots of a table with one quantity and the same materials: simulation / observation - 1."""

    table: str
    quantity: str
    materials: tuple[str, ...]  # of the projectile and the target, or of the bar
    shots: int
    bias: tuple[float, float] | None  # interval of the mean, at 95 %; None of fewer than FEWEST shots
    scatter: float | None  # the standard deviation about the mean, likewise
    stated: float | None  # largest relative error that a shot states; None where none states any


class StoredShot(TypedDict, total=False):
    """A published shot with what was computed for it, SI."""

    table: str
    quantity: str
    unit: str
    parameters: Mapping[str, str | float]
    observed: float | None
    bounds: tuple[float, float]
    uncertainty: float | None
    simulated: float | None
    numerical_uncertainty: float | None
    flags: Sequence[str]
    source: str
    confidence: str
    note: str


class Stored(TypedDict):
    """The results as they were computed."""

    physics_version: int
    measurements: Mapping[str, int]  # versions of their definitions
    grids: Mapping[str, Mapping[str, float | Sequence[float]]]  # by table
    shots: Sequence[StoredShot]


def stored() -> Stored:
    """The results as they were computed."""
    document: Stored = json.loads(STORED.read_text(encoding="utf-8"))
    return document


def ratio(row: StoredShot) -> float:
    """Simulation over observation, less 1; NaN where there is no simulation, and of a range."""
    if row["simulated"] is None or row["observed"] is None:
        return math.nan
    return float(row["simulated"] / row["observed"] - 1.0)


def bias_and_scatter(rows: Sequence[StoredShot]) -> tuple[int, tuple[float, float] | None, float | None]:
    """Number of compared shots, interval of the mean of their ratios less 1 by Student's t, and standard deviation.

    None of both with fewer than ``FEWEST``.
    """
    import numpy as np

    from studies.quantities.least_squares import linear

    ratios = np.array([value for value in map(ratio, rows) if not math.isnan(value)])
    if len(ratios) < FEWEST:
        return len(ratios), None, None
    mean = linear([np.ones(len(ratios))], ratios)
    middle, half = float(mean.constants[0]), float(mean.intervals[0])
    return len(ratios), (middle - half, middle + half), float(ratios.std(ddof=1))


def compared_shots() -> Iterator[ComparedShots]:
    """All shots, by table, quantity and materials."""
    groups: dict[tuple[str, str, tuple[str, ...]], list[StoredShot]] = {}
    for row in stored()["shots"]:
        materials = tuple(str(row["parameters"][role]) for role in ROLES if role in row["parameters"])
        groups.setdefault((row["table"], row["quantity"], materials), []).append(row)
    for (table, quantity, materials), rows in groups.items():
        count, bias, scatter = bias_and_scatter(rows)
        errors = [row["uncertainty"] / row["observed"] for row in rows if row["uncertainty"] and row["observed"]]
        if count:
            stated = max(errors, default=None)
            yield ComparedShots(table, quantity, materials, count, bias, scatter, stated)
