"""The table of published shots is that of today."""

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from docs.pages import shots
from solver import PHYSICS_VERSION
from studies import measurements
from tests.claims.rows import Row, equal, relative

# An estimate: processors compute other bits, which matter that breaks up makes larger.
SAME = 2e-3
CHOSEN = 2  # shots of each table: the shortest bars, and both holes


def key(row: Mapping) -> tuple:
    return (row["table"], row["quantity"], row["observed"], *sorted(row["parameters"].items()))


@pytest.mark.claim("shots", "shots", minutes=3.0)
def test_shots__has_every_published_shot_as_it_is_computed_now(tmp_path: Path, compared: Callable[[Row], None]) -> None:
    """The page of shots has every published shot that ships, and what the default recipe gives for it now."""
    document = shots.stored()
    compared(equal("physics version", expected=PHYSICS_VERSION, got=document["physics_version"]))
    versions = {name: measurements.load(name).version for name in document["measurements"]}
    compared(equal("versions of the measurements", expected=versions, got=document["measurements"]))
    kept = {key(row): row["simulated"] for row in document["shots"]}
    count = sum(len(shots.published(name)) for name in shots.TABLES)
    compared(equal("shots in the table", expected=count, got=len(kept)))
    for name in shots.TABLES:
        if name == "craters":
            continue  # two minutes; the demo has it
        chosen = sorted(shots.published(name), key=lambda shot: float(shot.parameters.get("bar_length") or 0.0))
        for row in shots.computed(name, tmp_path / name, chosen[:CHOSEN]):
            where = f"{name}, {row['parameters']['speed']:g} m/s, {row['quantity']} (mm)"
            stored, now = kept[key(row)], row["simulated"]
            if stored is None or now is None:
                compared(equal(where, expected=stored, got=now))
            else:
                compared(relative(where, expected=1e3 * stored, got=1e3 * now, within=SAME))
