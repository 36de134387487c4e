"""A claim that does not hold is reported as failed, and no selection of claims is empty in silence."""

import json
from pathlib import Path

import pytest

from tests.claims import marked
from tests.claims.__main__ import main

TESTS = '''
import pytest
from tests.claims.rows import Row, equal

@pytest.mark.claim("new", "holds")
def test_holds(compared):
    """One is one."""
    compared(equal("one", expected=1, got=1), Row("figure (mm)", 15.3, 99.0, passed=None))

@pytest.mark.claim("new", "fails", minutes=1.0)
def test_fails(compared):
    compared(equal("one", expected=1, got=1), equal("two", expected=2, got=1))

@pytest.mark.claim("new", "raises", says="A third is found.")
def test_raises(compared):
    compared(equal("first", expected=1, got=1))
    raise ArithmeticError("the third was lost")

@pytest.mark.claim("other", "empty", minutes=1.0, short=True)
def test_empty(compared):
    """Nothing."""
'''
EXPECTED = {
    "holds": [("one", "PASS"), ("figure (mm)", "REPORT"), ("One is one.", "PASS")],
    "fails": [("one", "PASS"), ("two", "FAIL"), ("test_fails", "FAIL")],
    "raises": [("first", "PASS"), ("A third is found.", "FAIL")],
    "empty": [("Nothing.", "FAIL")],
}


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("claims") / "test_of_claims.py"
    file.write_text(TESTS)
    return file


@pytest.fixture(autouse=True)
def _claims(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No other claims, and no plugins of installed packages; the full form ends with the test."""
    monkeypatch.setattr(marked, "files", lambda: [str(file)])
    monkeypatch.setenv(marked.IN_FULL, "1")
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")


def test_claims__are_judged_row_by_row_and_printed_and_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["new", "empty", "--json", str(tmp_path / "claims.json")]) == 1
    rows = json.loads((tmp_path / "claims.json").read_text())["claims"]
    for name, expected in EXPECTED.items():
        assert [(row["claim"], row["verdict"]) for row in rows if row["case"] == name] == expected
    *lines, reported, counted = capsys.readouterr().out.splitlines()
    assert (reported, counted) == ("1 reported and not gated", "4 passed, 4 failed")
    printed = [line.split(" | ")[:3] for line in lines if " | " in line]
    assert {row["claim"] for row in rows} <= {words[2] for words in printed if len(words) == 3}


def test_claim__that_nobody_makes_is_no_success(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["no-such-set"]) == 2
    assert "the sets are new, other" in "".join(capsys.readouterr())


def test_list__names_claims_and_runs_none(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--list", "new"]) == 0
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert lines == ["new fails 1 min test_fails", "new holds One is one.", "new raises A third is found."]
