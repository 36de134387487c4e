"""Published numbers of the laws to their printed digits, and tables that were computed apart from this code."""

from collections.abc import Callable, Iterator

import numpy as np

from studies import laws
from studies.laws import (
    Shield,
    carey_mcdonnell_dixon,
    cour_palais,
    hill,
    lundeberg,
    maiden_al,
    maiden_c,
    nysmith_denardo,
    sawle,
    schonberg,
    schonberg_taylor,
    whipple_nno,
    zhang_tan,
)
from studies.laws.plates import ALUMINIUM, thickness_ratio
from tests.claims import Row, claim, equal
from tests.studies.support.published import examples_of, module_of

# D/d by each law in the order of ``HOLES``: metal, t/d, v in km/s, then the values. Computed apart from this code.
TABLE = """
Al 0.10 2 1.09 1.09 1.56 0.74 1.10 1.26 1.20 1.15 1.18 0.52
Al 0.10 4 1.29 1.29 1.65 1.04 1.39 1.39 1.36 1.35 1.23 0.91
Al 0.10 6 1.48 1.48 1.71 1.28 1.59 1.52 1.50 1.50 1.26 1.17
Al 0.10 7 1.58 1.58 1.74 1.38 1.67 1.58 1.57 1.56 1.27 1.29
Al 0.25 2 1.26 1.26 2.03 1.12 1.50 1.43 1.44 1.48 1.44 0.83
Al 0.25 4 1.61 1.61 2.20 1.58 1.89 1.73 1.76 1.80 1.56 1.44
Al 0.25 6 1.97 1.97 2.31 1.93 2.16 2.02 2.02 2.04 1.63 1.86
Al 0.25 7 2.15 2.15 2.36 2.09 2.27 2.17 2.15 2.14 1.67 2.03
Al 0.50 4 2.03 2.03 2.91 2.16 2.38 2.26 2.28 2.32 2.05 2.03
Al 0.50 6 2.60 2.60 3.08 2.64 2.72 2.80 2.72 2.66 2.23 2.62
Al 0.50 7 2.88 2.88 3.16 2.85 2.86 3.07 2.92 2.81 2.29 2.88
Cu 0.25 2 1.26 1.38 2.09 1.99 1.66 1.54 1.56 1.61 1.44 0.83
Cu 0.25 3 1.44 1.63 2.20 2.44 1.90 1.74 1.77 1.81 1.51 1.17
Cu 0.25 4 1.61 1.87 2.27 2.82 2.09 1.94 1.95 1.98 1.56 1.44
Cu 0.25 5 1.79 2.11 2.34 3.15 2.25 2.14 2.12 2.12 1.60 1.66
Cu 0.25 6 1.97 2.35 2.39 3.45 2.39 2.33 2.28 2.25 1.63 1.86
Cu 0.25 7 2.15 2.59 2.44 3.73 2.51 2.52 2.43 2.37 1.67 2.03
"""
# Density of the sphere over that of the sheet, density of the sphere (kg/m3), bulk sound speed (m/s).
METALS = {"Al": (2.80 / 2.70, 2800.0, 5350.0), "Cu": (1.0, 8930.0, 3940.0)}

Hole = Callable[[float, float, float, float, float], object]  # of v, t/d, the three numbers above
HOLES: dict[str, Hole] = {
    "maiden_al": lambda v, t, ratio, density, C: maiden_al.hole_ratio(v, t),
    "maiden_c": lambda v, t, ratio, density, C: maiden_c.hole_ratio(v, t, C),
    "sawle": lambda v, t, ratio, density, C: sawle.hole_ratio(v, t, ratio, C),
    "nysmith_denardo": lambda v, t, ratio, density, C: nysmith_denardo.hole_ratio(v, t, density),
    "lundeberg": lambda v, t, ratio, density, C: lundeberg.hole_ratio(v, t, ratio, C),
    "schonberg": lambda v, t, ratio, density, C: schonberg.hole_ratio(v, t, C),
    "schonberg_taylor": lambda v, t, ratio, density, C: schonberg_taylor.hole_ratio(v, t, C),
    "hill": lambda v, t, ratio, density, C: hill.hole_ratio(v, t, ratio, C, C),
    "carey_mcdonnell_dixon": lambda v, t, ratio, density, C: carey_mcdonnell_dixon.hole_ratio(v, t),
    "zhang_tan": lambda v, t, ratio, density, C: zhang_tan.hole_ratio(v, t),
}

# Fig. 4-4 of NASA/TM-2009-214785: a plate of 0.44 cm, BHN 95 and 5.1 km/s, and a bumper of 0.12 cm 10 cm before a wall
# of 0.32 cm and 40 ksi; 2.796 on 2.713 g/cm3. Critical diameters in cm, computed apart from this code.
SPEEDS = (1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14)  # km/s
PLATE = (
    "0.4446 0.2870 0.2222 0.1852 0.1609 0.1434 0.1301 0.1196 0.1039 0.0926 0.0840",
    "0.4580 0.2956 0.2288 0.3139 0.3989 0.4839 0.5690 0.5205 0.4486 0.3972 0.3584",
)
SHIELD = Shield(0.12e-2, 0.32e-2, 10e-2, 40.0 / 0.145038 * 1e6)
PROJECTILE, TARGET = 2796.0, 2713.0  # kg/m3


@claim(
    "laws-published-numbers",
    says="every law gives the numbers that stand beside its formula to their printed digits: published ones, those of "
    "its cross-check where it is recalled, and its printed constants where no other number is published",
    quick=True,
)
def laws_published_numbers() -> Iterator[Row]:
    modules = {module_of(law): law for law in map(laws.load, laws.names())}
    for module, law in modules.items():
        name = module.__name__.rpartition(".")[2]
        examples = examples_of(law)
        for each in examples:
            yield Row(f"{name}: {each.source}", each.want, each.got, each.passed)
        if not examples:
            yield Row(f"{name}: published numbers", "some", "none", False)


@claim(
    "laws-tables",
    says="ten laws of holes at seventeen points, and the critical diameters of a plate and of a Whipple shield at "
    "eleven speeds, have the values of tables that were computed apart from this code",
    quick=True,
)
def laws_tables() -> Iterator[Row]:
    for line in TABLE.split("\n")[1:-1]:
        metal, thickness, speed, *printed = line.split()
        shot = (1e3 * float(speed), float(thickness), *METALS[metal])
        holes = " ".join(f"{float(str(hole(*shot))):.2f}" for hole in HOLES.values())
        where = f"{metal}, t/d {thickness}, {speed} km/s: {', '.join(HOLES)}"
        yield equal(where, expected=" ".join(printed), got=holes)
    speeds = 1e3 * np.array(SPEEDS, float)
    shield = 100.0 * whipple_nno.critical_diameter(speeds, TARGET, PROJECTILE, SHIELD)
    for name, expected, values in (
        ("plate of 0.44 cm", PLATE[0], [100.0 * _perforating(speed) for speed in speeds]),
        ("Whipple shield", PLATE[1], shield),
    ):
        got = " ".join(f"{value:.4f}" for value in values)
        yield equal(f"{name}: critical diameter (cm), 1 to 14 km/s", expected=expected, got=got)


def _perforating(speed: float) -> float:
    """The sphere, m, whose perforation thickness is that of the plate."""
    from scipy.optimize import brentq

    def excess(diameter: float) -> float:
        depth = cour_palais.depth_ratio(speed, diameter, PROJECTILE / TARGET, 5100.0, 95.0)
        return float(diameter * thickness_ratio(depth, ALUMINIUM["perforation"])) - 0.44e-2

    return float(brentq(excess, 1e-5, 1e-1, xtol=1e-12))
