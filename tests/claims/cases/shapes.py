"""Sizes that measurements read off shapes of known sizes."""

from collections.abc import Iterator
from dataclasses import replace

from tests.claims import Row, claim
from tests.studies.measurements.shapes import rows_of, shapes


@claim(
    "known-shapes",
    says="a scooped half space, a drilled ellipse of 20 x 12 mm, the crater of a tilted shot and two separated spheres "
    "are read to a tenth of a cell, whatever the order of their particles",
)
def known_shapes() -> Iterator[Row]:
    for name, shape in shapes().items():
        for row in rows_of(shape):
            yield replace(row, claim=f"{name}: {row.claim} (SI)")
