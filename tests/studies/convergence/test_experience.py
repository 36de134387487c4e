"""The mesh error from experience: what a model says of a grid, where it is silent, and what it makes of several."""

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import pytest

from solver import PHYSICS_VERSION
from studies.convergence import experience
from studies.convergence.experience import (
    NINETY_FIVE,
    Domain,
    Experience,
    MeshError,
    MeshGrid,
    MeshModel,
    cells_for,
    combined,
    mesh_error,
    stored,
    why_unknown,
)

GRID = MeshGrid("hole_diameter", across=20.0, through=5.0, speed=4e3, strength=3e8)
MODEL = MeshModel({"through": 1.0, "across": 0.2}, {"always": 0.003, "through": 0.1, "across": 0.04}, in_space=2.0)
DOMAIN = Domain(
    across=(10.0, 160.0),
    through=(2.0, 64.0),
    speed=(1.5e3, 8e3),
    strength=(1e7, 2e9),
    density_ratio=(0.1, 7.0),
    length=(0.5, 2.0),
    thickness=(0.05, 1.0),
    obliquity=(0.0, 1.0),
)
KNOWN: Mapping[str, Experience] = MappingProxyType({"hole_diameter": Experience(MODEL, DOMAIN)})


@pytest.fixture(autouse=True)
def known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(experience, "stored", lambda: KNOWN)


def test_mesh_error__is_a_bias_and_a_scale_that_fall_with_the_cells() -> None:
    error = mesh_error(GRID)
    assert error is not None
    assert error.bias == pytest.approx(1.0 / 25.0 + 0.2 / 20.0)
    assert error.scale == pytest.approx(math.hypot(0.003, 0.1 / 25.0, 0.04 / 20.0))
    assert error.corrected(1.0) == pytest.approx(math.exp(-0.05))
    assert error.bar == NINETY_FIVE * error.scale
    finer = mesh_error(GRID.refined(40.0))
    assert finer is not None
    assert finer.bias == pytest.approx(1.0 / 100.0 + 0.2 / 40.0)
    assert mesh_error(GRID.refined(400.0)) is not None  # finer than any of the ensemble
    in_space = mesh_error(replace(GRID, in_space=True))
    assert in_space is not None
    assert in_space.scale == 2.0 * error.scale


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"quantity": "crater_depth"}, "no such quantity"),
        ({"speed": 9e3}, "speed 9e+03 outside of 1.5e+03 to 8e+03"),
        ({"across": 8.0}, "across 8 outside of 10 to 160"),
        ({"through": 0.9}, "thickness 0.045 outside of 0.05 to 1"),
        ({"length": 3.0}, "length 3 outside of 0.5 to 2"),
    ],
)
def test_mesh_error__is_unknown_outside_of_its_domain(changes: dict[str, float], why: str) -> None:
    outside = replace(GRID, **changes)  # type: ignore[arg-type]
    assert mesh_error(outside) is None
    assert why in why_unknown(outside)


def test_stored_experience__counts_for_one_version_of_the_physics(monkeypatch: pytest.MonkeyPatch) -> None:
    assert stored()
    stored.cache_clear()
    monkeypatch.setattr(experience, "PHYSICS_VERSION", PHYSICS_VERSION + 1)
    assert stored() == {}
    stored.cache_clear()


def test_cells_for__are_the_fewest_that_hold_an_accuracy() -> None:
    cells = cells_for(0.03, [GRID])
    assert cells is not None
    bars = [error.bar for each in (cells - 1.0, cells) if (error := mesh_error(GRID.refined(each)))]
    assert bars[-1] <= 0.03 < bars[0]
    assert cells_for(0.005, [GRID]) is None  # below what is left on any grid
    assert cells_for(0.03, [GRID, replace(GRID, quantity="crater_depth")]) is None


def test_several_grids__narrow_the_bar_or_disagree() -> None:
    coarse, fine = MeshError(0.1, 0.02), MeshError(0.02, 0.01)
    agreeing = combined([([math.exp(0.02)], fine), ([math.exp(0.1)], coarse)])
    assert agreeing.value == pytest.approx(1.0)
    assert agreeing.bar <= fine.bar
    assert not agreeing.disagree
    apart = combined([([math.exp(0.02)], fine), ([1.3 * math.exp(0.1)], coarse)])
    assert apart.disagree
    assert apart.bar >= 1.3 - apart.value


@pytest.mark.parametrize(("half", "disagree"), [(0.03, False), (0.05, True)])
def test_offsets__of_one_grid_disagree_where_they_scatter_more_than_it_does(half: float, disagree: bool) -> None:
    """Beyond 4.03 scales, the 99 % of Student's distribution, from their mean."""
    point = combined([([1.0 - half, 1.0 + half], MeshError(0.0, 0.01))])
    assert point.disagree == disagree
    assert (point.bar >= half) == disagree
