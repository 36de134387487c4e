"""``whipple laws``: what cannot be written is refused in words."""

from pathlib import Path

import pytest

from tests.service.support.command import run

SHOT = ("--speed", "6 km/s", "--diameter", "5 mm", "--projectile", "al-2017-t4", "--target", "al-6061-t6")


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        (("--out", "nowhere/laws.html"), "--out"),
        (("--out", "laws.txt"), "--out"),
        (("--speed", "60 km/s"), "speed"),
        (("--target", "cheese"), "target"),
    ],
)
def test_arguments__that_name_nothing_are_refused(
    arguments: tuple[str, ...],
    field: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("laws", *SHOT, *arguments) == 2
    assert field in capsys.readouterr().err
