"""The probability that a shield's wall is perforated, from the margins of the equations, calibrated on the shots.

The method, each step written down before its first fit:

1. The margin of an equation is x = ln(d/d_c), with its critical diameter d_c for the shot.
2. One curve an equation: logit P = a(v) + b(v) x + c theta, with one coefficient of the obliquity theta in rad, and an
   intercept and a slope that are continuous in the normal speed v: linear between the values at knots, constant beyond
   the outer ones. It has the greatest posterior density with each shot of weight one, and priors that are normal about
   zero with standard deviations of 2.5 for the values of a and for c and of 10 for those of b: so weak that they matter
   where a knot has few shots. Three forms may be taken, whose knots are at
   - 3 and 7 km/s: where the equations themselves change their limb;
   - 3, 5 and 7 km/s: between their limbs the equations are linear in the speed, and know least in the middle;
   - 1.5, 3, 7 and 10 km/s: the powers of the speed in the limbs may be wrong, too.
   Each is scored as in step 6 on the shots that the choice may see, by the Brier score of the mean; taken is the one
   with the fewest knots that is within 0.001 of the best. The score of the method is that of laboratories which neither
   a curve nor the choice of its form has seen. It may be at most 0.140: with curves that jump from one range of the
   speed to the next it was 0.137.
3. It is fitted to the published shots that the screening keeps and the equation's range covers.
4. P of a shield is the mean of the curves of those equations whose range covers it: none is best everywhere. Outside of
   all shots (``outside``) there is none.
5. The interval holds what a laboratory that is not among these may find: of each curve expit(logit P -+ 1.96 s) with
   s^2 = f' C f + tau^2, where C is the covariance of the constants (the inverse curvature at the maximum), f the terms
   of the curve, and tau the standard deviation between laboratories: DerSimonian and Laird's (1986) estimate from an
   offset of the logit for each laboratory (one step of Newton from none). Of several equations it is the mean of the
   bounds.
6. It is validated by leaving out each laboratory in turn, all its reports at once: fitted to the others, asked about
   it. Each shot then has a prediction that has not seen its laboratory. Brier score over all shots, for the mean and
   each equation; reliability: shots in ten bins of equal number by P, of each the mean of P less the share of failures;
   intervals: in each laboratory left out its shots in the order of P are cut into groups of at least ten (fewer are one
   group with nothing cut), of each of which the number of failures is inside or outside the middle 95 % of its
   distribution, binomial about a logit that varies normally by the s of its shots.
"""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, astuple, dataclass, replace
from functools import cache, partial
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from studies.laws import Law
from studies.outcomes.found import DEVIATE
from studies.shields.roots import root_between
from studies.shields.shield import ShotAtShield
from studies.shields.shots.judged import equations, margin, margins
from studies.shields.shots.outside import outside_of_shots
from studies.shields.shots.records import Probability, written
from studies.shields.shots.table import ShieldShot, laboratory, published

STORED = Path(__file__).with_name("fitted.json")
Knots = tuple[float, ...]  # m/s, ascending: normal speeds at which intercept and slope have values of their own
FORMS: tuple[Knots, ...] = ((3e3, 7e3), (3e3, 5e3, 7e3), (1.5e3, 3e3, 7e3, 10e3))
KNOTS = FORMS[1]  # of the curves that ship: the form that ``validation.chosen`` takes
WIDEST = 20.0  # logarithm of a ratio of diameters: no chance is as low or as high as beyond it
STEPS, STEP = 50, 1e-10  # of Newton's method: at most, and of the constants where it ends


def expit(logit: ArrayLike) -> NDArray:
    """The probability of a logit, 1/(1 + exp(-x)), without overflow: importing scipy.special takes 0.5 s (2026-11).

    >>> expit([-800.0, 0.0, 2.0]).round(4).tolist()
    [0.0, 0.5, 0.8808]
    """
    return np.exp(np.minimum(logit, 0.0)) / (1.0 + np.exp(-np.abs(logit)))


def logit(chance: ArrayLike) -> NDArray:
    """The logit of a probability, ln(P/(1 - P)).

    >>> logit([0.5, 0.8808]).round(3).tolist()
    [0.0, 2.0]
    """
    return np.log(chance) - np.log1p(-np.asarray(chance))


@dataclass(frozen=True)
class Curve:
    """The probability of failure as a function of an equation's margin."""

    law: str
    constants: tuple[float, ...]  # of ``terms``
    covariance: tuple[tuple[float, ...], ...]
    between: float  # standard deviation of the logit between laboratories
    shots: int  # of the fit

    def logits(self, of: NDArray) -> tuple[NDArray, NDArray]:
        """The logit of each row of ``terms``, and its standard deviation in a laboratory that is not seen."""
        variance = np.einsum("ni,ij,nj->n", of, np.array(self.covariance), of) + self.between**2
        return of @ np.array(self.constants), np.sqrt(variance)

    def chance(self, shot: ShotAtShield, margin: float) -> float:
        """The probability alone."""
        intercept, slope = (np.interp(shot.normal_speed, KNOTS, self.constants[first:-1:2]) for first in (0, 1))
        return float(expit(intercept + slope * margin + self.constants[-1] * shot.obliquity))

    def probability(self, shot: ShotAtShield, margin: float) -> Probability:
        """That the wall of a shot with a margin is perforated."""
        logit, deviation = (float(of_one[0]) for of_one in self.logits(terms([margin], [shot])))
        return Probability(*(float(expit(logit + k * deviation)) for k in (0.0, -DEVIATE, DEVIATE)))


def terms(margins: Sequence[float], shots: Sequence[ShotAtShield | ShieldShot], knots: Knots = KNOTS) -> NDArray:
    """What the constants multiply, a row a shot: at each knot its share and that times the margin, and the angle."""
    speeds = [shot.normal_speed for shot in shots]
    shares = [np.interp(speeds, knots, knot) for knot in np.eye(len(knots))]
    columns = [column for share in shares for column in (share, share * margins)]
    return np.column_stack([*columns, [shot.obliquity for shot in shots]])


def prior_of(count: int) -> NDArray:
    """Standard deviations of the priors of so many constants: those of intercepts, slopes and the angle."""
    return np.array([2.5, 10.0] * (count // 2) + [2.5])


def fit(law: str, of: NDArray, failed: NDArray, laboratories: Sequence[str]) -> Curve:
    """The curve with the greatest posterior density for rows of ``terms``, their outcomes and laboratories."""
    constants, covariance = most_probable(of, failed, prior_of(of.shape[1]))
    between = _between(expit(of @ constants), failed, laboratories)
    return Curve(law, tuple(constants.tolist()), tuple(map(tuple, covariance.tolist())), between, len(of))


def most_probable(
    of: NDArray, failed: NDArray, prior: NDArray, known: NDArray | float = 0.0
) -> tuple[NDArray, NDArray]:
    """The constants c of logit P = ``known`` + ``of`` c with the greatest posterior density, and their covariance.

    ``of`` has a row a shot, ``known`` what is in its logit without constants. The prior is normal about zero with the
    standard deviations ``prior``; the covariance is the inverse curvature at the maximum, which Newton's method finds.
    """
    constants, tightness = np.zeros(len(prior)), np.diag(prior**-2.0)
    for _ in range(STEPS):
        chance = expit(known + of @ constants)
        curvature = of.T @ (of * (chance * (1.0 - chance))[:, np.newaxis]) + tightness
        step = np.linalg.solve(curvature, of.T @ (failed - chance) - tightness @ constants)
        constants = constants + step
        if np.abs(step).max() < STEP:
            break
    return constants, np.linalg.inv(curvature)


def _between(chance: NDArray, failed: NDArray, laboratories: Sequence[str]) -> float:
    """Standard deviation of the logit between laboratories, DerSimonian and Laird (1986), Control. Clin. Trials 7, 177.

    The offset of a laboratory is one Newton step from none: (failures - expected) / information.
    """
    names = np.array(laboratories)
    groups = [names == name for name in np.unique(names)]
    weights = np.array([float((chance * (1.0 - chance))[group].sum()) for group in groups])
    offsets = np.array([float((failed - chance)[group].sum()) for group in groups]) / weights
    mean = np.average(offsets, weights=weights)
    excess = float(weights @ (offsets - mean) ** 2) - (len(groups) - 1)
    return math.sqrt(max(0.0, excess / float(weights.sum() - (weights**2).sum() / weights.sum())))


# --- the curves that ship --------------------------------------------------------------------------


def fitted(law: Law, shots: Sequence[ShieldShot]) -> Curve:
    """The curve of an equation for the shots that its range covers."""
    pairs = [(x, shot) for x, shot in zip(margins(law, shots), shots, strict=True) if not math.isnan(x)]
    covered = [shot for _, shot in pairs]
    failed = np.array([shot.is_perforated for shot in covered], float)
    return fit(law.name, terms([x for x, _ in pairs], covered), failed, [laboratory(shot) for shot in covered])


def compute() -> dict[str, Curve]:
    """The curves of all equations for the published shots, as ``fitted.json`` has them."""
    return {law.name: fitted(law, published().shots) for law in equations()}


@cache
def curves() -> Mapping[str, Curve]:
    """The curve of each equation, as stored."""
    stored = json.loads(STORED.read_text(encoding="utf-8"))
    return {name: Curve(**{**curve, "constants": tuple(curve["constants"])}) for name, curve in stored.items()}


def probability(shot: ShotAtShield) -> Probability | None:
    """That the wall of a shield is perforated; None outside of all shots, and where no equation covers the shot."""
    return None if any(outside_of_shots(shot)) else mean_of_curves(shot)


def mean_of_curves(shot: ShotAtShield) -> Probability | None:
    """The mean of the curves of the equations that cover a shot, outside of all shots too; None without an equation."""
    said = [curves()[law.name].probability(shot, x) for law, x in _covering(shot)]
    if not said:
        return None
    return Probability(*(sum(values) / len(said) for values in zip(*map(astuple, said), strict=True)))


def chance_of(shot: ShotAtShield) -> Callable[[ShotAtShield], float] | None:
    """The probability of shots that differ in sizes from one; None where no equation covers it.

    No equation has a range in the sizes of sphere, bumper, wall and stand-off, so that those that cover the shot cover
    the others.
    """
    covering = [(curves()[law.name], law) for law, _ in _covering(shot)]
    if not covering:
        return None
    return lambda other: sum(curve.chance(other, margin(law, other)) for curve, law in covering) / len(covering)


def chance_of_diameter(shot: ShotAtShield) -> Callable[[float], float] | None:
    """The probability as a function of the projectile's diameter, m, all else as in the shot; it rises.

    A margin is ln d less that of a critical diameter, which does not depend on d. None where no equation covers a shot.
    """
    covering = _covering(shot)
    if not covering:
        return None

    def chance(diameter: float) -> float:
        larger = math.log(diameter / shot.projectile_diameter)
        return sum(curves()[law.name].chance(shot, x + larger) for law, x in covering) / len(covering)

    return chance


def diameters_at(shot: ShotAtShield, chances: Sequence[float]) -> list[float]:
    """The projectile's diameter, m, that fails with each of the chances, all else as in the shot.

    NaN outside of all shots, and where no equation covers the shot.
    """
    chance = chance_of_diameter(shot)
    if chance is None:
        return [math.nan] * len(chances)
    size = shot.projectile_diameter

    def excess(asked: float, logarithm: float) -> float:
        return chance(size * math.exp(logarithm)) - asked

    logarithms = [root_between(partial(excess, asked), -WIDEST, WIDEST, within=1e-9) for asked in chances]
    sizes = [size * math.exp(logarithm) for logarithm in logarithms]
    return [
        math.nan if any(outside_of_shots(replace(shot, projectile_diameter=diameter))) else diameter
        for diameter in sizes
    ]


def _covering(shot: ShotAtShield) -> list[tuple[Law, float]]:
    """The equations that cover a shot, with its margins."""
    pairs = ((law, margin(law, shot)) for law in equations())
    return [(law, x) for law, x in pairs if not math.isnan(x)]


if __name__ == "__main__":
    STORED.write_text(written({name: asdict(curve) for name, curve in compute().items()}), encoding="utf-8")
