"""What a sweep costs, and what each accuracy would make of it."""

from dataclasses import replace

import pytest

from studies.runs import run
from studies.sweeps import examples
from studies.sweeps.accuracy import ACCURACY
from studies.sweeps.cost import MOST_LOOKED_AT, cost_of, presets_of, sweep_cost
from studies.sweeps.document import read_yaml
from studies.sweeps.sweep import Sweep

DOCUMENT = read_yaml(examples.text("smoke"), "smoke")
SWEEP = Sweep.parse(DOCUMENT)


def test_presets__are_those_of_the_table_with_the_cost_of_their_runs() -> None:
    presets = {each.name: each for each in presets_of(SWEEP, most_runs=1000)}
    assert list(presets) == list(ACCURACY)
    for name, each in presets.items():
        expected = cost_of(SWEEP.at_accuracy(name))
        assert each.cost is not None
        assert each.cost.runs == each.runs == expected.runs
        assert each.cost.core_seconds == pytest.approx(expected.core_seconds)
        assert each.cost.bytes == pytest.approx(expected.bytes)
    costs = [each.cost.core_seconds for each in presets.values() if each.cost]
    assert costs == sorted({*costs})
    fine = {each.name: each for each in presets_of(SWEEP, most_runs=17)}["fine"]
    assert (fine.runs, fine.cost, fine.reason) == (18, None, "more than 17 runs")


def test_preset__of_runs_that_are_too_large_says_so() -> None:
    small = replace(SWEEP, max_particles=max(run.estimate(each.run).particles for each in SWEEP.runs()))
    (fine,) = [each for each in presets_of(small, 1000) if each.name == "fine"]
    assert fine.cost is None
    assert fine.reason.endswith("in a run")


def test_presets__are_none_where_the_resolution_is_fixed() -> None:
    own = replace(SWEEP, fixed={**SWEEP.fixed, "cells_per_diameter": 8.0}, resolutions=())
    assert list(presets_of(own, 1000)) == []


def test_cost__of_many_coarse_runs_is_mostly_that_of_any_run() -> None:
    """2 000 runs on 4 cells per diameter took 165 s on two cores and 242 MB; the estimate said 28 core-s and 63 MB."""
    speeds = {"start": "2 km/s", "stop": "5.99 km/s", "step": "0.01 km/s"}
    thicknesses = [f"{thickness} mm" for thickness in range(1, 6)]
    fixed = {name: each for name, each in DOCUMENT["fixed"].items() if name != "plate_thickness"}
    axes = {"speed": speeds, "plate_thickness": thicknesses}
    coarse = Sweep.parse({**DOCUMENT, "fixed": fixed, "axes": axes, "resolution": 4})
    cost = cost_of(coarse)
    assert cost.runs == 2000
    assert cost.core_seconds == pytest.approx(2 * 165.0, rel=0.3)
    assert cost.bytes == pytest.approx(242e6, rel=0.3)
    assert 300e6 < cost.memory < 350e6


def test_cost__of_many_points_is_told_from_a_few() -> None:
    """The drawn points' mean lies within a fifth of that of all: their costs differ by half, 64 of them were drawn."""
    axes = {
        "speed": {"start": "2 km/s", "stop": "8 km/s", "step": "100 m/s"},
        "plate_thickness": ["1 mm", "2 mm", "3 mm", "4 mm"],
    }
    fixed = {name: value for name, value in DOCUMENT["fixed"].items() if name not in axes}
    sweep = Sweep.parse({**DOCUMENT, "fixed": fixed, "axes": axes, "resolution": 8})
    every = [run.estimate(point.run) for point in sweep.runs()]
    cost = sweep_cost(sweep)
    assert (cost.runs, cost.looked_at) == (244, MOST_LOOKED_AT)
    expected = sum(each.core_seconds for each in every)
    assert cost.of(cost.priced).core_seconds == pytest.approx(expected, rel=0.2)
