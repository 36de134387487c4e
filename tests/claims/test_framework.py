"""The framework itself: a claim that does not hold cannot look as if it did."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from tests.claims import Claim, Row, at_least, at_most, claim, framework, within
from tests.claims.__main__ import judge, main
from tests.claims.framework import UnknownClaim, Word

ONE_CLAIM = """
from tests.claims import Row, claim

@claim("one", says="one is one")
def one():
    return Row("one", 1, 1, passed=True)
"""


@claim("holds", says="one is one", quick=True)
def holds() -> Row:
    return Row("one", 1, 1, passed=True)


@claim("fails", says="one is two")
def fails() -> Iterator[Row]:
    yield Row("one", 1, 1, passed=True)
    yield Row("two", 2, 1, passed=False)


@claim("raises", says="a third is found")
def raises() -> Iterator[Row]:
    yield Row("first", 1, 1, passed=True)
    raise ArithmeticError("the third was lost")


@claim("reports", says="a figure")
def reports() -> Iterator[Row]:
    yield Row("figure (mm)", 15.3, 99.0, passed=None)


@claim("empty", says="nothing")
def empty() -> list[Row]:
    return []


def test_run__a_row_that_fails_is_reported_as_such() -> None:
    assert [verdict.word for verdict in framework.run(fails)] == [Word.PASS, Word.FAIL]


def test_run__an_exception_fails_with_its_text_and_keeps_the_rows_before_it() -> None:
    first, second = framework.run(raises)
    assert first.word is Word.PASS
    assert second.word is Word.FAIL
    assert second.row.got == "ArithmeticError: the third was lost"
    assert "third was lost" in second.trace


def test_run__a_claim_that_compares_nothing_fails() -> None:
    (verdict,) = framework.run(empty)
    assert verdict.word is Word.FAIL


def test_run__a_reported_row_is_not_gated() -> None:
    (verdict,) = framework.run(reports)
    assert verdict.word is Word.REPORT


@pytest.mark.parametrize(
    ("claims", "status"),
    [
        ([holds], 0),
        ([holds, reports], 0),
        ([holds, fails], 1),
        ([raises, holds], 1),
        ([empty], 1),
    ],
    ids=["holds", "reports", "fails", "raises", "empty"],
)
def test_judge__exit_status_is_one_when_anything_failed(claims: list[Claim], status: int) -> None:
    assert judge(claims) == status


def test_judge__prints_aligned_columns_and_a_plain_last_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    judge([holds, fails, reports])
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["claim", "expected", "got", "verdict", "seconds"]
    column = lines[0].index("verdict")
    assert [line[column:].split()[0] for line in lines[2:6]] == ["PASS", "PASS", "FAIL", "REPORT"]
    assert lines[-1] == "2 passed, 1 failed"


def test_judge__json_holds_the_same_verdicts(tmp_path: Path) -> None:
    judge([fails, reports], json_file=tmp_path / "claims.json")
    rows = json.loads((tmp_path / "claims.json").read_text())["claims"]
    assert [row["verdict"] for row in rows] == ["PASS", "FAIL", "REPORT"]
    assert rows[2]["got"] == 99.0


def test_main__an_unknown_set_proves_nothing() -> None:
    assert main(["no-such-set"]) == 2


def test_select__an_unknown_claim_is_refused() -> None:
    with pytest.raises(UnknownClaim, match="no-such-claim"):
        framework.select(["no-such-claim"])


def test_run__something_other_than_a_row_fails() -> None:
    odd = replace(holds, check=lambda: [True])  # type: ignore[list-item]
    assert [verdict.word for verdict in framework.run(odd)] == [Word.FAIL]


def test_load__finds_claims_by_folder_and_refuses_a_name_used_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "invented" / "new_set"
    folder.mkdir(parents=True)
    (folder / "first.py").write_text(ONE_CLAIM)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(framework, "PACKAGE", "invented")
    monkeypatch.setattr(framework, "sets", lambda: ["new-set"])
    assert [(one.set, one.name) for one in framework.load("new-set")] == [("new-set", "one")]
    (folder / "second.py").write_text(ONE_CLAIM)
    with pytest.raises(ValueError, match="a second time"):
        framework.load("new-set")


def test_within__takes_the_tolerance_it_was_given() -> None:
    assert within("depth", expected=14.0, got=15.5, absolute=1.5).passed
    assert not within("depth", expected=14.0, got=15.6, absolute=1.5).passed
    assert within("drift", expected=-2.0, got=-2.1, relative=0.06).passed


@pytest.mark.parametrize("tolerances", [{}, {"relative": 0.1, "absolute": 1.0}])
def test_within__refuses_no_tolerance_and_two(tolerances: dict[str, float]) -> None:
    with pytest.raises(TypeError, match="one tolerance"):
        within("depth", expected=1.0, got=1.0, **tolerances)


def test_comparisons__not_a_number_never_passes() -> None:
    nan = float("nan")
    assert within("depth", expected=14.0, got=nan, absolute=1.5).passed is False
    assert at_most("drift", limit=1.0, got=nan).passed is False
    assert at_least("speedup", limit=4.0, got=nan).passed is False
