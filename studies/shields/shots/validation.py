"""The probability of failure validated on laboratories left out: Brier score, reliability and intervals.

The method is in ``probability``: each shot is predicted by curves that have seen no shot of its laboratory.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from studies.shields.shots.chance import FORMS, KNOTS, Knots, expit, fit, terms
from studies.shields.shots.judged import equations, margins
from studies.shields.shots.table import ShieldShot, laboratory

MEAN = "mean"  # of the equations, in place of the name of one
BINS = 10
FEWEST = 10  # shots of a group whose failures an interval holds or does not
TAIL = 0.025
NO_BETTER = 0.001  # of the Brier score: a form with more knots has to be better by more
NODES = np.polynomial.hermite_e.hermegauss(41)  # of the normal distribution


@dataclass(frozen=True)
class Predicted:
    """Shots with the logits of equations that have not seen their laboratory."""

    failed: NDArray  # 1 or 0, a shot
    groups: Sequence[str]  # the laboratory of each
    logits: Mapping[str, NDArray]  # by equation; NaN where its range does not cover the shot
    deviations: Mapping[str, NDArray]

    def chance(self, name: str) -> NDArray:
        """P of each shot by an equation, or by the mean of those that cover it."""
        if name != MEAN:
            return expit(self.logits[name])
        return np.nanmean([expit(logit) for logit in self.logits.values()], axis=0)


def predict(
    shots: Sequence[ShieldShot], group: Callable[[ShieldShot], str] = laboratory, knots: Knots = KNOTS
) -> Predicted:
    """Each shot as the shots of the other laboratories predict it, or of the other groups of any kind."""
    groups = np.array([group(shot) for shot in shots])
    failed = np.array([shot.is_perforated for shot in shots], float)
    logits, deviations = dict[str, NDArray](), dict[str, NDArray]()
    for law in equations():
        of_law = np.array(margins(law, shots))
        covered = ~np.isnan(of_law)
        rows = terms(list(np.nan_to_num(of_law)), shots, knots)
        logit, deviation = np.full((2, len(shots)), math.nan)
        for name in np.unique(groups):
            out, seen = covered & (groups == name), covered & (groups != name)
            curve = fit(law.name, rows[seen], failed[seen], list(groups[seen]))
            logit[out], deviation[out] = curve.logits(rows[out])
        logits[law.name], deviations[law.name] = logit, deviation
    return Predicted(failed, groups.tolist(), logits, deviations)


def brier(predicted: Predicted, name: str = MEAN) -> float:
    """Mean square of P less the outcome, over the shots that are covered."""
    return float(np.nanmean((predicted.chance(name) - predicted.failed) ** 2))


def near_the_limit(predicted: Predicted, low: float = 0.3, high: float = 0.7) -> tuple[int, float]:
    """Shots whose P lies between two chances, and its Brier score there; a coin has 0.25."""
    chance = predicted.chance(MEAN)
    undecided = (low <= chance) & (chance <= high)
    return int(undecided.sum()), float(((chance - predicted.failed)[undecided] ** 2).mean())


def scores_of_forms(shots: Sequence[ShieldShot]) -> dict[Knots, float]:
    """The Brier score of each form on laboratories left out of these shots."""
    return {knots: brier(predict(shots, knots=knots)) for knots in FORMS}


def chosen(shots: Sequence[ShieldShot]) -> Knots:
    """The form with the fewest knots that is, on laboratories left out, no worse than the best."""
    scores = scores_of_forms(shots)
    return next(knots for knots in FORMS if scores[knots] <= min(scores.values()) + NO_BETTER)


def reliability(predicted: Predicted, name: str = MEAN) -> list[tuple[int, float, float]]:
    """Shots, mean of P and share of failures of bins of equal number by P."""
    chance = predicted.chance(name)
    order = [place for place in np.argsort(chance, kind="stable") if not math.isnan(chance[place])]
    return [
        (len(part), float(chance[part].mean()), float(predicted.failed[part].mean()))
        for part in np.array_split(order, BINS)
    ]


def coverage(predicted: Predicted, name: str = MEAN) -> tuple[int, int]:
    """How many groups of shots have a number of failures inside their interval, and how many there are."""
    chance, labs = predicted.chance(name), np.array(predicted.groups)
    inside = []
    for lab in np.unique(labs):
        members = np.flatnonzero((labs == lab) & ~np.isnan(chance))
        order = members[np.argsort(chance[members], kind="stable")]
        parts = np.array_split(order, max(1, len(order) // FEWEST))
        inside += [_is_inside(predicted, name, part) for part in parts if len(part)]
    return sum(inside), len(inside)


def _is_inside(predicted: Predicted, name: str, group: NDArray) -> bool:
    """Whether the failures of a group lie in the middle 95 % of their distribution, neither tail being below 2.5 %."""
    from scipy.stats import binom  # 0.8 s, which every process that publishes would wait for

    nodes, weights = NODES
    laws = [name] if name != MEAN else list(predicted.logits)
    shifted = [
        expit(predicted.logits[law][group, np.newaxis] + nodes * predicted.deviations[law][group, np.newaxis])
        for law in laws
    ]
    chance = np.nanmean(shifted, axis=0).mean(axis=0)  # of a shot of the group, by node
    failures = int(predicted.failed[group].sum())
    of_count = binom.pmf(np.arange(len(group) + 1)[:, np.newaxis], len(group), chance) @ (weights / weights.sum())
    return bool(of_count[: failures + 1].sum() > TAIL and of_count[failures:].sum() > TAIL)
