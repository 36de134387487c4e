"""docs/accuracy.md and docs/limits.md state the numbers of the stored results."""

import json

from docs.pages import DOCS, counted, read_json, shots, simulated_shields, validation, verification
from studies.convergence import experience
from studies.observations.compared import FEWEST, compared_shots

TEXT = " ".join((DOCS / "accuracy.md").read_text(encoding="utf-8").split())
ROWS = [line.split(" | ") for line in (DOCS / "accuracy.md").read_text(encoding="utf-8").splitlines() if "|" in line]


def number(what: str) -> str:
    """The number of a row of the table, by the begin of its first cell."""
    [value] = [cells[1] for cells in ROWS if cells[0].startswith(f"| {what}")]
    return value


def test_accuracy__has_the_bias_of_the_published_shots() -> None:
    for table, quantity, name in (
        ("Taylor bars, OFHC copper", "Length of the bar", "length of Taylor bars of OFHC copper"),
        ("Taylor bars, aluminium 6061-T6", "Length of the bar", "of aluminium 6061-T6"),
        ("Taylor bars, steel 4340", "Length of the bar", "of steel 4340"),
        ("Craters, copper and aluminium", "Crater depth", "depth of craters"),
        ("Craters, copper and aluminium", "Crater diameter", "diameter of these craters"),
        ("Holes, aluminium on aluminium and on copper", "Hole diameter", "hole in thin copper"),
    ):
        [rows] = [
            rows for title, of, rows in shots.grouped(shots.stored()["shots"]) if (title, of) == (table, quantity)
        ]
        count, bias, scatter = shots.cells(rows)
        if int(count) >= FEWEST:
            assert number(name) == f"{bias} %"
            assert f"[{count} shots]" in TEXT
            assert f"scatter {scatter} %" in TEXT
        else:
            ratios = sorted(ratio for ratio in map(shots.ratio, rows) if ratio == ratio)
            assert number(name) == " to ".join(dict.fromkeys(map(shots.percent, (ratios[0], ratios[-1])))) + " %"


def test_accuracy__has_the_gates_that_hold() -> None:
    published = read_json(validation.STORED)["cases"]
    finest = [row for name, kept in published.items() if "/" not in name for row in kept["rows"]]
    assert number("gates of published problems") == counted(finest)
    exact = read_json(verification.STORED)["cases"]
    assert number("gates of problems with an exact answer") == counted([row for rows in exact.values() for row in rows])
    missed = [name for name, rows in exact.items() if any(row.get("passed") is False for row in rows)]
    assert missed == ["sph-elastic-waves"]


def test_accuracy__has_the_walls_that_are_told_right() -> None:
    first = [run for run in read_json(simulated_shields.STORED)["runs"] if run["grid"] == simulated_shields.GRIDS[0]]
    told = simulated_shields.outcomes(first, [simulated_shields.OF_PLATES])
    judged, _ = simulated_shields.rated([(shot.outcome, says) for shot, says in told])
    assert number("walls of shields") == f"{judged.right.count} of {judged.right.of} right"
    assert judged.careful.count == 0


def test_accuracy__has_the_mesh_error_of_a_hole() -> None:
    tested = json.loads(experience.STORED.read_text(encoding="utf-8"))["quantities"]["hole_diameter"]["tested"]
    assert number("mesh error of a hole") == f"bar of {100.0 * tested['widest_bar']:.1f} % at most"
    share, count = tested["covered"]["metal"]
    assert f"{100.0 * share:.0f} % of {count} differences inside" in TEXT


def test_limits__say_that_holes_and_craters_have_too_few_shots() -> None:
    assert not [group for group in compared_shots() if group.quantity.startswith(("hole", "crater")) and group.bias]
    limits = " ".join((DOCS / "limits.md").read_text(encoding="utf-8").split())
    assert "Of holes and craters there are fewer, too few for an interval" in limits
