"""The search for a limit on outcomes with a known answer."""

import math
from functools import partial
from typing import Any

import pytest

from studies.quantities.findings import InvalidInput
from studies.quantities.measured import CLOSED_BY_FILM, STILL_COMING, TOO_COARSE
from studies.runs.run import Run
from studies.sweeps.cost import cost_of
from studies.sweeps.search import Chance, LimitOutcome, Search, SearchVerdict, outcome_in, replay
from studies.sweeps.sweep import Sweep
from tests.samples import needs

SEARCH = Search("perforated", 100.0, 200.0, 2.0, unit="m s-1")
DOCUMENT: dict[str, Any] = {
    "scenario": "plugging",
    "axes": {
        "speed": {"limit_of": "perforated", "between": ["100 m/s", "200 m/s"], "tolerance": "10 m/s"},
        "nose": ["blunt", "conical"],
    },
    "resolution": 8,
}


searched = partial(replay, SEARCH)


@pytest.mark.parametrize("exact", [100.5, 133.3, 150.0, 187.9, 199.5])
def test_search__brackets_a_limit_within_its_tolerance(exact: float) -> None:
    limit = searched(lambda speed: speed >= exact)
    assert limit.verdict is SearchVerdict.BRACKETED
    assert limit.lower < exact <= limit.upper
    assert limit.upper - limit.lower <= SEARCH.tolerance
    assert len(limit.tried) <= SEARCH.most_tries
    assert limit.next is None


@pytest.mark.parametrize(
    ("value", "flag", "outcome"),
    [
        (0.0, "", False),
        (1.0, "", True),
        (None, "undecided", None),
        (0.0, CLOSED_BY_FILM, None),
        (0.0, STILL_COMING, None),
        (1.0, STILL_COMING, True),
        (1.0, TOO_COARSE, None),
    ],
)
def test_outcome__that_may_change_is_none(value: float | None, flag: str, outcome: LimitOutcome) -> None:
    summary = {"measurements": {"perforated": {"value": value, "flags": [flag]}}}
    assert outcome_in(summary, "perforated") is outcome


@pytest.mark.parametrize("perforates", [True, False])
def test_search__names_both_ends_that_give_the_same(perforates: bool) -> None:
    limit = searched(lambda speed: perforates)
    assert limit.verdict is SearchVerdict.NOT_BRACKETED
    assert limit.tried == SEARCH.start()
    assert math.isnan(limit.value)
    for words in (f"{int(perforates)} at 100 m/s", f"{int(perforates)} at 200 m/s"):
        assert words in limit.reason
    silent = searched(lambda speed: None if speed == 200.0 else False)
    assert silent.verdict is SearchVerdict.NOT_BRACKETED
    assert "without an outcome at 200 m/s" in silent.reason
    assert searched(lambda speed: speed < 120.0).verdict is SearchVerdict.NOT_BRACKETED


@pytest.mark.parametrize(("ones", "interval"), [({150.0}, (100.0, 200.0)), ({100.0, 200.0}, (100.0, 200.0))])
def test_search__gives_the_interval_of_outcomes_that_are_not_monotone(
    ones: set[float], interval: tuple[float, float]
) -> None:
    limit = searched(lambda speed: speed in ones)
    assert limit.verdict is SearchVerdict.NON_MONOTONE
    assert (limit.lower, limit.upper) == interval
    assert limit.next is None


def test_search__goes_on_from_results_alone() -> None:
    """Each try follows from those before, whoever asks."""
    done: dict[float, bool] = {}
    while (limit := searched(lambda speed: done.get(speed, "missing"))).verdict is SearchVerdict.UNFINISHED:
        done.update((speed, speed >= 171.0) for speed in limit.tried)
    assert list(done)[:3] == [100.0, 150.0, 200.0]
    assert limit == searched(lambda speed: speed >= 171.0)
    assert sorted(done) == list(limit.tried)


@needs("plugging")
def test_sweep__searches_each_point_of_the_other_axes() -> None:
    sweep = Sweep.parse(DOCUMENT)
    assert [point.coordinates["speed"] for point in sweep.runs()[::2]] == [100.0, 150.0, 200.0]
    assert Sweep.parse(sweep.document()) == sweep
    assert cost_of(sweep).runs == sweep.most_runs == 2 * (2 + 4)
    exact = {"blunt": 180.0, "conical": 120.0}
    limits = sweep.limits(lambda run: float(run.parameters["speed"] or 0.0) >= exact[str(run.parameters["nose"])])
    assert [at["nose"] for at, _ in limits] == ["blunt", "conical"]
    for at, limit in limits:
        assert limit.lower < exact[str(at["nose"])] <= limit.upper
    table = sweep.tried(limits)
    runs = {point.run.id for point in table.runs()}
    assert runs >= {point.run.id for point in sweep.runs()}
    assert len(runs) == sum(len(limit.tried) for _, limit in limits)


@needs("plugging")
@pytest.mark.parametrize(
    ("change", "others", "field"),
    [
        ({"limit_of": "plug_mass"}, {}, ".limit_of"),
        ({"between": ["200 m/s", "100 m/s"]}, {}, ".between[1]"),
        ({"between": ["200 m/s"]}, {}, ".between"),
        ({"tolerance": "300 m/s"}, {}, ".tolerance"),
        ({"steps": 3}, {}, ".steps"),
        ({"tolerance": None, "until": "10 mm"}, {}, ".until"),
        ({"tolerance": None, "until": "200 %"}, {}, ".until"),
        ({"until": "10 %"}, {}, ".until"),
        ({"tolerance": None, "until": 0.1, "between": ["0 m/s", "100 m/s"]}, {}, ".between[0]"),
        ({}, {"combine": "zip"}, ""),
        ({}, {"model_part": "screen"}, ""),
    ],
)
def test_search__is_refused_with_its_field(change: dict[str, Any], others: dict[str, Any], field: str) -> None:
    axes = {**DOCUMENT["axes"], "speed": {**DOCUMENT["axes"]["speed"], **change}}
    with pytest.raises(InvalidInput) as refused:
        Sweep.parse({**DOCUMENT, **others, "axes": axes})
    assert f"axes.speed{field}" in [finding.field for finding in refused.value.findings]


@needs("plugging")
def test_search__on_several_grids_leaves_open_what_they_disagree_about() -> None:
    """The coarse grid perforates from 120, the fine one from 140 m/s."""
    sweep = Sweep.parse({**DOCUMENT, "resolution": [8, 12]})
    exact = {8.0: 120.0, 12.0: 140.0}

    def outcome_of(run: Run) -> bool:
        return float(run.parameters["speed"] or 0.0) >= exact[float(run.parameters["cells_per_diameter"] or 0.0)]

    limits = sweep.limits(outcome_of)
    for _, limit in limits:
        assert limit.verdict is SearchVerdict.BRACKETED
        assert 110.0 <= limit.lower < 120.0
        assert 140.0 <= limit.upper <= 150.0
    runs = sweep.tried(limits).runs()
    assert len(runs) == 2 * sum(len(limit.tried) for _, limit in limits)
    assert sweep.most_runs == 2 * 2 * (2 + 4)
    [(_, waiting), *_] = sweep.limits(
        lambda run: "running" if run.parameters["cells_per_diameter"] == 12.0 else outcome_of(run)
    )
    assert waiting.verdict is SearchVerdict.UNFINISHED


# --- until -----------------------------------------------------------------------------------------

GUIDED = Search("perforated", 100.0, 800.0, 1.0, until=0.1, unit="m s-1")


def chance_about(middle: float) -> Chance:
    """A chance that rises in the logarithm about a value, by a factor of 1.3 to either side of half of it."""
    return lambda value: 1.0 / (1.0 + (value / middle) ** (-2.2 / math.log(1.3)))


@pytest.mark.parametrize("exact", [101.0, 150.0, 300.0, 500.0, 799.0])
@pytest.mark.parametrize("chance", [None, chance_about(310.0), chance_about(120.0), lambda value: 1.0])
def test_until__narrows_the_interval_as_asked_whatever_guides_it(exact: float, chance: Chance | None) -> None:
    limit = replay(GUIDED, lambda speed: speed >= exact, chance)
    assert limit.verdict is SearchVerdict.BRACKETED
    assert limit.lower < exact <= limit.upper
    assert math.log(limit.upper / limit.lower) <= 0.1 * (1.0 + 1e-9)
    assert len(limit.tried) <= GUIDED.most_tries


def test_until__takes_fewer_runs_where_the_chance_is_right() -> None:
    """Limits drawn from the chance itself, beside a plain search of the same width there."""
    chance = chance_about(310.0)
    limits = [next(v for v in range(100, 801) if chance(v) >= share) for share in (0.1, 0.3, 0.5, 0.7, 0.9)]
    guided = [len(replay(GUIDED, lambda v, x=x: v >= x, chance).tried) for x in limits]  # type: ignore[misc]
    plain = Search("perforated", 100.0, 800.0, 31.0)
    halved = [len(replay(plain, lambda v, x=x: v >= x).tried) for x in limits]  # type: ignore[misc]
    assert sum(guided) < 0.8 * sum(halved)


@pytest.mark.parametrize("perforates", [True, False])
def test_until__tries_an_end_before_it_says_that_nothing_is_bracketed(perforates: bool) -> None:
    limit = replay(GUIDED, lambda speed: perforates, chance_about(310.0))
    assert limit.verdict is SearchVerdict.NOT_BRACKETED
    assert (GUIDED.low if perforates else GUIDED.high) in limit.tried
    silent = replay(GUIDED, lambda speed: None if speed > 200.0 else False)
    assert silent.reason.startswith("perforated is 0 at 1")


@pytest.mark.parametrize("search", [SEARCH, GUIDED])
def test_search__leaves_an_open_value_inside_its_interval(search: Search) -> None:
    low, high = search.low + 20.0, search.low + 80.0
    limit = replay(search, lambda speed: None if low < speed < high else speed > low)
    assert limit.verdict is SearchVerdict.BRACKETED
    assert limit.lower <= low
    assert limit.upper >= high
    assert limit.reason.startswith("wider than asked: perforated is open at 1")
