"""The case about bits is large enough for what it says about threads."""

from typing import Any

import pytest

from solver.simulation import start
from studies.cases.verification import DEFAULT, bits

THREADS = 2


@pytest.mark.parametrize(
    ("geometry", "parameters"),
    [
        *((geometry, {}) for geometry in bits.CELLS),
        *(("axisymmetric", addition.parameters) for addition in bits.ADDITIONS.values()),
    ],
)
def test_bits__has_work_for_each_thread_in_each_field(geometry: str, parameters: dict[str, Any]) -> None:
    """The impact with its particles mapped to the nodes, as at the beginning of a step."""
    simulation = start(bits.impact(geometry, DEFAULT, **parameters), threads=THREADS, shares=bits.SHARES)
    stepper: Any = simulation.stepper
    assert len(simulation.partition.shares) > THREADS
    for field in stepper.fields:
        stepper._scatter(field, simulation.partition)
        shares = simulation.partition.shares[:, field.bodies]
        assert (shares[:, :, 1] > shares[:, :, 0]).all()
        assert len(simulation.pool.ranges(field.blocks.size)) == THREADS
        # Nodes that several shares add to: there the order of the sums decides the bits.
        assert (field.touched[1] & field.touched[2]).any()
