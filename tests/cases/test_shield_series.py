"""Two published series of shots on shields that bracket a limit: the outcome of each shot on three grids."""

from collections.abc import Callable
from pathlib import Path

import pytest

from docs.pages.shield_series import THREE, runs_of, series, told
from studies.cases.rows import Row, equal, reported


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("piekutowski", marks=pytest.mark.claim("shields", "piekutowski", minutes=10.0)),
        pytest.param("reimerdes", marks=pytest.mark.claim("shields", "reimerdes", minutes=65.0)),
    ],
)
def test_simulation__tells_the_outcome_of_each_shot(name: str, tmp_path: Path, compared: Callable[[Row], None]) -> None:
    """A series of shots around the limit of a shield has its outcomes on three grids.

    That of Piekutowski and Poorman has not: all walls hold on all grids, also the four that were perforated (4.77 to
    5.81 mm). No matter breaks there, as 2219-T87 has no published fracture strains: the deepest crater is 4 to 21 % of
    the wall, which bulges by 1.5 to 5.6 mm.
    """
    each = series()[name]
    for shot in each.shots:
        runs = list(runs_of(shot, each.failures, tmp_path))
        for run in runs:
            if run["perforated"] is not None:
                where = f"{1e3 * shot.projectile_diameter:g} mm, {run['failure']}, {run['cells']:g} cells"
                compared(reported(f"{where}: perforated", run["perforated"]))
        assert len(runs) == len(THREE) * len(each.failures)
        says, why = told(runs)
        behind = f"{1e3 * shot.projectile_diameter:g} mm behind {1e3 * shot.bumper_thickness:.3g} mm"
        compared(equal(f"{behind}: wall{f' ({why})' if why else ''}", expected=shot.outcome, got=says))
