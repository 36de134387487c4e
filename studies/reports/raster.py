"""Sections of runs as small PNG files: each pixel has the colour of the nearest particle, or none where there is none.

Colours are viridis, and inferno for temperature (van der Walt and Smith 2015, CC0): they grow evenly in lightness, so
that they read in grey and with any colour vision.
"""

import io
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

from studies.films.section import Section, Sections

# Colour of the raster at equal distances, as matplotlib has them; in between they are mixed, to within 7 of 255.
VIRIDIS = (
    "440154 48186a 472d7b 424086 3b528b 33638d 2c728e 26828e 21918c 1f9f88 27ad81 3dbc74 5cc863 81d34d aadc32 d5e21a "
    "fde725"
)
INFERNO = (
    "000004 0b0724 210c4a 3d0965 57106e 71196e 8a226a a32c61 bc3754 d04545 e35933 f1711f f98c0a fcaa0f f9c932 f2e865 "
    "fcffa4"
)

CLEAR, UNKNOWN = 0, 1  # palette entries: no matter, and matter whose value is not known
SHADES = 254  # palette entries of colours
GREY = (140, 140, 140)
# A gap that is narrower than twice this, in widths of a particle, is closed: particles of whole matter are drawn apart
# by that much before the grid no longer joins them. The outer edge of matter stays half a width from its particles.
CLOSED = 0.75
EDGE = 0.5


@dataclass(frozen=True)
class Frame:
    """The part of a section that a picture shows, m."""

    left: float
    right: float
    top: float  # lowest coordinate along the line of flight, where the projectile comes from
    bottom: float

    @property
    def width(self) -> float:
        return self.right - self.left

    @property
    def height(self) -> float:
        return self.bottom - self.top


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


def radiogram(sections: Sections, frame: Frame, columns: int, sign: float, limits: tuple[float, float]) -> bytes:
    """The picture of a radiograph; ``sign`` is 1 where the frame counts along the flight, else -1."""
    taken = sections.radiograph
    assert taken is not None
    rows = max(1, round(columns * frame.height / frame.width))
    across = frame.left + (np.arange(columns) + 0.5) * frame.width / columns
    along = sign * (frame.top + (np.arange(rows) + 0.5) * frame.height / rows)
    column = np.floor(np.abs(across) / taken.pixel).astype(np.int64)
    row = np.floor((along - taken.origin) / taken.pixel).astype(np.int64)
    count = taken.density.shape
    inside = ((row >= 0) & (row < count[0]))[:, None] & (column < count[1])
    place = row[:, None] * count[1] + column
    shown = inside & (taken.density.ravel()[np.where(inside, place, 0)] > 0.0)
    return png(np.where(shown, place, -1), taken.density.ravel(), limits, VIRIDIS)


def png(particles: np.ndarray, values: np.ndarray, limits: tuple[float, float], colours: str) -> bytes:
    """The picture of particles (rows, columns) by their values (n,), with a transparent ground."""
    from PIL import Image

    low, high = limits
    with np.errstate(invalid="ignore"):
        shade = np.clip((values - low) / (high - low), 0.0, 1.0) * (SHADES - 1)
        entry = np.where(np.isfinite(values), np.nan_to_num(shade).round() + 2, UNKNOWN)
    index = np.append(entry, CLEAR).astype(np.uint8)[particles]
    picture = Image.fromarray(index, "P")
    table = np.vstack([[(0, 0, 0), GREY], ramp(colours, SHADES)])
    picture.putpalette(table.astype(np.uint8).tobytes())
    file = io.BytesIO()
    picture.save(file, "PNG", transparency=CLEAR, optimize=True)
    return file.getvalue()


def ramp(colours: str, count: int) -> np.ndarray:
    """A number of colours (count, 3), 0..255, mixed between those of a table."""
    texts = colours.split()
    steps = np.array([[int(text[i : i + 2], 16) for i in (0, 2, 4)] for text in texts], float)
    at = np.linspace(0.0, len(texts) - 1, count)
    mixed = [np.interp(at, np.arange(len(texts)), channel) for channel in steps.T]
    return np.round(np.stack(mixed, axis=-1))
