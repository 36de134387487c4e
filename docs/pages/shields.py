"""shields.md: the shots on shields that ship, the equations judged by them, and the probability of failure."""

from collections.abc import Iterator, Sequence

import numpy as np

from docs.pages import table
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

COLLECTION = "https://github.com/shannonjryan/pyBLOSSUM"


SHIELD = Shield(1.2e-3, 3.2e-3, 0.1, 40.0 * KSI)  # of Fig. 4-4 of the handbook: bumper and wall of 6061-T6


def at_plotted_shield(shot: Shot) -> Shot:
    """A shot at the shield for which laws.md draws critical diameters."""
    return at_shield(shot, SHIELD)


def pages() -> dict[str, str]:
    """shields.md."""
    return {"shields.md": "\n".join([*_shots(), *_judged(), *_probability(), *_sources()]) + "\n"}


def _shots() -> Iterator[str]:
    screening = published()
    failed = sum(shot.is_perforated for shot in screening.shots)
    left_out = ", ".join(f"{count} {rule}" for rule, count in screening.left_out.items())
    total = len(screening.shots) + sum(screening.left_out.values())
    yield "# Shots on shields\n"
    yield (
        f"{total} published shots of aluminium spheres on Whipple shields of two aluminium walls ship with the "
        f"outcome of the wall, from the collection of S. Ryan and W. Schonberg, [pyBLOSSUM]({COLLECTION}), commit "
        "fe0a7df, MIT licence. A wall with detached spall counts as held: the collection tells holes alone. Yield "
        "stresses are values of handbooks.\n"
    )
    yield (
        "Left out are rows with impossible numbers (sizes and yield stresses that are not positive, more than 20 "
        "km/s, an obliquity that hits no plate, a density more than 2 % off that of the alloy), and a shot that a "
        "second source repeats: the same number, the same outcome, and all sizes within 3 %. Shots of one source "
        f"that agree in all but their number are repeats, and stay. {left_out}; {len(screening.shots)} are used, of "
        f"which {failed} perforated the wall.\n"
    )
    doubted = [shot for shot in collected().shots if shot.source == IN_DOUBT]
    others = [compared_pairs([shot for shot in screening.shots if shot.source == key]) for key in sources()]
    agree, contradict = (sum(pair[place] for pair in others) for place in (0, 1))
    yield (
        f"Of `{IN_DOUBT}` **the outcomes seem to be the wrong way round**: of {sum(compared_pairs(doubted))} pairs of "
        "its shots that are alike (alloys, angle; bumper, stand-off and speed within 3 %) but for a thicker wall, in "
        f"{compared_pairs(doubted)[1]} the thicker one was perforated and the other held. Of all other sources "
        f"{agree} pairs agree on what is stronger (a smaller sphere counts too), and {contradict} contradict it. The "
        "report itself could not be read.\n"
    )
    yield (
        "`whipple shots` lists them, and those nearest to [your shield](does-my-shield-hold.md); `--own FILE` takes a "
        "table of your own with the same columns: the sizes, densities, yield stress and `outcome` (`perforated` or "
        "`held`) are needed, `obliquity`, `source`, `shot` and the names of the materials are not.\n"
    )
    yield (
        "The distance of two shots is the root of the sum of squares of ln of the ratios of d, t_b, t_w, S, v, the "
        "densities of projectile, bumper and wall and the yield stress of the wall, and of the difference of the "
        "angles in rad: the equations are products of powers, so that a ratio counts the same for a foil as for a "
        "plate, and they do not agree on the powers, so that none is weighted. Near is up to "
        f"{NEAR:g}, where five of these differ by a quarter each. A density that is a factor of more than "
        f"{OTHER_METAL:g} apart is another metal, and never near: of a steel sphere 0 shots are.\n"
    )


def _judged() -> Iterator[str]:
    yield "## Equations judged by shots\n"
    yield (
        "An equation says that the wall fails where the sphere is larger than its critical diameter, and is asked "
        "about the shots that its range covers. Unsafe: said to hold, and perforated. Too careful: said to fail, and "
        "held. Brackets: Wilson's interval at 95 %.\n"
    )
    rows = [_row(judged) for law in equations() for judged in judge_by_range(law, published().shots)]
    yield table(["equation", "normal speed", "shots", "right", "unsafe", "too careful", "failures caught"], rows)


def _row(judged: Judged) -> list[str]:
    name = f"{laws.load(judged.law).title} ({SHORT[judged.law]})"
    shares = judged.right, judged.unsafe, judged.careful, judged.caught
    return [name, judged.where, str(judged.right.of), *map(_share, shares)]


def _share(share: Share) -> str:
    low, high = share.interval
    return f"{100.0 * share.value:.1f} % ({100.0 * low:.0f} to {100.0 * high:.0f})"


def _probability() -> Iterator[str]:
    yield "## Probability that the wall fails\n"
    yield (
        "Shots that are equal in everything differ in outcome, so that the answer is a probability. Each equation "
        "has a logistic curve, logit P = a + b ln(d/d_c) + c theta, with a and b continuous in the normal speed; P is "
        "the mean of the curves of the equations that cover the shot. The interval, at 95 %, holds what a laboratory "
        "that is not among these may find. The whole method was written down before its first fit: "
        "`studies/shields/shots/chance.py`.\n"
    )
    yield (
        "a and b are linear between values at knots, and constant beyond the outer ones. Three forms could be taken, "
        "with knots at 3 and 7 km/s (where the equations change their limb), at 3, 5 and 7 km/s (between their limbs "
        "they know least in the middle), or at 1.5, 3, 7 and 10 km/s (the powers of the speed in the limbs may be "
        "wrong, too). Each is scored by laboratories left out of the shots that the choice may see; taken is the one "
        "with the fewest knots that is within 0.001 of the best. The score that counts is that of laboratories which "
        "neither a curve nor the choice of its form has seen: at most 0.140, where curves that jump from one range of "
        "the speed to the next had 0.137.\n"
    )
    constants = [
        [SHORT[name], str(curve.shots), *(f"{value:.2f}" for value in curve.constants), f"{curve.between:.2f}"]
        for name, curve in curves().items()
    ]
    values = [f"{letter} at {knot / 1e3:g} km/s" for knot in KNOTS for letter in "ab"]
    yield table(["equation", "shots", *values, "c", "between laboratories"], constants)
    shots = published().shots
    scores = scores_of_forms(shots)
    others = " and ".join(f"{score:.3f} with {_knots(knots)}" for knots, score in scores.items() if knots != KNOTS)
    yield (
        f"Taken is the form with knots at {_knots(KNOTS)} km/s: on laboratories left out the Brier score is "
        f"{scores[KNOTS]:.3f} with it, {others}. It is taken as well whichever laboratory is left out, so that the "
        "scores below are those of laboratories that the choice has not seen (`make claims shield-score`).\n"
    )
    laboratories = len({laboratory(shot) for shot in shots})
    reports = len({shot.source for shot in shots})
    yield (
        f"Validated with each of the {laboratories} laboratories left out, and with each of the {reports} sources "
        "left out: every shot is predicted by curves that have not seen its group. Aimed at were a Brier score of at "
        "most 0.16, at most 0.1 between P and the share of failures in each of ten bins, and intervals that hold in "
        "90 to 99 % of groups of ten or more shots. What was reached, also where it is less:\n"
    )
    by_laboratory, by_source = predict(shots), predict(shots, lambda shot: shot.source)
    rows = [
        [left_out, "mean" if name == MEAN else SHORT[name], *_calibrated(predicted, name)]
        for left_out, predicted in (("laboratory", by_laboratory), ("source", by_source))
        for name in (MEAN, *predicted.logits)
    ]
    header = ["left out", "P of", "Brier score", "bins of equal number: largest", "of equal width: largest", "held"]
    yield table(header, rows)
    undecided, score = near_the_limit(by_laboratory)
    yield "P of the mean is what is answered. Outside of all shots none is.\n"
    yield (
        f"**Near the limit P is worth hardly more than a coin**: of the {undecided} shots with P from 0.3 to 0.7 its "
        f"Brier score, on laboratories left out, is {score:.3f}, and that of a coin 0.25. What P tells is on which "
        "side of this band a shield is.\n"
    )
    yield "What a simulation of the shot adds to P was measured on [drawn shots](simulated-shields.md).\n"


def _knots(knots: Sequence[float]) -> str:
    """ "3, 5, 7"."""
    return ", ".join(f"{knot / 1e3:g}" for knot in knots)


def _calibrated(predicted: Predicted, name: str) -> list[str]:
    inside, groups = coverage(predicted, name)
    chance = predicted.chance(name)
    tenths = np.floor(10.0 * np.where(np.isnan(chance), -1.0, chance))
    bins = [part for part in (np.flatnonzero(tenths == tenth) for tenth in range(10)) if len(part) >= 20]
    width = max(abs(float(chance[part].mean() - predicted.failed[part].mean())) for part in bins)
    return [f"{brier(predicted, name):.3f}", f"{_apart(predicted, name):.3f}", f"{width:.3f}", f"{inside} of {groups}"]


def _apart(predicted: Predicted, name: str = MEAN) -> float:
    """The largest difference of P and the share of failures of a bin."""
    return max(abs(said - share) for _, said, share in reliability(predicted, name))


def _sources() -> Iterator[str]:
    yield "## Sources\n"
    shots = collected().shots
    rows = []
    for key, row in sources().items():
        count = sum(shot.source == key for shot in shots)
        rows.append([f"`{key}`", citation(key), row["laboratory"], str(count), row["note"]])
    yield table(["source", "publication", "laboratory", "shots", "note"], rows)
