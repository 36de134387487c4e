"""What whipple gives for the published shots that ship, beside them: bias and scatter by quantity and materials.

``python -m docs.pages compute shots`` computes ``compared.json``, from which docs/shots.md is made too.
"""

import json
import math
import statistics
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

STORED = Path(__file__).with_name("compared.json")
ROLES = ("projectile", "target", "bar")  # parameters of a shot that name its materials


@dataclass(frozen=True)
class ComparedShots:
    """The shots of a table with one quantity and the same materials: simulation / observation - 1."""

    table: str
    quantity: str
    materials: tuple[str, ...]  # of the projectile and the target, or of the bar
    shots: int
    bias: float  # the mean
    scatter: float | None  # the standard deviation about it; None of a single shot
    stated: float | None  # largest relative error that a shot states; None where none states any


def stored() -> dict[str, Any]:
    """The results as they were computed."""
    document: dict[str, Any] = json.loads(STORED.read_text(encoding="utf-8"))
    return document


def ratio(row: Mapping[str, Any]) -> float:
    """Simulation over observation, less 1; NaN where there is no simulation."""
    if row["simulated"] is None:
        return math.nan
    return float(row["simulated"] / row["observed"] - 1.0)


def bias_and_scatter(rows: Sequence[Mapping[str, Any]]) -> tuple[int, float, float]:
    """Number of compared shots, mean and standard deviation of their ratios less 1; NaN where there is none."""
    ratios = [value for value in map(ratio, rows) if not math.isnan(value)]
    bias = statistics.mean(ratios) if ratios else math.nan
    return len(ratios), bias, statistics.stdev(ratios) if len(ratios) > 1 else math.nan


def compared_shots() -> Iterator[ComparedShots]:
    """All shots, by table, quantity and materials."""
    groups: dict[tuple[str, str, tuple[str, ...]], list[Mapping[str, Any]]] = {}
    for row in stored()["shots"]:
        materials = tuple(row["parameters"][role] for role in ROLES if role in row["parameters"])
        groups.setdefault((row["table"], row["quantity"], materials), []).append(row)
    for (table, quantity, materials), rows in groups.items():
        count, bias, scatter = bias_and_scatter(rows)
        errors = [row["uncertainty"] / row["observed"] for row in rows if row["uncertainty"]]
        if count:
            yield ComparedShots(
                table,
                quantity,
                materials,
                count,
                bias,
                None if math.isnan(scatter) else scatter,
                max(errors, default=None),
            )
