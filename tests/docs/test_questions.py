"""The pages of questions show what their commands print."""

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from docs.pages import DOCS, read_json, simulated_shields
from studies import laws
from studies.answers.answer import answers
from studies.answers.question import read_question
from studies.shields.shots import joined
from studies.shields.shots.drawn import SimulationKind, failures_found
from studies.shields.shots.judged import equations, judge
from studies.shields.shots.table import published
from studies.sweeps.document import read_yaml
from tests.claims.marked import claimed
from tests.claims.rows import equal

BLOCK = re.compile(r"```(\w+)\n(.*?)```", re.DOTALL)
SHIELD = (DOCS / "does-my-shield-hold.md").read_text(encoding="utf-8")
RUNS = read_json(simulated_shields.STORED)["runs"]


@pytest.mark.parametrize(
    "name", claimed(["which-law", "does-my-shield-hold", "worked-design"], ["which-law"], "docs", "questions")
)
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


def test_page_of_the_shield__has_the_counts_of_published_and_simulated_shots() -> None:
    text, shots = " ".join(SHIELD.split()), published().shots
    careful = judge(laws.load("whipple_srl"), shots)
    best = max(judge(law, shots).right.value for law in equations())
    assert f"{len(shots)} published shots" in text
    assert f"{100.0 * careful.unsafe.value:.1f} % of the shots were said to hold and did not" in text
    assert f"{100.0 * careful.careful.value:.0f} % were said to fail and held" in text
    assert f"The best equation is right in {100.0 * best:.0f} % of the shots" in text
    first = [run for run in RUNS if run["grid"] == simulated_shields.GRIDS[0]]
    for failure, said in (("void-growth", "was right about"), ("none", "the default of shields, it was right about")):
        told = [(shot.outcome, says) for shot, says in simulated_shields.outcomes(first, [failure])]
        right = simulated_shields.rated(told)[0].right
        assert f"{said} {right.count} of {right.of}" in text


def test_readme__has_the_first_line_of_its_answer() -> None:
    text = (DOCS.parent / "README.md").read_text(encoding="utf-8")
    shield = text.partition("cat > shield.yaml <<'END'\n")[2].partition("END")[0]
    [answer] = answers(read_question(read_yaml(shield, "shield.yaml")))
    assert f"It begins `{answer.headline()}`" in text


@pytest.mark.claim("mend", "shield-pages")
def test_pages_about_simulated_walls__begin_with_how_many_failures_they_find(compared: Callable[..., None]) -> None:
    """What a simulated wall that holds is worth stands first, and what all runs together decide after it."""
    found = failures_found("void-growth", 3e3)
    assert found is not None
    for page, said in (
        (SHIELD, f"of {found.of} published walls that were perforated"),
        (simulated_shields.pages()["simulated-shields.md"], f"Of the {found.of} drawn walls that were perforated"),
    ):
        first = page.split("\n\n")[1].replace("\n", " ")
        compared(
            equal("begins with the failures", expected=True, got=said in first),
            equal("says how many", expected=True, got=f"found {found.count}" in first),
        )
    kinds = simulated_shields.simulations(RUNS)
    gained, within = joined.validated(kinds[SimulationKind(("void-growth",), "one")]).gained()
    compared(equal("gain of void-growth", expected=True, got=f"falls by {gained:.3f} ± {within:.3f}" in SHIELD))
    decided = [shot for shot, outcome in simulated_shields.simulation(RUNS) if outcome != "open"]
    shares = {law.name: judge(law, decided).right for law in equations()}
    right = [name for name, share in shares.items() if share.count == share.of == len(decided)]
    expected = ["whipple_jsc", "whipple_nno", "whipple_reimerdes"]
    compared(equal(f"right about all {len(decided)} that all runs decide", expected=expected, got=right))
