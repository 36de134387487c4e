"""Pixels of sections of runs: each has the colour of the nearest particle, or none where there is none.

Colours are viridis, and inferno for temperature (van der Walt and Smith 2015, CC0): they grow evenly in lightness, so
that they read in grey and with any colour vision.
"""

from dataclasses import replace

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import Colormap, Normalize
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

from studies.reports.drawing.canvas import GREY
from studies.reports.picture import Frame
from studies.sections.radiograph import Radiograph
from studies.sections.section import Section, Sections

# A gap that is narrower than twice this, in widths of a particle, is closed: particles of whole matter are drawn apart
# by that much before the grid no longer joins them. The outer edge of matter stays half a width from its particles.
CLOSED = 0.75
EDGE = 0.5


def nearest(sections: Sections, section: Section, frame: Frame, columns: int) -> np.ndarray:
    """The particle (rows, columns) at each pixel of a frame, -1 where there is none.

    The other side of the axis is the mirror image, in a frame that has the axis in its middle.
    """
    if sections.mirrored:
        right = replace(frame, left=0.0)
        half = _nearest(sections, section, right, round(columns * right.width / frame.width))
        return np.hstack([half[:, ::-1], half])
    return _nearest(sections, section, frame, columns)


def _nearest(sections: Sections, section: Section, frame: Frame, columns: int) -> np.ndarray:
    rows = max(1, round(columns * frame.height / frame.width))
    x = frame.left + (np.arange(columns) + 0.5) * frame.width / columns
    y = frame.top + (np.arange(rows) + 0.5) * frame.height / rows
    place = np.stack(np.broadcast_arrays(x, y[:, np.newaxis]), axis=-1).reshape(-1, 2)
    particles = np.full((rows, columns), -1)
    if not len(section.position):
        return particles
    widths = sections.spacing[section.body].max(axis=1)
    reach = (EDGE + CLOSED) * float(widths.max())
    distance, at = cKDTree(section.position).query(place, distance_upper_bound=reach)
    inside = np.isfinite(distance)
    inside[inside] = distance[inside] <= (EDGE + CLOSED) * widths[at[inside]]
    # Closing: matter, widened by so much and narrowed again.
    pixel = frame.width / columns
    within = distance_transform_edt(inside.reshape(rows, columns)) * pixel
    shown = (within > CLOSED * widths.max()) | (distance <= EDGE * widths.max()).reshape(rows, columns)
    particles[shown] = at.reshape(rows, columns)[shown]
    return particles


def in_radiograph(taken: Radiograph, frame: Frame, columns: int, sign: float) -> np.ndarray:
    """The pixel of a radiograph (rows, columns) at each pixel of a frame, -1 where there is no matter.

    ``sign`` is 1 where the frame counts along the flight, else -1.
    """
    rows = max(1, round(columns * frame.height / frame.width))
    across = frame.left + (np.arange(columns) + 0.5) * frame.width / columns
    along = sign * (frame.top + (np.arange(rows) + 0.5) * frame.height / rows)
    column = np.floor(np.abs(across) / taken.pixel).astype(np.int64)
    row = np.floor((along - taken.origin) / taken.pixel).astype(np.int64)
    count = taken.density.shape
    inside = ((row >= 0) & (row < count[0]))[:, None] & (column < count[1])
    place = row[:, None] * count[1] + column
    shown = inside & (taken.density.ravel()[np.where(inside, place, 0)] > 0.0)
    return np.where(shown, place, -1)


def coloured(particles: np.ndarray, values: np.ndarray, limits: tuple[float, float], field: str) -> np.ndarray:
    """Colours (rows, columns, 4), 0..255, of particles (rows, columns) by their values (n,); clear where none is."""
    shades = colours(field)(Normalize(*limits)(np.ma.masked_invalid(values)), bytes=True)
    shown: np.ndarray = np.vstack([shades, np.zeros((1, 4), np.uint8)])[particles]
    return shown


def colours(field: str) -> Colormap:
    """The colours of a field, from low to high; grey where its value is not known."""
    return colormaps["inferno" if field == "temperature" else "viridis"].with_extremes(bad=GREY)
