"""Shapes in three dimensions and separated spheres have their known sizes, in whatever order their particles come."""

import pytest

from tests.rows import check
from tests.studies.measurements.shapes import rows_of, shapes

# The scooped half space costs as much as the tilted crater, and is read about the axis in ``test_known_answers``.
NAMES = [name for name in shapes() if name != "scooped half space"]


@pytest.mark.parametrize("name", NAMES)
def test_shape__has_its_known_sizes(name: str) -> None:
    check(rows_of(shapes()[name]))
