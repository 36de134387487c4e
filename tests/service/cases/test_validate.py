"""``whipple validate``: rows, pages, and what it refuses."""

import re
from pathlib import Path

import pytest

from service.cases import validation as validation_commands
from studies.cases import rows
from tests.service.support.command import run

Capsys = pytest.CaptureFixture[str]


def verified(monkeypatch: pytest.MonkeyPatch, *figures: float) -> None:
    """Let a verification case give these figures where 1 within 0.5 is expected."""
    compared = [rows.relative("pressure (GPa)", expected=1.0, got=figure, within=0.5) for figure in figures]
    answers = [rows.Verified("similarity", row, 0.1) for row in compared]
    monkeypatch.setattr(validation_commands, "verify", lambda _names: answers)


@pytest.mark.parametrize(("figures", "status"), [((1.0, 1.1), 0), ((1.0, 1.6), 1)])
def test_validate__of_a_case_prints_its_rows_and_writes_its_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys, figures: tuple[float, ...], status: int
) -> None:
    verified(monkeypatch, *figures)
    assert run("validate", "similarity", "--out", tmp_path) == status
    *lines, counts, pages = capsys.readouterr().out.splitlines()
    assert [line.split(" | ")[0] for line in lines] == ["similarity"] * 2
    assert counts == f"{2 - status} passed, {status} failed, 0 reported"
    assert pages == f"pages: {tmp_path / 'index.html'}"
    assert counts in (tmp_path / "index.html").read_text()
    assert f"got {figures[1]:g}" in lines[1]
    cells = re.findall(r"<td[^>]*>([^<]*)</td>", (tmp_path / "similarity.html").read_text())
    assert f"{figures[1]:g}" in cells


def test_validate__refuses_what_it_does_not_have(tmp_path: Path, capsys: Capsys) -> None:
    assert run("validate", "table-3-5", "--out", tmp_path) == 2
    assert "did you mean 'table-3-" in capsys.readouterr().err
    assert run("validate", "--level", "best", "--out", tmp_path) == 2
    assert "quick, thesis, fine" in capsys.readouterr().err
