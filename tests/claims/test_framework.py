"""A claim that does not hold is reported as failed, and no selection of claims is empty in silence."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from tests.claims import Claim, Row, claim, equal, framework
from tests.claims.__main__ import judge, main
from tests.claims.framework import UnknownClaim

ONE_CLAIM = """
from tests.claims import equal, claim

@claim("one", says="one is one")
def one():
    return equal("one", expected=1, got=1)
"""


@claim("holds", says="one is one", quick=True)
def holds() -> Row:
    return equal("one", expected=1, got=1)


@claim("fails", says="one is two")
def fails() -> Iterator[Row]:
    yield equal("one", expected=1, got=1)
    yield equal("two", expected=2, got=1)


@claim("raises", says="a third is found")
def raises() -> Iterator[Row]:
    yield equal("first", expected=1, got=1)
    raise ArithmeticError("the third was lost")


@claim("reports", says="a figure")
def reports() -> Row:
    return Row("figure (mm)", 15.3, 99.0, passed=None)


EMPTY = Claim("empty", says="nothing", check=list)
ODD = replace(holds, check=lambda: [True])  # type: ignore[list-item]


@pytest.mark.parametrize(
    ("chosen", "verdicts"),
    [
        (holds, ["PASS"]),
        (fails, ["PASS", "FAIL"]),
        (raises, ["PASS", "FAIL"]),
        (reports, ["REPORT"]),
        (EMPTY, ["FAIL"]),
        (ODD, ["FAIL"]),
    ],
    ids=["holds", "fails", "raises", "reports", "empty", "no row"],
)
def test_run__judges_each_row(chosen: Claim, verdicts: list[str]) -> None:
    rows = list(framework.run(chosen))
    assert [each.row.verdict for each in rows] == verdicts
    assert judge([holds, chosen]) == int("FAIL" in verdicts)


def test_run__fails_an_exception_with_its_text() -> None:
    *_, last = framework.run(raises)
    assert last.row.got == "ArithmeticError: the third was lost"
    assert "third was lost" in last.trace


def test_judge__prints_and_writes_every_row(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "claims.json"
    judge([fails, reports], json_file=file)
    *lines, empty, counted, last = capsys.readouterr().out.splitlines()
    rows = json.loads(file.read_text())["claims"]
    assert [row["verdict"] for row in rows] == ["PASS", "FAIL", "REPORT"]
    assert [line.split(" | ")[1].strip() for line in lines] == [row["verdict"] for row in rows]
    assert rows[2]["got"] == 99.0
    assert (empty, counted, last) == ("", "1 reported and not gated", "1 passed, 1 failed")


def test_main__of_an_unknown_set_is_no_success() -> None:
    assert main(["no-such-set"]) == 2


def test_select__refuses_an_unknown_claim() -> None:
    with pytest.raises(UnknownClaim, match="no-such-claim"):
        framework.select(["no-such-claim"])


def test_load__finds_claims_by_folder_and_refuses_a_name_used_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "invented" / "new_set"
    folder.mkdir(parents=True)
    (folder / "first.py").write_text(ONE_CLAIM)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(framework, "PACKAGE", "invented")
    monkeypatch.setattr(framework, "sets", lambda: ["new-set"])
    assert [(each.set, each.name) for each in framework.load("new-set")] == [("new-set", "one")]
    (folder / "second.py").write_text(ONE_CLAIM)
    with pytest.raises(ValueError, match="a second time"):
        framework.load("new-set")


def test_select__of_a_set_takes_the_claims_that_it_names_from_others() -> None:
    chosen = {(each.set, each.name) for each in framework.select(["cases"])}
    assert ("proven", "loads") in chosen
    assert ("proven", "sod") not in chosen
