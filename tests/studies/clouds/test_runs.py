"""A run of a debris cloud: what is molten at its end."""

import json

from studies.runs.execution import heated_fractions, observer_of
from studies.runs.remeasure import load_state
from tests.studies.runs.solved import asked, solved


def test_result__has_the_molten_share_of_its_final_state() -> None:
    folder = solved("debris_cloud")
    stated = json.loads((folder / "result.json").read_text())["numbers"]["molten_mass_fraction"]
    final = load_state(folder / "state.npz")
    fractions = heated_fractions(observer_of(asked("debris_cloud")).setting.problem, final)
    assert stated == fractions["molten_mass_fraction"]
    assert stated > 0.0
