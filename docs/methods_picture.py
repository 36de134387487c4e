"""docs/methods.png: the thesis' plate at 6 km/s by both methods, in section at 2, 5 and 30 us, by plastic strain.

``python -m docs.methods_picture`` computes it anew on the finest grid of the claim ``methods-thin-plate``, in minutes.
"""

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from studies.films.section import Sections, read_sections
from studies.reports.drawing.pixels import coloured, nearest
from studies.reports.sections.pictures import Frame
from studies.runs.execution import execute
from studies.sweeps.sweep import Sweep
from tests.cases.test_methods import GRIDS, document

FILE = Path(__file__).parent / "methods.png"
WIDTH, GAP = 300, 16  # px of a panel, and between two
FIELD = "plastic_strain"
FRAME = Frame(-0.022, 0.022, -0.008, 0.024)  # m
STRAINS = (0.0, 3.0)  # ends of the colours


def sections() -> list[Sections]:
    """The stored sections of each method."""
    stored = []
    for point in Sweep.parse({**document(), "resolution": GRIDS[-1]}).runs():
        with tempfile.TemporaryDirectory() as folder:
            execute(point.run, Path(folder))
            stored.append(read_sections(Path(folder) / "sections.npz"))
    return stored


def write(stored: Sequence[Sections]) -> None:
    """Write the picture: a row for each method, times from left to right, flight downwards."""
    from PIL import Image

    rows = [
        [
            coloured(nearest(each, state, FRAME, WIDTH), np.asarray(state.fields[FIELD]), STRAINS, FIELD)
            for state in sorted(each.states, key=lambda state: state.time)
        ]
        for each in stored
    ]
    images = [[Image.fromarray(panel) for panel in row] for row in rows]
    high = images[0][0].height
    size = (len(images[0]) * (WIDTH + GAP) - GAP, len(images) * (high + GAP) - GAP)
    sheet = Image.new("RGBA", size, "white")
    for row, panels in enumerate(images):
        for column, image in enumerate(panels):
            sheet.alpha_composite(image, (column * (WIDTH + GAP), row * (high + GAP)))
    sheet.convert("RGB").quantize(128).save(FILE, optimize=True)


if __name__ == "__main__":
    write(sections())
