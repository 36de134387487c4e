"""Axes that are sampled: Latin hypercubes and Sobol sequences, the same points from the same document."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from studies.quantities.findings import InvalidInput
from studies.sweeps.cost import cost_of
from studies.sweeps.reading import SweepLimits
from studies.sweeps.sampling import METHODS
from studies.sweeps.sweep import Sweep
from tests.studies.support.sized import HOLES

SAMPLED: Mapping[str, Any] = {
    **HOLES,
    "combine": "sobol",
    "points": 16,
    "seed": 3,
    "axes": {"speed": {"low": "3 km/s", "high": "7 km/s"}, "plate_thickness": {"low": "1 mm", "high": "2 mm"}},
}


def changed(**parts: Any) -> dict[str, Any]:
    return {**SAMPLED, **parts}


def axes(**parts: Any) -> dict[str, Any]:
    return changed(axes={**SAMPLED["axes"], **parts})


@pytest.mark.parametrize("method", METHODS)
def test_points__have_a_value_in_every_stratum_of_every_axis(method: str) -> None:
    # True of a Latin hypercube by definition, and of a scrambled Sobol sequence of a power of two: Owen (1998).
    sweep = Sweep.parse(changed(combine=method))
    assert len(sweep.runs()) == sweep.size == 16
    again, other = (Sweep.parse(changed(combine=method, seed=seed)).axes for seed in (3, 4))
    assert sweep.axes == again != other
    for axis, (low, high) in zip(sweep.axes, ((3e3, 7e3), (1e-3, 2e-3)), strict=True):
        shares = (np.array(axis.values, float) - low) / (high - low)
        assert sorted(np.floor(16 * shares)) == list(range(16))


def test_document__of_a_sample_states_its_values_and_is_read_as_itself() -> None:
    sweep = Sweep.parse(changed(resolution=[8, 16], offsets=2))
    document = json.loads(json.dumps(sweep.document()))
    assert Sweep.parse(document) == sweep
    assert len(document["axes"]["speed"]["values"]) == document["points"] == 16
    assert sweep.grid.shape == (16, 2, 2)
    assert cost_of(sweep).runs == 64
    document["axes"]["speed"]["values"][0] = "3.25 km/s"
    assert Sweep.parse(document).axes[0].values[0] == 3250.0
    with pytest.raises(InvalidInput, match="at most 20 runs"):
        Sweep.parse(document, SweepLimits(max_runs=20))


@pytest.mark.parametrize(
    ("document", "field", "cure"),
    [
        (changed(points=12), "points", "write points: 8 or points: 16"),
        (changed(points=2**20), "points", "write points: 16"),
        (changed(seed=None), "seed", "write seed: 1"),
        (changed(combine="halton"), "combine", "use one of"),
        ({**HOLES, "seed": 1}, "seed", "leave it out"),
        (axes(speed=["3 km/s"]), "axes.speed", "low"),
        (axes(target={"low": 1, "high": 2}), "axes.target", ""),
        (axes(speed={"low": "3 km/s"}), "axes.speed.high", "low"),
        (axes(speed={"low": "7 km/s", "high": "3 km/s"}), "axes.speed.high", "low"),
        (axes(speed={"start": "3 km/s", "high": "7 km/s"}), "axes.speed.start", ""),
        *(
            (axes(speed={**SAMPLED["axes"]["speed"], "values": values}), "axes.speed.values", "leave values out")
            for values in (["4 km/s"], ["8 km/s"] * 16)
        ),
    ],
)
def test_sample__that_is_wrong_is_refused_by_name(document: dict[str, Any], field: str, cure: str) -> None:
    with pytest.raises(InvalidInput) as refused:
        Sweep.parse(document)
    assert [finding for finding in refused.value.findings if finding.field == field and cure in finding.cure]
