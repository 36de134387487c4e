"""What each measurement reads off states with a known answer, and what leaves its reading where it is."""

import dataclasses
import math
from collections.abc import Callable
from itertools import chain
from typing import Any

import numpy as np
import pytest

from studies.measurements import History
from studies.quantities.measured import DEFINITION
from tests import samples
from tests.studies.measurements.states import (
    BREADTH,
    CELL,
    CRATER,
    DEPTH,
    DIAMETER,
    EDGE,
    HOLE,
    OPENINGS,
    PARTICLE,
    RADIUS,
    ROUND_OFF,
    TENTH,
    THICKNESS,
    WALLS,
    bored_half_space,
    collared_disc,
    cratered,
    dented_disc,
    drilled_disc,
    hollowed_half_space,
    impact,
    lattice,
    line,
    lipped_disc,
    read,
    scooped_half_space,
    value,
    with_particle,
)

AXES = ("largest", "smallest", "mean_root")
Build = Callable[[], Any]


def conical_disc() -> Any:
    """A plate whose hole has the drill's radius in its middle plane."""
    radius, depth = lattice(line(0.0, RADIUS), line(0.0, THICKNESS))
    left = radius > HOLE + (depth - 0.5 * THICKNESS)
    return impact(radius[left], depth[left], thickness=THICKNESS, breadth=RADIUS)


def cap(share: float) -> Any:
    """A crater of the scoop's radius at the surface and a share of it deep, a part of a sphere."""
    depth = share * CRATER
    sphere = (CRATER**2 + depth**2) / (2.0 * depth)
    return cratered(lambda z: math.sqrt(sphere**2 - (z + sphere - depth) ** 2), depth)


def cap_volume(share: float) -> float:
    depth = share * CRATER
    return math.pi * depth * (3.0 * CRATER**2 + depth**2) / 6.0


def off_by_a_tenth(share: float) -> float:
    """The volume by which a cap with another surface differs, a tenth of a cell away everywhere."""
    return math.pi * CRATER**2 * (1.0 + share**2) * TENTH


def walled_crater(height: float) -> Any:
    """A crater with a lip as wide as eight particles and of a height (m), which ends exactly there."""
    block = cratered(WALLS["hemisphere"], CRATER)
    for place in line(-height, 0.0):
        for radius in line(CRATER + PARTICLE, CRATER + 9.0 * PARTICLE):
            block = with_particle(block, float(radius), float(place))
    return block


def depths(*depth: float) -> History:
    return History(np.arange(len(depth)) * 1e-6, {"crater_depth": np.array(depth)})


CAP = (0.25 * DIAMETER) ** 2 / (4.0 * CRATER)  # half of a flat column's floor lies below it
SHIFTS = [0.1 * part for part in range(11)]  # cells

# Measurement, state, value, and how far off the reading may be.
KNOWN: list[tuple[str, Build, float, float]] = [
    # An edge on a lattice is known to half a particle, and a diameter has two of them.
    *(
        (name, lambda s=shift: drilled_disc(HOLE + s * CELL), 2.0 * (HOLE + shift * CELL), 2 * EDGE)
        for name in OPENINGS
        for shift in (SHIFTS if name == "hole_diameter" else [0.0])
    ),
    *(
        ("hole_diameter", lambda w=w, z=z: collared_disc(HOLE, inwards=w, depth=z), 2.0 * (HOLE - w), 0.05 * PARTICLE)
        for w in (CELL, 4.0 * CELL)
        for z in (-CELL, CELL, THICKNESS)
    ),
    # The narrowest bin of a cone is a cell high, and its wall a cell deep.
    ("hole_diameter", conical_disc, 2.0 * HOLE - THICKNESS, 2.0 * CELL),
    ("hole_diameter_areal", conical_disc, 2.0 * HOLE, 2.0 * EDGE),
    ("hole_diameter_midplane", conical_disc, 2.0 * HOLE, 2.0 * CELL),
    ("hole_diameter_lip", lambda: lipped_disc(HOLE, HOLE + 3.3e-3), 2 * HOLE + 6.6e-3, 1e-14),
    *(("crater_diameter", lambda s=share: cap(s), 2.0 * CRATER, 2.0 * TENTH) for share in (0.3, 0.5, 0.8)),
    *(
        ("crater_diameter", lambda c=c: cratered(WALLS["cylinder"], c * CELL), 2 * CRATER, 2 * TENTH)
        for c in (3.0, 5.0, 7.0)
    ),
    # Lattice points leave one by one, so the reading follows a tenth of a cell to within a particle.
    *(
        (name, lambda s=shift: scooped_half_space(CRATER + s * CELL), of(CRATER + shift * CELL), off)
        for name, of, off in (
            ("crater_depth", lambda r: r - CAP, 2.0 * PARTICLE),
            ("crater_diameter", lambda r: 2.0 * r, 4.0 * PARTICLE),
        )
        for shift in SHIFTS[::5]
    ),
    ("crater_depth", lambda: scooped_half_space(0.0), 0.0, PARTICLE),
    *(
        ("crater_volume", lambda s=share: cap(s), cap_volume(share), off_by_a_tenth(share))
        for share in (0.2, 0.5, 0.83, 1.0)
    ),
    (
        "crater_volume",
        lambda: cratered(WALLS["cylinder"], 7.0 * CELL),
        math.pi * CRATER**2 * 7.0 * CELL,
        math.pi * CRATER**2 * TENTH,
    ),
    *(("crater_lip_height", lambda c=cells: walled_crater(c * CELL), cells * CELL, TENTH) for cells in (1.0, 2.5, 5.0)),
    ("crater_rebound", lambda: depths(1e-3, 4e-3, 5e-3, math.nan, 4.5e-3), 0.1, ROUND_OFF),
    ("crater_depth_over_diameter", lambda: scooped_half_space(CRATER), 0.5, PARTICLE / CRATER),
    *chain(*samples.offered("KNOWN")),
]


@pytest.mark.parametrize(("name", "build", "expected", "off"), KNOWN)
def test_reading__is_the_known_answer(name: str, build: Build, expected: float, off: float) -> None:
    assert abs(value(name, build()) - expected) <= off


def gone_disc() -> Any:
    disc = drilled_disc(HOLE)
    nothing = np.zeros_like(disc.target)
    return dataclasses.replace(disc, attached=nothing, attached_target=nothing)


def near_back(crater: float, *, absorbs: bool = False) -> Any:
    return dataclasses.replace(scooped_half_space(crater * DEPTH), back_absorbs=absorbs)


# Measurement, state, flags; a value comes with the flags of the second table only.
NO_VALUE: list[tuple[str, Build, str]] = [
    *(
        (name, state, flag)
        for name in OPENINGS
        for state, flag in (
            (lambda: drilled_disc(0.0), "not_perforated"),
            (lambda: dented_disc(0.375), "not_perforated"),
            (lambda: dented_disc(0.875), "not_perforated"),
            (lambda: drilled_disc(RADIUS - 2.0 * CELL), "not_contained"),
            (gone_disc, "not_contained"),
        )
    ),
    ("hole_diameter_areal", lambda: dented_disc(1.0, stretch=1.9), "not_perforated"),
    ("hole_diameter", lambda: dented_disc(1.0, stretch=1.9), "not_perforated"),
    ("hole_diameter", lambda: collared_disc(HOLE, inwards=HOLE - PARTICLE, depth=CELL), "not_perforated"),
    ("hole_diameter_lip", lambda: drilled_disc(HOLE), "no_lip"),
    ("hole_diameter_lip", lambda: lipped_disc(HOLE, HOLE + 1.1 * DIAMETER), "no_lip"),
    ("crater_depth", bored_half_space, "perforated"),
    ("crater_depth_over_diameter", bored_half_space, "perforated"),
    ("crater_diameter", lambda: scooped_half_space(0.0), "no_crater"),
    ("crater_diameter", lambda: cratered(lambda z: (2.0 if z < 1.5 * CELL else 12.0) * CELL, CRATER), "no_crater"),
    ("crater_depth_over_diameter", lambda: scooped_half_space(0.0), "no_crater"),
    *(
        (name, lambda: scooped_half_space(BREADTH - 2.0 * CELL), "not_contained")
        for name in ("crater_diameter", "crater_volume", "crater_diameter_largest")
    ),
    ("crater_volume", lambda: scooped_half_space(0.0), "no_crater"),
    ("crater_volume", bored_half_space, "perforated"),
    ("crater_lip_height", lambda: scooped_half_space(CRATER), "no_lip"),
    ("crater_lip_height", lambda: walled_crater(6.5 * CELL), "lip_at_edge"),
    ("crater_rebound", lambda: depths(math.nan, math.nan), "no_crater"),
    ("hole_diameter_mean_root", lambda: drilled_disc(0.0), "not_perforated"),
    *chain(*samples.offered("NO_VALUE")),
]
DOUBTED: list[tuple[str, Build, str]] = [
    *chain(*samples.offered("DOUBTED")),
    *((name, lambda: dented_disc(0.125), "closed_on_axis") for name in OPENINGS),
    ("hole_diameter_areal", lambda: dented_disc(1.0, stretch=2.1), "closed_on_axis"),
    *((name, lambda: drilled_disc(0.51 * RADIUS), "near_rim") for name in OPENINGS),
    *((name, lambda: drilled_disc(0.49 * RADIUS), "") for name in OPENINGS),
    ("hole_diameter_lip", lambda: lipped_disc(HOLE, HOLE + DIAMETER - 0.5 * CELL), "lip_at_window"),
    ("crater_rebound", lambda: depths(1e-3, 4e-3, 5e-3), "before_maximum"),
    ("hole_diameter_lip", lambda: lipped_disc(HOLE, HOLE + DIAMETER - 1.5 * CELL), ""),
    *(
        (name, state, flag)
        for name in ("crater_depth", "crater_depth_over_diameter")
        for state, flag in (
            (lambda: near_back(0.30), ""),
            (lambda: near_back(0.37), "near_back"),
            (lambda: near_back(0.37, absorbs=True), ""),
        )
    ),
]


@pytest.mark.parametrize(("name", "build", "flag"), [*NO_VALUE, *DOUBTED])
def test_reading__is_flagged(name: str, build: Build, flag: str) -> None:
    reading = read(name, build())
    assert reading.flags == ((flag,) if flag else ())
    assert math.isnan(reading.value) == ((name, build, flag) in NO_VALUE)


def stray(part: float, depth: float = 0.5) -> Build:
    return lambda: with_particle(drilled_disc(HOLE), part * HOLE, depth * THICKNESS)


def scooped() -> Any:
    return scooped_half_space(CRATER)


# Measurement, state, state with a change that must not move the reading, and by how much it may.
UNMOVED: list[tuple[str, Build, Build, float]] = [
    # A particle that flies in the hole fills half of a ring of the bin, at its own radius.
    *(
        ("hole_diameter", lambda: drilled_disc(HOLE), stray(part, depth), 2.0 * part * 0.5 * PARTICLE)
        for part in (0.3, 0.6, 0.9)
        for depth in (0.3, 0.5)
    ),
    # Beside the plate nothing shares its bin.
    *(("hole_diameter", lambda: drilled_disc(HOLE), stray(0.3, depth), ROUND_OFF) for depth in (-1.125, 2.125)),
    *(("hole_diameter_areal", lambda: drilled_disc(HOLE), stray(part), 1e-14) for part in (0.3, 0.6, 0.9)),
    # One of the eight particles through the thickness: an eighth of a particle on each side.
    ("hole_diameter_areal", lambda: drilled_disc(HOLE), stray(1.0 - 0.6 * PARTICLE / HOLE), 2.0 * PARTICLE / 8.0),
    ("hole_diameter_midplane", lambda: drilled_disc(HOLE), stray(0.6, -1.0), 0.0),
    ("crater_depth", scooped, lambda: hollowed_half_space(CRATER, roof=2e-3, height=2e-3), 1e-14),
    *(
        (name, scooped, lambda: with_particle(scooped(), 0.1 * CRATER, 0.4 * CRATER), 1e-14)
        for name in ("crater_depth", "crater_diameter")
    ),
]


@pytest.mark.parametrize(("name", "before", "after", "off"), UNMOVED)
def test_reading__stays_where_it_is(name: str, before: Build, after: Build, off: float) -> None:
    assert abs(value(name, after()) - value(name, before())) <= off


@pytest.mark.parametrize("build", [conical_disc, lambda: drilled_disc(HOLE)])
def test_part_of_the_definition__is_half_of_the_gap_between_both_diameters(build: Build) -> None:
    state = build()
    gap = value("hole_diameter_areal", state) - value("hole_diameter", state)
    part = read("hole_diameter", state).parts[DEFINITION]
    assert math.isclose(part, 0.5 * abs(gap), rel_tol=1e-9, abs_tol=1e-12)
    assert DEFINITION not in read("hole_diameter_areal", state).parts
