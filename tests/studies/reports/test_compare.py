"""Judgements of laws: by which bars, beside which values, and which laws judge nothing."""

import math
from dataclasses import replace

import pytest
import xarray as xr

from studies.laws import DRAWN_ONLY
from studies.quantities.measured import NOT_COMPARED
from studies.reports.compare import compare
from studies.reports.judgement import nearest
from studies.reports.records import Judgement, Outcome
from tests.studies.support import fakes

MAIDEN = "maiden_al"  # its stated range is 2.5 to 5.5 km/s
HOLES = fakes.holes()


def judged(dataset: xr.Dataset, law: str, reference: str = "simulation") -> Judgement:
    (entry,) = [each for each in compare(dataset).judgements if (each.law, each.reference) == (law, reference)]
    return entry


@pytest.mark.parametrize(("flag", "compared"), [*((f, 0) for f in NOT_COMPARED), ("near_rim", 1)])
def test_law__has_no_difference_from_a_value_whose_flags_speak_against_it(flag: str, compared: int) -> None:
    run = HOLES.runs()[0].run
    flagged = replace(fakes.result(run), measurements={"hole_diameter": fakes.measured(0.012, flag)})
    dataset = fakes.cube_of(HOLES, {**fakes.results(HOLES), run.id: flagged})
    points = judged(dataset, "maiden_c").points
    assert sum(point.difference is not None for point in points) == 17 + compared


def with_confidence(word: str) -> xr.Dataset:
    """Holes in runs and in a shot, with every law of one confidence."""
    laws = [replace(law, confidence=word) for law in fakes.HOLE_LAWS]
    return fakes.cube_of(HOLES, laws=laws, observations=[fakes.observed(4e3, 3e-3, 17.9e-3)])


@pytest.mark.parametrize("word", ["memory", "indicative"])
def test_law__that_is_drawn_only_enters_no_headline(word: str) -> None:
    laws = [each for each in compare(with_confidence(word)).judgements if each.law != "simulation"]
    assert len(laws) == 2 * len(fakes.HOLE_LAWS[:3]) + 2 * len(fakes.YIELDS)
    assert {each.drawn_only for each in laws} == {DRAWN_ONLY[word]}
    assert nearest(laws, "simulation") == []


@pytest.mark.parametrize(("word", "stated"), [("cross-checked", True), ("read", False)])
def test_unchecked__names_the_laws_that_are_recalled(word: str, stated: bool) -> None:
    assert ("recalled" in [each.code for each in compare(with_confidence(word)).unchecked]) == stated


# --- observations ---------------------------------------------------------------------------------


def test_observation__judges_a_law_by_its_own_error_bar() -> None:
    shot = fakes.observed(4e3, 3e-3, 17.9e-3)
    entry = judged(fakes.cube_of(HOLES, observations=[shot]), MAIDEN, "observation")
    assert shot.shot is not None
    answer = fakes.HOLE_LAWS[0].evaluate(shot.shot, "").value
    assert entry.low == entry.high == pytest.approx(answer / 17.9e-3 - 1.0)
    assert entry.tested == 1
    assert entry.bar == pytest.approx(0.3 / 17.9)
    without = fakes.cube_of(HOLES, observations=[replace(shot, uncertainty=None)])
    assert judged(without, MAIDEN, "observation").tested == 0


def test_observation__judges_the_simulation_by_both_error_bars_together() -> None:
    dataset = fakes.cube_of(fakes.refined_holes(), observations=[fakes.observed(2e3, 2e-3, 11.5e-3, 0.3e-3)])
    at = dataset.sel(speed=2e3)
    parts = (0.3e-3, float(at.hole_diameter_converged_uncertainty), float(at.hole_diameter_definition_part))
    models = at.hole_diameter_model_part.isel(cells_per_diameter=-1, offset=0)
    entry = judged(dataset, "simulation", "observation")
    assert entry.low == pytest.approx(float(at.hole_diameter_converged) / 11.5e-3 - 1.0)
    known = [part for part in (*parts, float(models)) if math.isfinite(part)]
    assert entry.bar == pytest.approx(math.hypot(*known) / 11.5e-3)
    assert entry.outcome is Outcome.WITHIN
