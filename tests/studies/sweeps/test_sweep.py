"""Sweep documents: checked in one go, canonical, counted before they are expanded."""

import contextlib
import copy
import dataclasses
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.units import Described, Dimensionless, Metre, MetrePerSecond
from studies import materials
from studies.quantities.findings import Finding, InvalidInput, nearest_cure, refusal
from studies.quantities.parameters import MaterialName, declared
from studies.scenarios import Size
from studies.sweeps import examples
from studies.sweeps.accuracy import ACCURACY
from studies.sweeps.axes import AxisReader
from studies.sweeps.document import read_sweep_file, read_yaml
from studies.sweeps.reading import ACCEPTED, SweepLimits
from studies.sweeps.sweep import Sweep


@dataclass(frozen=True, kw_only=True)
class PlateParameters:
    """A small thin plate, so that these tests do not move when the real one does."""

    speed: Annotated[MetrePerSecond, Described("", minimum=100.0, maximum=20e3)]
    plate_thickness: Annotated[Metre, Described("", minimum=1e-5, maximum=1.0)]
    projectile_diameter: Annotated[Metre, Described("", minimum=1e-5, maximum=1.0)]
    projectile: MaterialName
    target: MaterialName
    shape: Literal["sphere", "cylinder"] = "sphere"
    cells_per_diameter: Annotated[Dimensionless, Described("", minimum=2.0, maximum=512.0)]
    offset: Annotated[Dimensionless, Described("", minimum=0.0, maximum=1.0)] = 0.0
    fixed_dt: Metre | None = None
    threads: Annotated[int, Described("", minimum=1, maximum=64)] = 1
    heating: bool = True

    def size(self, _materials: object) -> Size:
        """A cube as thick as the plate, with a particle in each cell."""
        cells = self.plate_thickness / self.projectile_diameter * self.cells_per_diameter
        return Size(particles=round(cells**3), steps=1)


PLATE = SimpleNamespace(
    name="plate",
    parameters=PlateParameters,
    materials=("projectile", "target"),
    measurements=("hole_diameter",),
    record=lambda values: PlateParameters(**values),
)


def load(name: str) -> Any:
    if name != "plate":
        raise refusal("scenario", name, "a scenario", nearest_cure(name, ["plate"]))
    return PLATE


def resolve(scenario: str, parameters: Mapping[str, Any], given: Mapping[str, Any]) -> Any:
    if parameters["plate_thickness"] > 10 * parameters["projectile_diameter"]:
        raise InvalidInput([Finding("plate_thickness", "thick", "ten diameters", "use a block")])
    resolved = {role: material.resolved() for role, material in given.items()}
    return SimpleNamespace(scenario=scenario, parameters=parameters, materials=resolved)


@pytest.fixture(autouse=True)
def plate(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> None:
    """The small plate stands in for all scenarios, but where the shipped examples are read."""
    if "example" not in request.fixturenames:
        monkeypatch.setattr("studies.scenarios.load", load)
        monkeypatch.setattr("studies.scenarios.names", lambda: ["plate"])
        monkeypatch.setattr("studies.runs.run.resolve", resolve)


DOCUMENT: dict[str, Any] = {
    "name": "holes",
    "scenario": "plate",
    "fixed": {
        "projectile": "copper-ofhc",
        "target": "copper-ofhc",
        "projectile_diameter": "8 mm",
        "target.strength.A": "100 MPa",
    },
    "axes": {
        "speed": {"start": "2 km/s", "stop": "7 km/s", "step": "1 km/s"},
        "plate_thickness": ["2 mm", "3 mm", "4 mm"],
    },
    "resolution": 32,
}


def changed(path: str, value: Any) -> dict[str, Any]:
    """The document with one place set; a path is keys between slashes."""
    document = copy.deepcopy(DOCUMENT)
    *parents, last = path.split("/")
    place = document
    for parent in parents:
        place = place[parent]
    place[last] = value
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
    assert (sweep.shape, sweep.size, sweep.combine) == ((6, 3), 18, "grid")
    assert sweep.fixed["target.strength.A"] == 100e6


@pytest.mark.parametrize(
    ("name", "values", "expected"),
    [
        ("plate_thickness", ("0.1 mm", "0.4 mm", "0.1 mm"), (1e-4, 2e-4, 3e-4, 4e-4)),
        ("speed", ("7 km/s", "5 km/s", "-1 km/s"), (7e3, 6e3, 5e3)),
        ("threads", (1, 5, 2), (1, 3, 5)),
    ],
    ids=["tenths", "downwards", "whole numbers"],
)
def test_range__is_exact(name: str, values: tuple[Any, ...], expected: tuple[float, ...]) -> None:
    steps = dict(zip(("start", "stop", "step"), values, strict=True))
    axes = {axis.name: axis for axis in Sweep.parse(changed(f"axes/{name}", steps)).axes}
    assert axes[name].values == expected


@given(st.integers(10, 400), st.integers(1, 40), st.integers(0, 30))
def test_range__equals_the_list_written_out(start: int, step: int, count: int) -> None:
    parameter = declared(PlateParameters)["plate_thickness"]
    stop = f"{start + step * count} um"
    by_step = {"start": f"{start}e-3 mm", "stop": stop, "step": f"{step}e-6 m"}
    by_list = [f"{start + step * number} um" for number in range(count + 1)]
    reader = AxisReader(most_values=100, materials=())
    first, second = (reader.read(parameter, "t", form, "t") for form in (by_step, by_list))
    assert first == second


def test_document__is_canonical_and_reads_as_itself() -> None:
    sweep = Sweep.parse(DOCUMENT)
    document = json.loads(json.dumps(sweep.document()))
    assert Sweep.parse(document) == sweep
    assert Sweep.parse(document).document() == document
    assert document["axes"]["plate_thickness"] == ["2 mm", "3 mm", "4 mm"]
    assert Sweep.parse(changed("axes/plate_thickness", ["0.002 m", "3.0e-3 m", "4000 um"])).document() == document


def test_document__keeps_materials_and_observations() -> None:
    document = changed("observations", "speed [km/s],quantity,value,source\n6,hole_diameter,19 mm,x")
    copper = materials.load("copper-ofhc").document()
    document["materials"] = {"my-copper": {**copper, "name": "my-copper"}}
    document["fixed"]["target"] = "my-copper"
    sweep = Sweep.parse(document)
    again = Sweep.parse(json.loads(json.dumps(sweep.document())))
    assert again == sweep
    assert again.observations[0].value == 0.019


def test_constant__that_two_materials_measure_differently_is_one_of_neither() -> None:
    """Johnson and Cook's A is a stress, Steinberg and Guinan's a rise with pressure."""
    constants = {
        "Y0": (120, "MPa"),
        "Y_max": (640, "MPa"),
        "beta": (36, "1"),
        "n": (0.45, "1"),
        "A": (28.3, "1/TPa"),
        "B": (3.77e-4, "1/K"),
        "a": (1.5, "1"),
        "gamma0": (2.02, "1"),
    }
    sourced = {"source": "Steinberg (1996), UCRL-MA-106439", "confidence": "verified"}
    strength = {name: {"value": value, "unit": unit, **sourced} for name, (value, unit) in constants.items()}
    copper = materials.load("copper-ofhc").document()
    pressed = {**copper, "name": "pressed", "strength": {"kind": "steinberg-guinan", **strength}}
    document = changed("axes/target", ["copper-ofhc", "pressed"])
    document["materials"] = {"pressed": pressed}
    del document["fixed"]["target"]
    assert "target.strength.A" in refused(document)
    document["axes"]["target"] = ["pressed"]
    document["fixed"]["target.strength.A"] = "30 1/TPa"
    assert Sweep.parse(document).fixed["target.strength.A"] == 30e-12


def test_runs__of_a_grid_vary_the_last_axis_fastest() -> None:
    points = Sweep.parse(DOCUMENT).runs()
    assert len(points) == 18
    assert points[1].index == (0, 1)
    assert points[1].coordinates == {"speed": 2000.0, "plate_thickness": 0.003}
    run = points[0].run
    assert run.parameters["cells_per_diameter"] == 32.0
    assert (run.materials["target"]["strength"]["A"], run.materials["projectile"]["strength"]["A"]) == (100e6, 90e6)


def test_runs__of_a_zip_pair_the_axes() -> None:
    document = changed("axes/speed", ["2 km/s", "4 km/s", "2 km/s"])
    document["combine"] = "zip"
    sweep = Sweep.parse(document)
    assert sweep.shape == (3,)
    assert [point.index for point in sweep.runs()] == [(0,), (1,), (2,)]
    refined = Sweep.parse({**document, "resolution": [16, 32]})
    assert refined.shape == (3, 2)
    assert [point.index for point in refined.runs()][:3] == [(0, 0), (0, 1), (1, 0)]


def test_runs__over_materials_and_their_constants() -> None:
    document = changed("axes/target", ["copper-ofhc", "al-2024-t3"])
    document["axes"]["target.strength.A"] = ["80 MPa", "90 MPa"]
    del document["fixed"]["target"], document["fixed"]["target.strength.A"]
    points = Sweep.parse(document).runs()
    targets = [point.run.materials["target"] for point in points]
    assert {target["name"] for target in targets} == {"copper-ofhc", "al-2024-t3"}
    assert {target["strength"]["A"] for target in targets} == {80e6, 90e6}


def test_runs__name_the_points_that_are_refused() -> None:
    document = changed("axes/plate_thickness", ["2 mm", "90 mm"])
    with pytest.raises(InvalidInput, match="plate_thickness = 90 mm") as caught:
        Sweep.parse({**document, "resolution": [16, 32]}).runs()
    [finding] = caught.value.findings
    assert "cells_per_diameter = 16" in finding.value


@pytest.mark.parametrize(
    ("path", "value", "parts"),
    [
        ("scenario", "plates", ["scenario", "did you mean 'plate'"]),
        ("scenario", None, ["scenario", "use one of: plate"]),
        ("scenario", ["plate"], ["scenario"]),
        ("axis", {}, ["axis", "did you mean 'axes'"]),
        ("name", "", ["name"]),
        ("name", 3, ["name"]),
        ("combine", "grids", ["combine", "did you mean 'grid'"]),
        ("combine", ["grid"], ["combine"]),
        ("resolution", "32 mm", ["resolution", "plain number"]),
        ("resolution", -1, ["resolution", "2 to 512"]),
        ("resolution", True, ["resolution"]),
        ("resolution", float("nan"), ["resolution", "finite"]),
        ("resolution", None, ["resolution", "nothing"]),
        ("resolution", [], ["resolution", "at least one"]),
        ("resolution", [16, 32, 16.0], ["resolution", "16", "once"]),
        ("resolution", [16, "fine"], ["resolution[1]", "plain number"]),
        ("resolution", [16, 1], ["resolution[1]", "2 to 512"]),
        ("resolution", [16, None], ["resolution[1]", "null"]),
        ("resolution", {"start": 16, "stop": 64}, ["resolution.step"]),
        ("offsets", 0, ["offsets", "from 1 to 32", "write 3"]),
        ("offsets", 33, ["offsets", "from 1 to 32"]),
        ("offsets", 1.5, ["offsets", "whole number"]),
        ("offsets", [0, 0.5], ["offsets", "plain number"]),
        ("offsets", True, ["offsets", "plain number"]),
        ("accuracy", "fine", ["accuracy", "resolution", "give one of the two"]),
        ("fixed", 3, ["fixed"]),
        ("fixed/target", "copper-ohfc", ["fixed.target", "did you mean 'copper-ofhc'"]),
        ("fixed/target", 3, ["fixed.target"]),
        ("fixed/shape", "spere", ["fixed.shape", "sphere"]),
        ("fixed/heating", "yes", ["fixed.heating", "true or false"]),
        ("fixed/threads", 1.5, ["fixed.threads", "whole number"]),
        ("fixed/projectile_diameter", 8, ["fixed.projectile_diameter", "; write '8 mm'"]),
        ("fixed/projectile_diameter", "8 kg", ["fixed.projectile_diameter", "length"]),
        ("fixed/projectile_diameter", "-8 mm", ["from 10 um to 1 m", "nearest allowed"]),
        ("fixed/projectile_diameter", "nan mm", ["fixed.projectile_diameter"]),
        ("fixed/projectile_diameter", None, ["fixed.projectile_diameter", "null"]),
        ("fixed/target.strength.a", "1 MPa", ["did you mean 'target.strength.A'"]),
        ("fixed/target.strength.A", "1 mm", ["fixed.target.strength.A", "pressure"]),
        ("fixed/speed", "6 km/s", ["axes.speed", "fixed or varied"]),
        ("fixed/cells_per_diameter", 8, ["resolution", "give one of the two"]),
        ("axes", {}, ["axes", "at least one"]),
        ("axes", None, ["axes", "at least one"]),
        ("axes", [1], ["axes", "names and values"]),
        ("axes/speed", [], ["axes.speed", "at least one value"]),
        ("axes/speed", "6 km/s", ["axes.speed", "list"]),
        ("axes/speed", [6, "7 km/s"], ["axes.speed[0]", "write '6 km/s'"]),
        ("axes/speed", ["6 km/s", None], ["axes.speed[1]", "null"]),
        ("axes/speed", ["6 km/s", "2 kg"], ["axes.speed[1]", "speed"]),
        ("axes/speed", ["6 km/s", "6000 m/s"], ["axes.speed", "6 km/s", "once"]),
        ("axes/sped", ["6 km/s"], ["axes.sped", "did you mean 'speed'"]),
        ("axes/resolution", [8, 16], ["axes.resolution", "cells_per_diameter"]),
        ("axes/fixed_dt", [None], ["axes.fixed_dt[0]"]),
        ("axes/shape", {"start": "a"}, ["axes.shape", "list of values"]),
        ("axes/projectile", {"start": "a"}, ["axes.projectile", "fixed or varied"]),
        ("axes/speed", {"start": "2 km/s"}, ["axes.speed.stop", "axes.speed.step"]),
        ("axes/speed", {"start": "2 km/s", "stop": "7 km/s", "stp": 1}, ["axes.speed.stp", "did you mean"]),
        (
            "axes/speed",
            {"start": "2 km/s", "stop": "7 km/s", "step": "2 km/s"},
            ["axes.speed.stop", "stop: 6 km/s or stop: 8 km/s"],
        ),
        (
            "axes/speed",
            {"start": "2 km/s", "stop": "7 km/s", "step": "-1 km/s"},
            ["axes.speed.step", "leads from start to stop"],
        ),
        ("axes/speed", {"start": "2 km/s", "stop": "7 km/s", "step": "0 km/s"}, ["axes.speed.step"]),
        ("axes/speed", {"start": "2 km/s", "stop": "90 km/s", "step": "1 km/s"}, ["axes.speed.stop", "20 km/s"]),
        (
            "axes/speed",
            {"start": "2 km/s", "stop": "7 km/s", "step": "1e-9 km/s"},
            ["axes.speed", "at most 1000 values"],
        ),
        ("materials", 3, ["materials"]),
        ("materials", {"copper-ofhc": {}}, ["materials.copper-ofhc", "no shipped material"]),
        ("materials", {"mine": {}}, ["materials.mine: nothing for density", "eos"]),
        ("materials", {"mine": 3}, ["materials.mine"]),
        ("observations", 3, ["observations"]),
        ("observations", [{"speed": 6}], ["observations[0]: speed"]),
    ],
)
def test_parse__names_field_value_limit_and_cure(path: str, value: Any, parts: list[str]) -> None:
    message = refused(changed(path, value))
    assert all(word in message for word in parts), message


def test_parse__refuses_a_material_once_and_not_its_name_again() -> None:
    document = changed("materials", {"mine": {"base": "steel-4340", "strength": {"A": 900}}})
    document["fixed"] = {**document["fixed"], "target": "mine"}
    with pytest.raises(InvalidInput) as caught:
        Sweep.parse(document)
    assert [finding.field for finding in caught.value.findings] == ["materials.mine.strength.A"]


@pytest.mark.parametrize("document", [None, 3, [], "sweep", {}, {1: 2}, {"scenario": "plate"}])
def test_parse__of_no_sweep_is_refused(document: Any) -> None:
    refused(document)


def test_parse__tells_everything_at_once() -> None:
    document = changed("fixed/target", "copper-ohfc")
    document["fixed"]["shap"] = "sphere"
    document["axes"]["speed"] = [6]
    document["combine"] = "product"
    document["resolution"] = "fine"
    message = refused(document)
    assert all(field in message for field in ("fixed.target", "fixed.shap", "axes.speed[0]", "combine", "resolution"))


PLACES = ["fixed", "axes", "axes/speed", "axes/speed/start", "fixed/target", "fixed/shape"]
PLACES += ["fixed/target.strength.A", "fixed/threads", "materials", "observations", "resolution"]
PLACES += ["offsets", "accuracy"]
ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda some: st.lists(some, max_size=3) | st.dictionaries(st.text(max_size=8), some, max_size=3),
    max_leaves=6,
)


@given(st.sampled_from(PLACES), ANYTHING)
def test_parse__of_anything_anywhere_refuses_and_never_crashes(path: str, value: Any) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("studies.scenarios.load", load)
        patch.setattr("studies.scenarios.names", lambda: ["plate"])
        with contextlib.suppress(InvalidInput):
            Sweep.parse(changed(path, value))


def test_parse__of_a_misspelt_required_parameter_refuses_it_once() -> None:
    document = changed("axes/velocity", ["6 km/s"])
    del document["axes"]["speed"]
    with pytest.raises(InvalidInput) as caught:
        Sweep.parse(document)
    assert [finding.field for finding in caught.value.findings] == ["axes.velocity"]


def test_parse__names_every_missing_parameter() -> None:
    document = changed("fixed", {})
    document["axes"] = {"speed": ["6 km/s"]}
    message = refused(document)
    for name in ("plate_thickness", "projectile_diameter", "projectile", "target"):
        assert f"fixed.{name}: nothing" in message


def test_parse__of_a_zip_asks_for_equal_lengths_and_new_points() -> None:
    document = changed("combine", "zip")
    assert "speed: 6, plate_thickness: 3" in refused(document)
    document["axes"] = {"speed": ["6 km/s"] * 2, "plate_thickness": ["2 mm"] * 2}
    assert "once" in refused(document)


def test_limits__are_counted_before_anything_is_expanded() -> None:
    wide = {"start": "1 mm", "stop": "1000 mm", "step": "1 mm"}
    document = changed("axes/plate_thickness", wide)
    document["axes"]["speed"] = {"start": "1 km/s", "stop": "19 km/s", "step": "0.1 km/s"}
    document["axes"]["threads"] = {"start": 1, "stop": 64, "step": 1}
    assert "11584000 runs" in refused(document)
    assert "at most 2 axes" in refused(document, SweepLimits(max_axes=2))
    assert "at most 5 values" in refused(DOCUMENT, SweepLimits(max_values=5))
    assert "at most 17 runs" in refused(DOCUMENT, SweepLimits(max_runs=17))
    assert Sweep.parse(DOCUMENT, SweepLimits(max_runs=18)).size == 18


def test_limits__refuse_a_run_of_too_many_particles_at_its_point() -> None:
    most = 16**3  # the plate of 4 mm at 32 cells across 8 mm
    assert len(Sweep.parse(DOCUMENT, SweepLimits(max_particles=most)).runs()) == 18
    with pytest.raises(InvalidInput) as caught:
        Sweep.parse(DOCUMENT, SweepLimits(max_particles=most - 1)).runs()
    (finding,) = caught.value.findings
    assert "4.1e+03" in finding.value
    assert "plate_thickness = 4 mm" in finding.value
    assert "at most 4095" in finding.limit
    assert "fewer cells" in finding.cure


def test_limits__on_particles_hold_at_every_accuracy_and_are_no_part_of_the_question() -> None:
    few, many = (Sweep.parse(refined(resolution=32), SweepLimits(max_particles=most)) for most in (10, 10**9))
    assert few == many
    assert few.document() == many.document()
    free = Sweep.parse(refined(resolution=None, accuracy="draft"), SweepLimits(max_particles=10))
    with pytest.raises(InvalidInput, match="particles"):
        free.at_accuracy("fine").runs()


def test_accepted__lets_in_again_whatever_a_door_has_let_in() -> None:
    document = changed("axes/plate_thickness", ["80 mm"])
    document["resolution"] = 512
    with pytest.raises(InvalidInput, match="particles"):
        Sweep.parse(document).runs()
    assert len(Sweep.parse(document, ACCEPTED).runs()) == 6


# --- resolutions and offsets ------------------------------------------------------------------------


def refined(**changes: Any) -> dict[str, Any]:
    document = copy.deepcopy(DOCUMENT) | changes
    return {key: value for key, value in document.items() if value is not None}


def test_refinement__computes_each_point_at_each_resolution_and_offset() -> None:
    sweep = Sweep.parse(refined(resolution=[16, 32, 64], offsets=3))
    assert (sweep.shape, sweep.size) == ((6, 3, 3, 3), 162)
    points = sweep.runs()
    assert len(points) == 162
    assert points[10].index == (0, 1, 0, 1)
    assert points[10].coordinates == {
        "speed": 2000.0,
        "plate_thickness": 0.003,
        "cells_per_diameter": 16.0,
        "offset": 0.333333333333,
    }
    assert points[10].run.parameters["offset"] == 0.333333333333
    assert points[10].run.parameters["cells_per_diameter"] == 16.0


def test_refinement__of_one_resolution_and_one_offset_changes_no_run() -> None:
    plain, listed = Sweep.parse(DOCUMENT), Sweep.parse(refined(resolution=[32], offsets=1))
    assert plain == listed
    assert plain.refinements == ()
    assert [point.run.parameters for point in plain.runs()] == [point.run.parameters for point in listed.runs()]


@pytest.mark.parametrize(
    "changes",
    [
        {"resolution": [64, 16, 32]},
        {"offsets": 4},
        {"resolution": [16, 32], "offsets": 2},
        {"resolution": {"start": 8, "stop": 32, "step": 8}},
        {"resolution": None, "accuracy": "fine"},
    ],
)
def test_refinement__is_canonical_and_reads_as_itself(changes: dict[str, Any]) -> None:
    sweep = Sweep.parse(refined(**changes))
    document = json.loads(json.dumps(sweep.document()))
    assert Sweep.parse(document) == sweep
    assert Sweep.parse(document).document() == document
    assert list(sweep.resolutions) == sorted(sweep.resolutions)


@pytest.mark.parametrize("name", ACCURACY)
def test_accuracy__stands_for_resolutions_and_offsets(name: str) -> None:
    preset = ACCURACY[name]
    written_out = refined(resolution=list(preset.resolutions), offsets=preset.offsets)
    sweep = Sweep.parse(refined(resolution=None, accuracy=name))
    assert sweep == Sweep.parse(written_out)
    assert sweep == Sweep.parse(DOCUMENT).at_accuracy(name)


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        ({"accuracy": "fyne"}, ["accuracy", "did you mean 'fine'"]),
        ({"accuracy": 3}, ["accuracy", "one of draft"]),
        ({"accuracy": ["fine"]}, ["accuracy"]),
        ({"accuracy": "fine", "offsets": 2}, ["accuracy", "offsets", "one of the two"]),
    ],
)
def test_accuracy__that_is_wrong_is_refused(changes: dict[str, Any], parts: list[str]) -> None:
    message = refused(refined(resolution=None, **changes))
    assert all(word in message for word in parts), message
    assert "resolution: nothing" not in message  # the preset gives it, once it is a name


@pytest.mark.parametrize("part", ["fixed", "axes"])
@pytest.mark.parametrize(
    ("parameter", "changes", "key"),
    [
        ("cells_per_diameter", {"accuracy": "draft", "resolution": None}, "accuracy"),
        ("cells_per_diameter", {"resolution": [8, 16]}, "resolution"),
        ("offset", {"accuracy": "fine", "resolution": None}, "accuracy"),
        ("offset", {"offsets": 3}, "offsets"),
    ],
)
def test_refinement__of_what_is_given_elsewhere_is_refused(
    part: str, parameter: str, changes: dict[str, Any], key: str
) -> None:
    document = refined(**changes)
    document[part][parameter] = 0.5 if part == "fixed" else [0.5]
    message = refused(document)
    assert f"{key}: " in message
    assert f"{parameter} under {part}" in message


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        ({"offsets": 2}, ["offsets", "a scenario with offset"]),
        ({"accuracy": "fine"}, ["accuracy", "a scenario with offset"]),
        ({"accuracy": "draft"}, []),
    ],
)
def test_offsets__need_a_scenario_that_has_one(
    monkeypatch: pytest.MonkeyPatch, changes: dict[str, Any], parts: list[str]
) -> None:
    fields = [each for each in dataclasses.fields(PlateParameters) if each.name != "offset"]
    record = dataclasses.make_dataclass(
        "Still", [(each.name, each.type, each) for each in fields], frozen=True, kw_only=True
    )
    still = SimpleNamespace(**{**vars(PLATE), "parameters": record})
    monkeypatch.setattr("studies.scenarios.load", lambda name: still)
    document = refined(resolution=None if "accuracy" in changes else 32, **changes)
    if parts:
        message = refused(document)
        assert all(word in message for word in parts), message
        with pytest.raises(ValueError, match="fine"):
            Sweep.parse(DOCUMENT).at_accuracy("fine")
    else:
        assert Sweep.parse(document).resolutions == ACCURACY["draft"].resolutions


def test_limits__count_resolutions_and_offsets_before_anything_is_expanded() -> None:
    document = refined(resolution=[16, 32, 64], offsets=3)
    message = refused(document, SweepLimits(max_runs=161))
    assert "162 runs (18 points, each 9 times" in message
    assert Sweep.parse(document, SweepLimits(max_runs=162)).size == 162
    many = refined(resolution={"start": 2, "stop": 500, "step": 1}, offsets=32)
    assert "287424 runs" in refused(many)


def test_constant__must_belong_to_every_material_of_its_role() -> None:
    document = changed("axes/target", ["copper-ofhc", "copper-thesis-plastic"])
    del document["fixed"]["target"]
    assert "fixed.target.strength.A" in refused(document)


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
    ("changes", "field"),
    [
        ({"name": "a\x1b[2Jb"}, "name"),
        ({"name": "two\nlines"}, "name"),
        ({"title": "left\u202eright"}, "title"),
        ({"materials": {"mine": {"title": "\x9b31m"}}}, "materials"),
    ],
)
def test_control_characters__are_refused_at_the_door_and_stay_readable_behind_it(
    changes: dict[str, Any], field: str
) -> None:
    document = {**DOCUMENT, **changes}
    with pytest.raises(InvalidInput) as refused:
        Sweep.parse(document)
    finding = next(each for each in refused.value.findings if each.field == field)
    assert finding.value.isprintable()
    if field != "materials":
        assert getattr(Sweep.parse(document, ACCEPTED), field) == changes[field]
