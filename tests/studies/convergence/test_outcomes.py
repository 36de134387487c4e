"""Outcomes over grids: agreed only where every run that counts says the same."""

import math
from collections.abc import Sequence

import pytest

from studies.convergence.outcomes import agree
from studies.convergence.richardson import Sample
from studies.quantities.measured import CLOSED_BY_FILM, STILL_COMING, TOO_COARSE

WORDS = ("holds", "is open")


def runs(*outcomes: tuple[float, float | None, str]) -> list[Sample]:
    """Runs by their cells, their outcome (None: undecided) and a flag."""
    return [
        Sample(
            1.0 / cells,
            math.nan if outcome is None else outcome,
            nothing=outcome is None,
            quality_flags=(flag,) * bool(flag),
        )
        for cells, outcome, flag in outcomes
    ]


FAILED = Sample(1.0 / 48.0, math.nan)
THREE = ((16, 0.0, ""), (24, 0.0, ""), (36, 0.0, ""))


@pytest.mark.parametrize(
    ("samples", "verdict", "value", "reason"),
    [
        (runs(*THREE), "grids agree", 0.0, "3 grids agree"),
        (runs((16, 1.0, ""), (24, 1.0, "")), "grids agree", 1.0, "2 grids agree"),
        (runs((16, 1.0, "")), "single grid", 1.0, "one resolution says nothing about the mesh"),
        (
            runs((16, 1.0, ""), (24, 1.0, ""), (36, 0.0, "")),
            "open",
            None,
            "holds with 36 cells; is open with 16 and 24 cells",
        ),
        # Coarser than the three that count.
        (runs((8, 1.0, ""), *THREE), "grids agree", 0.0, "3 grids agree"),
        (
            runs((16, 0.0, ""), (24, 0.0, ""), (24, 1.0, "")),
            "open",
            None,
            "holds with 16 and 24 cells; is open with 24 cells",
        ),
        (runs((16, 0.0, ""), (16, 1.0, "")), "open", None, "offsets of its one resolution disagree"),
        (
            runs((16, 0.0, ""), (24, 0.0, ""), (36, None, "")),
            "open",
            None,
            "undecided with 36 cells; holds with 16 and 24 cells; 1 of 3 resolutions without a value; "
            "the finest among them",
        ),
        (
            runs((16, 0.0, ""), (24, 0.0, CLOSED_BY_FILM)),
            "open",
            None,
            "holds, but closed by film at the finest resolution",
        ),
        (runs((16, 0.0, STILL_COMING)), "open", None, "holds, but still coming at the finest resolution"),
        (runs((8, 1.0, ""), (12, 1.0, TOO_COARSE)), "open", None, "is open, but too coarse at the finest resolution"),
        (runs((16, 0.0, CLOSED_BY_FILM), (24, 0.0, "")), "grids agree", 0.0, "2 grids agree"),
        (runs((16, 1.0, CLOSED_BY_FILM), (24, 1.0, STILL_COMING)), "grids agree", 1.0, "2 grids agree"),
        (
            [*runs(*THREE), FAILED],
            "grids agree",
            0.0,
            "3 grids agree; 1 of 4 resolutions without a value; the finest among them",
        ),
        ([FAILED], "no value", None, "no run has a value; 1 of 1 resolutions without a value; the finest among them"),
    ],
)
def test_outcome__is_what_all_runs_say_that_count(
    samples: Sequence[Sample], verdict: str, value: float | None, reason: str
) -> None:
    point = agree(samples, WORDS)
    assert (point.verdict, point.reason) == (verdict, reason)
    assert math.isnan(point.value) if value is None else point.value == value
    assert math.isnan(point.uncertainty)
    again = agree(list(reversed(samples)), WORDS)
    assert (again.verdict, again.reason) == (verdict, reason)
