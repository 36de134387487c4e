"""Residuals: their statistics by hand, their ranges, and how a shot off the grid is met."""

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from studies.cubes import cube
from studies.reports.compare import (
    NO_MESH,
    NOT_BOTH,
    ONLY_SIMULATION,
    Comparison,
    Residual,
    Statistics,
    compare,
    sentence,
    statistics,
)
from studies.reports.sightings import bring_to
from tests.studies.support import fakes


def holes(*shots: fakes.Observed, trouble: bool = False) -> xr.Dataset:
    sweep = fakes.holes()
    known = fakes.with_trouble(sweep) if trouble else fakes.results(sweep)
    return cube.build(sweep, known, fakes.catalogue(observations=shots))


def residual(comparison: Comparison, subject: str, reference: str = "simulation") -> Residual:
    (found,) = [
        one for one in comparison.residuals if one.subject == subject and one.reference == reference
    ]
    return found


def test_statistics__are_those_of_subject_minus_reference() -> None:
    places = [{"speed": speed} for speed in (1.0, 2.0, 3.0)]
    found = statistics(np.array([1.0, 2.0, 9.0]), np.array([2.0, 4.0, 6.0]), places)
    assert found.n == 3
    assert found.bias == 0.0
    assert found.rms == pytest.approx(math.sqrt((1 + 4 + 9) / 3))
    assert found.largest is not None
    assert (found.largest.value, found.largest.at) == (3.0, {"speed": 3.0})
    assert found.relative_bias == pytest.approx((-0.5 - 0.5 + 0.5) / 3)


def test_statistics__the_largest_keeps_its_sign() -> None:
    found = statistics(np.array([1.0, 5.0]), np.array([4.0, 4.0]), [{"x": 0.0}, {"x": 1.0}])
    assert found.largest is not None
    assert found.largest.value == -3.0


def test_statistics__over_no_points_is_n_0_and_no_number() -> None:
    found = statistics(np.array([np.nan, 1.0]), np.array([1.0, np.nan]), [{}, {}])
    assert found.n == 0
    assert (found.bias, found.rms, found.largest) == (None, None, None)


def test_statistics__nothing_is_relative_to_zero() -> None:
    places = [{"x": 0.0}, {"x": 1.0}]
    found = statistics(np.array([1.0, 3.0]), np.array([0.0, 2.0]), places)
    assert (found.n, found.bias) == (2, 1.0)
    assert found.relative_bias == 0.5
    none = statistics(np.array([1.0]), np.array([0.0]), places)
    assert (none.n, none.relative_bias, none.relative_largest) == (1, None, None)


def test_observation_of_another_set_up__is_not_compared_with_a_run() -> None:
    at: dict[str, float | str] = {"speed": 4e3, "plate_thickness": 2e-3}
    at["projectile"] = "al-2024-t3"
    value, _, how = bring_to(holes(), "hole_diameter", at)
    assert math.isnan(value)
    assert how == "not simulated: another projectile"


def test_law__is_judged_where_it_answers_and_again_inside_its_range() -> None:
    dataset = holes()
    found = residual(compare(dataset), "maiden_al")
    answers = dataset.hole_diameter_by_law.sel(hole_diameter_law="maiden_al")
    difference = answers - dataset.hole_diameter
    assert found.everywhere.n == 18
    assert found.everywhere.bias == pytest.approx(float(difference.mean()))
    inside = difference.sel(speed=[3e3, 4e3, 5e3])  # its stated range is 2.5 to 5.5 km/s
    assert found.in_range is not None
    assert found.in_range.n == 9
    assert found.in_range.bias == pytest.approx(float(inside.mean()))


def test_law__without_a_point_in_its_range_says_n_0() -> None:
    found = residual(compare(holes()), "strength_ln/Y = 240 MPa")
    assert found.everywhere.n == 18
    assert found.in_range is not None
    assert found.in_range.n == 0


def test_law__is_not_counted_where_it_is_meaningless_or_the_run_has_no_value() -> None:
    answered = residual(compare(holes()), "zhang_tan").everywhere.n
    dataset = holes()
    answers = dataset.hole_diameter_by_law.sel(hole_diameter_law="zhang_tan")
    assert answered == int(np.isfinite(answers).sum()) < 18
    assert residual(compare(holes(trouble=True)), "maiden_c").everywhere.n == 15


def test_value_of_a_failed_run__is_not_a_reference() -> None:
    sweep = fakes.holes()
    known = fakes.results(sweep)
    first = sweep.runs()[0].run.id
    known[first] = replace(known[first], state="failed", reason="late")
    dataset = cube.build(sweep, known, fakes.catalogue())
    assert residual(compare(dataset), "maiden_c").everywhere.n == 17


@pytest.mark.parametrize(
    ("flag", "compared"),
    [("closed_on_axis", False), ("too_coarse", False), ("near_rim", True), ("still_growing", True)],
)
def test_value__whose_error_nobody_knows_is_compared_with_no_law(flag: str, compared: bool) -> None:
    sweep = fakes.holes()
    run = sweep.runs()[0].run
    hole = fakes.measured(0.012, flag)
    known = {**fakes.results(sweep), run.id: fakes.Result(run.id, {"hole_diameter": hole})}
    laws = compare(cube.build(sweep, known, fakes.catalogue())).residuals
    assert laws
    assert {law.points for law in laws} == {len(sweep.runs()) - (not compared)}


def test_statement__says_that_the_reference_is_a_simulation_unless_shots_are_given() -> None:
    assert compare(holes()).statement == ONLY_SIMULATION
    assert "observed shots that the sweep brought" in compare(holes(*fakes.SHOTS)).statement


def test_observation_on_a_run__is_met_by_that_run() -> None:
    dataset = holes()
    value, uncertainty, how = bring_to(
        dataset, "hole_diameter", {"speed": 4e3, "plate_thickness": 3e-3}
    )
    cell = dataset.sel(speed=4e3, plate_thickness=3e-3)
    assert (value, uncertainty) == (
        float(cell.hole_diameter),
        float(cell.hole_diameter_uncertainty),
    )
    assert how == "computed"


def test_observation_between_runs__is_met_by_linear_interpolation() -> None:
    dataset = holes()
    value, _, how = bring_to(dataset, "hole_diameter", {"speed": 4.5e3, "plate_thickness": 2.25e-3})
    corners = dataset.hole_diameter.sel(speed=[4e3, 5e3], plate_thickness=[2e-3, 3e-3])
    expected = corners.mean("speed").values @ [0.75, 0.25]
    assert value == pytest.approx(expected)
    assert how.startswith("linear between neighbouring runs")


@pytest.mark.parametrize(
    ("at", "why"),
    [
        ({"speed": 9e3, "plate_thickness": 2e-3}, "outside the axis speed"),
        ({"speed": 3e3}, "does not state plate_thickness"),
        ({"speed": 2.5e3, "plate_thickness": 2e-3}, "a neighbouring run has no value"),
    ],
)
def test_observation__that_the_sweep_cannot_meet_is_said_to_be_so(at: dict, why: str) -> None:
    value, _, how = bring_to(holes(trouble=True), "hole_diameter", at)
    assert math.isnan(value)
    assert why in how


def test_observation_in_a_zip__is_met_by_the_run_with_its_parameters_alone() -> None:
    axes = (
        fakes.Axis("speed", "m s-1", (2e3, 4e3)),
        fakes.Axis("plate_thickness", "m", (2e-3, 3e-3)),
    )
    sweep = fakes.Sweep(axes, combine="zip")
    dataset = cube.build(sweep, fakes.results(sweep), fakes.catalogue())
    value, _, how = bring_to(dataset, "hole_diameter", {"speed": 4e3, "plate_thickness": 3e-3})
    assert (value, how) == (float(dataset.hole_diameter[1]), "computed")
    _, _, how = bring_to(dataset, "hole_diameter", {"speed": 3e3, "plate_thickness": 3e-3})
    assert how == "no run has these parameters"


def test_observations__judge_the_simulation_and_each_law() -> None:
    shot = fakes.observed(4e3, 3e-3, 17.9e-3)
    dataset = holes(shot)
    comparison = compare(dataset)
    simulated = float(dataset.hole_diameter.sel(speed=4e3, plate_thickness=3e-3))
    found = residual(comparison, "simulation", "observation")
    assert found.everywhere.n == 1
    assert found.everywhere.bias == pytest.approx(simulated - 17.9e-3)
    assert found.in_range is None
    law = residual(comparison, "maiden_al", "observation")
    assert shot.shot is not None
    answer = fakes.HOLE_LAWS[0].evaluate(shot.shot, "").value
    assert law.everywhere.bias == pytest.approx(answer - 17.9e-3)


def said(bias: float, relative_bias: float) -> str:
    found = Statistics(2, bias=bias, rms=1.0, relative_bias=relative_bias, relative_rms=1.0)
    return sentence(
        Residual("hole_diameter", "m", "law", "a law", "simulation", found, found, points=2)
    )


def test_sentence__says_the_way_of_the_number_that_it_prints() -> None:
    # Law 20.5 and 0.5 mm against 20 and 0.8 mm: 0.1 mm larger, 17.5 % smaller.
    assert "17.5\u202f% smaller" in said(1e-4, -0.175)
    assert "17.5\u202f% larger" in said(-1e-4, 0.175)


def test_sentence__counts_all_points_that_have_a_value() -> None:
    dataset = holes()
    found = residual(compare(dataset), "zhang_tan")
    answers = dataset.hole_diameter_by_law.sel(hole_diameter_law="zhang_tan")
    inside = dataset.hole_diameter_by_law_in_range.sel(hole_diameter_law="zhang_tan") == 1
    assert found.points == 18
    assert f"({int((inside & answers.notnull()).sum())} of 18 points)" in sentence(found)


def test_sentence__counts_converged_points_where_it_compares() -> None:
    sweep = fakes.refined_holes()
    dataset = cube.build(sweep, fakes.results(sweep), fakes.catalogue())
    found = residual(compare(dataset), "maiden_al")  # its stated range is 2.5 to 5.5 km/s
    assert found.in_range is not None
    assert (found.everywhere.converged, found.everywhere.n) == (3, 6)
    assert (found.in_range.converged, found.in_range.n) == (1, 3)
    assert "(3 of 6 points)" in sentence(found)
    assert "(converged at 1 of 3 points)" in sentence(found)


def test_observation_without_an_error__does_not_judge_the_simulation() -> None:
    sweep = fakes.refined_holes()
    for uncertainty, judged in ((0.3e-3, 1), (None, 0)):
        shot = fakes.observed(2e3, 2e-3, 13e-3, uncertainty)
        dataset = cube.build(sweep, fakes.results(sweep), fakes.catalogue(observations=[shot]))
        found = residual(compare(dataset), "simulation", "observation")
        assert found.everywhere.judged == judged
    assert NOT_BOTH in sentence(found)


# --- error bars that hold no mesh error -----------------------------------------------------------


@pytest.mark.parametrize("offsets", [(0.0,), fakes.OFFSETS])
def test_single_grid__judges_no_law_by_its_error_bar(offsets: tuple[float, ...]) -> None:
    sweep = fakes.refined_holes((16.0,), offsets)
    dataset = cube.build(sweep, fakes.results(sweep), fakes.catalogue())
    found = residual(compare(dataset), "maiden_c")
    assert found.everywhere.n == 6
    assert (found.everywhere.judged, found.everywhere.within) == (0, 0)
    assert found.everywhere.bar is None
    assert f"whose {NO_MESH}" in sentence(found)
    assert "inside the error bar" not in sentence(found)


def test_single_grid__does_not_judge_the_simulation_by_an_observation_either() -> None:
    comparison = compare(holes(fakes.observed(4e3, 3e-3, 17.9e-3)))
    found = residual(comparison, "simulation", "observation")
    assert found.everywhere.judged == 0
    assert f"; {NOT_BOTH}" in sentence(found)


def test_observation__judges_a_law_by_its_own_error_bar() -> None:
    comparison = compare(holes(fakes.observed(4e3, 3e-3, 17.9e-3)))
    found = residual(comparison, "maiden_al", "observation")
    assert found.everywhere.judged == 1
    assert "inside the error bar" in sentence(found)
    unbarred = compare(holes(fakes.observed(4e3, 3e-3, 17.9e-3, None)))
    assert "which has no error bar" in sentence(residual(unbarred, "maiden_al", "observation"))


def test_point_with_one_grid_left__is_compared_and_not_judged() -> None:
    sweep = fakes.refined_holes()
    known = fakes.results(sweep)
    for point in sweep.runs():
        if point.coordinates["speed"] == 2e3 and point.coordinates["cells_per_diameter"] > 16.0:
            known[point.run.id] = replace(known[point.run.id], state="failed", reason="late")
    found = residual(compare(cube.build(sweep, known, fakes.catalogue())), "maiden_c")
    assert (found.everywhere.n, found.everywhere.judged) == (6, 5)
