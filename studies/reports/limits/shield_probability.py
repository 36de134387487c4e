"""The probability that a simulated wall fails: from equations and shots, and joined with what the simulation says."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from studies.cubes.points import by_run, places_of, refinements_of
from studies.cubes.variables import EQUIVALENT_DIAMETER
from studies.laws import Shot
from studies.observations.shields.answers import shown
from studies.observations.shields.drawn import SimulationKind, beside_held, briefly_beside_held
from studies.observations.shields.joined import NOT_JOINED, Simulated, cells_across, cells_through, joint
from studies.observations.shields.judged import RANGES, range_of
from studies.observations.shields.outside import outside_of_shots
from studies.observations.shields.probability import Probability, probability
from studies.quantities.numerical_defaults import RECIPES
from studies.quantities.units import readable
from studies.reports.limits.outcomes import OF_MODEL
from studies.reports.limits.shield import ShieldLimit, shots_of
from studies.reports.limits.shield_verdict import ShieldTerms, place_of, values_of
from studies.reports.words import capital, joined, plural, shortest, words

ROUNDED = 1e-6  # relative: of a number of cells
MOST_SAID = 3  # speeds and shields with a sentence
# How the simulated shots were computed: by one recipe, and all cells by the rule.
_RECIPE = RECIPES["whipple"]
CALIBRATED: Mapping[str, Any] = {
    **{"geometry": "axisymmetric", "projectile_shape": "sphere", "edges": "fixed", "eos_form": "hugoniot"},
    **{"contact": "none", "particles_per_cell": _RECIPE.particles_per_cell},
    **{"shape": _RECIPE.shape, "scheme": _RECIPE.scheme, "tension": _RECIPE.tension},
    **{"viscosity_linear": _RECIPE.viscosity_linear, "viscosity_quadratic": _RECIPE.viscosity_quadratic},
}
CELLS = ("cells_per_diameter", "cells_per_wall")
TOLD: dict[bool | None, Simulated] = {True: "perforated", False: "held", None: "open"}
DOES: dict[bool | None, str] = {True: "perforates", False: "is held", None: "is undecided"}


@dataclass(frozen=True)
class WallChance:
    """How likely the wall fails at a point of a sweep."""

    diameter: float  # m
    perforated: bool | None  # by the simulation; None: open
    before: Probability  # from equations and shots
    joined: Probability | None  # with the simulation; None where it is not joined
    why: str  # it is not joined; else empty

    @property
    def best(self) -> Probability:
        """With the simulation where it is joined."""
        return self.joined or self.before

    @property
    def sentence(self) -> str:
        """ "71 % (45 to 88) to fail; 42 % (27 to 58) without simulation"."""
        after = f"{shown(self.before)} without simulation" if self.joined else NOT_JOINED
        return f"{shown(self.best)} to fail; {after}"


@dataclass(frozen=True)
class LimitChances:
    """How likely the wall fails at the points of a limit that have a probability, and why the others have none."""

    known: tuple[WallChance, ...]
    unknown: tuple[str, ...]  # a reason each


Computed = tuple[ShieldLimit, Sequence[WallChance]]


def chances_of(dataset: xr.Dataset, points: xr.Dataset, limits: Sequence[ShieldLimit]) -> list[LimitChances]:
    """The chances of the runs of each limit; none outside of all shots, and where no equation covers a run."""
    axes = [*limits[0].at] if limits else []
    shots: dict[tuple[Any, ...], list[Shot]] = {}
    for place, shot in shots_of(dataset):
        shots.setdefault(tuple(place[axis] for axis in axes), []).append(shot)
    settings = {name: by_run(points, name) for name in ("failure", *CALIBRATED, *CELLS) if name in points.variables}
    if CELLS[0] not in settings:  # of several grids the finest
        settings[CELLS[0]] = np.full(len(settings["failure"]), dataset[CELLS[0]].max())
    sizes = zip(by_run(points, "speed"), by_run(points, EQUIVALENT_DIAMETER.name), strict=True)
    keys = [(*(place[axis] for axis in axes), *size) for place, size in zip(places_of(points), sizes, strict=True)]
    cells = {key: cell for cell, key in enumerate(keys)}
    has_grids = CELLS[0] in refinements_of(dataset)
    chances = []
    for limit in limits:
        at = (*limit.at.values(), limit.speed)
        of_runs = [{name: each[cells[*at, run.diameter]] for name, each in settings.items()} for run in limit.runs]
        of_limit = [*_of_limit(shots.get(at[:-1], ()), limit, of_runs, has_grids)]
        known = tuple(each for each in of_limit if isinstance(each, WallChance))
        chances.append(LimitChances(known, tuple(each for each in of_limit if isinstance(each, str))))
    return chances


def _of_limit(
    shots: Sequence[Shot], limit: ShieldLimit, settings: Sequence[Mapping[str, Any]], has_grids: bool
) -> Iterator[WallChance | str]:
    """Chances at one speed on one shield, of which these are shots, by the settings of each run; or why it has none."""
    for run, mine in zip(limit.runs, settings, strict=True):
        shot = _shot_of(shots, limit.speed, run.diameter, is_sphere=mine["projectile_shape"] == "sphere")
        before = probability(shot) if shot else None
        if shot is None or before is None:
            yield next(outside_of_shots(shot) if shot else iter(()), "no equation covers it")
            continue
        kind = SimulationKind((str(mine["failure"]),), "several" if has_grids else "one")
        constants = joint(kind)
        if constants is None:
            how = "on several grids with one failure alone" if has_grids else f"with failure {kind.name}"
            why = f"no shots were simulated {how}"
        elif not constants.is_joined_at(shot.normal_speed):
            where = RANGES[range_of(shot.normal_speed)][0]
            why = f"{where}, simulations with failure {kind.name} are not seen to improve P"
        else:
            why = _why_not(shot, mine)
        after = constants.probability(before, TOLD[run.perforated]) if constants and not why else None
        yield WallChance(run.diameter, run.perforated, before, after, why and f"{NOT_JOINED}: {why}")


def _shot_of(shots: Sequence[Shot], speed: float, diameter: float, *, is_sphere: bool) -> Shot | None:
    """The shot of a run; None where a search tried a cylinder that no shot of the sweep is of."""
    for shot in shots:
        if math.isclose(shot.speed, speed, rel_tol=ROUNDED) and math.isclose(
            shot.projectile_diameter, diameter, rel_tol=ROUNDED
        ):
            return shot
    return replace(shots[0], speed=speed, projectile_diameter=diameter) if shots and is_sphere else None


def _why_not(shot: Shot, settings: Mapping[str, Any]) -> str:
    """Why no simulated shots are like the runs of a limit."""
    if shot.obliquity:
        return "no shots were simulated at an angle"
    for name, calibrated in CALIBRATED.items():
        if settings[name] != calibrated:
            value = settings[name] if isinstance(calibrated, str) else f"{settings[name]:g}"
            return f"no shots were simulated with {words(name)} {value}"
    assert shot.shield is not None
    across, through = (float(settings[name]) for name in CELLS)
    least = cells_across(shot.projectile_diameter, shot.shield.bumper_thickness)
    if across < least * (1.0 - ROUNDED):
        return f"the shots were simulated on at least {least:.0f} cells across"
    least = cells_through(shot.shield.wall_thickness, shot.projectile_diameter, least)
    if through < least * (1.0 - ROUNDED):
        return f"the shots were simulated on at least {least:.0f} cells through the wall"
    return ""


def in_words(limits: Sequence[ShieldLimit], chances: Sequence[LimitChances], terms: ShieldTerms) -> dict[str, Any]:
    """Headline of a sweep that brackets no limit, a sentence for each shot, and all chances as plain objects."""
    pairs = [(limit, mine.known) for limit, mine in zip(limits, chances, strict=True) if mine.known]
    groups = _of_shots(pairs)
    headline = ""
    if len(pairs) == len(limits) and all(len(limit.runs) == 1 for limit in limits):
        worst = max(groups, key=lambda group: max(mine[0].best.value for _, mine in group))
        headline = _headline(worst, _shield(worst, pairs, terms), "." if terms.has_grids else "; one mesh.")
    every = [chance for _, mine in pairs for chance in mine]
    why = list(dict.fromkeys(each.why for each in every if each.why))
    return {
        "headline": headline,
        "sentences": [
            *(_sentence(group, _shield(group, pairs, terms)) for group in groups[:MOST_SAID]),
            *(f"{capital(each)}." for each in (*why, *_without(limits, chances, terms))),
        ],
        "rows": [
            {"at": dict(limit.at), "speed": limit.speed, **asdict(chance), "does": _does(limit, chance)}
            for limit, mine in pairs
            for chance in mine
        ],
    }


def _without(limits: Sequence[ShieldLimit], chances: Sequence[LimitChances], terms: ShieldTerms) -> Iterator[str]:
    """Which limits and runs have no probability, and why."""
    places: dict[str, list[str]] = {}
    for limit, mine in zip(limits, chances, strict=True):
        if not mine.known and mine.unknown:
            places.setdefault(mine.unknown[0], []).append(place_of(limit, terms))
    yield from (f"no probability at {joined(at)}: {reason}" for reason, at in [*places.items()][:MOST_SAID])
    others = [reason for mine in chances if mine.known for reason in mine.unknown]
    if others:
        reasons = "; ".join([*dict.fromkeys(others)][:MOST_SAID])
        yield f"no probability of {plural(len(others), 'more point')}: {reasons}"


def _does(limit: ShieldLimit, chance: WallChance, model: str = "") -> str:
    """What the wall does in the simulation; where it holds, how many of the failures such simulations find."""
    does = DOES[chance.perforated] + model
    return f"{does} ({beside_held(limit.found)})" if chance.perforated is False else does


def _of_shots(pairs: Sequence[Computed]) -> list[list[Computed]]:
    """Limits of one speed and shield together, however they are computed."""
    groups: dict[tuple[Any, ...], list[Computed]] = {}
    for limit, chances in pairs:
        shield = [(name, value) for name, value in limit.at.items() if name not in OF_MODEL]
        groups.setdefault((limit.speed, *shield), []).append((limit, chances))
    return list(groups.values())


def _shield(group: Sequence[Computed], pairs: Sequence[Computed], terms: ShieldTerms) -> str:
    """Speed of a group, and what tells its shield from the others: "7 km/s, wall thickness 3 mm"."""
    limit = group[0][0]
    told = [name for name in limit.at if name not in OF_MODEL and len({each.at[name] for each, _ in pairs}) > 1]
    return ", ".join([readable(limit.speed, "m s-1"), *values_of({name: limit.at[name] for name in told}, terms)])


def _headline(group: Sequence[Computed], shield: str, end: str) -> str:
    """What the simulation of one shot says, and how likely the wall fails."""
    chances = [chance for _, [chance] in group]
    limit, [worst] = max(group, key=lambda each: each[1][0].best.value)
    begin = f"{shield}, {_size(worst)}:"
    if worst.joined:
        return shortest([f"{begin} {worst.sentence}{end}", f"{begin} {shown(worst.best)} to fail{end}"])
    outcomes = {each.perforated for each in chances}
    does = (DOES[worst.perforated] if len(outcomes) == 1 else DOES[None]).removeprefix("is ")
    why = " (models disagree)" if len(outcomes) > 1 else ""
    if outcomes == {False}:
        why = f" {briefly_beside_held(limit.found)}"
    likely = f"{shown(worst.before)} to fail"
    endings = (f" by equations and shots{end}", f" by equations{end}", end, ".")
    texts = [f"{begin} {does} in simulation{why}; {likely}{ending}" for ending in endings]
    return shortest([*texts, f"{begin} {likely}{end}"])


def _sentence(group: Sequence[Computed], shield: str) -> str:
    """The chances of a shot at the ends of the interval, or of the one run; where it has none, of the middle run."""
    said: dict[tuple[str, str], list[str]] = {}
    for limit, chances in group:
        ends = [each for each in chances if each.diameter in (limit.lower, limit.upper)]
        model = ", ".join(f"{words(name)} {value}" for name, value in limit.at.items() if name in OF_MODEL)
        for each in ends or [chances[len(chances) // 2]]:
            does = _does(limit, each, f" with {model}" if model else "")
            said.setdefault((_size(each), each.sentence), []).append(does)
    texts = [f"{size} {joined(list(dict.fromkeys(does)))}: {sentence}" for (size, sentence), does in said.items()]
    return f"At {shield}, {'. '.join(texts)}."


def _size(chance: WallChance) -> str:
    return readable(float(f"{chance.diameter:.3g}"), "m")
