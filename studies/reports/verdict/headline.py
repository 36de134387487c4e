"""The headline: in at most ``MOST_WORDS`` words the law to use, where, how far it is off, how sure that is, by what.

The rules were written down before any headline was looked at; docs/report.md has them for readers. Measured shots that
are known at first hand judge alone where there are any; else the simulation; doubtful shots say something only where
neither does, and then no law is recommended. A law stands on the widest stretch of neighbouring values of the abscissa
without a point at which it is too low or too high (``JudgedPoint.word``), if the stretch has half of its judged points
or more and the law may be used there, or is untested; else on all of them.
"""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any, Literal

from studies.reports.verdict.bands import BandValue, abscissa_of, columns_of
from studies.reports.verdict.evidence import TRUST, AxisOfSweep, Evidence, JudgedPoint, Subject
from studies.reports.verdict.stated import NumberRow
from studies.reports.verdict.texts import (
    capital,
    difference,
    joined,
    number_of,
    share,
    shortest,
    spanned,
    unit_of,
    words,
)
from studies.reports.verdict.trends import exponents_of

# No law is recommended where a larger share of the tested points has a difference beyond the joint uncertainty: one in
# five is what a few outliers may be, and the intervals of standard uncertainties leave out more by themselves.
REJECTING = 0.2
MOST_NAMED = 3  # laws that tie and are named
MOST_ROWS = 10  # laws of the table beside the headline

Judge = Literal["shots", "simulation", "doubtful"]
# From best to worst. "use": most points are tested, at most ``REJECTING`` of them reject, no difference and no joint
# uncertainty is above ``TRUST``. "wide": the same, and the joint uncertainty is above it. "untested": close or
# covered, and most points have no error bar that is a test.
Grade = Literal["use", "wide", "untested", "rejected", "far", "refuted"]
STANDS: Sequence[Grade] = ("use", "wide", "untested")
VERDICTS: Mapping[Grade, str] = {
    "use": "use",
    "wide": "agrees, wide bars",
    "untested": "untested",
    "rejected": "no",
    "far": "no",
    "refuted": "no: its exponent is refuted",
}


@dataclass(frozen=True)
class Standing:
    """A law over some values of the abscissa, by the points that judge it there."""

    law: str  # label
    name: str  # short
    grade: Grade
    values: tuple[BandValue, ...]  # of the abscissa, with judged points
    points: tuple[JudgedPoint, ...]
    elsewhere: tuple[JudgedPoint, ...]  # its other judged points

    @property
    def tested(self) -> list[JudgedPoint]:
        return [point for point in self.points if point.tests]

    @property
    def rejecting(self) -> int:
        """Tested points with a difference beyond the joint uncertainty."""
        return sum(abs(point.residual) > point.bar for point in self.tested)

    @property
    def worst(self) -> float:
        return max(abs(point.residual) for point in self.points)

    @property
    def bar(self) -> float:
        """The largest joint uncertainty that is a test; 0 where none is."""
        return max((point.bar for point in self.tested), default=0.0)

    @property
    def numerical(self) -> float:
        """The same without the model part; NaN where a point has none."""
        sizes = [point.numerical for point in self.tested]
        return max(sizes) if sizes and not any(map(math.isnan, sizes)) else math.nan


@dataclass(frozen=True)
class Headline:
    """What the headline on a quantity says, and its table."""

    text: str
    recommends: bool
    rows: tuple[NumberRow, ...]
    order: tuple[str, ...]  # labels of the laws, the first one first


def judged(evidence: Evidence, axes: Sequence[AxisOfSweep], name: str = "") -> Headline | None:
    """The headline on a quantity, which begins with ``name``; None where no point judges a law."""
    judge = _judge(evidence)
    if judge is None:
        return None
    standings = sorted(_standings(evidence, judge, axes), key=_rank)
    ties = _ties(standings)
    standings = [*ties, *(each for each in standings if each not in ties)]
    checked = {each.law: _checked(evidence, judge, each.law) for each in standings}
    texts = _texts(standings, judge, checked[standings[0].law], axes)
    # Labels of laws are one word; titles of a user's own may be long.
    texts += _texts([replace(each, name=each.law) for each in standings], judge, checked[standings[0].law], axes)
    if name:
        texts = [*(f"{name} {text}" for text in texts), *texts]
    rows = (row for each in standings for row in _rows(each, judge, checked[each.law], axes))
    recommends = judge != "doubtful" and standings[0].grade in ("use", "wide")
    order = tuple(each.law for each in standings)
    return Headline(capital(shortest(texts)), recommends, tuple(rows)[:MOST_ROWS], order)


# ---- which points judge --------------------------------------------------------------------------


def _judge(evidence: Evidence) -> Judge | None:
    every: Sequence[Judge] = ("shots", "simulation", "doubtful")
    return next((judge for judge in every if any(_points(law, judge) for law in _laws(evidence))), None)


def _laws(evidence: Evidence) -> list[Subject]:
    return [each for each in evidence.subjects if each.name != "simulation" and not each.drawn_only]


def _points(law: Subject, judge: Judge) -> list[JudgedPoint]:
    """The points of a law by which it is judged; none of a law against another reference."""
    if law.reference != ("simulation" if judge == "simulation" else "observation"):
        return []
    return [point for point in law.points if point.state == "judged" and point.doubtful == (judge == "doubtful")]


def _standings(evidence: Evidence, judge: Judge, axes: Sequence[AxisOfSweep]) -> Iterator[Standing]:
    laws = [law for law in _laws(evidence) if _points(law, judge)]
    titles = Counter(law.full_title for law in laws)
    names = short_names({law.name: law.full_title if titles[law.full_title] == 1 else law.name for law in laws})
    for law in laws:
        points = _points(law, judge)
        # Where shots are too few for an exponent, that of the simulation counts.
        exponents = list(exponents_of(points, axes)) or [
            exponent
            for other in _laws(evidence)
            if other.name == law.name
            for exponent in exponents_of(_points(other, "simulation"), axes)
        ]
        # What no error bar tests refutes nothing.
        refuted = any(point.tests for point in points) and any(exponent.is_refuted for exponent in exponents)
        columns = columns_of(points, abscissa_of(axes))
        stretch = _stretch(columns)
        inside = [point for several in stretch.values() for point in several]
        if 2 * len(inside) < len(points) or _grade(inside, refuted) not in STANDS:
            stretch, inside = columns, points
        elsewhere = tuple(point for value in columns if value not in stretch for point in columns[value])
        grade = _grade(inside, refuted)
        yield Standing(law.name, names[law.name], grade, tuple(stretch), tuple(inside), elsewhere)


def _stretch(columns: Mapping[BandValue, list[JudgedPoint]]) -> dict[BandValue, list[JudgedPoint]]:
    """The neighbouring values without a point that contradicts a law, with the most points."""
    runs = groupby(columns, key=lambda value: any(point.word in ("under", "over") for point in columns[value]))
    free = [{value: columns[value] for value in run} for contradicted, run in runs if not contradicted]
    return max(free, key=lambda run: sum(map(len, run.values())), default={})


def _grade(points: Sequence[JudgedPoint], refuted: bool) -> Grade:
    tested = [point for point in points if point.tests]
    if refuted:
        return "refuted"
    if any(point.word in ("under", "over") for point in points):
        return "far"
    if sum(abs(point.residual) > point.bar for point in tested) > REJECTING * len(tested):
        return "rejected"
    if 2 * len(tested) <= len(points):
        return "untested"
    return "use" if all(point.word == "close" for point in points) else "wide"


def _rank(law: Standing) -> tuple[Any, ...]:
    """Laws that may be used first, of these those with the most points; of others the nearest."""
    if law.grade in STANDS:
        return STANDS.index(law.grade), -len(law.points), law.worst
    return len(STANDS) + (law.grade == "refuted"), law.worst


def _ties(standings: Sequence[Standing]) -> list[Standing]:
    """The first law and those that the judge does not tell from it: of the same grade at the same points, with worst
    differences that are nearer to each other than the joint uncertainty, or than ``TRUST`` where none is known.
    """
    first = standings[0]
    places = [point.at for point in first.points]
    return [
        law
        for law in standings
        if law.grade == first.grade
        and [point.at for point in law.points] == places
        and abs(law.worst - first.worst) <= (first.bar or TRUST)
    ]


# ---- words ---------------------------------------------------------------------------------------


def _texts(standings: Sequence[Standing], judge: Judge, checked: str, axes: Sequence[AxisOfSweep]) -> list[str]:
    """The headline from its longest to its shortest form."""
    first = standings[0]
    place = _place(first.values, axes)
    gives = difference([point.residual for point in first.points])
    if judge == "doubtful":
        return [f"{place}: trust none; {first.name} is {gives}, against {checked} alone."]
    if first.grade == "refuted":
        every = "the exponent of every law" if len(standings) > 1 else "the exponent of its one law"
        return [f"{place}: trust none; {every} is refuted; {checked}."]
    if first.grade in ("rejected", "far"):
        nearest = "nearest " if first.worst == min(law.worst for law in standings) else ""
        reject = f", {first.rejecting} of {len(first.tested)} points reject" if first.rejecting else ""
        reject = reject.replace("1 of 1 points reject", "the one point rejects")
        return [f"{place}: trust none; {nearest}{first.name}, {gives}{why}; {checked}." for why in (reject, "")]
    ties = _ties(standings)
    gives = difference([point.residual for law in ties for point in law.points])
    bar = _uncertainty(ties)
    if len(ties) == 1:
        names, verb = [first.name], "agrees"
    else:
        listed = joined([law.name for law in ties], "or" if first.grade == "use" else "and")
        names, verb = [listed, f"{_count(len(ties))} laws"][len(ties) > MOST_NAMED :], "agree"
    if first.grade == "untested":
        checked = f"one mesh, {checked}" if judge == "simulation" else f"{checked} without error bars"
        forms = ["untested; {}, {gives}"]
    else:
        forms = ["use {}, {gives}, ±{bar}" if first.grade == "use" else "{} {verb} only to ±{bar}: {gives}"]
        forms.append("{}, {gives}, ±{bar}")
    ends = [f"; {checked}"]
    if len(ties) == 1 and first.elsewhere:
        ends.insert(0, f"; elsewhere {difference([point.residual for point in first.elsewhere])}; {checked}")
    texts = [form.format(name, gives=gives, bar=bar, verb=verb) for form in forms for name in names]
    return [f"{place}: {text}{end}." for text in texts for end in ends]


def _uncertainty(laws: Sequence[Standing]) -> str:
    """The largest joint uncertainty of laws: "7 %", "7 % numerically, ±16 % with models"."""
    total, sizes = share(max(law.bar for law in laws)), [law.numerical for law in laws]
    if any(map(math.isnan, sizes)):
        return total
    return f"{share(max(sizes))} numerically, ±{total} with models"


def _checked(evidence: Evidence, judge: Judge, label: str) -> str:
    """By what a law was judged: "simulation only", "3 shots", "one doubtful shot"."""
    laws = [law for law in _laws(evidence) if law.name == label]
    doubtful = [point for law in laws for point in _points(law, "doubtful")]
    if judge != "simulation":
        count = sum(len(_points(law, judge)) for law in laws)
        return f"{_count(count)} {'doubtful ' * (judge == 'doubtful')}shot{'s' * (count > 1)}"
    if any(point.word in ("under", "over") for point in doubtful):
        return "simulation; a doubtful shot disagrees"
    return "simulation, a doubtful shot" if doubtful else "simulation only"


def _count(count: int) -> str:
    return {1: "one", 2: "two", 3: "three"}.get(count, str(count))


def _place(values: Sequence[BandValue], axes: Sequence[AxisOfSweep]) -> str:
    """Values of the abscissa: "2-7 km/s", "plate thickness 2-3 mm"."""
    axis = abscissa_of(axes)
    known = [value for value in values if value is not None]
    name = "" if axis.name == "speed" else f"{words(axis.name)} "
    if not known:
        return f"without a {words(axis.name)}"
    if axis.unit is None:
        return f"{name}{joined(list(map(str, known)))}" if len(known) < MOST_NAMED else f"{len(known)} {name.strip()}s"
    return f"{name}{spanned(*(number_of(end, axis.unit) for end in (known[0], known[-1])))}{unit_of(axis.unit)}"


def short_names(titles: Mapping[str, str]) -> dict[str, str]:
    """Each title up to its first comma, bracket or "and", where no other title begins so.

    >>> short_names({"l": "Lundeberg, Stern and Bristow", "m": "Maiden (aluminium)", "c": "Maiden (sound speed)"})
    {'l': 'Lundeberg', 'm': 'Maiden (aluminium)', 'c': 'Maiden (sound speed)'}
    """
    begins = Counter(map(beginning, titles.values()))
    return {label: short if begins[short := beginning(title)] == 1 else title for label, title in titles.items()}


def beginning(title: str) -> str:
    for mark in (" (", ",", " and "):
        title = title.partition(mark)[0]
    return title


def _rows(law: Standing, judge: Judge, checked: str, axes: Sequence[AxisOfSweep]) -> Iterator[NumberRow]:
    """The numbers of a law where it stands, and elsewhere."""
    unknown = "mesh error unknown" if judge == "simulation" else "no error stated"
    rest = replace(law, points=law.elsewhere, grade="far")
    for here, where in ((law, _place(law.values, axes)), (rest, "elsewhere")):
        if here.points:
            residuals = [point.residual for point in here.points]
            yield NumberRow(
                law=law.name,
                where=where,
                smallest=min(residuals),
                largest=max(residuals),
                bar=here.bar if here.tested else None,
                points=len(here.points),
                rejecting=here.rejecting,
                tested=len(here.tested),
                difference=difference(residuals),
                uncertainty=f"±{_uncertainty([here])}" if here.tested else unknown,
                against=checked,
                verdict="doubtful shots judge nothing alone" if judge == "doubtful" else VERDICTS[here.grade],
            )


# ---- where no law is judged ----------------------------------------------------------------------


def why_none(every: Sequence[Evidence], run: str) -> str:
    """Why no law of any quantity is judged; empty where there is no law. ``run`` is the name of a point."""
    with_laws = [each for each in every if _laws(each)]
    if not with_laws:
        drawn = [(words(each.quantity), law.drawn_only) for each in every for law in each.subjects if law.drawn_only]
        return f"No verdict: the laws of {drawn[0][0]} are {drawn[0][1]}." if drawn else ""
    for evidence in with_laws:
        unjudged = {point.unjudged for law in _laws(evidence) for point in law.points if not point.outside}
        if unjudged and all(evidence.flagged):
            flags = list(dict.fromkeys(flag for flags in evidence.flagged for flag in flags))
            common = [flag for flag in flags if all(flag in each for each in evidence.flagged)]
            listed = joined([words(flag) for flag in common or flags], "and" if common else "or")
            listed = listed.replace("under resolved", "under-resolved")
            return shortest(
                [f"No verdict: every {run} is flagged as {listed}.", f"No verdict: every {run} is flagged."]
            )
        if unjudged:
            kinds = {"is flagged" if why.startswith("flagged") else why.removeprefix("the run ") for why in unjudged}
            whole = f"No verdict: every {run} in the range of a law"
            return shortest([f"{whole} {joined(sorted(kinds), 'or')}.", f"{whole} failed or is flagged."])
    return f"No verdict: no {run} is inside the range of a law."
