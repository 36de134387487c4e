"""Residuals: their statistics by hand, their ranges, and which error bars judge."""

import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from studies.cubes import cube
from studies.laws import DRAWN_ONLY, Range, Shot
from studies.laws._range import family
from studies.quantities.measured import NOT_COMPARED
from studies.reports.compare import ONLY_SIMULATION, References, Residual, Statistics, compare, statistics
from tests.studies.support import fakes

MAIDEN = "maiden_al"  # its stated range is 2.5 to 5.5 km/s


def holes(*shots: fakes.Observed, **replaced: Any) -> xr.Dataset:
    sweep = fakes.holes()
    return cube.build(sweep, {**fakes.results(sweep), **replaced}, fakes.catalogue(observations=shots))


def refined_holes(*shots: fakes.Observed, **replaced: Any) -> xr.Dataset:
    sweep = fakes.refined_holes()
    outcomes = {**fakes.results(sweep), **replaced}
    return cube.build(sweep, outcomes, fakes.catalogue(observations=shots))


def residual(dataset: xr.Dataset, subject: str, reference: str = "simulation") -> Residual:
    (entry,) = [each for each in compare(dataset).residuals if (each.subject, each.reference) == (subject, reference)]
    return entry


def of(subject: list[float], reference: list[float]) -> Statistics:
    places = [{"speed": float(number)} for number in range(len(subject))]
    return statistics(np.array(subject), References("simulation", np.array(reference), places))


def test_statistics__are_those_of_subject_minus_reference() -> None:
    entry = of([3.0, 6.0, 9.0], [2.0, 4.0, 6.0])
    assert (entry.n, entry.relative_bias) == (3, 0.5)
    assert entry.rms == pytest.approx(math.sqrt((1 + 4 + 9) / 3))
    assert entry.largest is not None
    assert (entry.largest.value, entry.largest.at) == (3.0, {"speed": 2.0})


@pytest.mark.parametrize("residuals", [[-1.0, 2.0], [1.0, 2.1]])
def test_statistics__have_no_mean_where_it_would_hide_the_residuals(residuals: list[float]) -> None:
    entry = of([10.0 + each for each in residuals], [10.0, 10.0])
    assert (entry.bias, entry.relative_bias) == (None, None)
    assert (entry.smallest, entry.greatest) == pytest.approx(residuals)


def test_statistics__over_no_points_is_n_0_and_no_number() -> None:
    assert of([math.nan, 1.0], [1.0, math.nan]) == Statistics(0)


def test_statistics__nothing_is_relative_to_zero() -> None:
    entry = of([1.0, 3.0], [0.0, 2.0])
    assert (entry.n, entry.bias, entry.relative_bias) == (2, 1.0, 0.5)
    assert of([1.0], [0.0]).relative_bias is None


def test_law__is_judged_where_it_answers_and_again_inside_its_range() -> None:
    dataset = holes()
    entry = residual(dataset, MAIDEN)
    difference = dataset.hole_diameter_by_law.sel(hole_diameter_law=MAIDEN) - dataset.hole_diameter
    inside = difference.sel(speed=[3e3, 4e3, 5e3])
    assert entry.in_range is not None
    assert (entry.everywhere.n, entry.in_range.n, entry.points) == (18, 9, 18)
    assert entry.everywhere.rms == pytest.approx(float((difference**2).mean() ** 0.5))
    assert entry.in_range.rms == pytest.approx(float((inside**2).mean() ** 0.5))


def test_law__without_a_point_in_its_range_says_n_0() -> None:
    entry = residual(holes(), "strength_ln/Y = 240 MPa")
    assert entry.everywhere.n == 18
    assert entry.in_range == Statistics(0)


def test_law__is_counted_where_it_has_a_meaning_and_the_run_succeeded() -> None:
    dataset = holes()
    answers = dataset.hole_diameter_by_law.sel(hole_diameter_law="zhang_tan")
    answered = residual(dataset, "zhang_tan").everywhere.n
    assert answered == int(np.isfinite(answers).sum()) < 18
    run = fakes.holes().runs()[0].run
    late = replace(fakes.result(run), state="failed", reason="late")
    assert residual(holes(**{run.id: late}), "maiden_c").everywhere.n == 17


@pytest.mark.parametrize(("flag", "compared"), [*((f, 0) for f in NOT_COMPARED), ("near_rim", 1)])
def test_law__is_not_compared_with_a_value_whose_flags_speak_against_it(flag: str, compared: int) -> None:
    run = fakes.holes().runs()[0].run
    flagged = replace(fakes.result(run), measurements={"hole_diameter": fakes.measured(0.012, flag)})
    assert residual(holes(**{run.id: flagged}), "maiden_c").points == 17 + compared


def with_confidence(word: str) -> xr.Dataset:
    """Holes in runs and in a shot, with every law of one confidence."""
    sweep = fakes.holes()
    catalogue = fakes.catalogue(observations=[fakes.observed(4e3, 3e-3, 17.9e-3)])
    laws = tuple(replace(law, confidence=word) for law in catalogue.laws)
    return cube.build(sweep, fakes.results(sweep), replace(catalogue, laws=laws))


@pytest.mark.parametrize("word", ["memory", "indicative"])
def test_law__that_is_drawn_only_enters_no_verdict_no_headline_and_no_average(word: str) -> None:
    comparison = compare(with_confidence(word))
    (quantity,) = comparison.verdict.quantities
    assert all(law.subject == "simulation" for law in quantity.laws)
    assert quantity.headline == ""
    assert quantity.rows == ()
    assert len(quantity.drawn) == len(fakes.HOLE_LAWS)
    assert all(DRAWN_ONLY[word] in text for text in quantity.drawn)
    laws = [each for each in comparison.residuals if each.subject != "simulation"]
    assert {each.reference for each in laws} == {"simulation", "observation"}
    several = [each.everywhere for each in laws if each.everywhere.n > 1]
    assert several
    assert all(each.rms is None and each.relative_bias is None for each in several)
    assert all(each.drawn_only == DRAWN_ONLY[word] for each in laws)


@pytest.mark.parametrize(("word", "stated"), [("cross-checked", True), ("read", False)])
def test_verdict__says_which_laws_are_recalled_and_by_whom(word: str, stated: bool) -> None:
    verdict = compare(with_confidence(word)).verdict
    (quantity,) = verdict.quantities
    laws = [law for law in quantity.laws if law.subject != "simulation"]
    assert laws
    assert all(("did not read the paper" in law.caveat) == stated for law in laws)
    assert ("did not read the paper" in " ".join(verdict.unchecked)) == stated
    assert not quantity.drawn


def test_verdict__lists_laws_for_other_materials_in_one_sentence() -> None:
    of_glass = Range((family("glass", "a source"),))
    sweep = fakes.holes()
    laws = tuple(
        fakes.law(name, "hole_diameter", lambda shot, variant: 2.5, title=f"title of {name}", range=of_glass)
        for name in ("first", "second")
    )
    catalogue = replace(fakes.catalogue(), laws=(*fakes.HOLE_LAWS, *laws))
    (quantity,) = compare(cube.build(sweep, fakes.results(sweep), catalogue)).verdict.quantities
    assert quantity.unjudged[-1] == ("For targets of other materials: title of first; title of second.")
    assert not any("glass" in text for text in quantity.unjudged)


def test_quantity__whose_runs_mix_versions_of_its_definition_gets_no_verdict() -> None:
    sweep = fakes.holes()
    run = sweep.runs()[0].run
    old = fakes.of_version(fakes.result(run), "hole_diameter", 7)
    dataset = holes(*fakes.SHOTS, **{run.id: old})
    comparison = compare(dataset)
    for each in comparison.residuals:
        if "simulation" in (each.reference, each.subject):
            assert (each.quantity, each.everywhere) == ("hole_diameter", Statistics(0))
    assert all(shot.simulation is None for shot in comparison.observations)
    assert list(comparison.mixed) == ["hole_diameter"]
    assert "versions 1 and 7" in comparison.mixed["hole_diameter"]
    # Neither another quantity nor one old version throughout is mixed.
    other = fakes.of_version(fakes.result(run), "hole_diameter_areal", 7)
    assert list(compare(holes(**{run.id: other})).mixed) == ["hole_diameter_areal"]
    every = {id: fakes.of_version(r, "hole_diameter", 7) for id, r in fakes.results(sweep).items()}
    comparison = compare(holes(**every))
    assert comparison.mixed == {}
    assert comparison.residuals[0].everywhere.n == 18


# --- error bars that judge ------------------------------------------------------------------------


def test_error_bar__judges_where_resolutions_show_the_mesh_error() -> None:
    dataset = refined_holes()
    entry = residual(dataset, "maiden_c")
    difference = dataset.hole_diameter_by_law.sel(hole_diameter_law="maiden_c") - dataset.hole_diameter_converged
    bars = dataset.hole_diameter_converged_uncertainty
    assert entry.everywhere.rms == pytest.approx(float((difference**2).mean() ** 0.5))
    assert (entry.everywhere.judged, entry.everywhere.converged) == (6, 3)
    assert entry.everywhere.within == int((np.abs(difference) <= bars).sum())
    assert entry.everywhere.bar == pytest.approx(float(bars.median()))


@pytest.mark.parametrize("offsets", [1, fakes.OFFSETS])
def test_error_bar__of_a_single_grid_judges_nothing(offsets: int) -> None:
    sweep = fakes.refined_holes((16.0,), offsets)
    dataset = cube.build(sweep, fakes.results(sweep), fakes.catalogue())
    entry = residual(dataset, "maiden_c")
    assert (entry.everywhere.n, entry.everywhere.judged, entry.everywhere.bar) == (6, 0, None)


# --- observations ---------------------------------------------------------------------------------


def test_statement__says_whether_the_reference_is_a_simulation_alone() -> None:
    assert compare(holes()).statement == ONLY_SIMULATION
    assert "observed shots that the sweep brought" in compare(holes(*fakes.SHOTS)).statement


def test_observation__judges_a_law_by_its_own_error_bar() -> None:
    shot = fakes.observed(4e3, 3e-3, 17.9e-3)
    entry = residual(holes(shot), MAIDEN, "observation")
    assert shot.shot is not None
    answer = fakes.HOLE_LAWS[0].evaluate(shot.shot, "").value
    assert entry.everywhere.bias == pytest.approx(answer - 17.9e-3)
    assert (entry.everywhere.judged, entry.everywhere.bar) == (1, 0.3e-3)
    unbarred = residual(holes(replace(shot, uncertainty=None)), MAIDEN, "observation")
    assert (unbarred.everywhere.judged, unbarred.everywhere.bar) == (0, None)


def test_observation__judges_the_simulation_by_both_error_bars_together() -> None:
    dataset = refined_holes(fakes.observed(2e3, 2e-3, 11.5e-3, 0.3e-3))
    converged = dataset.sel(speed=2e3)
    bar = math.hypot(0.3e-3, float(converged.hole_diameter_converged_uncertainty))
    entry = residual(dataset, "simulation", "observation")
    bias = float(converged.hole_diameter_converged) - 11.5e-3
    assert entry.everywhere.bias == pytest.approx(bias)
    assert entry.everywhere.bar == pytest.approx(bar)
    assert (entry.everywhere.within, entry.in_range) == (1, None)


def test_observation__does_not_judge_the_simulation_where_either_error_is_unknown() -> None:
    no_error = refined_holes(fakes.observed(2e3, 2e-3, 13e-3, None))
    no_mesh = holes(fakes.observed(4e3, 3e-3, 17.9e-3))
    for dataset in (no_error, no_mesh):
        entry = residual(dataset, "simulation", "observation")
        assert entry.everywhere.judged == 0


def test_observation__of_another_material_adds_no_constants_to_the_laws_of_the_runs() -> None:
    def variants(shot: Shot) -> tuple[str, ...]:
        return ("Y = 345 MPa",) if shot.speed == 4321.0 else ("Y = 90 MPa",)

    law = fakes.law("strength", "hole_diameter", lambda shot, variant: 2.0, variants=variants)
    sweep, shot = fakes.holes(), fakes.observed(4321.0, 2e-3, 15e-3)
    catalogue = replace(fakes.catalogue(observations=(shot,)), laws=(law,))
    residuals = compare(cube.build(sweep, fakes.results(sweep), catalogue)).residuals
    assert [(each.subject, each.reference) for each in residuals] == [
        ("strength/Y = 90 MPa", "simulation"),
        ("simulation", "observation"),
        ("strength/Y = 345 MPa", "observation"),
    ]


@pytest.mark.parametrize(("target", "judged"), [("copper", 0), ("aluminium", 1)])
def test_observation__of_another_material_than_all_runs_judges_nothing(target: str, judged: int) -> None:
    dataset = holes(fakes.observed(4e3, 3e-3, 17.9e-3))
    words = json.loads(dataset.attrs["vocabulary"])
    words["parameters"] = [*words["parameters"], "target"]
    dataset = dataset.assign_coords(target="aluminium").assign(observation_target=("observation", [target]))
    comparison = compare(dataset.assign_attrs(vocabulary=json.dumps(words)))
    assert len(comparison.observations) == 1
    against = [each for each in comparison.residuals if each.reference == "observation"]
    assert bool(against) == bool(judged)
