"""Which kernels sweeps need: one kind for all runs that share them."""

import pytest

from studies.runs.run import Run
from studies.sweeps import examples
from studies.sweeps.document import read_yaml
from studies.sweeps.kernels import kinds_of
from studies.sweeps.sweep import Sweep
from tests.samples import needs


def runs_of(example: str, **fixed: str) -> list[Run]:
    document = read_yaml(examples.text(example), example)
    whole = {**document, "fixed": {**document.get("fixed", {}), **fixed}}
    return [point.run for point in Sweep.parse(whole).runs()]


@pytest.mark.parametrize(
    ("example", "kinds"), [("holes", 1), ("craters", 1), pytest.param("taylor", 2, marks=needs("taylor_bar"))]
)
def test_kinds__are_those_of_geometry_choices_and_laws(example: str, kinds: int) -> None:
    assert len(kinds_of(runs_of(example))) == kinds
