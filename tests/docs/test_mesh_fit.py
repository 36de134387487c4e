"""The fit of mesh errors, on invented series whose error is known."""

import math
from dataclasses import replace

import numpy as np
import pytest

from docs.mesh_fit import GROUPS, HELD, Shot, Value, fit, left_out, share_held, sizes, wider_until_held
from studies.convergence.experience import FREEDOM, MeshGrid, MeshModel, bias_terms, scale_terms

TRUE = MeshModel(
    {"through": 1.0, "across": 0.3, "through strength": 0.4, "across strength": -0.1},
    {"always": 0.003, "through": 0.05, "across": 0.05},
)
METALS = 4
SERIES = 60


def invented(model: MeshModel = TRUE, *, seed: int = 1, wider: float = 1.0) -> list[Shot]:
    """Series on five grids whose values are off as a model says."""
    chance = np.random.default_rng(seed)
    shots = []
    for number in range(SERIES):
        thickness, speed = 0.05 * 20.0 ** chance.random(), chance.uniform(1.5e3, 8e3)
        values = []
        for across in (20.0, 28.0, 40.0, 56.0, 80.0):
            grid = MeshGrid("hole_diameter", across, across * thickness, speed, 3e8 * 2.0 ** chance.uniform(-1.0, 1.0))
            if grid.through > 2.0:
                error = model.error_on(grid)
                noise = wider * error.scale * chance.standard_t(FREEDOM)
                values.append(Value(grid, 0.02 * math.exp(error.bias + noise)))
        if len(values) > 1:
            shots.append(Shot(number, "plate", f"metal {number % METALS}", tuple(values)))
    return shots


def test_fit__finds_terms_and_scale_of_invented_series() -> None:
    model = fit(invented())
    assert model.bias.keys() == TRUE.bias.keys()
    for cells in (20.0, 40.0):
        for strength in (2e8, 5e8):
            grid = MeshGrid("hole_diameter", cells, 0.25 * cells, 4e3, strength)
            found, true = model.error_on(grid), TRUE.error_on(grid)
            assert found.bias == pytest.approx(true.bias, abs=true.scale)
            assert found.scale == pytest.approx(true.scale, rel=0.3)
    assert bias_terms(grid).keys() >= model.bias.keys()
    assert scale_terms(grid).keys() == model.scale.keys()


@pytest.mark.parametrize(("times", "expected"), [(1.0, True), (4.0 / 3.0, False)])
def test_coverage__holds_of_what_was_left_out_and_falls_with_other_coefficients(times: float, expected: bool) -> None:
    tested = []
    for inside, outside in left_out(invented(), GROUPS["metal"]):
        model = fit(inside)
        tested.append((replace(model, bias={name: times * each for name, each in model.bias.items()}), outside))
    found = sizes(tested)
    assert (HELD[0] <= share_held(found) <= HELD[1]) is expected
    wider = wider_until_held([found])
    assert (wider > 1.0) is not expected
    assert share_held(found, wider) >= HELD[0]
