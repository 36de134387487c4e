"""The cube as a person meets it."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

from tests.claims import Row, claim
from tests.studies.cubes.reading import checks


@claim(
    "cube-reads",
    says="print(cube) begins with the main results; labels have at most 40 characters and definitions a comment; fixed "
    "parameters are scalar coordinates, histories have times, and runs.csv has every run",
)
def cube_reads() -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as folder:
        yield from checks(Path(folder))
