"""``whipple demo``."""

import pytest

from service.demo import commands
from tests.service.support.command import run

Capsys = pytest.CaptureFixture[str]


def test_warm__that_fails_says_why(monkeypatch: pytest.MonkeyPatch, capsys: Capsys) -> None:
    monkeypatch.setattr(commands, "KERNELS", ("-c", "raise SystemExit('no compiler')"))
    assert run("demo", "--warm") == 1
    assert "no compiler" in capsys.readouterr().err
