"""An accuracy as a mesh error: read, resolved to the cells of each point, stored with an accepted sweep."""

import json
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pytest

from service.records.expansion import ExpandedSweep, expand, expand_again
from studies.convergence import experience
from studies.convergence.experience import Experience, cells_for, mesh_error
from studies.quantities.findings import InvalidInput
from studies.sweeps.accuracy import ACCURACY, USUAL, cells_of, in_percent, read_accuracy
from studies.sweeps.cost import cost_of, presets_of
from studies.sweeps.longer import with_values
from studies.sweeps.reading import ACCEPTED, SweepLimits
from studies.sweeps.sweep import Sweep
from tests.samples import needs
from tests.studies.convergence.test_experience import KNOWN

COPPER = {"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": "8 mm"}
HOLES: Mapping[str, Any] = {
    "name": "holes",
    "scenario": "thin_plate",
    "fixed": COPPER,
    "axes": {"speed": ["3 km/s", "6 km/s"], "plate_thickness": ["0.8 mm", "3.2 mm"]},
    "accuracy": "3 %",
}
SEARCH = {
    **HOLES,
    "scenario": "whipple_shield",
    "fixed": {
        **dict.fromkeys(("projectile", "bumper", "wall"), "al-6061-t6"),
        **{"bumper_thickness": "1 mm", "wall_thickness": "3 mm", "stand_off": "50 mm"},
    },
    "axes": {
        "speed": ["4 km/s", "6 km/s"],
        "projectile_diameter": {"limit_of": "wall_perforated", "between": ["2 mm", "8 mm"], "tolerance": "1 mm"},
    },
}


@pytest.fixture(autouse=True)
def known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(experience, "stored", lambda: KNOWN)


def without(document: Mapping[str, Any], *keys: str, **changes: Any) -> dict[str, Any]:
    return {key: part for key, part in {**document, **changes}.items() if key not in keys}


def cells(sweep: Sweep) -> list[Any]:
    return [point.run.parameters["cells_per_diameter"] for point in sweep.runs()]


def refused(document: Mapping[str, Any]) -> str:
    with pytest.raises(InvalidInput) as caught:
        Sweep.parse(document).runs()
    return str(caught.value)


def with_scale(scale: float) -> dict[str, Experience]:
    """Experience that is so many times as sure."""
    hole = KNOWN["hole_diameter"]
    scales = {name: scale * each for name, each in hole.model.scale.items()}
    return {"hole_diameter": replace(hole, model=replace(hole.model, scale=scales))}


@pytest.mark.parametrize(
    ("raw", "error"), [("3 %", 0.03), ("3%", 0.03), (" 2.5 % ", 0.025), (0.03, 0.03), ("0.03", 0.03), *ACCURACY.items()]
)
def test_accuracy__is_a_name_or_a_part_or_a_percentage(raw: Any, error: float) -> None:
    assert read_accuracy(raw) == error
    assert read_accuracy(in_percent(error)) == error


@pytest.mark.parametrize(
    ("raw", "cure"),
    [
        (3, "write 3 %"),
        ("0.5 %", "write 1 %"),
        (0.5, "write 1 %"),
        ("40 %", "write 30 %"),
        ("high", "did you mean 'fine'?"),
        ("3 mm", "write a number such as 3 %"),
        (True, "write a number such as 3 %"),
        ([0.03], "write a number such as 3 %"),
        ("nan %", "use one of"),
    ],
)
def test_accuracy__that_is_none_is_refused_with_a_cure(raw: Any, cure: str) -> None:
    assert cure in refused({**HOLES, "accuracy": raw})


def test_accuracy__gives_each_point_the_fewest_cells_that_hold_it() -> None:
    sweep = Sweep.parse(HOLES, SweepLimits(max_runs=4))
    assert (sweep.grid.shape, sweep.refinements) == ((2, 2), ())
    points = sweep.runs()
    for point in points:
        grid = point.run.mesh_grids["hole_diameter"]
        assert cells_for(0.03, [grid]) == grid.across
        error = mesh_error(grid)
        assert error is not None
        assert error.bar <= 0.03
    thin, thick, *_ = cells(sweep)
    assert thin > thick
    stated = Sweep.parse(without(HOLES, "accuracy", resolution=thin)).runs()
    assert (stated[0].run.id, stated[2].run.id) == (points[0].run.id, points[2].run.id)


@needs("elastic_bar")
def test_accuracy__is_usual_where_nothing_states_the_cells() -> None:
    assert Sweep.parse(without(HOLES, "accuracy")).accuracy == USUAL == ACCURACY["standard"]
    axes = {**HOLES["axes"], "cells_per_diameter": [12, 16]}
    for changes in ({"resolution": 16}, {"fixed": {**COPPER, "cells_per_diameter": 16}}, {"axes": axes}):
        assert Sweep.parse(without(HOLES, "accuracy", **changes)).accuracy is None
    bar = {"name": "b", "scenario": "elastic_bar", "axes": {"speed": ["1 m/s"]}}
    assert Sweep.parse(bar).accuracy is None


@needs("elastic_bar")
def test_accuracy__goes_with_offsets_and_not_with_a_resolution() -> None:
    sweep = Sweep.parse({**HOLES, "offsets": 2})
    assert (sweep.grid.shape, len({*cells(sweep)})) == ((2, 2, 2), 2)
    assert "give one of the two" in refused({**HOLES, "resolution": 16})
    assert "accuracy, or cells_per_diameter under fixed" in refused(
        {**HOLES, "fixed": {**COPPER, "cells_per_diameter": 16}}
    )
    assert "whose mesh error is known" in refused({**HOLES, "scenario": "elastic_bar"})


def test_accuracy__that_cannot_be_had_names_point_smallest_error_and_cure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(experience, "stored", lambda: with_scale(5.0))
    message = refused(HOLES)
    assert "accuracy: '3 %' (at speed = 3 km/s, plate_thickness = " in message
    assert "at least 3.9 %, on the finest grid; write accuracy: 3.9 %" in message
    assert len(Sweep.parse({**HOLES, "accuracy": "3.9 %"}).runs()) == 4


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"axes": {**HOLES["axes"], "speed": ["3 km/s", "9 km/s"]}}, "speed 9e+03 outside of 1.5e+03 to 8e+03"),
        ({"axes": {"speed": ["3 km/s"], "plate_thickness": ["0.08 mm"]}}, "thickness 0.01 outside of 0.05 to 1"),
        ({"fixed": {**COPPER, "recipe": "thesis"}}, "not with these numerics and failures"),
    ],
)
@pytest.mark.parametrize("accuracy", ["3 %", None])
def test_accuracy__where_the_mesh_error_is_unknown_asks_for_a_resolution(
    changes: dict[str, Any], why: str, accuracy: str | None
) -> None:
    message = refused(without({**HOLES, **changes}, *([] if accuracy else ["accuracy"])))
    assert why in message
    assert "resolution: 32" in message


def test_accuracy__counts_what_experience_knows_of_what_the_scenario_is_about() -> None:
    hole = KNOWN["hole_diameter"]
    block = {**HOLES, "scenario": "thick_plate", "axes": {"speed": ["4 km/s"]}}
    run = Sweep.parse(without(block, "accuracy", resolution=16)).runs()[0].run
    # No block has a thickness or cells through it, and the depth is the surer of the two.
    domain = replace(hole.domain, thickness=(0.0, float("inf")))
    deep = replace(hole, domain=domain, model=replace(hole.model, scale={"always": 0.0, "through": 0.0, "across": 0.1}))
    wide = replace(deep, model=replace(hole.model, scale={"always": 0.0, "through": 0.0, "across": 0.3}))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(experience, "stored", lambda: {"crater_depth": deep})
        depth = cells_of(run, 0.03)
        patch.setattr(experience, "stored", lambda: {"crater_depth": deep, "crater_diameter": wide})
        assert cells_of(run, 0.03) > depth
        none_covers = replace(wide, domain=replace(domain, speed=(5e3, 8e3)))
        patch.setattr(experience, "stored", lambda: {"crater_depth": deep, "crater_diameter": none_covers})
        with pytest.raises(InvalidInput, match="speed 4e"):
            cells_of(run, 0.03)


# --- the stored document ----------------------------------------------------------------------------


def accepted(document: Mapping[str, Any]) -> ExpandedSweep:
    expanded = expand(Sweep.parse(document), lambda run: 0.0)
    return replace(expanded, document=json.loads(json.dumps(expanded.document)))


@pytest.mark.parametrize(
    "document",
    [
        HOLES,
        without(HOLES, "accuracy"),
        {**HOLES, "combine": "zip"},
        {**HOLES, "combine": "sobol", "points": 4, "seed": 1, "axes": {
            "speed": {"low": "3 km/s", "high": "6 km/s"}, "plate_thickness": {"low": "0.8 mm", "high": "4 mm"}}},
        {**HOLES, "model_part": "screen"},
        pytest.param(SEARCH, marks=needs("whipple_shield")),
    ],
)  # fmt: skip
def test_accepted_sweep__keeps_its_runs_whatever_experience_tells_later(
    document: Mapping[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    before = accepted(document)
    assert before.document["accuracy"] == in_percent(Sweep.parse(document).accuracy or 0.0)
    for later in (with_scale(1.5), {}):
        monkeypatch.setattr(experience, "stored", lambda later=later: later)
        again = expand_again(before.document)
        assert [each.run_id for each in again.points] == [each.run_id for each in before.points]
        assert json.loads(json.dumps(again.document)) == before.document
    monkeypatch.setattr(experience, "stored", lambda: with_scale(1.5))
    anew = expand(Sweep.parse(before.document), lambda run: 0.0)
    assert [each.run_id for each in anew.points] != [each.run_id for each in before.points]


def test_accepted_sweep__of_an_older_version_keeps_the_cells_of_its_scenario() -> None:
    """A document without accuracy and resolution had the default; a name stood for resolutions, which it holds."""
    assert {*cells(Sweep.parse(without(HOLES, "accuracy"), ACCEPTED))} == {32.0}
    older = without(HOLES, "accuracy", resolution=[16, 24, 36], offsets=3)
    assert Sweep.parse(older, ACCEPTED).document() == Sweep.parse(older).document()
    assert Sweep.parse(older, ACCEPTED).size == 36


@needs("whipple_shield")
def test_search__has_one_grid_for_all_values_of_a_point() -> None:
    sweep = Sweep.parse(SEARCH)
    search = sweep.search
    assert search is not None
    at = {"speed": 4e3}
    tries = [sweep.of_point({**at, search.axis: value}) for value in (search.low, 0.005, search.high)]
    assert len({each.resolutions for each in tries}) == 1
    fewest = [cells_of(each.runs()[0].run, 0.03) for each in (tries[0], tries[-1])]
    assert tries[0].resolutions == (max(fewest),)
    assert len({*fewest}) == 2
    tried = sweep.tried(sweep.limits(lambda run: True))
    assert {*cells(tried)} == {*cells(sweep)}


def test_of_point_and_with_values__keep_the_cells_of_a_point_and_choose_those_of_new_ones() -> None:
    sweep = Sweep.parse(HOLES)
    last = sweep.runs()[1]
    alone = Sweep.parse(json.loads(json.dumps(sweep.of_point(last.coordinates).document())))
    assert (alone.accuracy, [point.run.id for point in alone.runs()]) == (None, [last.run.id])
    longer = cells(with_values(sweep, "plate_thickness", ["1.6 mm"]))
    assert longer[0::3] == cells(sweep)[0::2]
    assert longer[1] < longer[0]


# --- cost -------------------------------------------------------------------------------------------


@needs("elastic_bar")
def test_presets__are_the_named_errors_with_the_cells_and_the_cost_of_their_runs() -> None:
    sweep = Sweep.parse(without(HOLES, "accuracy", resolution=[8, 12], offsets=3))
    presets = [*presets_of(sweep, most_runs=100)]
    assert {each.name: each.error for each in presets} == ACCURACY
    for each in presets:
        chosen = cells(Sweep.parse(without(HOLES, accuracy=each.name)))
        assert (each.runs, each.cells, each.reason) == (4, (min(chosen), max(chosen)), "")
    costs = [each.cost.core_seconds for each in presets if each.cost]
    assert costs == sorted({*costs})
    assert [each.reason for each in presets_of(sweep, most_runs=3)] == ["more than 3 runs"] * 3
    fast = Sweep.parse(without(HOLES, "accuracy", resolution=8, axes={**HOLES["axes"], "speed": ["9 km/s"]}))
    assert all("speed 9e+03 outside" in each.reason for each in presets_of(fast, most_runs=100))
    bar = {"name": "b", "scenario": "elastic_bar", "axes": {"speed": ["1 m/s"]}}
    assert [*presets_of(Sweep.parse(bar), most_runs=100)] == []


def test_cost__of_many_coarse_runs_is_mostly_that_of_any_run() -> None:
    """2 000 runs on 4 cells per diameter took 165 s on two cores and 242 MB; the estimate said 28 core-s and 63 MB."""
    speeds = {"start": "2 km/s", "stop": "5.99 km/s", "step": "0.01 km/s"}
    axes = {"speed": speeds, "plate_thickness": [f"{thickness} mm" for thickness in range(1, 6)]}
    cost = cost_of(Sweep.parse(without(HOLES, "accuracy", axes=axes, resolution=4)))
    assert cost.runs == 2000
    assert cost.core_seconds == pytest.approx(2 * 165.0, rel=0.3)
    assert cost.bytes == pytest.approx(242e6, rel=0.3)
    assert 300e6 < cost.memory < 350e6
