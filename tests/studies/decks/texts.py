"""Decks of MPM3D written here: the thesis' appendix, bars of a scenario, explosive bars."""

from collections.abc import Iterable
from typing import Any

import numpy as np


def appendix_deck() -> str:
    """Appendix A of Ma (2005), its lost characters and its particles as the reader's docstring says."""
    across = [0.25 + 0.5 * i for i in range(4)]
    places = [
        (1 if k < 10 else 2, x, y, 0.25 + 0.5 * k)
        for k in range(20)
        for y in across
        for x in across
        if x * x + y * y < 4.0
    ]
    head = """mpm3d *** test my Code ! title
ppc 8 ! particles in a cell
nbgn 1200
nbmp 260
nmat 2
ncomp 2
spx 0.0 9.0
spy 0.0 9.0
spz -1.0 10.0
dcell 1.0
dt 1.0d-4
tstep 400
ostep 4
jaum on
cont on
! 0 free, 1 fixed, 2 symmetric
! x0 xn y0 yn z0 zn
fixed 2 0 2 0 2 0
material ! density, Young, Poisson, yield, B, n, C
1 john 8.9d-3 100.0d3 0.3d0 90 392 0.5 0.0
2 john 2.7d-3 70.0d3 0.3d0 90 392 0.5 0.0
! number, form, c0, lambda, gamma0
seos 1 1 3.3d3 1.49 1.96
seos 2 1 3.3d3 1.49 1.96
outr epeff
curv epeff 1
curv engs
curv engk
Particle
! ID mat comp X Y Z
"""
    table = [
        f"{number} 1 {component} {x:.4f}D+00 {y:.4f}D+00 {z:.4f}D+00"
        for number, (component, x, y, z) in enumerate(places, 1)
    ]
    tail = """velo
! number vx vy vz
comp 1 0.0 0.0 200.0
node 1 0.0 0.0 0.0
endv
endi
"""
    return head + "\n".join(table) + "\n" + tail


def thousandfold(value: float, powers: int = 1) -> str:
    """A double times 1000 to a power, as decimals that lose nothing: m as mm, kg as g."""
    mantissa, _, exponent = repr(float(value)).partition("e")
    return f"{mantissa}d{int(exponent or 0) + 3 * powers}"


def bar_deck(problem: Any, *, young: float, poisson: float) -> str:
    """The deck of a bar of the scenario ``elastic_bar`` in three dimensions, digit for digit."""
    [body], geometry = problem.bodies, problem.geometry
    lower = geometry.lower
    upper = lower + geometry.cells * geometry.spacing
    lines = [
        "mpm3d *** a bar on a wall",
        "! Unit: mm g N ms MPa",
        "nbco 1",
        "nbbo 1",
        f"nbmp {body.mass.size}",
        "nmat 1",
        *(
            f"sp{axis} {thousandfold(low)} {thousandfold(high)}"
            for axis, low, high in zip("xyz", lower, upper, strict=True)
        ),
        f"dcell {thousandfold(geometry.spacing)}",
        f"endtime {thousandfold(problem.end_time)}",
        f"dt {thousandfold(problem.fixed_dt)}",
        "musl on",
        "fixed " + " ".join(str(int(face)) for pair in problem.faces for face in pair),
        "material",
        f"1 elas {thousandfold(body.density, -2)} {thousandfold(young, -2)} {poisson!r}",
        f"Particle point 1 {body.mass.size}",
    ]
    velocity = np.broadcast_to(body.velocity, body.position.shape)
    lines += rows(body.mass, body.position)
    lines += ["velo", "body 1 " + " ".join(repr(float(v)) for v in velocity[0]), "endv", "endi"]
    return "\n".join(lines) + "\n"


def rows(masses: Iterable[float], places: Any) -> list[str]:
    """Rows of particles of material 1."""
    return [
        f"{number} 1 {thousandfold(mass)} " + " ".join(map(thousandfold, place))
        for number, (mass, place) in enumerate(zip(masses, places, strict=True), 1)
    ]


def points_deck(size: int) -> str:
    """A bar of as many points as a number of bytes holds, each in a row of its own as MPM3D-F90's bars have them."""
    head = """mpm3d *** bar of points
! Unit: mm g N ms MPa
nbco 1
nbbo 1
nbmp {count}
nmat 1
spx 0 40
spy 0 40
spz -1 200
dcell 1.0
dtscale 0.5
endtime 0.01
musl on
fixed 2 0 2 0 1 0
material
1 elas 8.93d-3 1.17d5 0.35
particle point 1 {count}
"""
    tail = "\nvelo\nbody 1 0 0 -190\nendv\nendi\n"
    row = "{:6d} 1 1.116250e-003 {:14.6e} {:14.6e} {:14.6e}"
    count = (size - len(head) - len(tail)) // (len(row.format(1, 0.0, 0.0, 0.0)) + 1)
    places = ((place % 40, place % 1600 // 40, place // 1600) for place in range(count))
    rows = [row.format(number, *(0.25 + 0.5 * each for each in place)) for number, place in enumerate(places, 1)]
    return head.format(count=count) + "\n".join(rows) + tail


def detonation_deck(cells: int) -> str:
    """A bar of TNT (mm, g, ms) that is lit at its closed end: our own words for MPM3D-F90's Deto1k with splines."""
    length = 100.0  # mm
    cell = length / cells
    return f"""mpm3d *** bar of TNT
! Unit: mm g N ms MPa
nbco 1
nbbo 1
nbmp {3 * cells}
nmat 1
spx {-cell!r} {length + 3 * cell!r}
spy {-cell!r} {2 * cell!r}
spz {-cell!r} {2 * cell!r}
dcell {cell!r}
bimp
bulk 4.0 0.2
dtscale 0.3
endtime {0.9 * length / 6930.0!r}
outtime 1.0d-3
fixed 2 0 2 2 2 2
material
1 hiex 1.63d-3 6930
seos 1 3 3.712d5 3.21d3 4.15 0.95 0.3 6993
deto 0 0 0
Particle block 1
1 1.63d-3 {cell / 3!r} 0 0 0 {3 * cells} 1 1
endi
"""


def soil_deck() -> str:
    """A block of soil (m, kg, s) that falls on its floor."""
    return """mpm3d soil
! Unit: m kg N s Pa
nbco 1
nbbo 1
nbmp 64
nmat 1
grid 0 6 0 6 0 6
dcell 1.0
dtscale 0.2
endt 0.01
musl on
fixed 2 0 2 0 1 0
material
1 dpm 2.1d3 0.7e8 0.3 0.3545 9.74d3 0.0 27.48d3
particle block 1
1 2.1d3 0.5 0 0 0.5 4 4 4
velo
body 1 0 0 -1
endv
endi
"""


def fluid_deck() -> str:
    """A ball of water before a block with a round hole of a metal that fails, and a disc of elastic matter."""
    return """mpm3d fluid
nbco 3
nbbo 3
nbmp 108
nmat 3
spx -4 4
spy -4 4
spz -4 6.5
dcell 1.0
dtscale 0.1
endt 0.001
gimp
contact lagr 0.1 1
material
1 null 1.0d-3 2.2d3 0
2 jcf 8.9d-3 117.0d3 0.3 90 292 0.31 0.025 1.09 20 1083 385 1d-3 0.5
3 pla2 2.7d-3 70d3 0.3 250 700
seos 1 1 0 2.2d3 9.5d3 1.457d4 0.28 0.28 0 0
seos 2 2 3.94d3 1.49 1.96 0
Particle sphere 1
1 1.0d-3 0.5 0 0 -1.5 2
particle blod 2
2 8.9d-3 0.5 -1.5 -1.5 1 6 6 2 0 0 0 1
Particle cicle 3
3 2.7d-3 0.5 0 0 3 2
velo
body 1 0 0 500
node 33 1 2 3
endv
endi
"""
