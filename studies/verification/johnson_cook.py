"""Johnson and Cook's yield stress at one point: strain, rate and temperature given, the stress returned to the surface.

The point is sheared without a change of volume, in many small steps, at a temperature that is held; the exact stress
is (A + B eps^n) (1 + C ln rate*) (1 - T*^m) at the plastic strain that the point has reached.
"""

import math
from collections.abc import Iterator

from solver.eos.mie_grueneisen import mie_grueneisen
from solver.strength.johnson_cook import JohnsonCook
from solver.stress import PointState
from studies.values.recipes import Recipe
from studies.verification import Case, Row, absolute, at_most, relative
from studies.verification._matter import matter_of, sheared

# Copper: Johnson and Cook (1983), Proc. 7th Int. Symp. Ballistics, 541.
A, B, N, C, M = 90e6, 292e6, 0.31, 0.025, 1.09
ROOM, MELT = 298.0, 1356.0
DENSITY, SHEAR_MODULUS = 8930.0, 47.7e9

STRAIN = 0.2
RATES = (1.0, 1e4)  # 1/s
TEMPERATURES = {"0 K": 0.0, "room": ROOM, "near melt": 1300.0, "above melt": 1500.0}

# The stress lies on the surface up to the solver's own tolerance of the plastic strain (1e-5 of the trial stress).
ON_SURFACE = 1e-4
# At room temperature and 1/s: 90 + 292 0.2^0.31 = 267 MPa; the elastic strain (0.2 %) is not plastic.
PRINTED, PRINTED_DIGITS = 267e6, 0.005


def yield_stress(strain: float, rate: float, temperature: float) -> float:
    """The law itself, Pa.

    >>> round(yield_stress(0.2, 1.0, ROOM) / 1e6)
    267
    >>> yield_stress(0.2, 1.0, MELT)
    0.0
    """
    homologous = min(max((temperature - ROOM) / (MELT - ROOM), 0.0), 1.0)
    rated = 1.0 + C * math.log(max(rate, 1.0))
    return (A + B * strain**N) * rated * (1.0 - homologous**M)


def _run(recipe: Recipe) -> Iterator[Row]:
    for rate in RATES:
        for name, temperature in TEMPERATURES.items():
            strain, stress = _sheared(rate, temperature)
            exact = yield_stress(strain, rate, temperature)
            where = f"{name}, {rate:g}/s, strain {STRAIN}"
            claim = f"{where}: equivalent stress (MPa)"
            if exact > 0.0:
                yield relative(claim, expected=exact / 1e6, got=stress / 1e6, within=ON_SURFACE)
            else:
                yield at_most(claim, limit=0.0, got=stress / 1e6)
            elastic = stress / (3.0 * SHEAR_MODULUS)
            yield absolute(
                f"{where}: plastic and elastic strain",
                expected=STRAIN,
                got=strain + elastic,
                within=ON_SURFACE * STRAIN,
            )
    _, stress = _sheared(1.0, ROOM)
    yield relative(
        "room, 1/s: the printed stress (MPa)", expected=PRINTED / 1e6, got=stress / 1e6, within=PRINTED_DIGITS
    )


def _sheared(rate: float, temperature: float) -> tuple[float, float]:
    """Plastic strain and equivalent stress after ``STRAIN`` at a rate (1/s) and a held temperature (K)."""
    eos = mie_grueneisen(density=DENSITY, c0=3940.0, s=1.489, gamma0=1.99, heat_capacity=383.0, temperature=ROOM)
    matter = matter_of(
        eos,
        shear_modulus=SHEAR_MODULUS,
        strength=JohnsonCook(A, B, N, C, M, 1.0),
        room_temperature=ROOM,
        melt_temperature=MELT,
    )
    point = PointState(DENSITY, 0.0, 0.0, 0.0, (0.0,) * 6, 0.0, temperature)
    held = {"temperature": temperature, "density": DENSITY, "energy": 0.0}
    return sheared(matter, point, held, strain=STRAIN, rate=rate)


CASE = Case(
    name="johnson-cook",
    says="a point follows Johnson and Cook's yield stress, cold to molten",
    source="Johnson and Cook (1983); Ma (2005), Eq. 2-20",
    run=_run,
)
