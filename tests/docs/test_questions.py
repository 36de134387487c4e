"""The pages of questions show what their commands print."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from docs.pages import DOCS, read_json, simulated_shields
from studies import laws
from studies.observations.shields.judged import equations, judge
from studies.observations.shields.shots import published
from tests.claims.marked import claimed

BLOCK = re.compile(r"```(\w+)\n(.*?)```", re.DOTALL)


@pytest.mark.parametrize("name", claimed(["which-law", "does-my-shield-hold"], ["which-law"], "docs", "questions"))
def test_page__shows_the_output_of_its_commands(name: str, tmp_path: Path) -> None:
    """Each line that is shown is the begin of one that the block before printed."""
    program = tmp_path / "bin" / "whipple"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m service "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    environment = {**os.environ, "PYTHONPATH": str(DOCS.parent), "PATH": f"{program.parent}:{os.environ['PATH']}"}
    output: list[str] = []
    shown = 0
    for language, text in BLOCK.findall((DOCS / f"{name}.md").read_text(encoding="utf-8")):
        if language == "sh":
            done = subprocess.run(
                ["sh", "-c", text], cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
            )
            output = done.stdout.splitlines()
        elif language == "text":
            for line in filter(None, text.splitlines()):
                assert any(printed.startswith(line) for printed in output), line
                shown += 1
    assert shown > 3


def test_page_of_the_shield__has_the_counts_of_the_published_shots() -> None:
    text = " ".join((DOCS / "does-my-shield-hold.md").read_text(encoding="utf-8").split())
    shots = published().shots
    careful = judge(laws.load("whipple_srl"), shots, "all")
    best = max(judge(law, shots, "all").right.value for law in equations())
    assert f"{len(shots)} published shots" in text
    assert f"{100.0 * careful.unsafe.value:.1f} % of the shots were said to hold and did not" in text
    assert f"{100.0 * careful.careful.value:.0f} % were said to fail and held" in text
    assert f"The best equation is right in {100.0 * best:.0f} % of the shots" in text


def test_page_of_the_shield__has_the_counts_of_the_simulated_shots() -> None:
    text = " ".join((DOCS / "does-my-shield-hold.md").read_text(encoding="utf-8").split())
    runs = read_json(simulated_shields.STORED)["runs"]
    first = [run for run in runs if run["grid"] == simulated_shields.GRIDS[0]]
    for failure, said in (("void-growth", "was right about"), ("none", "the default of shields, it was right about")):
        told = [(shot.outcome, says) for shot, says in simulated_shields.outcomes(first, [failure])]
        right = simulated_shields.rated(told)[0].right
        assert f"{said} {right.count} of {right.of}" in text
