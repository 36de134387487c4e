"""``whipple laws --at`` and ``whipple shots``: what cannot be read or written is refused in words."""

from pathlib import Path

import pytest

from studies.answers import examples
from tests.service.support.command import run


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        (("shots", "--own", "none.csv"), "--own"),
        (("shots", "--where", "obliquty=3"), "obliquity"),
        (("laws", "--at", examples()[0], "--out", "nowhere/shield.html"), "--out"),
        (("laws", "--at", examples()[0], "--out", "shield.txt"), "--out"),
    ],
)
def test_arguments__that_name_nothing_are_refused(
    arguments: tuple[str | Path, ...],
    field: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(*arguments) == 2
    assert field in capsys.readouterr().err


def test_shots__nearest_to_a_shield_are_counted_with_their_outcome(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("shots", "--at", examples()[0], "--count", 3) == 0
    said, _, *rows = capsys.readouterr().out.splitlines()
    failed = sum("perforated" in row for row in rows)
    assert (said, len(rows)) == (f"3 of 804 shots; the wall failed in {failed}", 3)
