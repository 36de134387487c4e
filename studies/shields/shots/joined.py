"""Whether a simulation of a shot tells more of how likely its wall fails than equations and shots alone do.

The method, written down before any outcome of a simulated shot was seen:

1. Shots are drawn by a seed from the published ones and simulated (docs/pages/simulated_shields.py). A simulation says
   perforated or held where all of its runs do, else open.
2. logit P = logit P_e + a where it says perforated, logit P_e + b where it says held, and P = P_e where it is open. P_e
   is the probability from equations and shots (``probability``), by curves that have not seen the shot's laboratory.
3. a and b have the greatest posterior density with each shot of weight one, and priors that are normal about zero with
   a standard deviation of 2.5, that of the intercepts of P_e. Their signs are free: a simulation that misleads says so.
4. The shots were drawn by their outcomes: in a range of the speed a share of the perforated ones and another one of
   those that held. The logarithm of the ratio of these shares is added to the logit of a shot in the fit, and there
   alone, so that a and b are those of all shots (Prentice and Pyke, 1979, Biometrika 66, 403).
5. A simulation by runs of other kinds is another one, with constants of its own: with either failure or with both, on
   one grid (the coarser one) or on several. It is fitted to what the runs of its kind alone say of the same shots.
6. The interval is expit(logit P -+ 1.96 s) with s^2 = s_e^2 + the variance of a or b, and s_e the distance of P_e from
   that end of its interval in the logit, over 1.96: it holds what a laboratory that is not seen may find.
7. It is validated by leaving out each laboratory in turn: its shots are predicted by curves of P_e and by a and b that
   have not seen it, and P_e of the other shots, to which a and b are fitted, has seen neither it nor their own
   laboratory. Brier score over the drawn shots, each of weight one, of P and of P_e, with the mean difference and 1.96
   of its standard errors; and both weighted by the inverse of the shares that were drawn.

Added when the outcomes were seen: a kind of simulation would be joined with P_e in a range of the normal speed
(``RANGES``) once the lower end of what it gains there in 7, the mean less 1.96 standard errors, is above zero. What is
not seen to help laboratories that are left out helps no shield that is not built yet. None is, so that reports have P_e
alone.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from studies.outcomes.found import DEVIATE
from studies.shields.shots.chance import expit, logit, most_probable
from studies.shields.shots.drawn import STORED, DrawnShots, Simulated, SimulationKind
from studies.shields.shots.judged import RANGES, range_of
from studies.shields.shots.records import Probability, written
from studies.shields.shots.table import ShieldShot, laboratory, published
from studies.shields.shots.validation import predict

PRIOR = np.array([2.5, 2.5])  # standard deviations of a and b
# Cells across the projectile in simulated shots, or those that leave so many through the bumper where these are more.
LEAST_CELLS, MOST_CELLS, THROUGH_BUMPER = 16.0, 48.0, 6.0
THROUGH_WALL = 8.0  # cells, at least


@dataclass(frozen=True)
class SimulatedShot:
    """A published shot that was drawn, and what its simulation says."""

    shot: ShieldShot
    share: float  # of the shots of its outcome in its range of the speed: how many were drawn
    odds: float  # share of the perforated ones over that of those that held, in this range
    told: Simulated


@dataclass(frozen=True)
class Joint:
    """What the outcome of a simulation adds to the logit of the probability."""

    perforated: float
    held: float
    covariance: NDArray  # (2, 2)

    def probability(self, before: Probability, told: Simulated) -> Probability:
        """The probability with the outcome of a simulation."""
        if told == "open":
            return before
        place = ("perforated", "held").index(told)
        shift, variance = (self.perforated, self.held)[place], self.covariance[place][place]
        middle, low, high = (float(logit(chance)) for chance in (before.value, before.low, before.high))
        down, up = (math.hypot(end - middle, DEVIATE * math.sqrt(variance)) for end in (low, high))
        return Probability(*(float(expit(middle + shift + by)) for by in (0.0, -down, up)))


@dataclass(frozen=True)
class Scores:
    """Drawn shots predicted without their laboratory: P_e, and P that is joined with the simulation."""

    before: Sequence[Probability]
    after: Sequence[Probability]
    failed: NDArray  # 1 or 0, a shot
    shares: NDArray  # that were drawn

    def squares(self) -> tuple[NDArray, NDArray]:
        """The square of P_e and of P less the outcome of each shot."""
        before, after = (np.array([chance.value for chance in said]) for said in (self.before, self.after))
        return (before - self.failed) ** 2, (after - self.failed) ** 2

    def brier(self, *, weighted: bool = False) -> tuple[float, float]:
        """Brier scores of P_e and of P; over all shots that might have been drawn where it is weighted."""
        weights = 1.0 / self.shares if weighted else np.ones(len(self.shares))
        before, after = (float(np.average(square, weights=weights)) for square in self.squares())
        return before, after

    def gained(self, shots: Sequence[int] | slice = slice(None)) -> tuple[float, float]:
        """The mean of P_e's square less P's over shots, and 1.96 of its standard errors."""
        before, after = self.squares()
        apart = (before - after)[shots]
        return float(apart.mean()), float(DEVIATE * apart.std(ddof=1) / math.sqrt(len(apart)))


def cells_across(diameter: float, bumper_thickness: float) -> float:
    """Cells across the projectile of a shot that was simulated, on its coarser grid.

    >>> cells_across(5e-3, 1e-3), cells_across(5e-3, 3e-3), cells_across(10e-3, 1e-3)
    (30.0, 16.0, 48.0)
    """
    return min(MOST_CELLS, max(LEAST_CELLS, THROUGH_BUMPER * diameter / bumper_thickness))


def cells_through(wall_thickness: float, diameter: float, across: float) -> float:
    """Cells through the wall of a shot that was simulated with so many cells across the projectile.

    >>> cells_through(2e-3, 5e-3, 30.0), cells_through(5e-3, 5e-3, 30.0)
    (8.0, 15.0)
    """
    return max(THROUGH_WALL, 0.5 * across * wall_thickness / diameter)


def joint_of(before: Sequence[Probability], shots: Sequence[SimulatedShot]) -> Joint:
    """The constants that join simulations with P_e of each shot."""
    told = np.array([[shot.told == "perforated", shot.told == "held"] for shot in shots], float)
    failed = np.array([shot.shot.is_perforated for shot in shots], float)
    known = logit([chance.value for chance in before]) + np.log([shot.odds for shot in shots])
    constants, covariance = most_probable(told, failed, PRIOR, known)
    return Joint(float(constants[0]), float(constants[1]), covariance)


def unseen(shots: Sequence[SimulatedShot], without: str = "") -> list[Probability]:
    """P_e of each shot by curves that have seen neither its laboratory nor one that none of the shots is of."""
    chances = _unseen(without)
    return [chances[shot.shot] for shot in shots]


@cache
def _unseen(without: str) -> Mapping[ShieldShot, Probability]:
    """P_e of the published shots of all laboratories but one, each by the others of these."""
    seen = [shot for shot in published().shots if laboratory(shot) != without]
    predicted = predict(seen)
    bounds = [
        np.nanmean([expit(x + by * predicted.deviations[law]) for law, x in predicted.logits.items()], axis=0).tolist()
        for by in (0.0, -DEVIATE, DEVIATE)
    ]
    return {shot: Probability(*values) for shot, *values in zip(seen, *bounds, strict=True)}


def validated(shots: Sequence[SimulatedShot]) -> Scores:
    """Each shot predicted by the other laboratories alone, with and without its simulation."""
    before, after = unseen(shots), list[Probability]()
    for mine, chance in zip(shots, before, strict=True):
        others = [other for other in shots if laboratory(other.shot) != laboratory(mine.shot)]
        joint = joint_of(unseen(others, laboratory(mine.shot)), others)
        after.append(joint.probability(chance, mine.told))
    failed = np.array([shot.shot.is_perforated for shot in shots], float)
    return Scores(before, after, failed, np.array([shot.share for shot in shots]))


# --- what ships -------------------------------------------------------------------------------------


def drawn_shots(shots: Sequence[SimulatedShot], scores: Scores) -> Iterator[DrawnShots]:
    """What the simulated shots say of their kind, by range of the normal speed."""
    for place in range(len(RANGES)):
        mine = [number for number, shot in enumerate(shots) if range_of(shot.shot.normal_speed) == place]
        failed = [shots[number].told for number in mine if shots[number].shot.is_perforated]
        gained, within = scores.gained(mine)
        yield DrawnShots(len(mine), gained, within, len(failed), failed.count("perforated"))


def store(simulations: Mapping[SimulationKind, Sequence[SimulatedShot]]) -> None:
    """Write what its shots say of each kind of simulation."""
    said = {kind.name: [*map(asdict, drawn_shots(shots, validated(shots)))] for kind, shots in simulations.items()}
    STORED.write_text(written(said), encoding="utf-8")
