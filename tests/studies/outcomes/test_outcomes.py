"""What a report says of outcomes: along an axis, over grids and models, and in its headline."""

from collections.abc import Callable, Mapping
from typing import Any

import pytest

from studies.cubes.variable import Quantity
from studies.outcomes import shots as of_shots
from studies.outcomes.found import Share
from studies.outcomes.section import ComputedWay, QuantityOutcomes, ShotOutcome
from studies.quantities.measured import Measured
from studies.reports.page import page
from studies.runs.results import RunResult
from studies.sweeps.axes import Axis
from tests.claims.rows import equal
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
    [stated] = document["outcomes"]["quantities"]
    why = "wall holds with 36 cells; wall perforated with 16 and 24 cells"
    said = "Wall holds at 4 km/s, undecided at 5 km/s, wall perforated at 6 km/s"
    ways = [shot["computed"][0] for shot in stated["shots"]]
    compared(
        equal("headline", expected=said, got=document["headline"].partition(" (")[0].rstrip(".")),
        equal("outcomes", expected=[False, None, True], got=[shot["outcome"] for shot in stated["shots"]]),
        equal("what its grids say where the wall holds", expected="3 grids agree", got=ways[0]["grids"]),
        equal("why it is open", expected=why, got=ways[1]["grids"]),
        equal("the page says so", expected=True, got='id="outcomes"' in page(document) and why in page(document)),
    )


def test_report__leaves_a_shot_undecided_where_its_models_disagree() -> None:
    document = document_of(by_model, SPEED, BOTH)
    assert document["headline"] == "Undecided at 4-5 km/s, wall perforated at 6 km/s."
    [stated] = document["outcomes"]["quantities"]
    assert [shot["outcome"] for shot in stated["shots"]] == [None, None, True]
    first = stated["shots"][0]
    assert first["at"] == {"speed": 4e3}
    assert [(way["model"]["geometry"], way["outcome"]) for way in first["computed"]] == [
        ("axisymmetric", False),
        ("quarter", True),
    ]


def way(outcome: bool | None, grids: str = "", *flags: str, says: bool | None = None, **model: str) -> ComputedWay:
    return ComputedWay(model, outcome, says, flags, grids, Share(7, 17) if outcome is False else None)


def shot(wall: float, *ways: ComputedWay) -> ShotOutcome:
    """A shot at a wall of some mm."""
    said = {each.outcome for each in ways}
    return ShotOutcome({"wall": 1e-3 * wall}, ways[0].outcome if len(said) == 1 else None, ways)


YES, NO, OPEN = way(True), way(False), way(None, "", "closed_by_film")
FOUND = "(finds 7 of 17 failures)"


@pytest.mark.parametrize(
    ("shots", "speed", "said"),
    [
        ([shot(2, way(False, "3 grids agree"))], None, f"Wall holds (3 grids agree) {FOUND}."),
        ([shot(2, OPEN)], 6.7e3, "At 6.7 km/s: undecided: closed by film."),
        ([shot(2, way(None, "", "still_attached", says=False))], None, "Undecided: wall holds, but still attached."),
        (
            [shot(2, way(False, geometry="axisymmetric"), way(True, geometry="quarter"))],
            None,
            "Undecided: wall holds with geometry axisymmetric; wall perforated with geometry quarter.",
        ),
        ([shot(2, way(None, "why " * 30))], None, "Undecided."),
        (
            [shot(2, YES), shot(4, NO), shot(3, YES)],
            6.7e3,
            f"At 6.7 km/s: wall perforated at wall 2-3 mm, wall holds at 4 mm, undecided between {FOUND}.",
        ),
        (
            [shot(wall, each) for wall, each in enumerate((NO, YES, NO, YES, NO, OPEN))],
            None,
            f"Wall holds at 3 of 6 points, wall perforated at 2 of 6 points, undecided at 1 of 6 points {FOUND}.",
        ),
    ],
)
def test_headline__says_where_an_outcome_is_known_and_where_undecided(
    shots: list[ShotOutcome], speed: float | None, said: str
) -> None:
    no, yes = HOLDS.outcomes
    outcomes = QuantityOutcomes("wall_perforated", (no, yes), True, tuple(shots))
    assert of_shots.headline(outcomes, {"wall": "m"}, speed) == said
