"""Thicknesses below which a plate spalls or is perforated, in depths of the crater in a thick block."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from numpy import asarray
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law, Range, Shot, christiansen_steel, cour_palais, cour_palais_ti
from studies.laws._handbook import COUR_PALAIS, HANDBOOK, RYAN
from studies.laws._range import stated

# Of the plate's thickness over the depth: Eqs. 4-3 to 4-5 for aluminium, Eq. 4-7 for titanium.
ALUMINIUM = {"spall": 3.0, "detached_spall": 2.2, "perforation": 1.8}
TITANIUM = {"spall": 3.0, "detached_spall": 2.4, "perforation": 1.8}
STEEL = {"perforation": 1.8}


def thickness_ratio(depth_ratio: ArrayLike, factor: ArrayLike) -> NDArray:
    """Limit of the thickness over the projectile's diameter, from the depth over it and the factor; broadcasts.

    t = k p. The plate of 0.44 cm of Fig. 4-4 of the handbook (BHN 95, 5.1 km/s, 2.713 g/cm3) is perforated at 7 km/s
    by spheres of 2.796 g/cm3 from 0.1301 cm on:

    >>> depth = cour_palais.depth_ratio(7e3, 0.1301e-2, 2.796 / 2.713, 5100.0, 95.0)
    >>> round(float(0.1301 * thickness_ratio(depth, ALUMINIUM["perforation"])), 3)
    0.44
    """
    return asarray(asarray(factor) * asarray(depth_ratio))


def _ratio(of_depth: Law, factor: float) -> Callable[[Shot, str], NDArray]:
    return lambda shot, variant: thickness_ratio(of_depth.ratio(shot, variant), factor)


def _laws(metal: str, of_depth: Law, factors: Mapping[str, float], source: str) -> tuple[Law, ...]:
    """A law for each limit of a metal, with the range of its depth."""
    return tuple(
        replace(
            of_depth,
            name=f"{limit}_{metal}",
            title=f"{limit.replace('_', ' ').capitalize()}, {of_depth.title}",
            quantity=f"{limit}_thickness",
            equation="",
            latex=f"$t = {factor:g} p$, {of_depth.latex}",
            source=source,
            ratio=_ratio(of_depth, factor),
        )
        for limit, factor in factors.items()
    )


GEHRING = Range(
    *cour_palais.LAW.range.limits, stated("0.32 cm aluminium on 2024-T3 at 7.4 km/s", f"{COUR_PALAIS}, p. 225")
)
LAW = (
    *_laws("al", cour_palais.LAW, ALUMINIUM, f"{HANDBOOK}, Eqs. 4-1 to 4-5"),
    *_laws("ti", cour_palais_ti.LAW, TITANIUM, f"{RYAN}, 245, Eq. 11"),
    *_laws("steel", christiansen_steel.LAW, STEEL, f"{HANDBOOK}, Eqs. 4-10 and 4-12"),
    Law(
        name="detached_spall_gehring",
        title="Detached spall, Gehring",
        quantity="detached_spall_thickness",
        latex=f"$t = 2.3 p$, {cour_palais.LAW.latex}",
        source=f"Gehring, in {COUR_PALAIS}, p. 225, who has 3 p for spall and 1.8 p for perforation too",
        confidence="second-hand",
        size_exponent=cour_palais.SIZE_EXPONENT,
        range=GEHRING,
        ratio=_ratio(cour_palais.LAW, 2.3),
        meaningless=cour_palais.LAW.meaningless,
    ),
)
