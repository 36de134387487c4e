"""Holes and craters under refinement: what three grids say of a fourth, twice as fine.

Both published holes, the one in aluminium as the example ``aluminium`` has it; the published crater of one copper, and
of the two in aluminium the harder, whose crater is the smaller: the grid tells it worst. The size of a block is a part
of the shot, the same on each grid.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from studies.cubes.points import Refined, refined
from studies.quantities.display import display_of
from studies.scenarios import load
from tests.cases.cubes import computed
from tests.claims.rows import Row, absolute, at_most

GRIDS, OFFSETS, FINER = [16, 24, 32], 3, 64  # cells across the projectile
# Share of the value: the difference to which a report calls a law close (docs/report.md). A wider bar holds anything.
WIDEST = 0.10


def _sphere(projectile: str, target: str, diameter: float, **more: Any) -> dict[str, Any]:
    return {"projectile": projectile, "target": target, "projectile_diameter": f"{diameter:g} mm", **more}


def _block(metal: str, diameter: float) -> dict[str, Any]:
    size = {"target_depth": f"{8.0 * diameter:g} mm", "target_radius": f"{7.5 * diameter:g} mm"}
    return _sphere(metal, metal, diameter, edges="absorbing", particles_per_cell=2, **size)


SHOTS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "hole-al-2024-t3": ("thin_plate", "6.18 km/s", _sphere("al-2024-t3", "al-2024-t3", 10.0, plate_thickness="4 mm")),
    "hole-copper": ("thin_plate", "5.75 km/s", _sphere("al-2024-t3", "copper-ofhc", 10.0, plate_thickness="1.5 mm")),
    "crater-al-6061-t6": ("thick_plate", "7 km/s", _block("al-6061-t6", 6.35)),
    "crater-copper": ("thick_plate", "6 km/s", _block("copper-ofhc", 4.746)),
}


@pytest.mark.claim("breaking", "holes-and-craters-converge", minutes=70.0)
@pytest.mark.parametrize("shot", SHOTS)
def test_holes_and_craters__converge_to_the_value_of_a_finer_grid(
    shot: str, compared: Callable[[Row], None], tmp_path: Path
) -> None:
    """The bar of a hole or crater on 16, 24 and 32 cells, three offsets each, holds the value on 64 cells."""
    scenario, speed, fixed = SHOTS[shot]
    sweep = {"title": shot, "scenario": scenario, "fixed": fixed, "axes": {"speed": [speed]}, "model_part": "none"}
    grids = computed({**sweep, "resolution": GRIDS, "offsets": OFFSETS}, tmp_path)
    finer = computed({**sweep, "resolution": FINER}, tmp_path)
    for name in load(scenario).settles:
        [of_grids] = refined(grids, name)
        got = finer[name].item()
        _compare(f"{shot}: {name} (mm)", of_grids, got, display_of(grids[name].attrs["units"]).factor, compared)


def _compare(where: str, grids: Refined, got: float, factor: float, compared: Callable[[Row], None]) -> None:
    """Rows of a quantity on three grids (SI), and of its value on the finer one."""
    converged = grids.converged
    value, bar = converged.value * factor, converged.uncertainty * factor
    levels = ", ".join(f"{factor * level.value:.5g} ± {factor * level.scatter:.2g}" for level in converged.levels)
    claim = f"{where}: {converged.verdict}; finest first {levels}; {converged.reason}"
    compared(Row(claim, "", value, None, order=converged.order, bar=bar))
    compared(at_most(f"{where}: bar, share of the value", limit=WIDEST, got=bar / value))
    claim = f"{where}: {FINER} cells within the bar of {GRIDS[-1]}"
    compared(absolute(claim, expected=value, got=factor * got, within=bar))
