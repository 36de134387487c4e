"""What a report says of outcomes: along an axis, over grids and models, and in its headline."""

from collections.abc import Callable, Mapping
from typing import Any

import pytest

from studies.cases.rows import equal
from studies.cubes.variable import Quantity
from studies.quantities.measured import Measured
from studies.reports import openings
from studies.reports.page import page
from studies.runs.results import RunResult
from studies.sweeps.axes import Axis
from tests.studies.support import fakes

HOLDS = Quantity("wall_perforated", "1", "1 where the wall has a hole", ("wall holds", "wall perforated"))
Outcome = Callable[[Mapping[str, Any]], float]
SPEED = Axis("speed", "m s-1", (4e3, 5e3, 6e3))
GRIDS = {"resolutions": (16.0, 24.0, 36.0)}


def document_of(outcome: Outcome, *axes: Axis, **changes: Any) -> dict[str, Any]:
    """The report on a sweep whose runs have an outcome that their parameters decide."""
    sweep = fakes.sweep_of(*axes, **changes)
    results = {}
    for point in sweep.runs():
        measured = Measured(outcome(point.run.parameters), None, {}, (), {"time": [], "value": []}, 1)
        results[point.run.id] = RunResult(
            point.run.id, "succeeded", measurements={"wall_perforated": measured}, provenance=fakes.PROVENANCE
        )
    return fakes.document_of(fakes.cube_of(sweep, results, quantities={"wall_perforated": HOLDS}, laws=[]))


def coarse_is_open(parameters: Mapping[str, Any]) -> float:
    """Between 4.5 and 5.5 km/s the coarse grids open what the fine one holds."""
    limit = 4.5e3 if parameters["cells_per_diameter"] < 30.0 else 5.5e3
    return float(parameters["speed"] > limit)


def by_model(parameters: Mapping[str, Any]) -> float:
    return float(parameters["geometry"] == "quarter" or parameters["speed"] > 5.5e3)


BOTH = Axis("geometry", None, ("axisymmetric", "quarter"))


@pytest.mark.claim("shields", "open-outcomes")
def test_report__leaves_a_shot_undecided_where_its_grids_disagree(compared: Callable[..., None]) -> None:
    """A report says at which shots the wall holds, where it is perforated, and where grids disagree, and how."""
    document = document_of(coarse_is_open, SPEED, **GRIDS)
    (stated,) = document["outcomes"]
    why = "wall holds with 36 cells; wall perforated with 16 and 24 cells"
    said = "Wall holds at 4 km/s, undecided at 5 km/s, wall perforated at 6 km/s (finds 8 of 17 failures)."
    beside = "3 grids agree; such simulations found 8 of 17 walls that were perforated"
    compared(
        equal("headline", expected=said, got=document["headline"]),
        equal("outcomes", expected=[0.0, None, 1.0], got=[row["outcome"] for row in stated["rows"]]),
        equal("beside the wall that holds", expected=beside, got=stated["rows"][0]["reason"]),
        equal("why it is open", expected=why, got=stated["rows"][1]["reason"]),
        equal("the page says so", expected=True, got='id="outcomes"' in page(document) and why in page(document)),
    )


def test_report__leaves_a_shot_undecided_where_its_models_disagree() -> None:
    document = document_of(by_model, SPEED, BOTH)
    assert document["headline"] == "Undecided at 4-5 km/s, wall perforated at 6 km/s."
    (stated,) = document["outcomes"]
    assert [row["outcome"] for row in stated["rows"]] == [None, None, 1.0]
    assert stated["rows"][0]["at"] == {"speed": 4e3}
    assert stated["rows"][0]["reason"] == (
        "wall holds with geometry axisymmetric; wall perforated with geometry quarter"
    )


def stated(*rows: tuple[float | None, str, float]) -> dict[str, Any]:
    """An outcome by its value, its reason and the thickness of a wall (mm)."""
    return {
        "words": list(HOLDS.outcomes),
        "rows": [{"at": {"wall": 1e-3 * wall}, "outcome": value, "reason": why} for value, why, wall in rows],
    }


WALLS = [{"name": "wall", "unit": "m"}]
FAST = [{"name": "speed", "value": 6.7e3}]


@pytest.mark.parametrize(
    ("rows", "fixed", "said"),
    [
        ([(0.0, "3 grids agree", 2)], [], "Wall holds (3 grids agree)."),
        ([(1.0, "one grid", 2)], FAST, "At 6.7 km/s: wall perforated (one grid)."),
        ([(None, "closed by film", 2)], FAST, "At 6.7 km/s: undecided: closed by film."),
        ([(None, "why " * 30, 2)], [], "Undecided."),
        (
            [(1.0, "", 2), (0.0, "", 4), (1.0, "", 3)],
            FAST,
            "At 6.7 km/s: wall perforated at wall 2-3 mm, wall holds at 4 mm, undecided between.",
        ),
        (
            [(1.0, "", 2), (None, "", 3), (0.0, "", 4)],
            [],
            "Wall perforated at wall 2 mm, undecided at 3 mm, wall holds at 4 mm.",
        ),
        ([(0.0, "", 2), (0.0, "", 4)], [], "Wall holds at wall 2-4 mm."),
        (
            [(value, "", wall) for wall, value in enumerate([0.0, 1.0, 0.0, 1.0, 0.0, None])],
            [],
            "Wall holds at 3 of 6 points, wall perforated at 2 of 6 points, undecided at 1 of 6 points.",
        ),
        ([], [], ""),
    ],
)
def test_headline__says_where_an_outcome_is_known_and_where_undecided(
    rows: list[tuple[float | None, str, float]], fixed: list[dict[str, Any]], said: str
) -> None:
    assert openings.of_outcomes(stated(*rows), {"fixed": fixed, "axes": WALLS}) == said
