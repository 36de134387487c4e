"""Words of the sizes at which a shield is just safe, and of the shots that were easier or harder."""

from collections.abc import Mapping

from studies.outcomes.found import Share
from studies.quantities.display import NONE, digits, display_of
from studies.shields.shots.answers import ShieldAnswer
from studies.shields.shots.records import NoSize, SafeSize, Size

COLUMNS = ("largest sphere (mm)", "thinnest wall (mm)", "shortest stand-off (mm)")
REASONS: Mapping[NoSize, str] = {
    NoSize.SAFE: "any",
    NoSize.UNSAFE: "none",
    NoSize.OUTSIDE_OF_SHOTS: "no shots like it",
    NoSize.NO_EQUATION: "no equation",
}


def safe_sizes_of(answer: ShieldAnswer) -> dict[str, tuple[str, ...]]:
    """The largest sphere, thinnest wall and shortest stand-off, mm: "at 10 % risk", then by the name of each law."""
    found = {(_limit(safe), safe.size): _printed(safe) for safe in answer.safe}
    limits = dict.fromkeys(limit for limit, _ in found)
    return {limit: tuple(found[limit, size] for size in Size) for limit in limits}


def _limit(safe: SafeSize) -> str:
    return safe.law or f"at {100.0 * (safe.risk or 0.0):.0f} % risk"


def _printed(safe: SafeSize) -> str:
    """A size in mm; a word where there is none, or where each is safe."""
    if safe.value is None:
        return REASONS[safe.reason or NoSize.NO_EQUATION]
    return digits(safe.value * display_of("m").factor)


def of_ordered_shots(answer: ShieldAnswer) -> str:
    """ "2 of 14 easier shots failed; no published shot is harder."."""
    kinds = (("easier", "failed", answer.easier), ("harder", "held", answer.harder))
    said = [
        f"{shots.contrary} of {shots.shots} {kind} shots {did}" if shots.shots else f"no published shot is {kind}"
        for kind, did, shots in kinds
    ]
    return f"In every respect: {'; '.join(said)}."


def share(share: Share) -> str:
    """A share of shots with its interval: "7 of 9 (45 to 94 %)"."""
    if not share.of:
        return NONE
    low, high = (f"{100.0 * bound:.0f}" for bound in share.interval)
    return f"{share.count} of {share.of} ({low} to {high} %)"
