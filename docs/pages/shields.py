"""shields.md: the shots on shields that ship, the equations judged by them, and the probability of failure."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from docs.pages import in_markdown, table
from studies import laws
from studies.laws import Shot
from studies.laws._handbook import KSI
from studies.outcomes.found import Share
from studies.shields.shield import Shield, at_shield
from studies.shields.shots.answers import SHORT
from studies.shields.shots.chance import KNOTS, curves
from studies.shields.shots.judged import Judged, equations, judge_by_range
from studies.shields.shots.table import (
    IN_DOUBT,
    NEAR,
    OTHER_METAL,
    citation,
    collected,
    compared_pairs,
    laboratory,
    published,
    sources,
)
from studies.shields.shots.validation import (
    MEAN,
    Predicted,
    brier,
    coverage,
    near_the_limit,
    predict,
    reliability,
    scores_of_forms,
)

SHIELD = Shield(1.2e-3, 3.2e-3, 0.1, 40.0 * KSI)  # of Fig. 4-4 of the handbook: bumper and wall of 6061-T6


def at_plotted_shield(shot: Shot) -> Shot:
    """A shot at the shield for which laws.md draws critical diameters."""
    return at_shield(shot, SHIELD)


def pages() -> dict[str, str]:
    """shields.md."""
    shots, left_out = published().shots, published().left_out
    by_laboratory, by_source = predict(shots), predict(shots, lambda shot: shot.source)
    undecided, undecided_score = near_the_limit(by_laboratory)
    text = in_markdown(
        "shields",
        left_out=left_out,
        shots=shots,
        in_doubt=IN_DOUBT,
        doubted=compared_pairs([shot for shot in collected().shots if shot.source == IN_DOUBT]),
        others=[compared_pairs([shot for shot in shots if shot.source == key]) for key in sources()],
        near=NEAR,
        other_metal=OTHER_METAL,
        judged=table(
            ["equation", "normal speed", "shots", "right", "unsafe", "too careful", "failures caught"],
            [_row(judged) for law in equations() for judged in judge_by_range(law, shots)],
        ),
        constants=_constants(),
        taken=KNOTS,
        scores=scores_of_forms(shots),
        knots=_knots,
        laboratories=len({laboratory(shot) for shot in shots}),
        validated=table(
            ["left out", "P of", "Brier score", "bins of equal number: largest", "of equal width: largest", "held"],
            [
                [left_out, "mean" if name == MEAN else SHORT[name], *_calibrated(predicted, name)]
                for left_out, predicted in (("laboratory", by_laboratory), ("source", by_source))
                for name in (MEAN, *predicted.logits)
            ],
        ),
        undecided=undecided,
        undecided_score=undecided_score,
        sources=_sources(),
    )
    return {"shields.md": text}


def _row(judged: Judged) -> list[str]:
    name = f"{laws.load(judged.law).title} ({SHORT[judged.law]})"
    shares = judged.right, judged.unsafe, judged.careful, judged.caught
    return [name, judged.where, str(judged.right.of), *map(_share, shares)]


def _share(share: Share) -> str:
    low, high = share.interval
    return f"{100.0 * share.value:.1f} % ({100.0 * low:.0f} to {100.0 * high:.0f})"


def _constants() -> str:
    rows = [
        [SHORT[name], str(curve.shots), *(f"{value:.2f}" for value in curve.constants), f"{curve.between:.2f}"]
        for name, curve in curves().items()
    ]
    values = [f"{letter} at {knot / 1e3:g} km/s" for knot in KNOTS for letter in "ab"]
    return table(["equation", "shots", *values, "c", "between laboratories"], rows)


def _knots(knots: Sequence[float]) -> str:
    """ "3, 5, 7"."""
    return ", ".join(f"{knot / 1e3:g}" for knot in knots)


def _calibrated(predicted: Predicted, name: str) -> list[str]:
    inside, groups = coverage(predicted, name)
    chance = predicted.chance(name)
    tenths = np.floor(10.0 * np.where(np.isnan(chance), -1.0, chance))
    bins = [part for part in (np.flatnonzero(tenths == tenth) for tenth in range(10)) if len(part) >= 20]
    width = max(abs(float(chance[part].mean() - predicted.failed[part].mean())) for part in bins)
    number = max(abs(said - share) for _, said, share in reliability(predicted, name))
    return [f"{brier(predicted, name):.3f}", f"{number:.3f}", f"{width:.3f}", f"{inside} of {groups}"]


def _sources() -> str:
    counts = Counter(shot.source for shot in collected().shots)
    rows = [
        [f"`{key}`", citation(key), row["laboratory"], str(counts[key]), row["note"]] for key, row in sources().items()
    ]
    return table(["source", "publication", "laboratory", "shots", "note"], rows)
