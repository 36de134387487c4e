"""The method of a thin plate: a parameter that changes the sums, what it refuses, and identities."""

from typing import Any

import pytest

from solver.problem import ArtificialViscosity, Smoothing
from solver.sph.smoothing import CubicSpline
from studies.runs.run import estimate
from studies.values.errors import InvalidInput
from tests.contracts.test_scenarios import asked, built

SPH = {"geometry": "quarter", "method": "sph"}


def test_sph__smooths_the_particles_of_the_grid_and_follows_debris() -> None:
    one, other = built(asked("thin_plate", **SPH)), built(asked("thin_plate", geometry="quarter"))
    assert one.problem.smoothing is not None
    assert other.problem.smoothing is None
    assert one.problem.retirement is None
    for mine, theirs in zip(one.problem.bodies, other.problem.bodies, strict=True):
        assert (mine.position == theirs.position).all()


def test_sph__has_the_viscosity_of_pairs_unless_it_is_stated() -> None:
    made = built(asked("thin_plate", **SPH)).problem.smoothing
    assert made == Smoothing(CubicSpline())
    stated = built(asked("thin_plate", **SPH, viscosity_linear=0.1)).problem.smoothing
    assert stated is not None
    assert stated.viscosity == ArtificialViscosity(0.1, 2.0)


def test_sph__is_part_of_the_identity_and_mpm_is_not() -> None:
    runs = [asked("thin_plate", geometry="quarter", **more) for more in ({}, {"method": "mpm"})]
    assert runs[0].id == runs[1].id != asked("thin_plate", **SPH).id
    assert estimate(asked("thin_plate", **SPH)).core_seconds > estimate(runs[0]).core_seconds


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"geometry": "axisymmetric"}, "geometry"),
        ({"edges": "absorbing"}, "edges"),
        ({"contact": "bardenhagen"}, "contact"),
        ({"scheme": "usf"}, "scheme"),
        ({"damping_rate": 1e6}, "damping_rate"),
        ({"debris": "retire"}, "debris"),
    ],
)
def test_sph__refuses_by_name_what_it_does_not_compute(changes: dict[str, Any], name: str) -> None:
    with pytest.raises(InvalidInput, match=rf"{name}(.|\n)*method sph"):
        asked("thin_plate", **{**SPH, **changes})
