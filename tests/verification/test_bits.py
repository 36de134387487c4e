"""The case about bits is large enough for what it says about threads."""

from typing import Any

import pytest

from solver.simulation import Simulation, start
from studies.verification import DEFAULT, bits

THREADS = 2


def mapped_impact(geometry: str, **parameters: object) -> Simulation:
    """The impact with its particles mapped to the nodes, as at the beginning of a step."""
    problem = bits.impact(geometry, DEFAULT, **parameters)
    simulation = start(problem, threads=THREADS, shares=bits.SHARES)
    for field in fields_of(simulation):
        stepper: Any = simulation.stepper
        stepper._scatter(field, simulation.partition)
    return simulation


def fields_of(simulation: Simulation) -> Any:
    """The velocity fields of the grid."""
    stepper: Any = simulation.stepper
    return stepper.fields


@pytest.mark.parametrize("geometry", bits.CELLS)
def test_bits__has_particles_of_each_body_in_more_shares_than_threads(geometry: str) -> None:
    shares = mapped_impact(geometry).partition.shares
    assert len(shares) > THREADS
    assert (shares[:, :, 1] > shares[:, :, 0]).all()


@pytest.mark.parametrize("geometry", bits.CELLS)
def test_bits__has_nodes_for_each_thread(geometry: str) -> None:
    simulation = mapped_impact(geometry)
    (field,) = fields_of(simulation)
    assert len(simulation.pool.ranges(field.blocks.size)) == THREADS


@pytest.mark.parametrize("geometry", bits.CELLS)
def test_bits__has_nodes_that_several_shares_add_to(geometry: str) -> None:
    """There the order of the sums decides the bits."""
    (field,) = fields_of(mapped_impact(geometry))
    assert (field.touched[1] & field.touched[2]).any()


@pytest.mark.parametrize("name", bits.ADDITIONS)
def test_bits__additions_have_work_for_each_thread_in_each_field(name: str) -> None:
    simulation = mapped_impact("axisymmetric", **bits.ADDITIONS[name].parameters)
    for field in fields_of(simulation):
        shares = simulation.partition.shares[:, field.bodies]
        assert (shares[:, :, 1] > shares[:, :, 0]).all()
        assert len(simulation.pool.ranges(field.blocks.size)) == THREADS
        assert (field.touched[1] & field.touched[2]).any()
