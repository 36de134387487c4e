"""Pictures as SVG: a raster of particles under axes, lengths and a colour bar, in the page's own colours.

Everything is in the document (:mod:`studies.reports.pictures`); here it becomes lines and text. Colours of lines are
classes of the page's style sheet, so that a picture reads in light and dark and on paper.
"""

import base64
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup, escape

from studies.films.section import Section, Sections, read_sections
from studies.reports.raster import INFERNO, VIRIDIS, Frame, nearest, png
from studies.values.formats import digits, display_of, printed, printed_in, with_unit

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
        section = sections.at(picture["moment"])
        assert section is not None
        key = (run, picture["moment"], width)
        if key not in self._nearest:
            # The fields of a state share their pixels.
            self._nearest = {key: nearest(sections, section, frame, 2 * round(0.5 * SHARP * width))}
        return png(
            self._nearest[key],
            _values(section, picture["field"]),
            picture["limits"],
            colours(picture["field"]),
        )

    def _sections(self, run: int) -> Sections:
        if self._read is None or self._read[0] != run:
            self._read = (run, read_sections(self.files[run]))
        return self._read[1]


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
    parts += [_text("small", width - 2, height + FOOT - 4, _time(picture["time"]), "end")]
    return _svg("thumbnail", width, height + FOOT, parts, picture["alt"])


def colour_keys(pictures: Sequence[Document]) -> Markup:
    """The colour bars that thumbnails share, each with the label of its field."""
    keys = []
    for picture in pictures:
        unit, ramp = picture["unit"], f"{_ramp_name(picture['field'])}-across"
        low, high = (printed_in(limit, unit) for limit in picture["limits"])
        scene = "at the end" if picture["kind"] == "end" else "debris"
        parts = [
            _text("tick", 0, 12, f"{scene}: {with_unit(picture['label'], unit)}", "start"),
            f'<rect x="24" y="18" width="{KEY - 68}" height="{BAR}" fill="url(#{ramp})"/>',
            _text("tick", 20, 28, low, "end"),
            _text("tick", KEY - 40, 28, high, "start"),
        ]
        keys.append(
            _svg("key", KEY, 34, parts, f"Colours {scene}: {picture['label']} from {low} to {high}")
        )
    return Markup("".join(keys))


def full_size(picture: Document, frame: Frame, raster: bytes) -> str:
    """A picture with axes and a colour bar."""
    width = FULL - LEFT - RIGHT
    scale = width / frame.width
    height = frame.height * scale
    parts = [
        f'<rect class="frame" x="{LEFT}" y="{ABOVE}" width="{width}" height="{_px(height)}"/>',
        _image(raster, LEFT, ABOVE, width, height),
    ]
    parts += _axes(frame, scale, width, height)
    parts += _lengths(picture, frame, LEFT, ABOVE, scale)
    parts += _colour_bar(picture, FULL - RIGHT + BAR_GAP, ABOVE, max(height, 90.0))
    return _svg("full", FULL, ABOVE + max(height, 90.0) + BELOW, parts, picture["alt"])


def _svg(kind: str, width: float, height: float, parts: list[str], alt: str) -> str:
    text = escape(alt)
    return (
        f'<svg class="picture {kind}" viewBox="0 0 {_px(width)} {_px(height)}" role="img" aria-label="{text}">'
        f"{''.join(parts)}</svg>"
    )


def _image(raster: bytes, x: float, y: float, width: float, height: float) -> str:
    content = base64.b64encode(raster).decode("ascii")
    return (
        f'<image x="{_px(x)}" y="{_px(y)}" width="{_px(width)}" height="{_px(height)}" preserveAspectRatio="none" '
        f'href="data:image/png;base64,{content}"/>'
    )


# ---- parts ---------------------------------------------------------------------------------------


def _lengths(picture: Document, frame: Frame, x: float, y: float, scale: float) -> Iterator[str]:
    """Measured lengths: across the axis between two lines along it, along the axis from the surface."""
    axis, surface = x - frame.left * scale, y - frame.top * scale
    bottom = y + frame.height * scale
    for number, length in enumerate(picture["across"]):
        half = 0.5 * length["value"] * scale
        # Across an opening, whose middle is free; of a crater at the surface where it is measured.
        at = surface if length["quantity"] == "crater_diameter" else bottom - 10.0 - 18.0 * number
        yield from (
            _line("measured thin", axis + side * half, y + 2, axis + side * half, bottom - 2)
            for side in (-1, 1)
        )
        yield _arrow("measured", axis - half, at, axis + half, at)
        yield _text("measured", axis, at - LABEL_AT, _millimetres(length["value"]), "middle")
    for length in picture["along"]:
        end = surface + length["value"] * scale
        yield _line("measured thin", axis - 24, end, axis + 24, end)
        yield _arrow("measured", axis, surface, axis, end)
        yield _text(
            "measured",
            axis + LABEL_AT,
            0.5 * (surface + end) + 4,
            _millimetres(length["value"]),
            "start",
        )


def _scale_bar(frame: Frame, scale: float, height: float) -> Iterator[str]:
    """A bar of a round length in the lower left corner."""
    length = step_of(frame.width / 4.0)
    end = 6 + length * scale
    yield _line("scale", 6, height - 3, end, height - 3)
    yield _text("small", 6, height - 7, _millimetres(length, digits), "start")


def _axes(frame: Frame, scale: float, width: float, height: float) -> Iterator[str]:
    """Millimetres along both sides, from the axis and from the original surface."""
    factor = display_of("m").factor
    step = step_of(frame.width / TICKS)
    for at in _ticks(frame.left, frame.right, step):
        x, y = LEFT + (at - frame.left) * scale, ABOVE + height
        yield _line("axis", x, y, x, y + 4)
        yield _text("tick", x, y + 16, digits(round(at * factor, 9)), "middle")
    for at in _ticks(frame.top, frame.bottom, step):
        y = ABOVE + (at - frame.top) * scale
        yield _line("axis", LEFT - 4, y, LEFT, y)
        yield _text("tick", LEFT - 6, y + 4, digits(round(at * factor, 9)), "end")
    yield _text("tick", LEFT + width, ABOVE + height + 30, display_of("m").unit, "end")


def _colour_bar(picture: Document, x: float, y: float, height: float) -> Iterator[str]:
    """The colours with their numbers; the label runs along them."""
    low, high = picture["limits"]
    ramp = _ramp_name(picture["field"])
    yield f'<rect x="{_px(x)}" y="{_px(y)}" width="{BAR}" height="{_px(height)}" fill="url(#{ramp})"/>'
    factor = display_of(picture["unit"]).factor
    for at in _ticks(low * factor, high * factor, step_of((high - low) * factor / 4.0)):
        level = y + height * (1.0 - (at / factor - low) / (high - low))
        yield _line("axis", x + BAR, level, x + BAR + 3, level)
        yield _text(
            "tick",
            x + BAR + 5,
            min(max(level + 4, y + 9), y + height),
            digits(round(at, 9)),
            "start",
        )
    middle = y + 0.5 * height
    label = with_unit(picture["label"], picture["unit"])
    yield (
        f'<text class="tick" transform="translate({_px(x + 68)} {_px(middle)}) rotate(-90)" text-anchor="middle">'
        f"{escape(label)}</text>"
    )


def step_of(length: float) -> float:
    """A round step near a length.

    >>> step_of(0.0011), step_of(0.0034), step_of(7.1)
    (0.001, 0.005, 5.0)
    """
    power = 10.0 ** math.floor(math.log10(length))
    return float(
        f"{min((1.0, 2.0, 5.0, 10.0), key=lambda step: abs(math.log(step * power / length))) * power:.12g}"
    )


def _ticks(low: float, high: float, step: float) -> list[float]:
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [number * step for number in range(first, last + 1)]


def _millimetres(value: float, form: Any = None) -> str:
    unit = display_of("m")
    text = form(round(value * unit.factor, 9)) if form else printed(value, "length")
    return f"{text} {unit.unit}"


def _time(seconds: float) -> str:
    return f"{printed_in(float(f'{seconds:.3g}'), 's')} {display_of('s').unit}"


def _line(kind: str, x1: float, y1: float, x2: float, y2: float) -> str:
    return f'<line class="{kind}" x1="{_px(x1)}" y1="{_px(y1)}" x2="{_px(x2)}" y2="{_px(y2)}"/>'


def _arrow(kind: str, x1: float, y1: float, x2: float, y2: float) -> str:
    """A line with a head at both ends."""
    angle = math.atan2(y2 - y1, x2 - x1)
    heads = []
    for x, y, towards in ((x1, y1, angle), (x2, y2, angle + math.pi)):
        ends = [
            (x + 7 * math.cos(towards + side), y + 7 * math.sin(towards + side))
            for side in (-0.4, 0.4)
        ]
        corners = " ".join(f"{_px(a)},{_px(b)}" for a, b in ((x, y), *ends))
        heads.append(f'<polygon class="{kind} head" points="{corners}"/>')
    return _line(kind, x1, y1, x2, y2) + "".join(heads)


def _text(kind: str, x: float, y: float, text: str, anchor: str) -> str:
    return f'<text class="{kind}" x="{_px(x)}" y="{_px(y)}" text-anchor="{anchor}">{escape(text)}</text>'


def _px(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")
