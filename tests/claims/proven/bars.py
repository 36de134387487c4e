"""Waves, vibration and contact of bars."""

from collections.abc import Iterator

from tests.claims import Row, claim
from tests.claims.proven._rows import case


@claim(
    "elastic-waves",
    says="elastic step waves have their stress and speed, a rod that of a bar",
    quick=True,
)
def elastic_waves() -> Iterator[Row]:
    return case("elastic-waves")


@claim(
    "bar-contact",
    says="a bar stays at the wall for 2 L / c within 3 %, leaves with 0.93 of its momentum, and is never pulled",
    quick=True,
)
def bar_contact() -> Iterator[Row]:
    return case("bar-contact")


@claim(
    "vibrating-bar",
    says="kinetic energy and the strain energy that the stress holds: their change halves with the cell between the "
    "finest two of four grids; coarser pairs beside",
    quick=True,
)
def vibrating_bar() -> Iterator[Row]:
    return case("vibrating-bar")


@claim(
    "thesis-bar",
    says="the thesis' bar leaves the wall on every grid; after 2 L / c within 10 % on 4 and 16 cells per diameter, and "
    "on 32 as a body of revolution; 8 cells miss it by one or two per cent, printed beside; where its energy is",
)
def thesis_bar() -> Iterator[Row]:
    return case("thesis-bar")


@claim(
    "taylor-bar",
    says="Taylor bar: mean error at most 0.02 in 3-D and 0.015 axisymmetric, geometries within 1 %",
)
def taylor_bar() -> Iterator[Row]:
    return case("taylor-bar")


@claim(
    "contact",
    says="bodies approach, touch, slide and part, bars with at least 0.1 of the speed at which they met (0.93 is asked "
    "at a wall); touch makes no kinetic energy, booked energy closes the balance",
    quick=True,
)
def contact() -> Iterator[Row]:
    return case("contact")
