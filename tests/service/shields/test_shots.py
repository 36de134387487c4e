"""``whipple shots``: the nearest to a shield, and what is refused."""

import pytest

from studies.shields.answered import TARGET
from tests.service.support.command import run


@pytest.mark.parametrize(
    ("arguments", "field"),
    [(("shots", "--own", "none.csv"), "--own"), (("shots", "--where", "obliquty=3"), "obliquity")],
)
def test_arguments__that_name_nothing_are_refused(
    arguments: tuple[str, ...], field: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(*arguments) == 2
    assert field in capsys.readouterr().err


def test_shots__nearest_to_a_shield_are_counted_with_their_outcome(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("shots", "--at", str(TARGET.example), "--count", 3) == 0
    said, _, *rows = capsys.readouterr().out.splitlines()
    failed = sum("perforated" in row for row in rows)
    assert (said, len(rows)) == (f"3 of 804 shots; the wall failed in {failed}", 3)
