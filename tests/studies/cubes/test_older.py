"""Results of a sweep whose runs had other ids when they were computed."""

from typing import Any

import pytest

from studies.cubes.older import by_present_ids
from studies.quantities.measured import Measured
from studies.runs.results import RunResult
from studies.sweeps.sweep import Sweep
from tests.samples import needs

GRID = {
    "scenario": "thin_plate",
    "fixed": {
        "projectile": "copper-ofhc",
        "target": "copper-ofhc",
        "projectile_diameter": "8 mm",
        "plate_thickness": "2 mm",
    },
    "axes": {"speed": ["3 km/s", "4 km/s", "6 km/s"]},
    "resolution": [4, 6],
}
SEARCH = {
    "scenario": "plugging",
    "axes": {"speed": {"limit_of": "perforated", "between": ["100 m/s", "200 m/s"], "tolerance": "10 m/s"}},
    "resolution": 8,
}
SPEEDS = [100.0, 150.0, 200.0, 175.0, 162.5, 156.25]  # that the search tries, for a limit of 155 m/s


def result(id: str, speed: float) -> RunResult:
    perforated = Measured(float(speed >= 155.0), None, {}, (), {"time": [0.0], "value": [0.0]}, 1)
    return RunResult(id, "succeeded", measurements={"perforated": perforated})


@pytest.mark.parametrize("document", [GRID, pytest.param(SEARCH, marks=needs("plugging"))])
def test_older_results__are_those_of_the_points_with_the_same_coordinates(document: dict[str, Any]) -> None:
    sweep = Sweep.parse(document)
    coordinates: list[dict[str, Any]] = [{"speed": speed} for speed in SPEEDS]
    if not sweep.search:
        coordinates = [dict(point.coordinates) for point in sweep.runs()]
    places = [(at, f"older {number}") for number, at in enumerate(coordinates)]
    results = {id: result(id, float(at["speed"])) for at, id in places}
    present = by_present_ids(sweep, results, places)
    assert present.keys() > results.keys()
    ids = {id: each.run_id for id, each in present.items() if id not in results}
    assert sorted(ids.values()) == sorted(results)
    if not sweep.search:
        assert ids == {point.run.id: places[number][1] for number, point in enumerate(sweep.runs())}
        first = {id: each for id, each in results.items() if id == "older 0"}
        assert len(by_present_ids(sweep, first, places)) == 2  # the others stay empty
