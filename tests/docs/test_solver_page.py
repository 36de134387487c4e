"""docs/solver.md runs from top to bottom, and its numbers are those of the exact shock."""

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "solver.md"


@pytest.mark.claim("docs", "solver-page", minutes=0.2)
def test_solver_page__runs_and_meets_the_exact_shock(capsys: pytest.CaptureFixture[str]) -> None:
    """The blocks are one program; its assertions compare with the exact answer."""
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    exec(compile("\n".join(blocks), str(PAGE), "exec"), {})
    assert capsys.readouterr().out.count("exact") == 3
