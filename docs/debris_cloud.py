"""docs/debris-cloud.png: the cloud of Ma (2005), section 3.1.2, at 9 us, in section and seen from the side.

``python -m docs.debris_cloud`` computes it anew on the finest grid of the claim ``debris-cloud``, in minutes.
"""

import io
import tempfile
from pathlib import Path

import numpy as np

from studies import materials
from studies.films.section import END, Sections, read_sections
from studies.reports.raster import VIRIDIS, Frame, nearest, png, radiogram
from studies.runs.execution import execute
from studies.runs.run import resolve
from tests.claims.cases.clouds import CASE, COPPER, GRIDS

FILE = Path(__file__).parent / "debris-cloud.png"
WIDTH, GAP = 360, 24  # px of a panel, and between both
FRAME = Frame(-0.026, 0.026, -0.022, 0.054)  # m
SPEEDS, DENSITIES = (0.0, 6600.0), (0.0, 40.0)  # ends of the colours, m/s and kg/m2


def sections() -> Sections:
    """The stored sections of the case."""
    roles = {role: materials.load(COPPER) for role in ("projectile", "target")}
    run = resolve("debris_cloud", {**CASE, "cells_per_diameter": GRIDS[-1]}, roles)
    with tempfile.TemporaryDirectory() as folder:
        execute(run, Path(folder))
        return read_sections(Path(folder) / "sections.npz")


def write() -> None:
    """Write the picture: particles by speed on the left, areal density on the right, flight downwards."""
    from PIL import Image

    stored = sections()
    end = stored.at(END)
    assert end is not None
    shown = nearest(stored, end, FRAME, WIDTH)
    panels = [
        png(shown, np.asarray(end.fields["speed"]), SPEEDS, VIRIDIS),
        radiogram(stored, FRAME, WIDTH, 1.0, DENSITIES),
    ]
    images = [Image.open(io.BytesIO(panel)).convert("RGBA") for panel in panels]
    height = max(image.height for image in images)
    sheet = Image.new("RGBA", (2 * WIDTH + GAP, height), "white")
    for place, image in enumerate(images):
        sheet.alpha_composite(image, (place * (WIDTH + GAP), 0))
    sheet.convert("RGB").quantize(128).save(FILE, optimize=True)


if __name__ == "__main__":
    write()
