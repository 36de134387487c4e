"""Residuals: their statistics by hand, their ranges, and which error bars judge."""

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from studies.laws import DRAWN_ONLY
from studies.quantities.measured import NOT_COMPARED
from studies.reports.compare import References, Residual, compare, statistics
from studies.reports.judgement import nearest
from tests.studies.support import fakes

MAIDEN = "maiden_al"  # its stated range is 2.5 to 5.5 km/s
HOLES = fakes.holes()


def residual(dataset: xr.Dataset, subject: str, reference: str = "simulation") -> Residual:
    (entry,) = [each for each in compare(dataset).residuals if (each.subject, each.reference) == (subject, reference)]
    return entry


@pytest.mark.parametrize("residuals", [[-1.0, 2.0], [1.0, 2.1]])
def test_statistics__have_no_mean_where_it_would_hide_the_residuals(residuals: list[float]) -> None:
    reference = References("simulation", np.array([10.0, 10.0]), [{"speed": 2e3}, {"speed": 3e3}])
    entry = statistics(10.0 + np.array(residuals), reference)
    assert (entry.bias, entry.relative_bias) == (None, None)
    assert (entry.smallest, entry.greatest) == pytest.approx(residuals)


@pytest.mark.parametrize(("flag", "compared"), [*((f, 0) for f in NOT_COMPARED), ("near_rim", 1)])
def test_law__is_not_compared_with_a_value_whose_flags_speak_against_it(flag: str, compared: int) -> None:
    run = HOLES.runs()[0].run
    flagged = replace(fakes.result(run), measurements={"hole_diameter": fakes.measured(0.012, flag)})
    dataset = fakes.cube_of(HOLES, {**fakes.results(HOLES), run.id: flagged})
    assert residual(dataset, "maiden_c").points == 17 + compared


def with_confidence(word: str) -> xr.Dataset:
    """Holes in runs and in a shot, with every law of one confidence."""
    laws = [replace(law, confidence=word) for law in fakes.HOLE_LAWS]
    return fakes.cube_of(HOLES, laws=laws, observations=[fakes.observed(4e3, 3e-3, 17.9e-3)])


@pytest.mark.parametrize("word", ["memory", "indicative"])
def test_law__that_is_drawn_only_enters_no_headline_and_no_average(word: str) -> None:
    comparison = compare(with_confidence(word))
    judged = [each for each in comparison.judgements if each.law != "simulation"]
    assert len(judged) == 2 * len(fakes.HOLE_LAWS[:3]) + 2 * len(fakes.YIELDS)
    assert {each.drawn_only for each in judged} == {DRAWN_ONLY[word]}
    assert nearest(judged, "simulation") == []
    laws = [each for each in comparison.residuals if each.subject != "simulation"]
    assert {each.reference for each in laws} == {"simulation", "observation"}
    several = [each.everywhere for each in laws if each.everywhere.n > 1]
    assert several
    assert all(each.rms is None and each.relative_bias is None for each in several)
    assert all(each.drawn_only == DRAWN_ONLY[word] for each in laws)


@pytest.mark.parametrize(("word", "stated"), [("cross-checked", True), ("read", False)])
def test_unchecked__names_the_laws_that_are_recalled(word: str, stated: bool) -> None:
    assert ("recalled" in [each.code for each in compare(with_confidence(word)).unchecked]) == stated


# --- observations ---------------------------------------------------------------------------------


def test_observation__judges_a_law_by_its_own_error_bar() -> None:
    shot = fakes.observed(4e3, 3e-3, 17.9e-3)
    entry = residual(fakes.cube_of(HOLES, observations=[shot]), MAIDEN, "observation")
    assert shot.shot is not None
    answer = fakes.HOLE_LAWS[0].evaluate(shot.shot, "").value
    assert entry.everywhere.bias == pytest.approx(answer - 17.9e-3)
    assert (entry.everywhere.judged, entry.everywhere.bar) == (1, 0.3e-3)
    without = fakes.cube_of(HOLES, observations=[replace(shot, uncertainty=None)])
    unbarred = residual(without, MAIDEN, "observation")
    assert (unbarred.everywhere.judged, unbarred.everywhere.bar) == (0, None)


def test_observation__judges_the_simulation_by_both_error_bars_together() -> None:
    dataset = fakes.cube_of(fakes.refined_holes(), observations=[fakes.observed(2e3, 2e-3, 11.5e-3, 0.3e-3)])
    converged = dataset.sel(speed=2e3)
    bar = math.hypot(0.3e-3, float(converged.hole_diameter_converged_uncertainty))
    entry = residual(dataset, "simulation", "observation")
    bias = float(converged.hole_diameter_converged) - 11.5e-3
    assert entry.everywhere.bias == pytest.approx(bias)
    assert entry.everywhere.bar == pytest.approx(bar)
    assert (entry.everywhere.within, entry.in_range) == (1, None)
