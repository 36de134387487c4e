"""Pictures as SVG: a raster of particles under axes, lengths and a colour bar, in the page's own colours.

Everything is in the document (:mod:`studies.reports.pictures`); here it becomes lines and text. Colours of lines are
classes of the page's style sheet, so that a picture reads in light and dark and on paper.
"""

import base64
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from markupsafe import Markup, escape

from studies.films.radiograph import AREAL_DENSITY
from studies.films.section import Section, Sections, read_sections
from studies.reports.raster import INFERNO, VIRIDIS, Frame, nearest, png, radiogram
from studies.reports.svg import arrow, line, microseconds, millimetres, px, step_of, svg, text, ticks
from studies.values.formats import digits, display_of

Document = Mapping[str, Any]

# px of the drawing; the page scales it.
FULL, THUMBNAIL, SMALL = 440, 240, 116  # width; small: of debris in the card of a run
LEFT, RIGHT, ABOVE, BELOW = 40, 84, 8, 34  # around the raster of a full picture
FOOT = 20  # below a thumbnail
KEY = 240  # width of a colour bar that lies
BAR, BAR_GAP = 12, 10  # width of the colour bar, and its distance
SHARP = 1.6  # raster pixels of a pixel
TICKS = 5  # of an axis, about
LABEL_AT = 5  # px between a line and its label


class Gallery:
    """Draws the pictures of a report from the files of its runs' sections."""

    def __init__(self, files: Mapping[int, Path]):
        self.files = files  # by run number
        self._read: tuple[int, Sections] | None = None
        self._nearest: dict[tuple[Any, ...], Any] = {}

    def picture(self, run: int, picture: Document, *, full: bool) -> Markup:
        """A picture of the document, in full or as a thumbnail."""
        frame = Frame(**picture["frame"])
        if full:
            raster = self._raster(run, picture, frame, FULL - LEFT - RIGHT)
            return Markup(full_size(picture, frame, raster))
        width = THUMBNAIL if picture["kind"] == "end" else SMALL
        return Markup(thumbnail(picture, frame, self._raster(run, picture, frame, width), width))

    def _raster(self, run: int, picture: Document, frame: Frame, width: int) -> bytes:
        sections = self._sections(run)
        if picture["field"] == AREAL_DENSITY:
            columns = 2 * round(0.5 * SHARP * width)
            return radiogram(sections, frame, columns, picture["sign"], picture["limits"])
        section = sections.at(picture["moment"])
        assert section is not None
        position = section.position * (1.0, picture["sign"])
        section = replace(section, position=position)
        key = (run, picture["moment"], width)
        if key not in self._nearest:
            # The fields of a state share their pixels.
            self._nearest = {key: nearest(sections, section, frame, 2 * round(0.5 * SHARP * width))}
        return png(self._nearest[key], _values(section, picture["field"]), picture["limits"], colours(picture["field"]))

    def _sections(self, run: int) -> Sections:
        if self._read is None or self._read[0] != run:
            self._read = (run, read_sections(self.files[run]))
        return self._read[1]


def _labelled(picture: Document) -> str:
    """The field of a picture with its unit: "pressure (GPa)"."""
    return f"{picture['label']} ({picture['unit']})" if picture["unit"] else picture["label"]


def _number(value: float) -> str:
    return digits(float(f"{value:.6g}"))


def _values(section: Section, field: str) -> Any:
    return section.fields[field]


def colours(field: str) -> str:
    """The table of colours of a field, from low to high."""
    return INFERNO if field == "temperature" else VIRIDIS


def _ramp_name(field: str) -> str:
    return "heat" if field == "temperature" else "plain"


def ramps() -> Markup:
    """The colours of the bars, which all pictures of a page share; an SVG without size."""
    gradients = []
    for field in ("plastic_strain", "temperature"):
        steps = colours(field).split()
        shades = "".join(
            f'<stop offset="{place / (len(steps) - 1):.4f}" stop-color="#{colour}"/>'
            for place, colour in enumerate(steps)
        )
        name = _ramp_name(field)
        gradients += [
            f'<linearGradient id="{name}" x1="0" x2="0" y1="1" y2="0">{shades}</linearGradient>',
            f'<linearGradient id="{name}-across">{shades}</linearGradient>',
        ]
    return Markup(f'<svg class="ramps" aria-hidden="true"><defs>{"".join(gradients)}</defs></svg>')


# ---- whole pictures ------------------------------------------------------------------------------


def thumbnail(picture: Document, frame: Frame, raster: bytes, width: int) -> str:
    """A small picture: the raster, a scale, the time and the measured lengths."""
    scale = width / frame.width
    height = frame.height * scale
    parts = [_image(raster, 0, 0, width, height)]
    parts += _lengths(picture, frame, 0, 0, scale)
    parts += _scale_bar(frame, scale, height + FOOT)
    parts += [text("small", width - 2, height + FOOT - 4, microseconds(picture["time"]), "end")]
    return svg("of-run thumbnail", width, height + FOOT, parts, picture["alt"])


def colour_keys(pictures: Sequence[Document]) -> Markup:
    """The colour bars that thumbnails share, each with the label of its field."""
    keys = []
    for picture in pictures:
        ramp = f"{_ramp_name(picture['field'])}-across"
        low, high = (_number(limit * picture["factor"]) for limit in picture["limits"])
        scene = "at the end" if picture["kind"] == "end" else "debris"
        parts = [
            text("tick", 0, 12, f"{scene}: {_labelled(picture)}", "start"),
            f'<rect x="24" y="18" width="{KEY - 68}" height="{BAR}" fill="url(#{ramp})"/>',
            text("tick", 20, 28, low, "end"),
            text("tick", KEY - 40, 28, high, "start"),
        ]
        keys.append(svg("key", KEY, 34, parts, f"Colours {scene}: {picture['label']} from {low} to {high}"))
    return Markup("".join(keys))


def full_size(picture: Document, frame: Frame, raster: bytes) -> str:
    """A picture with axes and a colour bar."""
    width = FULL - LEFT - RIGHT
    scale = width / frame.width
    height = frame.height * scale
    parts = [
        f'<rect class="frame" x="{LEFT}" y="{ABOVE}" width="{width}" height="{px(height)}"/>',
        _image(raster, LEFT, ABOVE, width, height),
    ]
    parts += _axes(frame, scale, width, height, picture["sign"])
    parts += _lengths(picture, frame, LEFT, ABOVE, scale)
    parts += _colour_bar(picture, FULL - RIGHT + BAR_GAP, ABOVE, max(height, 90.0))
    return svg("of-run full", FULL, ABOVE + max(height, 90.0) + BELOW, parts, picture["alt"])


def _image(raster: bytes, x: float, y: float, width: float, height: float) -> str:
    content = base64.b64encode(raster).decode("ascii")
    place = f'x="{px(x)}" y="{px(y)}" width="{px(width)}" height="{px(height)}"'
    return (
        f'<rect class="ground" {place}/>'
        f'<image {place} preserveAspectRatio="none" href="data:image/png;base64,{content}"/>'
    )


# ---- parts ---------------------------------------------------------------------------------------


def _lengths(picture: Document, frame: Frame, x: float, y: float, scale: float) -> Iterator[str]:
    """Measured lengths: across the axis between two lines along it, along the axis from the surface."""
    axis = x + (picture["middle"] - frame.left) * scale
    surface = y - frame.top * scale
    bottom = y + frame.height * scale
    for length in picture["across"]:
        half = 0.5 * length["value"] * scale
        # Of a hole below it, where nothing stands; else at the surface, where it is measured.
        at = bottom - 10.0 if length["quantity"] == "hole_diameter" else surface
        yield from (
            line("measured thin", axis + side * half, y + 2, axis + side * half, bottom - 2) for side in (-1, 1)
        )
        yield arrow("measured", axis - half, at, axis + half, at)
        yield text("measured", axis, at - LABEL_AT, millimetres(length["value"]), "middle")
    for length in picture["along"]:
        end = surface + picture["sign"] * length["value"] * scale
        yield line("measured thin", axis - 24, end, axis + 24, end)
        yield arrow("measured", axis, surface, axis, end)
        yield text("measured", axis + LABEL_AT, 0.5 * (surface + end) + 4, millimetres(length["value"]), "start")


def _scale_bar(frame: Frame, scale: float, height: float) -> Iterator[str]:
    """A bar of a round length in the lower left corner."""
    length = step_of(frame.width / 4.0)
    end = 6 + length * scale
    yield line("scale", 6, height - 3, end, height - 3)
    yield text("small", 6, height - 7, millimetres(length, digits), "start")


def _axes(frame: Frame, scale: float, width: float, height: float, sign: float) -> Iterator[str]:
    """Millimetres along both sides, from the axis and from the original surface."""
    factor = display_of("m").factor
    step = step_of(frame.width / TICKS)
    for at in ticks(frame.left, frame.right, step):
        x, y = LEFT + (at - frame.left) * scale, ABOVE + height
        yield line("axis", x, y, x, y + 4)
        yield text("tick", x, y + 16, digits(round(at * factor, 9)), "middle")
    for at in ticks(frame.top, frame.bottom, step):
        y = ABOVE + (at - frame.top) * scale
        yield line("axis", LEFT - 4, y, LEFT, y)
        yield text("tick", LEFT - 6, y + 4, digits(round(sign * at * factor, 9)), "end")
    yield text("tick", LEFT + width, ABOVE + height + 30, display_of("m").unit, "end")


def _colour_bar(picture: Document, x: float, y: float, height: float) -> Iterator[str]:
    """The colours with their numbers; the label runs along them."""
    low, high = picture["limits"]
    ramp = _ramp_name(picture["field"])
    yield f'<rect x="{px(x)}" y="{px(y)}" width="{BAR}" height="{px(height)}" fill="url(#{ramp})"/>'
    factor = picture["factor"]
    for at in ticks(low * factor, high * factor, step_of((high - low) * factor / 4.0)):
        level = y + height * (1.0 - (at / factor - low) / (high - low))
        yield line("axis", x + BAR, level, x + BAR + 3, level)
        yield text("tick", x + BAR + 5, min(max(level + 4, y + 9), y + height), digits(round(at, 9)), "start")
    middle = y + 0.5 * height
    label = _labelled(picture)
    yield (
        f'<text class="tick" transform="translate({px(x + 68)} {px(middle)}) rotate(-90)" text-anchor="middle">'
        f"{escape(label)}</text>"
    )
