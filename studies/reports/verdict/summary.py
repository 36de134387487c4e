"""What stands below the headline: what was not checked, and how whipple itself does beside published shots."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from studies.quantities.display import NARROW_SPACE, decimals, digits, signed
from studies.reports.verdict.evidence import DEFINITION, FIRST_HAND, MESH, MODEL, Evidence
from studies.reports.verdict.texts import capital, joined, plural, words

MOST_GROUPS = 3  # groups of published shots


def unchecked(every: Sequence[Evidence]) -> tuple[str, ...]:
    """Sentences on what was not checked of the verdict on some quantities, and by whom; what they share once."""
    about: dict[str, list[str]] = {}
    for evidence in every:
        for text in _unchecked(evidence):
            about.setdefault(text, []).append(words(evidence.quantity))
    sentences = []
    for text, names in about.items():
        whose = "" if len(names) == len(every) else f"{joined(names)}: "
        sentences.append(f"{capital(whose + text)}.")
    return tuple(sentences)


def _unchecked(evidence: Evidence) -> Iterator[str]:
    if not evidence.shots:
        yield "no measured shot was given, so nothing here was compared with nature"
    for confidence, count in evidence.shots.items():
        if confidence not in FIRST_HAND:
            yield f"{plural(count, 'shot')} of {sum(evidence.shots.values())} is doubtful ({confidence})"
    if evidence.points:
        parts, points = evidence.parts, plural(evidence.points, "point")
        if unknown := evidence.points - parts[MESH]:
            yield f"the mesh error is unknown at {unknown} of {points}"
        if not parts[DEFINITION]:
            yield "nobody assessed how much another definition of the measured quantity would change it"
        if parts[MODEL] < evidence.points:
            yield "nobody assessed what other material data and models would change"
        elif evidence.alloys:
            alloys = joined(evidence.alloys)
            yield f"what other material data and models change was computed for {alloys}, another alloy"
        elif evidence.distant:
            yield (
                f"what other material data and models change was measured at other speeds or plates (t/d) for "
                f"{evidence.distant} of {points}, up to a factor of {digits(evidence.distance, 2)} away"
            )
        if not evidence.has_scatter:
            yield "the sources of the laws publish no scatter"
    if flagged := sum(map(bool, evidence.flagged)):
        counts = Counter(flag for flags in evidence.flagged for flag in flags)
        flags = joined([f"{words(flag)} {count}" for flag, count in counts.most_common()])
        yield f"{flagged} of {plural(len(evidence.flagged), 'point')} flagged, drawn open, and not judged: {flags}"
    caveats: dict[str, list[str]] = {}
    for law in evidence.subjects:
        if law.caveat and any(point.state == "judged" for point in law.points):
            caveats.setdefault(law.caveat, []).append(law.title)
    for caveat, titles in caveats.items():
        yield f"{'; '.join(dict.fromkeys(titles))}: {caveat}"


def shots_text(groups: Sequence[Mapping[str, Any]]) -> str:
    """How whipple itself does beside the published shots that ship."""
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
