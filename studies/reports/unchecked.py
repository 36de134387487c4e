"""What was not checked about the values of a sweep: a code, with how many points or names it is about."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace

from studies.reports.evidence import DEFINITION, FIRST_HAND, MESH, MODEL, Evidence
from studies.reports.records import Code, Unchecked


def unchecked(every: Sequence[Evidence]) -> tuple[Unchecked, ...]:
    """What was not checked, once for the quantities that share it."""
    found: dict[Unchecked, list[str]] = {}
    for evidence in every:
        for each in _unchecked(evidence):
            found.setdefault(each, []).append(evidence.quantity)
    return tuple(replace(each, quantities=tuple(names)) for each, names in found.items())


def _unchecked(evidence: Evidence) -> Iterator[Unchecked]:
    doubtful = sum(count for confidence, count in evidence.shots.items() if confidence not in FIRST_HAND)
    if doubtful:
        yield Unchecked(Code.DOUBTFUL_SHOTS, (), doubtful, sum(evidence.shots.values()))
    if points := evidence.points:
        parts = evidence.parts
        for code, known in (
            (Code.MESH, parts[MESH]),
            (Code.DEFINITION, parts[DEFINITION]),
            (Code.MODELS, parts[MODEL]),
        ):
            if known < points:
                yield Unchecked(code, (), points - known, points)
        if parts[MODEL] == points and evidence.alloys:
            yield Unchecked(Code.OTHER_ALLOY, (), points, points, evidence.alloys)
        elif parts[MODEL] == points and evidence.distant:
            yield Unchecked(Code.DISTANT_MODELS, (), evidence.distant, points, factor=round(evidence.distance, 3))
        if not evidence.has_scatter:
            yield Unchecked(Code.SCATTER, ())
    if flagged := sum(map(bool, evidence.flagged)):
        counts = Counter(flag for flags in evidence.flagged for flag in flags)
        yield Unchecked(
            Code.FLAGGED, (), flagged, len(evidence.flagged), tuple(flag for flag, _ in counts.most_common())
        )
    recalled = [law.title for law in evidence.subjects if law.caveat and any(p.state == "judged" for p in law.points)]
    if recalled:
        yield Unchecked(Code.RECALLED, (), names=tuple(dict.fromkeys(recalled)))
