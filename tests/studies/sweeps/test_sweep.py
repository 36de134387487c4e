"""Sweep documents: checked in one go, canonical, counted before they are expanded."""

import copy
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies import materials, scenarios
from studies.quantities.findings import InvalidInput
from studies.quantities.parameters import declared
from studies.runs.run import estimate
from studies.sweeps import examples
from studies.sweeps.axes import AxisReader
from studies.sweeps.document import read_sweep_file, read_yaml
from studies.sweeps.kernels import kinds_of
from studies.sweeps.longer import with_values
from studies.sweeps.reading import SweepLimits
from studies.sweeps.sweep import Sweep
from tests.samples import needs

RANGE = {"start": "2 km/s", "stop": "7 km/s", "step": "1 km/s"}
DOCUMENT: dict[str, Any] = {
    "name": "holes",
    "scenario": "thin_plate",
    "fixed": {
        "projectile": "copper-ofhc",
        "target": "copper-ofhc",
        "projectile_diameter": "8 mm",
        "target.strength.A": "100 MPa",
    },
    "axes": {"speed": RANGE, "plate_thickness": ["2 mm", "3 mm", "4 mm"]},
    "resolution": 32,
}
THICK = {"fixed": {**DOCUMENT["fixed"], "plate_thickness": "2 mm"}}
OF_ROLE = {"fixed": {"projectile": "copper-ofhc", "projectile_diameter": "8 mm", "plate_thickness": "2 mm"}}


# A path in the document, the value that is a mistake there, and what the error says.
MISTAKES: list[tuple[str, Any, list[str]]] = [
    ("scenario", "thin_plates", ["scenario", "did you mean 'thin_plate'"]),
    ("scenario", None, ["scenario", "use one of: "]),
    ("axis", {}, ["axis", "did you mean 'axes'"]),
    ("name", "", ["name"]),
    ("combine", "grids", ["combine", "did you mean 'grid'"]),
    ("resolution", "32 mm", ["resolution", "plain number"]),
    ("resolution", -1, ["resolution", "2 to 512"]),
    ("resolution", [16, 32, 16.0], ["resolution", "16", "once"]),
    ("resolution", [16, 1], ["resolution[1]", "2 to 512"]),
    ("resolution", {"start": 16, "stop": 64}, ["resolution.step"]),
    ("offsets", 0, ["offsets", "from 1 to 32", "write 3"]),
    ("offsets", 1.5, ["offsets", "whole number"]),
    ("accuracy", "fine", ["accuracy", "resolution", "give one of the two"]),
    ("fixed/target", "copper-ohfc", ["fixed.target", "did you mean 'copper-ofhc'"]),
    ("fixed/projectile_shape", "spere", ["fixed.projectile_shape", "sphere"]),
    ("fixed/thermal_softening", "yes", ["fixed.thermal_softening", "true or false"]),
    ("fixed/particles_per_cell", 1.5, ["fixed.particles_per_cell", "whole number"]),
    ("fixed/projectile_diameter", 8, ["fixed.projectile_diameter", "; write '8 mm'"]),
    ("fixed/projectile_diameter", "8 kg", ["fixed.projectile_diameter", "length"]),
    ("fixed/projectile_diameter", "-8 mm", ["from 10 um to 1 m", "nearest allowed"]),
    ("fixed/target.strength.a", "1 MPa", ["did you mean 'target.strength.A'"]),
    ("fixed/target.strength.A", "1 mm", ["fixed.target.strength.A", "pressure"]),
    ("fixed/speed", "6 km/s", ["axes.speed", "fixed or varied"]),
    ("fixed/cells_per_diameter", 8, ["resolution", "give one of the two"]),
    ("axes", {}, ["axes", "at least one"]),
    ("axes/speed", [], ["axes.speed", "at least one value"]),
    ("axes/speed", [6, "7 km/s"], ["axes.speed[0]", "write '6 km/s'"]),
    ("axes/speed", ["6 km/s", "2 kg"], ["axes.speed[1]", "speed"]),
    ("axes/speed", ["6 km/s", "6000 m/s"], ["axes.speed", "6 km/s", "once"]),
    ("axes/sped", ["6 km/s"], ["axes.sped", "did you mean 'speed'"]),
    ("axes/resolution", [8, 16], ["axes.resolution", "cells_per_diameter"]),
    ("axes/speed", {"start": "2 km/s"}, ["axes.speed.stop", "axes.speed.step"]),
    ("axes/speed", {"start": "2 km/s", "stop": "7 km/s", "stp": 1}, ["axes.speed.stp", "did you mean"]),
    ("axes/speed", {**RANGE, "step": "2 km/s"}, ["axes.speed.stop", "stop: 6 km/s or stop: 8 km/s"]),
    ("axes/speed", {**RANGE, "step": "-1 km/s"}, ["axes.speed.step", "leads from start to stop"]),
    ("axes/speed", {"start": "2 km/s", "stop": "90 km/s", "step": "1 km/s"}, ["axes.speed.stop", "20 km/s"]),
    ("axes/speed", {"start": "2 km/s", "stop": "7 km/s", "step": "1e-9 km/s"}, ["axes.speed", "at most 1000 values"]),
    ("materials", {"copper-ofhc": {}}, ["materials.copper-ofhc", "no shipped material"]),
    ("materials", {1: {}}, ["materials: 1 is refused", "names that are texts", "in quotes: '1'"]),
    ("materials", {"mine": {}}, ["materials.mine: nothing for density", "eos"]),
    ("observations", [{"speed": 6}], ["observations[0]: speed"]),
]


def changed(path: str, value: Any, of: Mapping[str, Any] = DOCUMENT) -> dict[str, Any]:
    """The document, or another one, with one place set, or taken away by ``...``; a path is keys between slashes."""
    document = copy.deepcopy(dict(of))
    *parents, last = path.split("/")
    place = document
    for parent in parents:
        place = place[parent]
    place[last] = value
    if value is ...:
        del place[last]
    return document


def refused(document: Any, limits: SweepLimits | None = None) -> str:
    with pytest.raises(InvalidInput) as caught:
        Sweep.parse(document, limits)
    for finding in caught.value.findings:
        assert all((finding.field, finding.value, finding.limit, finding.cure))
    return str(caught.value)


def test_parse__gives_exact_values_in_si_with_the_stop() -> None:
    sweep = Sweep.parse(DOCUMENT)
    speed, thickness = sweep.axes
    assert speed.values == (2000.0, 3000.0, 4000.0, 5000.0, 6000.0, 7000.0)
    assert (speed.unit, thickness.values) == ("m s-1", (0.002, 0.003, 0.004))
    assert (sweep.grid.shape, sweep.size, sweep.combine) == ((6, 3), 18, "grid")
    assert sweep.fixed["target.strength.A"] == 100e6


@given(st.integers(10, 400), st.integers(1, 40), st.integers(0, 30))
def test_range__equals_the_list_written_out(start: int, step: int, count: int) -> None:
    parameter = declared(scenarios.load("thin_plate").parameters)["plate_thickness"]
    stop = f"{start + step * count} um"
    by_step = {"start": f"{start}e-3 mm", "stop": stop, "step": f"{step}e-6 m"}
    by_list = [f"{start + step * number} um" for number in range(count + 1)]
    reader = AxisReader(most_values=100, materials=())
    first, second = (reader.read(parameter, "t", form, "t") for form in (by_step, by_list))
    assert first == second


def test_document__is_one_for_every_spelling() -> None:
    spelled = changed("axes/plate_thickness", ["0.002 m", "3.0e-3 m", "4000 um"])
    assert Sweep.parse(spelled).document() == Sweep.parse(DOCUMENT).document()


def test_document__keeps_materials_and_observations() -> None:
    document = changed("observations", "speed [km/s],quantity,value,source\n6,hole_diameter,19 mm,x")
    copper = materials.load("copper-ofhc").document()
    document["materials"] = {"my-copper": {**copper, "name": "my-copper"}}
    document["fixed"]["target"] = "my-copper"
    sweep = Sweep.parse(document)
    again = Sweep.parse(json.loads(json.dumps(sweep.document())))
    assert again == sweep
    assert again.observations[0].value == 0.019


def test_runs__of_a_grid_vary_the_last_axis_fastest() -> None:
    points = Sweep.parse(DOCUMENT).runs()
    assert points[1].index == (0, 1)
    assert points[1].coordinates == {"speed": 2000.0, "plate_thickness": 0.003}
    run = points[0].run
    assert run.parameters["cells_per_diameter"] == 32.0
    assert tuple(run.materials[role].value_at("strength.A") for role in ("target", "projectile")) == (100e6, 90e6)


def test_runs__of_a_zip_pair_the_axes() -> None:
    document = {**changed("axes/speed", ["2 km/s", "4 km/s", "2 km/s"]), "combine": "zip"}
    assert [point.index for point in Sweep.parse(document).runs()] == [(0,), (1,), (2,)]
    refined = Sweep.parse({**document, "resolution": [16, 32]})
    assert refined.grid.shape == (3, 2)
    assert [point.index for point in refined.runs()][:3] == [(0, 0), (0, 1), (1, 0)]


def test_runs__name_the_points_that_are_refused() -> None:
    document = changed("axes/plate_thickness", ["2 mm", "0.2 mm"])
    with pytest.raises(InvalidInput, match=r"plate_thickness = (0\.2 mm|200 um)") as caught:
        Sweep.parse({**document, "resolution": [16, 32]}).runs()
    [finding] = caught.value.findings
    assert "cells_per_diameter = 16" in finding.value


@pytest.mark.parametrize(("path", "value", "parts"), MISTAKES)
def test_parse__names_field_value_limit_and_cure(path: str, value: Any, parts: list[str]) -> None:
    message = refused(changed(path, value))
    assert all(word in message for word in parts), message


@pytest.mark.parametrize("document", [None, 3, [], "sweep", {}, {1: 2}, {"scenario": "thin_plate"}])
def test_parse__of_no_sweep_is_refused(document: Any) -> None:
    refused(document)


def test_parse__of_a_zip_asks_for_equal_lengths_and_new_points() -> None:
    assert "speed: 6, plate_thickness: 3" in refused(changed("combine", "zip"))
    twice = {"speed": ["6 km/s"] * 2, "plate_thickness": ["2 mm"] * 2}
    assert "once" in refused({**DOCUMENT, "combine": "zip", "axes": twice})


def test_limits__are_counted_before_anything_is_expanded() -> None:
    axes = {
        "plate_thickness": {"start": "1 mm", "stop": "1000 mm", "step": "1 mm"},
        "speed": {"start": "1 km/s", "stop": "19 km/s", "step": "0.1 km/s"},
        "particles_per_cell": {"start": 1, "stop": 4, "step": 1},
    }
    document = changed("axes", axes)
    assert "724000 runs" in refused(document)
    assert "at most 2 axes" in refused(document, SweepLimits(max_axes=2))
    assert "at most 5 values" in refused(DOCUMENT, SweepLimits(max_values=5))
    assert "at most 17 runs" in refused(DOCUMENT, SweepLimits(max_runs=17))
    assert Sweep.parse(DOCUMENT, SweepLimits(max_runs=18)).size == 18


def test_limits__refuse_a_run_of_too_many_particles_at_its_point() -> None:
    most = max(estimate(point.run).particles for point in Sweep.parse(DOCUMENT).runs())
    assert len(Sweep.parse(DOCUMENT, SweepLimits(max_particles=most)).runs()) == 18
    with pytest.raises(InvalidInput) as caught:
        Sweep.parse(DOCUMENT, SweepLimits(max_particles=most - 1)).runs()
    assert "plate_thickness = 4 mm" in str(caught.value)
    assert f"at most {most - 1}" in str(caught.value)


# --- resolutions and offsets ------------------------------------------------------------------------


def refined(**changes: Any) -> dict[str, Any]:
    document = copy.deepcopy(DOCUMENT) | changes
    return {key: value for key, value in document.items() if value is not None}


def test_refinement__computes_each_point_at_each_resolution_and_offset() -> None:
    sweep = Sweep.parse(refined(resolution=[16, 32, 64], offsets=3))
    points = sweep.runs()
    assert (sweep.grid.shape, sweep.size, len(points)) == ((6, 3, 3, 3), 162, 162)
    assert points[10].index == (0, 1, 0, 1)
    refined_by = {"cells_per_diameter": 16.0, "offset": 0.333333333333}
    assert points[10].coordinates == {"speed": 2000.0, "plate_thickness": 0.003, **refined_by}
    assert refined_by.items() <= points[10].run.parameters.items()


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"resolution": [64, 16, 32]},
        {"offsets": 4},
        {"resolution": [16, 32], "offsets": 2},
        {"resolution": {"start": 8, "stop": 32, "step": 8}},
        {"resolution": None, "accuracy": "fine"},
    ],
)
def test_document__is_canonical_and_reads_as_itself(changes: dict[str, Any]) -> None:
    sweep = Sweep.parse(refined(**changes))
    document = json.loads(json.dumps(sweep.document()))
    assert Sweep.parse(document) == sweep
    assert Sweep.parse(document).document() == document
    assert list(sweep.resolutions) == sorted(sweep.resolutions)


@pytest.mark.parametrize(
    "text", ["a: [1", "- 1", "", "a: !!python/object/apply:os.getcwd []", "[" * 5000, "\x00", "a: 1\na: 2"]
)
def test_read_yaml__of_broken_text_names_the_file(text: str) -> None:
    with pytest.raises(InvalidInput, match=r"sweep\.yaml" + (".*'a' occurs twice" if "a: 2" in text else "")):
        read_yaml(text, "sweep.yaml")


def test_read_sweep_file__takes_observations_from_beside_it(tmp_path: Path) -> None:
    (tmp_path / "shots.csv").write_text("quantity,value,source\nhole_diameter,19 mm,x\n")
    file = tmp_path / "sweep.yaml"
    file.write_text(json.dumps({**DOCUMENT, "observations": "shots.csv"}))
    assert Sweep.parse(read_sweep_file(file)).observations[0].value == 0.019
    with pytest.raises(InvalidInput, match=r"none\.yaml"):
        read_sweep_file(tmp_path / "none.yaml")


@pytest.mark.parametrize("example", examples.names())
def test_example__makes_runs(example: str) -> None:
    sweep = Sweep.parse(read_yaml(examples.text(example), example))
    assert sweep.name == example
    assert len(sweep.runs()) == sweep.size
    assert Sweep.parse(sweep.document()) == sweep


@pytest.mark.parametrize(
    ("example", "kinds"), [("holes", 1), ("craters", 1), pytest.param("taylor", 2, marks=needs("taylor_bar"))]
)
def test_kinds_of_kernels__are_those_of_geometry_choices_and_laws(example: str, kinds: int) -> None:
    sweep = Sweep.parse(read_yaml(examples.text(example), example))
    assert len(kinds_of(point.run for point in sweep.runs())) == kinds


@pytest.mark.parametrize(
    ("field", "value"),
    [
        *(("name", text) for text in ("a\x1b[2Jb", "two\nlines")),
        ("title", "left\u202eright"),
        ("materials", {"mine": {"title": "\x9b31m"}}),
    ],
)
def test_control_characters__are_refused(field: str, value: Any) -> None:
    with pytest.raises(InvalidInput) as refused:
        Sweep.parse({**DOCUMENT, field: value})
    assert next(each for each in refused.value.findings if each.field == field).value.isprintable()


@pytest.mark.parametrize(
    "changes",
    [
        {"resolution": [16, 32], "offsets": 3},
        {"combine": "zip", "axes": {"speed": ["3 km/s", "4 km/s"], "plate_thickness": ["2 mm", "3 mm"]}},
        {"combine": "sobol", "points": 4, "seed": 1, "axes": {"speed": {"low": "3 km/s", "high": "4 km/s"}}, **THICK},
        {"ends": [{"speed": "7 km/s", "plate_thickness": "4 mm", "end_time": "9 us"}]},
        {"axes": {"speed": ["3 km/s"], "target": ["al-6061-t6", "copper-ofhc"]}, **OF_ROLE},
    ],
)
def test_of_point__is_the_same_run_and_nothing_beside_it(changes: dict[str, Any]) -> None:
    sweep = Sweep.parse(refined(**changes))
    last = sweep.runs()[-1]
    alone = Sweep.parse(json.loads(json.dumps(sweep.of_point(last.coordinates).document())))
    assert [point.run.id for point in alone.every_run()] == [last.run.id]


def test_with_values__keeps_the_order_of_values_that_ascend() -> None:
    sweep = Sweep.parse(refined(resolution=[16, 32]))
    assert with_values(sweep, "speed", ["4500 m/s"]).axes[0].values[2:5] == (4000.0, 4500.0, 5000.0)
    assert with_values(sweep, "cells_per_diameter", [24]).resolutions == (16.0, 24.0, 32.0)
    falling = Sweep.parse(refined(axes={"speed": ["4 km/s", "3 km/s"]}, **THICK))
    assert with_values(falling, "speed", ["3.5 km/s"]).axes[0].values == (4000.0, 3000.0, 3500.0)
    with pytest.raises(InvalidInput, match="an axis with values of its own"):
        with_values(sweep, "target", ["lead"])
    with pytest.raises(InvalidInput, match="speed"):
        with_values(sweep, "speed", ["3 km/s"])  # twice
