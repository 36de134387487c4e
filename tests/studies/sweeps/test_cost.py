"""What a sweep costs."""

import pytest

from studies.sweeps import examples
from studies.sweeps.cost import cost_of
from studies.sweeps.document import read_yaml
from studies.sweeps.sweep import Sweep

DOCUMENT = read_yaml(examples.text("smoke"), "smoke")


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
