"""Doubts about constants that are allowed: of another program's sign, in another unit, or at odds with one another."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING

from solver.units import Described, Unit, marked
from studies import materials as shipped
from studies.materials import Material
from studies.materials.schema import Scalars
from studies.quantities.findings import Doubt
from studies.quantities.parameters import Value, marks
from studies.quantities.units import readable
from studies.scenarios.parts.matter import yield_stress

if TYPE_CHECKING:
    from solver.matter.laws import Matter

# rho0 c0^2 is the bulk modulus at zero pressure; Ma (2005) alone has 3.6 and 3.94 km/s for copper.
BULK_MODULUS_AGREEMENT = 0.15
# Of the shear modulus: a perfect crystal slips at G / 2 pi (Frenkel 1926, Z. Phys. 37, 572), no metal at a tenth.
STRONGEST = 0.1
# Of the bulk modulus: without flaws solids part at about a tenth to a fifth of it (Grady 1988, J. Mech. Phys. Solids
# 36, 353).
MOST_TENSION = 0.2
# Times the density of a shipped material of the same family: alloying changes it by tenths.
LIKE_DENSITY = 2.0


def doubts_of(material: Material) -> Iterator[Doubt]:
    """The doubts about the constants of a material, one of each."""
    units = material.paths()
    unusual = (
        doubt
        for path, about in material.usual()
        for doubt in _unusual(path, material.constant(path), about, units.get(path, "1"))
    )
    at_odds = _of_density(material), _of_stiffness(material), _of_tension(material), _of_fracture(material)
    first: dict[str, Doubt] = {}
    for doubt in chain(*at_odds, unusual):
        first.setdefault(doubt.name, doubt)
    yield from first.values()


def doubts_of_matter(matter: "Matter", stated: float | None) -> Iterator[Doubt]:
    """The doubts about matter without a material, by the fields of its laws; ``stated`` is its bulk modulus, Pa."""
    from solver.matter.eos import reference_density, reference_sound_speed

    density = reference_density(matter.eos)
    yield from _unusual("density", density, marked(Scalars, Described)["density"], "kg m-3")
    if stated is not None:
        yield from _of_moduli(density * reference_sound_speed(matter.eos) ** 2, stated, matter.shear_modulus)
    for record in (matter.eos, matter.strength, matter.failure):
        kind: type = type(record)
        units = marked(kind, Unit)
        for name, about in marked(kind, Described).items():
            if about.usual is not None:
                yield from _unusual(name, getattr(record, name), about, units[name].symbol)


def doubts_of_parameters(record: type, values: Mapping[str, Value]) -> Iterator[Doubt]:
    """The doubts about the parameters of a scenario, by name: those of the constants of failures."""
    units = marks(record, Unit)
    for name, about in marks(record, Described).items():
        if about.usual is not None:
            yield from _unusual(name, values.get(name), about, units[name].symbol)


def _unusual(name: str, value: Value, about: Described, unit: str) -> Iterator[Doubt]:
    """The doubt about a number beyond what is usual; there is none about a zero where matter may go without."""
    assert about.usual is not None
    low, high = about.usual
    if not isinstance(value, int | float) or low <= value <= high or (value == 0.0 == about.minimum):
        return
    what = about.meaning.partition(";")[0]
    yield Doubt(name, _short(value, unit), f"{_short(low, unit)} to {_short(high, unit)} is usual ({what})")


def _short(value: float, unit: str) -> str:
    """A number with the digits that a doubt needs."""
    return readable(float(f"{value:.4g}"), unit)


def _of_stiffness(material: Material) -> Iterator[Doubt]:
    elastic = material.elastic
    for doubt in _of_moduli(material.stiffness, elastic.bulk_modulus, elastic.shear_modulus):
        yield replace(doubt, name=f"elastic.{doubt.name}")
    stress = yield_stress(material)
    if stress is not None and stress > STRONGEST * elastic.shear_modulus:
        why = f"{_short(stress, 'Pa')} is more than a tenth of the shear modulus, at which no metal yields"
        yield Doubt("strength", material.strength.kind, why)


def _of_moduli(acts: float, stated: float, shear: float) -> Iterator[Doubt]:
    """The doubts about a bulk and a shear modulus beside the bulk modulus of the equation of state, Pa."""
    if not math.isclose(stated, acts, rel_tol=BULK_MODULUS_AGREEMENT):
        why = f"the equation of state has rho0 c0^2 = {_short(acts, 'Pa')}, which acts alone: this modulus is not used"
        yield Doubt("bulk_modulus", _short(stated, "Pa"), why)
    if shear > 1.5 * acts:
        why = f"above 1.5 bulk moduli, {_short(1.5 * acts, 'Pa')}, Poisson's ratio is negative"
        yield Doubt("shear_modulus", _short(shear, "Pa"), why)


def _of_tension(material: Material) -> Iterator[Doubt]:
    most = MOST_TENSION * material.stiffness
    for path in ("tension.spall_strength", "spall.strength"):
        value = material.constant(path)
        if value is not None and value > most:
            why = f"no solid bears a tension above a fifth of its bulk modulus, {_short(most, 'Pa')}"
            yield Doubt(path, _short(value, "Pa"), why)


def _of_fracture(material: Material) -> Iterator[Doubt]:
    """D1 + D2 exp(D3 sigma*) falls with sigma*, which is positive in tension.

    Abaqus writes exp(-d3 eta) with the same eta (Analysis User's Guide, Johnson-Cook criterion of damage initiation).
    """
    D2, D3 = material.fracture.D2, material.fracture.D3
    if D2 is not None and D3 is not None and D2 * D3 > 0.0:
        why = (
            "with D1 + D2 exp(D3 sigma*), sigma* positive in tension, matter would bear more in tension than in "
            f"compression: programs that write exp(-D3 sigma*) have {_short(-D3, '1')} here as {_short(D3, '1')}"
        )
        yield Doubt("fracture.D3", _short(D3, "1"), why)


def _of_density(material: Material) -> Iterator[Doubt]:
    source = material.sources.get("density")
    if source is None or source.confidence != "user":
        return
    like = [other.density for other in map(shipped.load, shipped.names()) if other.family == material.family]
    if like and not min(like) / LIKE_DENSITY <= material.density <= max(like) * LIKE_DENSITY:
        why = f"{material.family} is {_short(min(like), 'kg m-3')} to {_short(max(like), 'kg m-3')}"
        yield Doubt("density", _short(material.density, "kg m-3"), why)
