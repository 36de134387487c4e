"""docs/own-shots.md: its tables are read as they stand, and it tells of every column."""

import re
from pathlib import Path

from studies.observations import COLUMNS, OWN_COLUMNS, read_observations
from studies.sweeps.reading import vocabulary

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "docs" / "own-shots.csv"
TEXT = (ROOT / "docs" / "own-shots.md").read_text(encoding="utf-8")
HOLES = vocabulary("thin_plate", {}, {})


def test_own_shots__tables_of_the_page_are_the_example() -> None:
    wide, long = re.findall(r"```csv\n(.*?)```", TEXT, re.DOTALL)
    assert wide == EXAMPLE.read_text(encoding="utf-8")
    sizes = [
        [(shot.quantity, shot.value, shot.uncertainty, shot.parameters) for shot in shots]
        for shots in (read_observations(wide, HOLES), read_observations(long, HOLES))
    ]
    assert sizes[0] == sizes[1]


def test_own_shots__tells_of_every_column() -> None:
    for name in OWN_COLUMNS:
        assert f"| `{name}` |" in TEXT, name
    assert COLUMNS.endswith("docs/own-shots.md")
