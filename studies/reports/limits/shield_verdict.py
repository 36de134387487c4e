"""The verdict on equations of shields in words: a sentence for each range of the normal speed, and the headline."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from studies.cubes.points import Place
from studies.observations.shields.answers import SHORT
from studies.observations.shields.drawn import beside_held, briefly_beside_held
from studies.observations.shields.judged import RANGES, range_of
from studies.quantities.display import digits, display_of
from studies.quantities.units import readable
from studies.reports.judgement import beginning
from studies.reports.limits.shield import CriticalDiameter, EquationWord, ShieldLimit, why_unjudged
from studies.reports.words import capital, difference, joined, plural, shortest, spanned, words

# From the gravest on: where the points of a range differ, an equation stands under the first.
SAID: Mapping[EquationWord, str] = {
    "unsafe": "unsafe",
    "careful": "too careful",
    "agrees": "agrees",
    "open": "not told apart",
    "unjudged": "not judged",
    "outside": "outside its range",
}
MOST_LISTED = 3  # points of a range whose intervals its sentence lists
STATEMENT = (
    "An equation is unsafe where its critical diameter is above the interval of the simulation, so that it says that "
    "a wall holds which is perforated; too careful below the interval; and agrees inside. The simulation calls a wall "
    "failed that is perforated, and so does Reimerdes; the other equations call detached spall a failure too, which "
    "makes them more careful. The yield stress of the wall is the first that its material states. "
)
ONE_GRID = "Every run is on one grid: what a finer one would change is unknown."
NO_RUN = "no run tells whether the wall holds"
SEVERAL = "A point whose grids disagree is undecided, and widens the interval."

Entry = tuple[ShieldLimit, CriticalDiameter]


@dataclass(frozen=True)
class ShieldTerms:
    """What the sentences about a sweep share."""

    units: Mapping[str, str | None]  # of the axes, SI; None for text
    what: str  # "spheres", or "projectiles"
    has_grids: bool  # whether each point has several


def verdict_on_equations(limits: Sequence[ShieldLimit], terms: ShieldTerms) -> dict[str, Any]:
    """Headline, statement, regimes and every point, as plain objects."""
    regimes = []
    for place, (name, *_) in enumerate(RANGES):
        mine = [limit for limit in limits if range_of(limit.normal_speed) == place]
        if mine:
            equations = list(_of_regime(mine))
            sentence = _sentence(name, mine, equations, terms)
            regimes.append({"regime": name, "points": len(mine), "sentence": sentence, "equations": equations})
    rows = [each.as_json() for each in limits]
    for each in (each for row in rows for each in row["equations"]):
        each["says"] = SAID[each["word"]]
    statement = STATEMENT + (SEVERAL if terms.has_grids else ONE_GRID)
    return {"headline": _headline(limits, terms), "statement": statement, "regimes": regimes, "rows": rows}


def _of_regime(limits: Sequence[ShieldLimit]) -> Iterator[dict[str, Any]]:
    """Each equation over the points of a range: its gravest word, at how many of them, and how far off it is there."""
    entries: dict[str, list[Entry]] = {}
    for limit in limits:
        for each in limit.equations:
            entries.setdefault(each.law, []).append((limit, each))
    for law, mine in entries.items():
        word = min((each.word for _, each in mine), key=list(SAID).index)
        of_word = [entry for entry in mine if entry[1].word == word]
        excesses = [_excess(entry) for entry in of_word] if word in ("unsafe", "careful") else []
        yield {
            "law": law,
            "name": short_name(of_word[0][1]),
            "word": word,
            "says": SAID[word],
            "points": len(of_word),
            "of": len(mine),
            "diameters": [each.diameter for _, each in of_word],
            "smallest": min(excesses, default=None),
            "largest": max(excesses, default=None),
        }


def _excess(entry: Entry) -> float:
    limit, each = entry
    return each.excess(limit.lower, limit.upper)


def short_name(equation: CriticalDiameter) -> str:
    """The author with what the field calls the equation: "Christiansen (NNO)", "Reimerdes"."""
    author, short = beginning(equation.title), SHORT.get(equation.law.partition("/")[0], "")
    return f"{author} ({short})" if short not in ("", author, equation.title) else author


# ---- sentences -----------------------------------------------------------------------------------


def _sentence(
    name: str, limits: Sequence[ShieldLimit], equations: Sequence[Mapping[str, Any]], terms: ShieldTerms
) -> str:
    """What the simulation gives in a range of the normal speed, and how each equation does there."""
    if len(limits) <= MOST_LISTED:
        held = joined([f"{_held(limit)} ({place_of(limit, terms)})" for limit in limits])
    else:
        held = joined([*_held_at(limits)])
    besides = dict.fromkeys(beside_held(limit.found) for limit in limits if math.isfinite(limit.lower))
    groups = []
    for word, says in SAID.items():
        mine = [each for each in equations if each["word"] == word]
        if mine:
            says = f"{says}, because runs are {why_unjudged(limits)}" if word == "unjudged" else says
            groups.append(f"{says}: {', '.join(map(_in_regime, mine))}")
    answers = "; ".join(groups) or "no equation is about such a shield"
    return f"{capital(name)}: the limit is {'; '.join([held, *besides])}. {capital(answers)}."


def _in_regime(equation: Mapping[str, Any]) -> str:
    """ "Christiansen (NNO) 3.9 mm, 11 % high", and at how many points where that is not all."""
    parts = [f"{equation['name']} {_sizes(min(equation['diameters']), max(equation['diameters']))}"]
    if equation["smallest"] is not None:
        parts.append(difference([equation["smallest"], equation["largest"]]))
    if equation["points"] < equation["of"]:
        parts.append(f"at {equation['points']} of {plural(equation['of'], 'point')}")
    return " ".join(parts) if len(parts) == 1 else f"{parts[0]} ({', '.join(parts[1:])})"


def _held(limit: ShieldLimit) -> str:
    """The interval of the simulation."""
    if limit.is_bracketed:
        return _sizes(limit.lower, limit.upper)
    if math.isfinite(limit.lower):
        return f"above {_sizes(limit.lower, limit.lower)}"
    return f"below {_sizes(limit.upper, limit.upper)}" if math.isfinite(limit.upper) else "unknown"


def _held_at(limits: Sequence[ShieldLimit]) -> Iterator[str]:
    """The intervals of many points: those with both ends together, and those with one."""
    kinds: dict[str, list[ShieldLimit]] = {}
    for limit in limits:
        kinds.setdefault("" if limit.is_bracketed else _held(limit).partition(" ")[0], []).append(limit)
    for kind, mine in sorted(kinds.items()):
        ends = [end for limit in mine for end in (limit.lower, limit.upper) if math.isfinite(end)]
        sizes = _sizes(min(ends), max(ends)) if ends else ""
        yield " ".join(filter(None, (kind, sizes, "at", plural(len(mine), "point"))))


def place_of(limit: ShieldLimit, terms: ShieldTerms) -> str:
    """ "7 km/s", and the values of the other axes."""
    return ", ".join([readable(limit.speed, "m s-1"), *values_of(limit.at, terms)])


def values_of(at: Place, terms: ShieldTerms) -> list[str]:
    """Values of axes with their names: "wall thickness 3 mm"."""
    texts = (
        value if isinstance(value, str) else readable(value, terms.units[name] or "1") for name, value in at.items()
    )
    return [f"{words(name)} {text}" for name, text in zip(at, texts, strict=True)]


def _sizes(low: float, high: float) -> str:
    """One or two diameters: "3.12-3.5 mm"."""
    display = display_of("m")
    return f"{spanned(digits(low * display.factor), digits(high * display.factor))} {display.unit}"


# ---- headline ------------------------------------------------------------------------------------


def _headline(limits: Sequence[ShieldLimit], terms: ShieldTerms) -> str:
    """The gravest verdict: the equation that is unsafe by most, else too careful by most, else how many agree."""
    entries = [(limit, each) for limit in limits for each in limit.equations]
    for word in ("unsafe", "careful"):
        if mine := [entry for entry in entries if entry[1].word == word]:
            limit, worst = max(mine, key=lambda entry: abs(_excess(entry)))
            says = f"{short_name(worst)} says {_sizes(worst.diameter, worst.diameter)}: {SAID[worst.word]}"
            others = sum(each.word == word for each in limit.equations) - 1
            return _stated(limit, [f"{says}, {others} more too", says] if others else [says], terms)
    if agreeing := [entry for entry in entries if entry[1].word == "agrees"]:
        limit = max((limit for limit, _ in agreeing), key=lambda each: each.speed)
        names = [short_name(each) for each in limit.equations if each.word == "agrees"]
        return _stated(limit, [f"all {len(names)} equations agree" if len(names) > 1 else f"{names[0]} agrees"], terms)
    known = [limit for limit in limits if math.isfinite(limit.lower) or math.isfinite(limit.upper)]
    if not known:
        is_told = any(run.perforated is not None for limit in limits for run in limit.runs)
        return f"No verdict: {'a larger projectile is held than one that perforates' if is_told else NO_RUN}."
    limit = max(known, key=lambda each: (each.is_bracketed, each.speed))
    if not entries:
        return _stated(limit, ["no equation is about such a shield"], terms)
    if limit.unjudged:
        return _stated(limit, [f"no equation is judged: {limit.unjudged}", "no equation is judged"], terms)
    covered = any(each.word != "outside" for _, each in entries)
    return _stated(limit, ["no equation is told apart" if covered else "no equation covers it"], terms)


def _stated(limit: ShieldLimit, says: Sequence[str], terms: ShieldTerms) -> str:
    """What the wall does and what is said of equations, in few enough words; the place goes last, after the mesh."""
    mesh = "" if terms.has_grids else "; one mesh"
    does, briefly = _does(limit)
    place, speed = f"At {place_of(limit, terms)},", f"At {readable(limit.speed, 'm s-1')}"
    begins = [f"{place} {terms.what} {does}", f"{place} {briefly}"] if limit.at else []
    bare = [f"{speed} {terms.what} {does}", f"{speed} {terms.what} {briefly}", f"{speed}, {briefly}"]
    texts = [
        f"{begin}; {text}{end}." for each in (begins, bare) for end in (mesh, "") for begin in each for text in says
    ]
    return shortest([*texts, f"{bare[-1]}."])


def _does(limit: ShieldLimit) -> tuple[str, str]:
    """What the wall does to projectiles, "up to 3.12-3.5 mm are held", and with fewer words."""
    if math.isfinite(limit.lower):
        sizes = f"up to {_sizes(limit.lower, limit.upper if limit.is_bracketed else limit.lower)}"
        found = briefly_beside_held(limit.found)
        return f"{sizes} are held {found}", f"{sizes} held {found}"
    sizes = f"from {_sizes(limit.upper, limit.upper)} on"
    return f"{sizes} perforate", f"{sizes} perforate"
