"""The verdict in a few sentences: which law to use where, which quantities have none, and what that rests on."""

from collections.abc import Mapping, Sequence
from typing import Any

from studies.quantities.display import NARROW_SPACE, decimals, digits, signed
from studies.reports.verdict.evidence import DEFINITION, MODEL, SCATTER, TRUST, Evidence
from studies.reports.verdict.stated import LawVerdict, StatedBand
from studies.reports.verdict.texts import (
    MOST_REASONS,
    NONE_AT_ALL,
    OF,
    at_most,
    capital,
    difference,
    joined,
    plural,
    title,
    words,
)

CLOSE = ("trusted", "numerically", "within")  # words of bands in which a law is recommended
MOST_GROUPS = 3  # groups of published shots
MOST_NAMED = 6  # quantities without a law that have the same reason
NO_LAW = "no law"
SURE = ("", "read", "verified", "user")  # confidences of shots that need no word
HOW_PARTS_READ = {
    DEFINITION: "definition of the measure",
    MODEL: "material and model",
    SCATTER: "published scatter of the laws",
}
# Shown as not assessed where no point has them.
EXPECTED = ("mesh error", DEFINITION, MODEL)


# ---- laws to use ---------------------------------------------------------------------------------


def recommendation(quantity: str, laws: Sequence[LawVerdict]) -> tuple[str, ...]:
    """Sentences on which law to use where, and what it does elsewhere: against observations, then the simulation.

    None where no point judges anything. Beside shots the simulation speaks of laws where it judges more points.
    """
    judged = [law for law in laws if law.judged]
    by_shots, by_simulation = (
        [law for law in judged if law.reference == reference and law.subject != "simulation"]
        for reference in ("observation", "simulation")
    )
    texts = [_which(by_shots)] if by_shots else []
    texts += [_of_simulation(law) for law in judged if law.subject == "simulation"]
    if _most_judged(by_simulation) > _most_judged(by_shots):
        judge = "by the simulation alone, " if by_shots else ""
        texts.append(judge + _which(by_simulation, recommended=not by_shots))
    if texts:
        texts[0] = f"{words(quantity)}: {texts[0]}"
    return tuple(f"{capital(text)}." for text in texts)


def _most_judged(laws: Sequence[LawVerdict]) -> int:
    return max((law.judged for law in laws), default=0)


def why_no_law(evidence: Evidence, laws: Sequence[LawVerdict]) -> str:
    """Why no law of a quantity is judged anywhere; empty where one is."""
    laws = [law for law in laws if law.subject != "simulation"]
    if any(law.judged for law in laws):
        return ""
    if not laws:
        drawn = any(subject.drawn_only for subject in evidence.subjects)
        return "its laws are drawn only" if drawn else NO_LAW
    inside = [band for law in laws for band in law.bands if band.word == "unjudged"]
    if not inside:
        return "no point inside the range of a law"
    # Without the number of points behind it.
    reasons = dict.fromkeys(reason.rpartition(" (")[0] for band in inside for reason in band.unjudged)
    return f"not judged: {'; '.join(list(reasons)[:MOST_REASONS])}"


def without_recommendation(reasons: Mapping[str, str]) -> str:
    """The quantities for which no law is recommended, each group of them with its reason."""
    groups: dict[str, list[str]] = {}
    for name, reason in sorted(reasons.items(), key=lambda item: item[1] == NO_LAW):
        groups.setdefault(reason, []).append(words(name))
    texts = [f"{joined(_first(names))} ({reason})" for reason, names in groups.items()]
    return f"No recommendation for {', '.join(texts)}." if texts else ""


def _first(names: Sequence[str]) -> list[str]:
    more = len(names) - MOST_NAMED + 1
    return [*names[: MOST_NAMED - 1], f"{more} others"] if more > 1 else list(names)


def _of_simulation(law: LawVerdict) -> str:
    """What the simulation gives beside observed shots."""
    assert law.smallest is not None
    assert law.largest is not None
    gives = difference([law.smallest, law.largest])
    than = "from" if gives == NONE_AT_ALL else "than"
    points = plural(law.judged, "judged point")
    return f"the simulation gives {gives} {than} {OF['observation']} ({points})"


def _which(laws: Sequence[LawVerdict], *, recommended: bool = True) -> str:
    """Which of some judged laws to use where, against one reference; beside shots the simulation recommends none."""
    best = max(laws, key=_merit)
    if best.close:
        clauses = [_use(best, recommended), _doing(best, "it ")]
        second = _second(best, laws)
        clauses.append("" if second is None else _use(second, recommended))
        return "; ".join(filter(None, clauses))
    nearest = f"{title(best, best.no_range)}, {_doing(best, '')}"
    if any(band.word == "agrees" for band in best.bands):
        return (
            f"no law can be recommended to {at_most(TRUST)} against {OF[best.reference]}, because the joint "
            f"uncertainty is wider where laws agree; the nearest, {nearest}"
        )
    return f"no law is within {at_most(TRUST)} of {OF[best.reference]} at any judged point; the nearest, {nearest}"


def _merit(law: LawVerdict) -> tuple[int, float, int, float]:
    """Close points first, and the smaller limit of these; then points that agree, and the smaller difference."""
    limit = max((band.limit for band in law.bands if band.word in CLOSE), default=1.0)
    agreeing = sum(band.judged for band in law.bands if band.word in ("agrees", "unjudged"))
    return law.close, -limit, agreeing, -max(abs(law.smallest or 0.0), abs(law.largest or 0.0))


def _use(law: LawVerdict, recommended: bool) -> str:
    """A law with each band in which it is close by itself: what lies between two of them is not recommended."""
    places = [f"{band.where}: {band.says}" for band in law.bands if band.word in CLOSE]
    use = "use " if recommended else ""
    text = ", ".join(places)
    if law.close == 1:
        text = f"{text[:-1]}, a single point)" if text.endswith(")") else f"{text} (a single point)"
    each = ", each" if len(places) > 1 else ""
    return f"{use}{title(law, law.no_range)} {text}{each} against {OF[law.reference]}"


def _doing(law: LawVerdict, it: str) -> str:
    """What a law does where it is judged and not close: "up to 4 km/s it under-predicts by 16 to 25 %"."""
    return joined([f"{band.where} {it}{_verb(band)}" for band in law.bands if band.judged and band.word not in CLOSE])


def _verb(band: StatedBand) -> str:
    """The words of a band after a subject: "is not judged: ...", "under-predicts by 20 %"."""
    return band.says if band.says.startswith(("under", "over", "agrees")) else f"is {band.says}"


def _second(best: LawVerdict, laws: Sequence[LawVerdict]) -> LawVerdict | None:
    """The law that is close at most points at which the best is not; None where no other is."""
    done = best.close_points
    others = [law for law in laws if law is not best and law.close_points - done]
    if not others:
        return None
    return max(others, key=lambda law: (len(law.close_points - done), _merit(law)))


def shots_text(groups: Sequence[Mapping[str, Any]] | None) -> str:
    """How whipple itself does beside the published shots that ship; empty of a cube that does not say so."""
    if groups is None:
        return ""
    if not groups:
        return "No published shot of these quantities in this metal ships, so the bias of whipple itself is unknown."
    texts = [of_shots(each) for each in groups[:MOST_GROUPS]]
    more = len(groups) - len(texts)
    rest = f"; {plural(more, 'more group')} below" if more else ""
    return f"Bias of whipple itself beside published shots: {'; '.join(texts)}{rest}."


def of_shots(group: Mapping[str, Any]) -> str:
    """ "final length −7.6 to −2.3 % (34 shots, copper-ofhc)", or that too few shots tell no bias."""
    materials = " on ".join(group["materials"])
    if group["bias"] is None:
        few = f"{plural(group['shots'], 'shot')}, too few for an interval"
        return f"{words(group['quantity'])} unknown ({few}, {materials})"
    low, high = (signed(100.0 * end, 1) for end in group["bias"])
    error = "" if group["stated"] is None else f", stated to ±{_percent(group['stated'])}"
    return (
        f"{words(group['quantity'])} {low} to {high}{NARROW_SPACE}%, scatter {_percent(group['scatter'])} "
        f"({group['shots']} shots, {materials}{error})"
    )


def _percent(share: float) -> str:
    return f"{decimals(100.0 * share, 1)}{NARROW_SPACE}%"


# ---- what it rests on ----------------------------------------------------------------------------


def flag_sentences(evidence: Evidence) -> tuple[str, ...]:
    """The flags that take points out of the judgement."""
    return tuple(
        f"{words(flag).capitalize()}: {count} of {plural(evidence.all_points, 'point')} "
        f"{'is' if count == 1 else 'are'} drawn open and not judged"
        for flag, count in sorted(evidence.flags.items(), key=lambda item: -item[1])
    )


def rests_text(every: Sequence[Evidence]) -> str:
    """What the judgement rests on, and how many points are left out: the same of several quantities once."""
    return _each_once({each.quantity: _rests(each) for each in every if each.points})


def bars_text(every: Sequence[Evidence]) -> str:
    """What the error bars hold, and what is not assessed: the same of several quantities once."""
    return _each_once({each.quantity: _bars(each) for each in every if each.points})


def _each_once(texts: Mapping[str, str]) -> str:
    """What is said of each quantity, as sentences: those that differ begin with the quantities that they are about."""
    groups: dict[str, list[str]] = {}
    for name, text in texts.items():
        groups.setdefault(text, []).append(words(name))
    if len(groups) == 1:
        return f"{capital(next(iter(groups)))}."
    return " ".join(f"{capital(joined(names))}: {text}." for text, names in groups.items())


def _rests(evidence: Evidence) -> str:
    model = "and model"
    if evidence.parts.get(MODEL, 0) < evidence.points:
        model = "only, the model part is not assessed"
    elif evidence.distant:
        model = (
            f"and on a model part that was measured at other speeds or t/d for {evidence.distant} of "
            f"{plural(evidence.points, 'point')}, up to a factor of {digits(evidence.distance, 2)} away"
        )
    mesh = "" if evidence.parts.get("mesh error") else "; one mesh, whose error is unknown"
    flagged = sum(map(bool, evidence.flagged))
    left = f"; {flagged} of {plural(evidence.all_points, 'point')} flagged and not judged"
    count = sum(evidence.shots.values())
    doubted = [
        word if known == count else f"{known} {word}" for word, known in evidence.shots.items() if word not in SURE
    ]
    how = f" ({joined(doubted)})" if doubted else ""
    beside = f"; beside {plural(count, 'observed shot')}{how}" if count else ""
    return f"rests on numerics {model}{mesh}{left if flagged else ''}{beside}"


def _bars(evidence: Evidence) -> str:
    held = [
        f"{HOW_PARTS_READ.get(part, part)}"
        + ("" if count == evidence.points else f" (at {count} of {evidence.points} points)")
        for part, count in evidence.parts.items()
        if count
    ]
    missing = [HOW_PARTS_READ.get(part, part) for part in EXPECTED if not evidence.parts.get(part)]
    if not evidence.has_scatter:
        missing.append(HOW_PARTS_READ[SCATTER])
    text = f"the joint uncertainty holds {', '.join(held) or 'nothing'}"
    return f"{text}; not assessed: {', '.join(missing)}" if missing else text
