"""docs/decks.md: its commands do what the page says, on its own deck."""

import re
import shlex
from pathlib import Path

import pytest

from studies.decks.macros import KINDS, REFUSED
from studies.sweeps.document import read_sweep_file
from studies.sweeps.sweep import Sweep
from tests.service.support.command import run

TEXT = (Path(__file__).parents[3] / "docs" / "decks.md").read_text(encoding="utf-8")
[DECK] = re.findall(r"<<'END'\n(.*?)END\n", TEXT, re.DOTALL)
COMMANDS = [
    shlex.split(line) for block in re.findall(r"```sh\n(whipple.*?)```", TEXT, re.DOTALL) for line in block.splitlines()
]
# What they compute is computed by the tests of sweeps.
COMPUTING = {"--run", "sweep", "submit"}


def test_commands__of_the_page_read_its_deck(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("bar.mpm").write_text(DECK)
    for _, *words in COMMANDS:
        if not COMPUTING & set(words):
            assert run(*words) == 0
    printed = capsys.readouterr().out
    assert re.search(r"nodes +2025 *\n", printed)
    assert re.search(r"particles +640 *\n", printed)
    [point] = Sweep.parse(read_sweep_file(Path("bar.yaml"))).runs()
    assert point.run.parameters["deck"] == DECK
    assert point.run.parameters["contact"] == "bardenhagen"


def test_page__tells_of_every_material_and_refusal() -> None:
    for name in (*KINDS, *REFUSED):
        assert f"`{name}`" in TEXT, name
