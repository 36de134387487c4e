"""The case about bits is large enough for what it says about threads."""

import pytest

from solver.simulation import Simulation, start
from solver.stress import CHUNK
from studies.verification import DEFAULT, bits

THREADS = 2


def sorted_impact(geometry: str, **parameters: object) -> Simulation:
    """The impact with its particles sorted into slabs, as at the beginning of a step."""
    simulation = start(bits.impact(geometry, DEFAULT, **parameters), threads=THREADS)
    simulation.stepper._sort(simulation.stage)
    return simulation


@pytest.mark.parametrize("geometry", bits.CELLS)
def test_bits__has_particles_of_a_body_for_each_thread(geometry: str) -> None:
    simulation = sorted_impact(geometry)
    pieces = [
        len(simulation.team.ranges(end - begin, CHUNK)) for begin, end in simulation.stage.ranges
    ]
    assert max(pieces) == THREADS


@pytest.mark.parametrize("geometry", bits.CELLS)
def test_bits__has_slabs_and_nodes_for_each_thread(geometry: str) -> None:
    stepper = sorted_impact(geometry).stepper
    assert len(stepper.node_ranges) == THREADS
    for shares in stepper._shares(stepper.fields[0]):
        assert len(shares) == THREADS


@pytest.mark.parametrize("name", bits.ADDITIONS)
def test_bits__additions_have_slabs_for_each_thread_in_each_field(name: str) -> None:
    stepper = sorted_impact("axisymmetric", **bits.ADDITIONS[name].parameters).stepper
    for field in stepper.fields:
        assert [len(shares) for shares in stepper._shares(field)] == [THREADS, THREADS]
