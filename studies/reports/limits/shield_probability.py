"""The probability that a simulated wall fails: from equations and shots, and joined with what the simulation says."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import xarray as xr

from studies.cubes.points import by_run, refinements_of
from studies.laws import Shot
from studies.observations.shields.answers import shown
from studies.observations.shields.joined import NOT_JOINED, Simulated, SimulationKind, cells_across, joint
from studies.observations.shields.probability import Probability, probability
from studies.quantities.units import readable
from studies.reports.limits.outcomes import OF_MODEL
from studies.reports.limits.shield import ShieldLimit, shot_at, shots_of
from studies.reports.verdict.texts import capital, joined, shortest, words

RESOLUTION = "cells_per_diameter"
ROUNDED = 1e-6  # relative: of a number of cells
MOST_SAID = 3  # speeds and shields with a sentence
CALIBRATED = {"geometry": "axisymmetric", "projectile_shape": "sphere"}  # of the simulated shots
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


Computed = tuple[ShieldLimit, Sequence[WallChance]]


def chances_of(dataset: xr.Dataset, points: xr.Dataset, limits: Sequence[ShieldLimit]) -> list[list[WallChance]]:
    """The chances of the runs of each limit; none where no equation covers a run."""
    shots, chances = shots_of(dataset), list[list[WallChance]]()
    finest = float(dataset[RESOLUTION].max()) if RESOLUTION in refinements_of(dataset) else None
    for limit in limits:
        shot, named = shot_at(shots, limit.at), ("failure", *CALIBRATED, *([RESOLUTION] if finest is None else ()))
        settings = {name: limit.at[name] if name in limit.at else by_run(points, name)[0] for name in named}
        chances.append([] if shot is None else list(_of_limit(shot, limit, settings, finest)))
    return chances


def _of_limit(
    shot: Shot, limit: ShieldLimit, settings: Mapping[str, Any], finest: float | None
) -> Iterator[WallChance]:
    """Chances at one speed on one shield; ``finest`` is the resolution of the finest of several grids."""
    kind = SimulationKind((str(settings["failure"]),), "one" if finest is None else "several")
    constants = joint(kind)
    cells = float(settings[RESOLUTION]) if finest is None else finest
    for run in limit.runs:
        before = probability(replace(shot, speed=limit.speed, projectile_diameter=run.diameter))
        if before is None:
            continue
        why = _why_not(limit, settings)
        least = cells_across(run.diameter, shot.plate_thickness or math.inf)
        if constants is None:
            how = f"with failure {kind.name}" if finest is None else "on several grids with one failure alone"
            why = f"no shots were simulated {how}"
        elif constants.gained <= 0.0:
            why = f"on {constants.shots} shots, simulations with failure {kind.name} did not improve P"
        elif not why and cells < least * (1.0 - ROUNDED):
            why = f"the shots were simulated on at least {least:.0f} cells across"
        after = constants.probability(before, TOLD[run.perforated]) if constants and not why else None
        yield WallChance(run.diameter, run.perforated, before, after, why and f"{NOT_JOINED}: {why}")


def _why_not(limit: ShieldLimit, settings: Mapping[str, Any]) -> str:
    """Why no simulated shots are like the runs of a limit."""
    if limit.normal_speed < limit.speed:
        return "no shots were simulated at an angle"
    for name, calibrated in CALIBRATED.items():
        if str(settings[name]) != calibrated:
            return f"no shots were simulated with {name.replace('_', ' ')} {settings[name]}"
    return ""


def in_words(limits: Sequence[ShieldLimit], chances: Sequence[Sequence[WallChance]], one_mesh: bool) -> dict[str, Any]:
    """Headline of a sweep that brackets no limit, a sentence for each shot, and all chances as plain objects."""
    pairs = [(limit, mine) for limit, mine in zip(limits, chances, strict=True) if mine]
    groups = _of_shots(pairs)
    headline = ""
    if len(pairs) == len(limits) and all(len(limit.runs) == 1 for limit in limits):
        worst = max(groups, key=lambda group: max(mine[0].best.value for _, mine in group))
        headline = _headline(worst, "; one mesh." if one_mesh else ".")
    why = list(dict.fromkeys(chance.why for _, mine in pairs for chance in mine if chance.why))
    return {
        "headline": headline,
        "sentences": [_sentence(group) for group in groups[:MOST_SAID]] + [f"{capital(each)}." for each in why],
        "rows": [
            {"at": dict(limit.at), "speed": limit.speed, **asdict(chance), "does": DOES[chance.perforated]}
            for limit, mine in pairs
            for chance in mine
        ],
    }


def _of_shots(pairs: Sequence[Computed]) -> list[list[Computed]]:
    """Limits of one speed and shield together, however they are computed."""
    groups: dict[tuple[Any, ...], list[Computed]] = {}
    for limit, chances in pairs:
        shield = [(name, value) for name, value in limit.at.items() if name not in OF_MODEL]
        groups.setdefault((limit.speed, *shield), []).append((limit, chances))
    return list(groups.values())


def _headline(group: Sequence[Computed], end: str) -> str:
    """What the simulation of one shot says, and how likely the wall fails."""
    chances = [chance for _, [chance] in group]
    worst = max(chances, key=lambda each: each.best.value)
    begin = f"{readable(group[0][0].speed, 'm s-1')}, {_size(worst)}:"
    if worst.joined:
        return f"{begin} {worst.sentence}{end}"
    outcomes = {each.perforated for each in chances}
    does = (DOES[outcomes.pop()] if len(outcomes) == 1 else DOES[None]).removeprefix("is ")
    why = " (models disagree)" if len(outcomes) > 1 else ""
    likely = f"{shown(worst.before)} to fail by"
    return shortest(
        [f"{begin} {does} in simulation{why}; {likely} {known}{end}" for known in ("equations and shots", "equations")]
    )


def _sentence(group: Sequence[Computed]) -> str:
    """The chances of a shot at the ends of the interval, or of the one run; where it has none, of the middle run."""
    said: dict[tuple[str, str], list[str]] = {}
    for limit, chances in group:
        ends = [each for each in chances if each.diameter in (limit.lower, limit.upper)]
        model = ", ".join(f"{words(name)} {value}" for name, value in limit.at.items() if name in OF_MODEL)
        for each in ends or [chances[len(chances) // 2]]:
            does = DOES[each.perforated] + (f" with {model}" if model else "")
            said.setdefault((_size(each), each.sentence), []).append(does)
    texts = [f"{size} {joined(list(dict.fromkeys(does)))}: {sentence}" for (size, sentence), does in said.items()]
    return f"At {readable(group[0][0].speed, 'm s-1')}, {'. '.join(texts)}."


def _size(chance: WallChance) -> str:
    return readable(float(f"{chance.diameter:.3g}"), "m")
