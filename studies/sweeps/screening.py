"""Screening runs: a run again with each other strength, failure and equation of state that has a source.

They show what the choice of models does to an answer; ``model_part: screen`` adds those of the middle of a sweep, with
the sweep's own materials as further strengths, and ``python -m docs.model_part`` stores those of a few reference shots.
"""

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from studies import materials as shipped
from studies.materials import Material
from studies.materials.schema import OPTIONAL
from studies.quantities.findings import InvalidInput
from studies.quantities.parameters import Value
from studies.runs.run import Run, resolve

# Relative standard deviation of the strength that sources state for one metal. Yield stress of Al 6061-T6: 276 MPa
# (pyBLOSSUM), 290 MPa (Steinberg 1996), 324 MPa (Lesuer 2001): 8 %. Flow stress of annealed copper at a plastic strain
# of 1 and 1e5/s: 492 MPa (Johnson and Cook 1983), 484 MPa (Johnson and Holmquist 1988), 582 MPa (Ma 2005, Table 2.1),
# 602 MPa (OpenMPM3D's Taylor bar), 609 MPa (Steinberg 1996): 11 %.
STRENGTH_DEVIATION = 0.10
# Failures whose constants have a source in the file of a material, and none.
SOURCED_FAILURES = ("none", "spall-rate", "johnson-cook", "johnson-cook-spall", "void-growth")

# Of each sourced failure why the rule of docs/failure.md threw it out.
THROWN_OUT = Path(__file__).with_name("thrown_out.json")

STRENGTH, FAILURE, EOS = "strength", "failure", "equation of state"
CONTRIBUTIONS = (STRENGTH, EOS)  # to the symmetric part of what models leave open
DRAWN = f"{STRENGTH} draw"  # how the change to a material of the sweep's own begins
STRONGER, WEAKER = f"{STRENGTH} +{STRENGTH_DEVIATION:.0%}", f"{STRENGTH} -{STRENGTH_DEVIATION:.0%}"


@dataclass(frozen=True)
class Screen:
    """One change of a run; without a run where there is no alternative."""

    name: str  # strength, failure or equation of state, and what is changed
    run: Run | None
    reason: str = ""  # why there is no run


def screens_of(run: Run, own: Iterable[Material] = ()) -> Iterator[Screen]:
    """Every change of a run; ``own`` are materials of its sweep: draws of a calibration, say."""
    materials = run.materials
    for name, factor in ((STRONGER, 1.0 + STRENGTH_DEVIATION), (WEAKER, 1.0 - STRENGTH_DEVIATION)):
        yield _screen(run, name, {role: _scaled(material, factor) for role, material in materials.items()}, {})
    # Other sources and other tempers of the same alloys that ship, and the sweep's own.
    for kind, others in ((STRENGTH, map(shipped.load, shipped.names())), (DRAWN, own)):
        for alternative in _of_strengths(materials, others):
            yield _exchanged(run, kind, materials, alternative)
    yield from _of_other_failure(run, materials)
    others = [other for material in _each_once(materials) if (other := _of_other_eos(material))]
    for other in others:
        yield _exchanged(run, EOS, materials, other)
    if not others:
        names = ", ".join(material.name for material in _each_once(materials))
        yield Screen(EOS, None, f"no material has the strength of {names} and another form")


def contributions_of(base: float, answers: Mapping[str, float]) -> dict[str, float]:
    """Relative standard uncertainties of an answer by strength and equation of state, from its values by the name of
    each change; those that can be told.

    The largest difference that a change makes: each alternative has a source, may be the right one, and is no limit
    between which others lie. Draws are equally likely: theirs is one, the root mean square.
    """
    differences = {name: abs(value - base) / abs(base) for name, value in answers.items()}
    draws = [differences.pop(name) for name in answers if name.startswith(DRAWN)]
    sizes = {kind: [size for name, size in differences.items() if name.startswith(kind)] for kind in CONTRIBUTIONS}
    if draws:
        sizes[STRENGTH].append(math.sqrt(math.fsum(size**2 for size in draws) / len(draws)))
    return {kind: max(of_kind) for kind, of_kind in sizes.items() if of_kind}


def failures_of(base: float, answers: Mapping[str, float], own: Value, of: Value) -> dict[str, float]:
    """Relative differences of the answer with each other failure from that with one (``of``); ``own`` is the base's."""
    by_failure: dict[Value, float] = {own: base}
    by_failure |= {
        name.removeprefix(f"{FAILURE} "): value for name, value in answers.items() if name.startswith(FAILURE)
    }
    mine = by_failure.pop(of, None)
    return {str(name): value / mine - 1.0 for name, value in by_failure.items()} if mine else {}


@cache
def thrown_out() -> Mapping[str, str]:
    """Failures that the rule of docs/failure.md throws out, each with the reasons."""
    reasons: dict[str, str] = json.loads(THROWN_OUT.read_text(encoding="utf-8"))["reasons"]
    return {failure: why for failure, why in reasons.items() if why}


def _screen(run: Run, name: str, materials: Mapping[str, Material], changes: Mapping[str, Value]) -> Screen:
    try:
        changed = resolve(run.scenario, {**run.parameters, **changes}, materials)
    except InvalidInput as error:
        return Screen(name, None, "; ".join(str(finding) for finding in error.findings))
    return Screen(name, changed)


def _scaled(material: Material, factor: float) -> Material:
    """A material with every constant of its strength that is a stress so many times as large."""
    for path, unit in material.paths().items():
        value = material.value_at(path)
        if path.startswith("strength.") and unit == "Pa" and value is not None:
            material = material.with_value(path, factor * value)
    return material


def _each_once(materials: Mapping[str, Material]) -> list[Material]:
    return list({material.name: material for material in materials.values()}.values())


def _exchanged(run: Run, kind: str, materials: Mapping[str, Material], other: Material) -> Screen:
    """The run with another material in each role of its alloy, which breaks as before: few have those constants."""
    changed = {
        role: replace(other, **{section: getattr(own, section) for section in OPTIONAL})
        if own.alloy == other.alloy
        else own
        for role, own in materials.items()
    }
    names = {role: material.name for role, material in changed.items()}
    return _screen(run, f"{kind} of {other.name}", changed, names)


def _of_other_failure(run: Run, materials: Mapping[str, Material]) -> Iterator[Screen]:
    """The run with each failure that takes all of its constants from the materials, but its own."""
    failure = run.parameters.get("failure")
    if failure is None:
        yield Screen(FAILURE, None, f"{run.scenario} has no failure to switch")
        return
    constants = {name: None for name in run.parameters if name.startswith("failure_")}
    for other in SOURCED_FAILURES:
        if other != failure:
            yield _screen(run, f"{FAILURE} {other}", materials, {**constants, "failure": other})


def _of_strengths(materials: Mapping[str, Material], others: Iterable[Material]) -> Iterator[Material]:
    """Of some materials those of the same alloys with another strength, each strength once."""
    alloys, known = {own.alloy for own in materials.values()}, [own.strength for own in materials.values()]
    for other in others:
        if other.alloy in alloys and other.strength not in known:
            known.append(other.strength)
            yield other


def _of_other_eos(material: Material) -> Material | None:
    """The first material that ships of the same alloy and strength with another kind of equation of state."""
    alike = (material.alloy, material.strength)
    for other in map(shipped.load, shipped.names()):
        if (other.alloy, other.strength) == alike and other.eos.kind != material.eos.kind:
            return other
    return None
