"""Warnings about a sweep that is allowed: slow impacts, plates that nothing perforates, doubtful constants."""

from collections import defaultdict
from collections.abc import Iterator

from studies import laws
from studies.laws import Shot
from studies.quantities.findings import Doubt
from studies.quantities.units import readable
from studies.scenarios.parts.doubts import doubts_of, doubts_of_parameters
from studies.sweeps.search import doubts_of_searches
from studies.sweeps.sweep import Sweep

# Damage number rho v^2 / Y from which on an impact deforms metal extensively: Johnson (1972), Impact Strength of
# Materials, chapter 1 (bullets about 10, hypervelocity from 1000).
EXTENSIVE = 10.0
# A target thicker than three crater depths does not even spall: Gehring, in Cour-Palais (1987).
NO_SPALL = 3.0
MOST_LOOKED_AT = 200  # points that differ in constants; each takes half a millisecond


def warnings_of(sweep: Sweep) -> list[str]:
    """One sentence for each doubt about the points of a sweep, with the farthest of them."""
    shots = list(sweep.shots())
    numbers, ratios = [damage_number(shot) for shot in shots], [depths(shot) for shot in shots]
    slow, thick = sum(number < EXTENSIVE for number in numbers), sum(r > NO_SPALL for r in ratios)
    searched = [axis.search.quantity for axis in sweep.axes if axis.search]
    warnings = [*doubts_of_searches(searched), *doubtful_constants(sweep)]
    if slow:
        number = min(numbers)
        speed = readable(shots[numbers.index(number)].speed, "m s-1")
        warnings.append(
            f"speed {speed}: rho v^2/Y = {number:.2g} is below {EXTENSIVE:g}, so that strength decides the outcome, "
            f"and no law of hypervelocity holds ({slow} of {len(shots)} points)"
        )
    if thick:
        ratio = max(ratios)
        thickness = shots[ratios.index(ratio)].thickness_ratio
        warnings.append(
            f"t/d = {thickness:.3g}: the plate is {ratio:.0f} times as thick as the crater in a thick block is deep "
            "(Charters and Summers), so that no hole is expected; use scenario thick_plate "
            f"({thick} of {len(shots)} points)"
        )
    return warnings


def doubtful_constants(sweep: Sweep) -> Iterator[str]:
    """A sentence for each constant of a material or a failure that is doubtful at some point, with the first value."""
    found, looked_at = defaultdict[tuple[str, str], list[Doubt]](list), 0
    for values, materials in sweep.each_constants(MOST_LOOKED_AT):
        looked_at += 1
        record = sweep.definition.parameters
        for doubt in (*doubts_of_parameters(record, values), *record.doubts(values)):
            found[doubt.name, ""].append(doubt)
        for role, material in materials.items():
            for doubt in doubts_of(material):
                found[f"{role}.{doubt.name}", material.name].append(doubt)
    for (name, of), doubts in found.items():
        where = "" if len(doubts) == looked_at else ", at some points"
        yield f"{name} = {doubts[0].value}{of and f' of {of}'}{where}: {doubts[0].why}"


def damage_number(shot: Shot) -> float:
    """rho v^2 / Y with the target's density and its smallest published yield stress; infinite without one."""
    stresses = [stress.value for stress in shot.target.yield_stresses]
    return shot.target.density * shot.speed**2 / min(stresses) if stresses else float("inf")


def depths(shot: Shot) -> float:
    """Thickness of the plate over the depth of a crater in a thick block; zero without a plate.

    Also zero of a plate no thicker than the projectile, which stops only what the damage number calls slow; so a
    sweep of thin plates loads no law.
    """
    if shot.plate_thickness is None or shot.thickness_ratio <= 1.0:
        return 0.0
    return shot.plate_thickness / laws.load("charters_summers").evaluate(shot).value
