"""What the measurements of a wall read off walls with a known answer."""

import math
from collections.abc import Callable

import pytest

from tests.claims.rows import absolute, equal
from tests.studies.measurements.states import CELL, DENSITY, EDGE, PARTICLE, ROUND_OFF, read, value
from tests.studies.shields.walls import (
    BULGE,
    PIECE,
    PIT,
    SCAB,
    SPALL_SPEED,
    WALL,
    Change,
    bulged,
    crushed,
    fallen_back,
    littered,
    parted,
    pit,
    plugged_out,
    scabbed,
    walled,
)

PIT_MASS, SCAB_MASS, PLUG_MASS = (
    math.pi * DENSITY * radius**2 * depth for radius, depth in (PIT, SCAB, (PIT[0], WALL))
)
# A circle on a lattice of squares is known to half a particle.
RAGGED = 2.0 * EDGE / PIT[0]
THIN = PARTICLE / WALL
# Changes; outcomes: perforated, failed, attached spall; measurement, value, and how far off the reading may be.
WALL_ANSWERS: list[tuple[tuple[Change, ...], tuple[int, ...], list[tuple[str, float, float]]]] = [
    ((), (0, 0, 0), [("crater_depth_over_thickness", 0.0, ROUND_OFF), ("bulge", 0.0, ROUND_OFF)]),
    ((pit(),), (0, 0, 0), [("momentum", PIT_MASS * SPALL_SPEED, RAGGED * PIT_MASS * SPALL_SPEED)]),
    (
        (pit(), bulged),
        (0, 0, 0),
        [
            ("crater_depth_over_thickness", PIT[1] / WALL, ROUND_OFF),
            ("bulge", BULGE, ROUND_OFF),
            ("detached_spall", 0.0, 0.0),
        ],
    ),
    ((pit(), littered), (0, 0, 0), [("detached_spall", 0.0, 0.0)]),
    ((fallen_back,), (1, 1, 0), [("detached_spall", 0.0, 0.0)]),
    ((crushed,), (1, 1, 0), [("detached_spall", 0.0, 0.0)]),
    (
        (scabbed,),
        (0, 1, 0),
        [
            ("crater_depth_over_thickness", 0.0, ROUND_OFF),
            ("detached_spall", SCAB_MASS, RAGGED * SCAB_MASS),
            ("spall_diameter", 2.0 * SCAB[0], 2.0 * EDGE),
            ("spall_velocity", SPALL_SPEED, ROUND_OFF * SPALL_SPEED),
            ("momentum", -SCAB_MASS * SPALL_SPEED, RAGGED * SCAB_MASS * SPALL_SPEED),
        ],
    ),
    ((pit(), scabbed), (0, 1, 0), [("crater_depth_over_thickness", PIT[1] / WALL, ROUND_OFF)]),
    ((pit(), parted), (0, 0, 1), [("crater_depth_over_thickness", PIT[1] / WALL, ROUND_OFF)]),
    # The crater opens into the gap.
    ((pit(WALL - SCAB[1]), parted), (0, 0, 0), [("crater_depth_over_thickness", 1.0 - SCAB[1] / WALL, ROUND_OFF)]),
    # A row of particles, half a cell, is left in the first state, and nothing in the second.
    ((pit(WALL - PARTICLE),), (0, 0, 0), [("crater_depth_over_thickness", 1.0 - THIN, ROUND_OFF)]),
    ((pit(WALL),), (1, 1, 0), [("hole_diameter", 2.0 * PIT[0], 2.0 * EDGE), ("detached_spall", 0.0, 0.0)]),
    (
        (plugged_out,),
        (1, 1, 0),
        [("detached_spall", PLUG_MASS, RAGGED * PLUG_MASS), ("crater_depth_over_thickness", 1.0, 0.0)],
    ),
]


@pytest.mark.claim("shields", "wall-known-answers")
@pytest.mark.parametrize("kind", ["axisymmetric", "quarter", "half"])
def test_walls__are_read_as_the_known_answers(kind: str, compared: Callable[..., None]) -> None:
    """Hole, crater, bulge, spall and momentum of made walls are read as they are, in two and three dimensions, and
    beside the middle of a half model."""
    for changes, outcomes, numbers in WALL_ANSWERS:
        state = walled(*changes, kind=kind)
        told = [read(f"wall_{name}", state).value for name in ("perforated", "failed", "attached_spall")]
        where = f"{kind}: {', '.join(change.__name__ for change in changes) or 'whole'}"
        compared(
            equal(f"{where}: perforated, failed, attached spall", expected=[*map(float, outcomes)], got=told),
            *(
                absolute(f"{where}: {name}", expected=expected, got=value(f"wall_{name}", state), within=off)
                for name, expected, off in numbers
            ),
        )


@pytest.mark.parametrize("kind", ["axisymmetric", "quarter", "half"])
def test_void__of_a_wall_is_that_of_its_whole_body(kind: str) -> None:
    """The slab stands three cells away from the rest up to a radius of 1.5 mm, and less up to 2.5 mm, at its edge."""
    wall = walled(parted, kind=kind).wall
    assert wall is not None
    least, most = (math.pi * radius**2 * 3.0 * CELL for radius in (SCAB[0] - 1e-3, SCAB[0]))
    assert least <= wall.void <= most
    intact = walled(kind=kind).wall
    assert intact is not None
    assert intact.void == 0.0


@pytest.mark.parametrize(("kind", "copies"), [("axisymmetric", 2.0 * math.pi), ("quarter", 4.0), ("half", 2.0)])
@pytest.mark.parametrize("bounced", [0, 1, 2])
def test_wall_momentum__is_twice_that_of_debris_that_went_back(kind: str, copies: float, bounced: int) -> None:
    """The first of two pieces has departed since; one that has not joined brought nothing."""
    expected = 2.0 * bounced * copies * PIECE * SPALL_SPEED
    assert abs(value("wall_momentum", walled(kind=kind, bounced=bounced)) - expected) <= ROUND_OFF
