"""docs/debris-cloud.png: the cloud of Ma (2005), section 3.1.2, at 9 us, in section and seen from the side.

``python -m docs.debris_cloud`` computes it anew on the finest grid of the claim ``debris-cloud``, in minutes.
"""

import tempfile
from pathlib import Path

import numpy as np

from studies.films.radiograph import AREAL_DENSITY
from studies.films.section import END, Sections, read_sections
from studies.reports.drawing.pixels import coloured, in_radiograph, nearest
from studies.reports.sections.pictures import Frame
from studies.runs.execution import execute
from tests.studies.measurements.test_debris_cloud import GRIDS, asked

FILE = Path(__file__).parent / "debris-cloud.png"
WIDTH, GAP = 360, 24  # px of a panel, and between both
FRAME = Frame(-0.026, 0.026, -0.022, 0.054)  # m
SPEEDS, DENSITIES = (0.0, 6600.0), (0.0, 40.0)  # ends of the colours, m/s and kg/m2


def sections() -> Sections:
    """The stored sections of the case."""
    with tempfile.TemporaryDirectory() as folder:
        execute(asked(GRIDS[-1]), Path(folder))
        return read_sections(Path(folder) / "sections.npz")


def write() -> None:
    """Write the picture: particles by speed on the left, areal density on the right, flight downwards."""
    from PIL import Image

    stored = sections()
    end = stored.at(END)
    assert end is not None
    shown = nearest(stored, end, FRAME, WIDTH)
    assert stored.radiograph is not None
    seen = in_radiograph(stored.radiograph, FRAME, WIDTH, 1.0)
    panels = [
        coloured(shown, np.asarray(end.fields["speed"]), SPEEDS, "speed"),
        coloured(seen, stored.radiograph.density.ravel(), DENSITIES, AREAL_DENSITY),
    ]
    images = [Image.fromarray(panel) for panel in panels]
    height = max(image.height for image in images)
    sheet = Image.new("RGBA", (2 * WIDTH + GAP, height), "white")
    for place, image in enumerate(images):
        sheet.alpha_composite(image, (place * (WIDTH + GAP), 0))
    sheet.convert("RGB").quantize(128).save(FILE, optimize=True)


if __name__ == "__main__":
    write()
