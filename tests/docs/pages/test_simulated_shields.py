"""The probability that a wall fails joined with simulations: its constants from outcomes that are drawn by chance."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from docs.pages import read_json
from docs.pages.simulated_shields import EACH, FAILURES, GRIDS, OF_PLATES, STORED, drawn, simulations
from studies.outcomes.found import Share
from studies.shields.shots import drawn as of_drawn
from studies.shields.shots.drawn import SimulationKind, failures_found
from studies.shields.shots.joined import SimulatedShot, joint_of, unseen, validated
from studies.shields.shots.judged import RANGES
from studies.shields.shots.records import Probability
from studies.shields.shots.table import laboratory
from tests.claims.rows import at_most, equal


def _even(chance: float) -> Probability:
    return Probability(chance, chance, chance)


def told(right: float, seed: int = 3) -> list[SimulatedShot]:
    """The shots that are drawn, each told rightly with a chance; a tenth is open."""
    random = np.random.default_rng(seed)
    shots = []
    for shot in drawn().values():
        other = "held" if shot.is_perforated else "perforated"
        says = shot.outcome if random.random() < right else other
        shots.append(SimulatedShot(shot, 0.5, 1.0, "open" if random.random() < 0.1 else says))  # type: ignore[arg-type]
    return shots


def test_joint__of_shots_that_were_drawn_by_outcome_is_that_of_all() -> None:
    """With every perforated shot twice the constants stay where the odds say so, and rise by ln 2 where they do not."""
    once = told(0.8)
    twice = [each for each in once for _ in range(1 + each.shot.is_perforated)]
    all_shots, known, unknown = (
        joint_of([_even(0.4)] * len(shots), shots)
        for shots in (once, [replace(each, odds=2.0) for each in twice], twice)
    )
    for name in ("perforated", "held"):
        assert getattr(known, name) == pytest.approx(getattr(all_shots, name), abs=0.1)
        assert getattr(unknown, name) - getattr(known, name) == pytest.approx(math.log(2.0), abs=0.1)


@pytest.mark.claim("shields", "joined-by-rule")
def test_validated__gains_by_simulations_that_are_right_and_by_no_others(compared: Callable[..., None]) -> None:
    """Joined with outcomes drawn rightly in 9 of 10 the Brier score falls; with a coin's it stays as it was."""
    right, coin = validated(told(0.9)), validated(told(0.5))
    before, after = right.brier()
    compared(at_most("Brier score, 9 of 10 right", limit=0.7 * before, got=after))
    before, after = coin.brier()
    compared(at_most("a coin: rise of the Brier score", limit=0.02, got=abs(after - before)))
    gained, within = coin.gained()
    compared(equal("a coin: nothing gained is in the interval", expected=True, got=-within < gained < within))


@pytest.mark.claim("mend", "joined-by-gain")
def test_simulations__are_joined_with_no_probability_because_none_is_seen_to_gain(
    compared: Callable[..., None],
) -> None:
    """The lower bound of what a kind of simulation gains is nowhere above zero; what is stored is that of its runs."""
    kinds = simulations(read_json(STORED)["runs"])
    compared(equal("kinds that are stored", expected={kind.name for kind in kinds}, got=set(of_drawn.stored())))
    for kind, shots in kinds.items():
        scores = validated(shots)
        for (where, low, high), mine in zip(RANGES, of_drawn.stored()[kind.name], strict=True):
            inside = [low <= each.shot.normal_speed < high for each in shots]
            before, after = (each[inside] for each in scores.squares())
            gained = float((before - after).mean())
            within = 1.96 * float((before - after).std(ddof=1)) / math.sqrt(sum(inside))
            compared(at_most(f"{kind.name}, {where}: lower bound of the gain", limit=0.0, got=gained - within))
            compared(equal(f"{kind.name}, {where}: shots", expected=sum(inside), got=mine.shots))
            assert (mine.gained, mine.within) == pytest.approx((gained, within), rel=1e-6)


def test_failures_found__are_those_of_the_stored_results() -> None:
    runs = [run for run in read_json(STORED)["runs"] if run["grid"] == GRIDS[0]]
    for failure in (*FAILURES, OF_PLATES):
        told_so = {run["shot"]: run["perforated"] == 1.0 for run in runs if run["failure"] == failure}
        fast = [number for number, shot in drawn().items() if shot.is_perforated and shot.speed >= 3e3]
        expected = Share(sum(told_so[number] for number in fast), len(fast))
        assert failures_found(failure, 3e3) == failures_found(failure, 9e3) == expected
    assert failures_found("none", 7e3) == Share(7, 17)
    assert failures_found("spall-rate", 7e3) is None
    assert failures_found("void-growth", 2e3) == Share(2, 2)


def test_unseen__knows_nothing_of_a_laboratory_that_is_left_out() -> None:
    shots = told(1.0)
    name = laboratory(shots[0].shot)
    others = [each for each in shots if laboratory(each.shot) != name]
    chances, less = unseen(others), unseen(others, name)
    assert all(few != all_laboratories for few, all_laboratories in zip(less, chances, strict=True))
    assert all(each.low < each.value < each.high for each in less)
    with pytest.raises(KeyError):
        unseen(shots, name)


def test_kinds__have_the_outcomes_of_their_runs_alone() -> None:
    """Of runs without failure on a coarse grid that perforate, where all others hold."""
    runs = [
        {"shot": number, "failure": failure, "grid": grid, "perforated": float((failure, grid) == ("none", GRIDS[0]))}
        for number in drawn()
        for failure in (*FAILURES, OF_PLATES)
        for grid in GRIDS
    ]
    says = {kind.name: {each.told for each in shots} for kind, shots in simulations(runs).items()}
    assert says == {
        "none, one grid": {"perforated"},
        "johnson-cook, one grid": {"held"},
        "johnson-cook and none, one grid": {"open"},
        "void-growth, one grid": {"held"},
        "johnson-cook and none, several grids": {"open"},
    }
    [shots] = [shots for kind, shots in simulations(runs).items() if kind == SimulationKind(("none",), "one")]
    assert sum(1.0 / each.share for each in shots) == pytest.approx(284)  # the shots that can be simulated
    assert {each.shot.outcome for each in shots if each.share < 0.12} == {"perforated", "held"}
    assert len(shots) <= 6 * EACH
