"""Screening runs: a run again with another strength, another failure or another equation of state.

They show what the choice of models does to an answer; ``model_part: screen`` adds those of the middle of a sweep, and
``python -m docs.model_part`` stores those of a few reference shots.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from studies import materials as shipped
from studies.materials import Material
from studies.quantities.findings import InvalidInput
from studies.runs.run import Run, materials_of, resolve

# Relative standard deviation of the strength that sources state for one metal. Yield stress of Al 6061-T6: 276 MPa
# (pyBLOSSUM), 290 MPa (Steinberg 1996), 324 MPa (Lesuer 2001): 8 %. Flow stress of annealed copper at a plastic strain
# of 1 and 1e5/s: 492 MPa (Johnson and Cook 1983), 484 MPa (Johnson and Holmquist 1988), 582 MPa (Ma 2005, Table 2.1),
# 602 MPa (OpenMPM3D's Taylor bar), 609 MPa (Steinberg 1996): 11 %.
STRENGTH_DEVIATION = 0.10
# K of the failure that is switched on, at the material's spall strength: 30 GPa of tension break copper in 5 ns
# (solver/matter/failure/spall.py).
FAILURE_TIME = 1e-6  # s

STRONGER, WEAKER, FAILURE, EOS = "stronger", "weaker", "failure", "equation of state"
SCREENS = (STRONGER, WEAKER, FAILURE, EOS)
CONTRIBUTIONS = ("strength", FAILURE, EOS)


@dataclass(frozen=True)
class Screen:
    """One change of a run; without a run where there is no alternative."""

    name: str  # one of SCREENS
    run: Run | None
    reason: str = ""  # why there is no run


def screens_of(run: Run) -> Iterator[Screen]:
    """Every change of a run."""
    materials = materials_of(run)
    yield _screen(run, STRONGER, _of_strength(materials, 1.0 + STRENGTH_DEVIATION), {})
    yield _screen(run, WEAKER, _of_strength(materials, 1.0 - STRENGTH_DEVIATION), {})
    yield _switched_failure(run, materials)
    others = {role: _of_other_eos(material) for role, material in materials.items()}
    if not any(others.values()):
        names = ", ".join(dict.fromkeys(material.name for material in materials.values()))
        yield Screen(EOS, None, f"no material has the strength of {names} and another form")
        return
    changed = {role: other or materials[role] for role, other in others.items()}
    yield _screen(run, EOS, changed, {role: material.name for role, material in changed.items()})


def contributions_of(base: float, answers: Mapping[str, float]) -> dict[str, float]:
    """Relative standard uncertainties of an answer, from its values with each change; those that can be told.

    Half the difference of a stronger and a weaker material, one standard deviation either way; and the difference
    that the other failure or equation of state makes, over sqrt(3): anything between both choices is equally likely
    (GUM, JCGM 100:2008, 4.3.7).
    """
    told = {}
    if STRONGER in answers and WEAKER in answers:
        told["strength"] = 0.5 * abs(answers[STRONGER] - answers[WEAKER]) / abs(base)
    for name in (FAILURE, EOS):
        if name in answers:
            told[name] = abs(answers[name] - base) / math.sqrt(3.0) / abs(base)
    return told


def _screen(run: Run, name: str, materials: Mapping[str, Material], changes: Mapping[str, object]) -> Screen:
    try:
        changed = resolve(run.scenario, {**run.parameters, **changes}, materials)
    except InvalidInput as error:
        return Screen(name, None, "; ".join(str(finding) for finding in error.findings))
    return Screen(name, changed)


def _of_strength(materials: Mapping[str, Material], factor: float) -> dict[str, Material]:
    """The materials with every constant of their strengths that is a stress so many times as large."""
    return {role: _scaled(material, factor) for role, material in materials.items()}


def _scaled(material: Material, factor: float) -> Material:
    for path, unit in material.paths().items():
        value = material.value_at(path)
        if path.startswith("strength.") and unit == "Pa" and value is not None:
            material = material.with_value(path, factor * value)
    return material


def _switched_failure(run: Run, materials: Mapping[str, Material]) -> Screen:
    """The run without the failure that it has, or with spall where it has none."""
    failure = run.parameters.get("failure")
    if failure is None:
        return Screen(FAILURE, None, f"{run.scenario} has no failure to switch")
    constants = {name: None for name in run.parameters if name.startswith("failure_")}
    if failure != "none":
        return _screen(run, FAILURE, materials, {**constants, "failure": "none"})
    return _screen(run, FAILURE, materials, {**constants, "failure": "spall", "failure_time": FAILURE_TIME})


def _of_other_eos(material: Material) -> Material | None:
    """The first material that ships with the same family and strength and another kind of equation of state."""
    alike = (material.family, material.strength)
    for other in map(shipped.load, shipped.names()):
        if (other.family, other.strength) == alike and other.eos.kind != material.eos.kind:
            return other
    return None
