"""The probability that a wall fails: its fit, its calibration on laboratories left out, and the answer for a shield."""

import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sklearn.linear_model import LogisticRegression

from studies import materials
from studies.cases.rows import Row, at_least, at_most, equal
from studies.laws import InnerBumper, Shield, Shot
from studies.observations.shields.answers import SHORT, answer
from studies.observations.shields.judged import equations, margin, margins, range_of
from studies.observations.shields.probability import (
    PRIOR,
    compute,
    curves,
    diameters_at,
    fit,
    fitted,
    probability,
    terms,
)
from studies.observations.shields.shots import NEAR, ShieldShot, distances, published
from studies.observations.shields.validation import MEAN, Predicted, brier, coverage, predict, reliability
from studies.quantities.findings import InvalidInput

SHOTS = published().shots
ALUMINIUM = materials.load("al-6061-t6")
# Of Fig. 4-4 of NASA/TM-2009-214785, hit by a sphere of 5 mm at 7 km/s.
SHIELD = Shield(1.2e-3, 3.2e-3, 0.1, 276e6)
SHOT = Shot(7e3, 5e-3, 1.2e-3, ALUMINIUM, ALUMINIUM, shield=SHIELD)
MOST_BRIER, MOST_APART, HELD = 0.16, 0.1, (0.90, 0.99)
MOST_WORDS, MOST_SECONDS = 20, 0.05


@pytest.fixture(scope="module")
def predicted() -> Predicted:
    return predict(SHOTS)


# --- the fit ---------------------------------------------------------------------------------------


def test_stored_curves__are_those_of_the_shots_that_ship() -> None:
    """``python -m studies.observations.shields.probability`` writes them."""
    for name, curve in compute().items():
        stored = curves()[name]
        assert stored.constants == pytest.approx(curve["constants"], rel=1e-6)
        assert np.array(stored.covariance) == pytest.approx(np.array(curve["covariance"]), rel=1e-6)
        assert stored.between == pytest.approx(curve["between"], rel=1e-6)
        assert stored.shots == curve["shots"]
    assert set(curves()) == {law.name for law in equations()}


def test_fit__is_the_logistic_regression_of_another_library() -> None:
    """With the priors as a ridge: each column times its standard deviation, and C = 1."""
    law = equations()[0]
    rows = terms(margins(law, SHOTS), SHOTS) * PRIOR
    failed = [shot.is_perforated for shot in SHOTS]
    other = LogisticRegression(C=1.0, fit_intercept=False, tol=1e-12, max_iter=10_000).fit(rows, failed)
    assert fitted(law, SHOTS).constants == pytest.approx(other.coef_[0] * PRIOR, rel=1e-4, abs=1e-5)


def test_fit__finds_the_scatter_between_laboratories() -> None:
    """Forty laboratories whose logits differ by a standard deviation of 1, then by none."""
    random = np.random.default_rng(7)
    names = np.repeat(np.arange(40), 100)
    rows = np.zeros((len(names), len(PRIOR)))
    rows[:, 0], rows[:, 1] = 1.0, random.normal(0.0, 0.3, len(names))
    for scatter in (0.0, 1.0):
        offsets = random.normal(0.0, scatter, 40)[names]
        failed = random.random(len(names)) < 1.0 / (1.0 + np.exp(-(4.0 * rows[:, 1] + offsets)))
        assert fit("made", rows, failed.astype(float), list(names)).between == pytest.approx(scatter, abs=0.25)


def test_curves__rise_with_the_margin_in_every_range() -> None:
    assert all(min(curve.constants[1:-1:2]) > 0.0 for curve in curves().values())
    assert [range_of(speed) for speed in (0.0, 2999.0, 3000.0, 6999.0, 7000.0, 2e4)] == [0, 0, 1, 1, 2, 2]


# --- calibration -----------------------------------------------------------------------------------


@pytest.mark.claim("door", "shield-calibration")
def test_probability__is_calibrated_on_laboratories_left_out(
    predicted: Predicted, compared: Callable[..., None]
) -> None:
    """P that a wall fails, on laboratories left out, has the Brier score, the bins and the intervals aimed at."""
    compared(at_most("Brier score", limit=MOST_BRIER, got=brier(predicted)))
    for name in predicted.logits:
        compared(at_most(f"Brier score of {name} alone", limit=MOST_BRIER, got=brier(predicted, name)))
    bins = reliability(predicted)
    compared(at_least("shots in each of ten bins of equal number", limit=20, got=min(shots for shots, *_ in bins)))
    apart = [said - share for _, said, share in bins]
    text = " ".join(f"{each:+.3f}" for each in apart)
    compared(at_most(f"P less share, {text}: largest", limit=MOST_APART, got=max(map(abs, apart))))
    chance = predicted.chance(MEAN)
    of_width = [np.flatnonzero(np.floor(10.0 * chance) == tenth) for tenth in range(10)]
    compared(at_least("shots in each of ten bins of equal width", limit=20, got=min(map(len, of_width))))
    apart = [float(chance[part].mean() - predicted.failed[part].mean()) for part in of_width]
    text = " ".join(f"{each:+.3f}" for each in apart)
    compared(at_most(f"P less share, {text}: largest", limit=MOST_APART, got=max(map(abs, apart))))
    inside, groups = coverage(predicted)
    compared(
        at_least(f"intervals that hold, of {groups} groups of shots", limit=HELD[0], got=inside / groups),
        at_most("the same", limit=HELD[1], got=inside / groups),
    )


@pytest.mark.claim("door", "shield-calibration")
def test_probability__is_calibrated_on_reports_left_out(compared: Callable[..., None]) -> None:
    """The same with the report of each shot left out in place of its laboratory."""
    predicted = predict(SHOTS, lambda shot: shot.source)
    compared(at_most("Brier score", limit=MOST_BRIER, got=brier(predicted)))
    apart = max(abs(said - share) for _, said, share in reliability(predicted))
    compared(at_most("P less share of failures in ten bins of equal number: largest", limit=MOST_APART, got=apart))
    inside, groups = coverage(predicted)
    compared(
        at_least(f"intervals that hold, of {groups} groups of shots", limit=HELD[0], got=inside / groups),
        at_most("the same", limit=HELD[1], got=inside / groups),
    )


def test_validation__of_shots_drawn_from_their_own_chances_holds() -> None:
    """Groups of ten with no scatter between laboratories: 95 % of them and more are inside."""
    random = np.random.default_rng(3)
    chances = random.uniform(0.05, 0.95, 4000)
    logits = {"made": np.log(chances / (1.0 - chances))}
    failed = (random.random(4000) < chances).astype(float)
    made = Predicted(failed, ["here"] * 4000, logits, {"made": np.zeros(4000)})
    inside, groups = coverage(made)
    assert groups == 400
    assert 0.95 <= inside / groups < 1.0
    assert max(abs(said - share) for _, said, share in reliability(made)) < 0.06
    shifted = replace(made, failed=np.ones(4000))
    assert coverage(shifted)[0] < 0.6 * groups


# --- the answer ------------------------------------------------------------------------------------


def test_answer__says_the_probability_the_equations_and_the_shots_near() -> None:
    got = answer(SHOT)
    assert got.probability is not None
    assert got.probability.low < got.probability.value < got.probability.high
    assert got.outside == ()
    assert got.near == sum(distance <= NEAR for distance in distances(SHOT, SHOTS)) > len(got.nearest)
    assert {judged.where for judged in got.judged} == {"near"}
    assert all(word.says == ("fails" if word.critical_diameter < 5e-3 else "holds") for word in got.words)
    begin, middle, end = got.sentence.split("; ")
    assert begin.endswith("to fail")
    assert middle == f"{got.near} shots near"
    assert end == "JSC, NNO, Reimerdes say holds, modNNO, SRL fails."


def test_answer__is_the_mean_of_the_curves_that_cover_the_shot() -> None:
    for shot, count in ((SHOT, 5), (replace(SHOT, obliquity=0.5), 4)):
        chances = [
            curves()[law.name].probability(shot, x).value
            for law in equations()
            if not math.isnan(x := margin(law, shot))
        ]
        assert len(chances) == count
        got = probability(shot)
        assert got is not None
        assert got.value == pytest.approx(np.mean(chances))


def test_diameters_at__have_these_chances() -> None:
    chances = (0.1, 0.5, 0.9)
    for chance, diameter in zip(chances, diameters_at(SHOT, chances), strict=True):
        got = probability(replace(SHOT, projectile_diameter=diameter))
        assert got is not None
        assert got.value == pytest.approx(chance, abs=1e-6)
    assert math.isnan(*diameters_at(replace(SHOT, shield=None), [0.5]))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"speed": 12e3}, "v = 12 km/s is above 9.89 km/s"),
        ({"projectile_diameter": 0.2e-3}, "S/d = 500 is above"),
        ({"obliquity": math.radians(80.0)}, "angle = 80 deg is above 75 deg"),
        ({"shield": replace(SHIELD, wall_thickness=0.1)}, "t_w = 100 mm is above 50.8 mm"),
        ({"shield": replace(SHIELD, bumper_thickness=10e-6)}, "d/t_b = 500 is above"),
        ({"projectile": materials.load("copper-ofhc")}, "the projectile is copper"),
        ({"length_ratio": 2.0}, "the projectile has L/d = 2"),
    ],
)
def test_answer__flags_a_shield_outside_of_all_shots(change: dict[str, Any], words: str) -> None:
    got = answer(replace(SHOT, **change))
    assert any(words in reason for reason in got.outside)
    assert "outside all shots" in got.sentence


def test_answer__of_three_walls_has_no_probability() -> None:
    shield = replace(SHIELD, stand_off=0.05, inner_bumper=InnerBumper(1e-3, 0.05))
    got = answer(replace(SHOT, shield=shield))
    assert got.probability is None
    assert got.sentence == "no probability: all shots have two walls; SRL says fails."


def test_answer__of_a_plate_is_refused() -> None:
    with pytest.raises(InvalidInput, match="shield"):
        answer(replace(SHOT, shield=None))


@pytest.mark.parametrize(
    ("part", "change"),
    [
        ("bumper", {"target": materials.load("copper-ofhc")}),
        ("wall", {"shield": replace(SHIELD, wall_family="copper")}),
    ],
)
def test_answer__of_another_metal_leaves_its_equations_out(part: str, change: dict[str, Any]) -> None:
    got = answer(replace(SHOT, **change))
    assert {word.says for word in got.words} == {"outside"}
    assert got.probability is None
    assert got.sentence == f"no probability: the {part} is copper, all shots are of aluminium."


def test_answer__has_the_users_own_shots_among_those_near() -> None:
    own = replace(next(shot for shot in SHOTS if shot.obliquity == 0.0), source="own", shot="1")
    alone, together = answer(own.as_shot()), answer(own.as_shot(), [own])
    assert together.near == alone.near + 1
    assert own in [each.shot for each in together.nearest]


@pytest.mark.claim("door", "shield-answer")
def test_answers__are_short_and_quick(compared: Callable[[Row], None]) -> None:
    """An answer for a shield has at most 20 words, names each equation as it decides, and takes at most 50 ms."""
    random = np.random.default_rng(1)
    answers, seconds = [], []
    answer(SHOT)
    for shot in map(as_shot, random.choice(np.array(SHOTS, object), 40)):
        other = replace(shot, projectile_diameter=shot.projectile_diameter * math.exp(random.normal(0.0, 0.7)))
        begin = time.perf_counter()
        answers.append((other, answer(other)))
        seconds.append(time.perf_counter() - begin)
    compared(at_most("words", limit=MOST_WORDS, got=max(len(got.sentence.split()) for _, got in answers)))
    told = [
        (word.says == "fails") == (margin(law, shot) > 0.0)
        for shot, got in answers
        for law, word in zip(equations(), got.words, strict=True)
        if word.says != "outside"
    ]
    compared(equal("equations that are told otherwise than they decide", expected=0, got=told.count(False)))
    compared(at_most("seconds of an answer, median of 40", limit=MOST_SECONDS, got=float(np.median(seconds))))


def as_shot(shot: ShieldShot) -> Shot:
    """The shot as laws take it."""
    return shot.as_shot()


def test_short_names__are_there_for_every_equation() -> None:
    assert {law.name for law in equations()} < set(SHORT)
