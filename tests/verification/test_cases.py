"""The frame of the verification cases cannot hide a failure; the cases themselves are claims."""

import math
from collections.abc import Iterator

import pytest

from solver.errors import ProblemError
from studies import verification
from studies.values.errors import InvalidInput
from studies.values.recipes import RECIPES, Recipe
from studies.verification import Case, Row
from tests.claims import framework


def test_quick_case__is_recomputed_by_a_quick_claim() -> None:
    claims = {one.name for one in framework.select(quick=True)}
    assert set(verification.names(quick=True)) <= claims


@pytest.mark.parametrize("name", verification.names())
def test_case__names_itself_after_its_problem_and_its_source(name: str) -> None:
    case = verification.load(name)
    assert case.title
    assert case.source


def test_row__that_is_not_a_number_fails() -> None:
    assert verification.relative("x", expected=1.0, got=math.nan, within=0.1).verdict == "FAIL"
    assert verification.absolute("x", expected=0.0, got=math.nan, within=0.1).verdict == "FAIL"
    assert verification.at_least("x", limit=1.0, got=math.nan).verdict == "FAIL"


def test_row__without_a_tolerance_is_reported() -> None:
    assert verification.relative("x", expected=1.0, got=9.0).verdict == "REPORT"
    assert verification.reported("x", 9.0).passed is None


@pytest.mark.parametrize("got", [math.nan, math.inf, -math.inf])
def test_row__that_reports_no_finite_number_fails(got: float) -> None:
    assert verification.reported("x", got).verdict == "FAIL"


def test_row__as_plain_objects_holds_no_nan() -> None:
    plain = verification.relative("x", expected=1.0, got=math.nan).as_json()
    assert plain["got"] is None
    assert plain["verdict"] == "REPORT"


def test_verify__makes_a_failed_row_of_what_the_solver_raises(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def run(recipe: Recipe) -> Iterator[Row]:
        yield verification.reported("first", 1.0)
        raise ProblemError("no particles")

    case = Case(name="broken", title="Broken", source="", run=run)
    monkeypatch.setattr(verification, "load", lambda name: case)
    rows = [one.row for one in verification.verify(["broken"], RECIPES["whipple"])]
    assert [row.verdict for row in rows] == ["REPORT", "FAIL"]
    assert "no particles" in rows[-1].claim


def test_load__of_an_unknown_case_names_the_nearest() -> None:
    with pytest.raises(InvalidInput, match="plate-impact"):
        verification.load("plate-impacts")
