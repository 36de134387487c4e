"""What a sweep costs, and what each accuracy would make of it."""

import pytest

from studies.sweeps import examples
from studies.sweeps.accuracy import ACCURACY
from studies.sweeps.cost import cost_of, presets_of
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
