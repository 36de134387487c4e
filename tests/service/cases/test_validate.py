"""``whipple validate``: rows, page, and what it refuses."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from service.cases import validation as validation_commands
from studies.cases import validation
from studies.quantities.comparison import relative
from tests.service.support.command import run

Capsys = pytest.CaptureFixture[str]


@pytest.mark.parametrize(("figures", "status"), [((1.0, 1.1), 0), ((1.0, 1.6), 1)])
def test_validate__of_a_case_prints_its_rows_and_writes_its_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys, figures: tuple[float, ...], status: int
) -> None:
    rows = [relative("pressure (GPa)", expected=1.0, got=figure, within=0.5) for figure in figures]
    case = replace(validation.load("taylor-bar"), rows=lambda level, cubes: rows, pictures=lambda cubes: ())
    monkeypatch.setattr(validation, "load", lambda name: case)
    monkeypatch.setattr(validation_commands, "_computed", lambda *_: [(case, {})])
    assert run("validate", "taylor-bar", "--out", tmp_path) == status
    *lines, counts, page = capsys.readouterr().out.splitlines()
    assert [line.split(" | ")[0] for line in lines] == ["taylor-bar"] * 2
    assert counts == f"{2 - status} passed, {status} failed, 0 reported"
    assert page == f"page: {tmp_path / 'index.html'}"
    text = (tmp_path / "index.html").read_text()
    assert counts in text
    assert f"got {figures[1]:g}" in lines[1]
    assert f"{figures[1]:g}" in re.findall(r"<td[^>]*>([^<]*)</td>", text)


def test_validate__refuses_what_it_does_not_have(tmp_path: Path, capsys: Capsys) -> None:
    assert run("validate", "table-3-5", "--out", tmp_path) == 2
    assert "did you mean 'table-3-" in capsys.readouterr().err
    assert run("validate", "--level", "best", "--out", tmp_path) == 2
    assert "'thesis'" in capsys.readouterr().err
