"""Pictures of runs: sections and radiographs with axes, measured lengths and colour bars.

Everything that they say is in the document (:mod:`studies.reports.picture`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from studies.quantities.display import digits, display_of, elapsed, printed
from studies.reports.drawing.canvas import arrow, as_svg, canvas, drawn_in_style, line, number, write
from studies.reports.drawing.pixels import coloured, colours, in_radiograph, nearest
from studies.reports.picture import Frame, Picture, rounded_up
from studies.sections.radiograph import AREAL_DENSITY
from studies.sections.section import read_sections

# points
FULL, THUMBNAIL, SMALL = 330.0, 180.0, 87.0  # width; small: of debris in the card of a run
LEFT, RIGHT, ABOVE, BELOW = 32.0, 62.0, 6.0, 30.0  # around the pixels of a full picture
FOOT = 15.0  # below a thumbnail
KEY, KEY_HEIGHT = 180.0, 26.0  # a colour bar that lies, with its label
BAR, BAR_GAP, LOWEST = 9.0, 8.0, 68.0  # width of the colour bar, its distance, and its least height
LABEL_AT = 4.0  # between a line and its label
SHARP = 2.1  # pixels of a picture in a point
SHADES = 128  # of a colour bar


class Gallery:
    """Draws the pictures of a report from the files of its runs' sections."""

    def __init__(self, files: Mapping[int, Path]):
        self._sections = lru_cache(1)(lambda run: read_sections(files[run]))  # by run number
        self._nearest: dict[tuple[int, int, float], np.ndarray] = {}

    def picture(self, run: int, picture: Picture, *, full: bool, place: str = "") -> Markup:
        """A picture of the document, in full or as a thumbnail, at a place of the page that is none of the usual."""
        assert picture.frame
        width = FULL - LEFT - RIGHT if full else THUMBNAIL if picture.kind == "end" else SMALL
        with drawn_in_style():
            pixels = self._pixels(run, picture, picture.frame, width)
            drawn = full_size if full else _thumbnail
            kind, salt = "full" if full else "thumbnail", f"{run}-{picture.moment}-{picture.field}-{full}{place}"
            return as_svg(drawn(picture, picture.frame, pixels), f"of-run {kind}", picture.alt, salt)

    def _pixels(self, run: int, picture: Picture, frame: Frame, width: float) -> np.ndarray:
        sections, columns = self._sections(run), 2 * round(0.5 * SHARP * width)
        if picture.field == AREAL_DENSITY:
            assert sections.radiograph
            places = in_radiograph(sections.radiograph, frame, columns, picture.sign)
            return coloured(places, sections.radiograph.density.ravel(), picture.limits, picture.field)
        section = sections.at(picture.moment)
        assert section is not None
        key = (run, picture.moment, width)
        if key not in self._nearest:
            # The fields of a state share their pixels.
            turned = replace(section, position=section.position * (1.0, picture.sign))
            self._nearest = {key: nearest(sections, turned, frame, columns)}
        return coloured(self._nearest[key], section.fields[picture.field], picture.limits, picture.field)


# ---- whole pictures ------------------------------------------------------------------------------


def _thumbnail(picture: Picture, frame: Frame, pixels: np.ndarray) -> Figure:
    """A small picture: the pixels, a scale, the time and the measured lengths."""
    width = THUMBNAIL if picture.kind == "end" else SMALL
    point = frame.width / width  # m
    height = frame.height / point
    drawing = canvas(width, height + FOOT)
    axes = _section(drawing, picture, frame, pixels, (0.0, FOOT, width, height))
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set_visible(False)
    length, foot = rounded_up(frame.width / 5.0), frame.bottom + FOOT * point
    begin = frame.left + 5.0 * point
    line(axes, "scale", (begin, begin + length), (foot - 2.0 * point,) * 2)
    unit = display_of("m")
    write(axes, "small", begin, foot - 5.0 * point, f"{number(length * unit.factor)} {unit.unit}", "left")
    write(axes, "small", frame.right - 2.0 * point, foot - 4.0 * point, elapsed(picture.time), "right")
    return drawing


def full_size(picture: Picture, frame: Frame, pixels: np.ndarray, above: float = ABOVE) -> Figure:
    """A picture with axes, in millimetres from the axis and from the original surface, and a colour bar.

    Above it there is room of so many points.
    """
    width = FULL - LEFT - RIGHT
    height = frame.height * width / frame.width
    tall = max(height, LOWEST)
    drawing = canvas(FULL, above + tall + BELOW)
    top = BELOW + tall
    axes = _section(drawing, picture, frame, pixels, (LEFT, top - height, width, height))
    factor = display_of("m").factor
    axes.xaxis.set_major_formatter(lambda at, _: number(at * factor))
    axes.yaxis.set_major_formatter(lambda at, _: number(picture.sign * at * factor))
    axes.locator_params(nbins=6, steps=(1, 2, 5, 10))
    axes.set_xlabel(display_of("m").unit, loc="right", labelpad=1.0)
    bar = drawing.add_axes(_rectangle(drawing, (FULL - RIGHT + BAR_GAP, BELOW, BAR, tall)))
    _bar(bar, picture, (0.0, 1.0, *picture.limits), np.linspace(1.0, 0.0, SHADES)[:, None])
    bar.yaxis.tick_right()
    bar.set_xticks([])
    bar.set_ylabel(_labelled(picture), fontsize=9.0)
    bar.yaxis.set_label_position("right")
    return drawing


def colour_keys(pictures: Sequence[Picture]) -> Markup:
    """The colour bars that thumbnails share, each with the label of its field."""
    keys = []
    for picture in pictures:
        scene = "at the end" if picture.kind == "end" else "debris"
        low, high = (digits(float(f"{limit * picture.factor:.6g}")) for limit in picture.limits)
        with drawn_in_style():
            drawing = canvas(KEY, KEY_HEIGHT)
            axes = drawing.add_axes(_rectangle(drawing, (18.0, 4.0, KEY - 51.0, BAR)))
            _bar(axes, picture, (*picture.limits, 0.0, 1.0), np.linspace(0.0, 1.0, SHADES)[None])
            axes.set_axis_off()
            drawing.text(0.0, 1.0, f"{scene}: {_labelled(picture)}", va="top", size=9.0)
            for text, end, beside, anchor in ((low, 0.0, -3.0, "right"), (high, 1.0, 3.0, "left")):
                note = axes.annotate(
                    text, (end, 0.5), (beside, 0.0), xycoords="axes fraction", textcoords="offset points"
                )
                note.set(ha=anchor, va="center", size=9.0)
            alt = f"Colours {scene}: {picture.label} from {low} to {high}"
            keys.append(as_svg(drawing, "key", alt, f"key-{picture.kind}"))
    return Markup("").join(keys)


# ---- parts ---------------------------------------------------------------------------------------


def _rectangle(drawing: Figure, place: Sequence[float]) -> tuple[float, float, float, float]:
    """A place in points (left, bottom, width, height) as parts of a drawing."""
    width, height = 72.0 * drawing.get_size_inches()
    return place[0] / width, place[1] / height, place[2] / width, place[3] / height


def _section(drawing: Figure, picture: Picture, frame: Frame, pixels: np.ndarray, place: Sequence[float]) -> Axes:
    """The pixels of a frame with the measured lengths; coordinates are metres, down along the line of flight."""
    axes = drawing.add_axes(_rectangle(drawing, place), facecolor="#ffffff")
    axes.grid(visible=False)
    extent = (frame.left, frame.right, frame.bottom, frame.top)
    axes.imshow(pixels, extent=extent, aspect="auto", interpolation="none")
    axes.set(xlim=extent[:2], ylim=extent[2:])
    _lengths(axes, picture, frame, frame.width / place[2])
    return axes


def _lengths(axes: Axes, picture: Picture, frame: Frame, point: float) -> None:
    """Measured lengths: across the axis between two lines along it, along the axis from the surface."""
    middle = picture.middle
    for length in picture.across:
        half = 0.5 * length.value
        # Of a hole below it, where nothing stands; else at the surface, where it is measured.
        at = frame.bottom - 8.0 * point if length.quantity == "hole_diameter" else 0.0
        for side in (-half, half):
            line(axes, "thin", (middle + side,) * 2, (frame.top + point, frame.bottom - point))
        arrow(axes, "measured", (middle - half, middle + half), (at, at))
        write(axes, "measured", middle, at - LABEL_AT * point, _millimetres(length.value), "center")
    for length in picture.along:
        end = picture.sign * length.value
        line(axes, "thin", (middle - 18.0 * point, middle + 18.0 * point), (end, end))
        arrow(axes, "measured", (middle, middle), (0.0, end))
        write(axes, "measured", middle + LABEL_AT * point, 0.5 * end, _millimetres(length.value), "left")


def _bar(axes: Axes, picture: Picture, extent: tuple[float, float, float, float], shades: np.ndarray) -> None:
    """The colours of a field between its limits, in the units that people read."""
    axes.grid(visible=False)
    axes.imshow(shades, cmap=colours(picture.field), extent=extent, aspect="auto", interpolation="none")
    axes.yaxis.set_major_formatter(lambda at, _: number(at * picture.factor))
    axes.spines[:].set_visible(False)


def _labelled(picture: Picture) -> str:
    """The field of a picture with its unit: "pressure (GPa)"."""
    return f"{picture.label} ({picture.unit})" if picture.unit else picture.label


def _millimetres(value: float) -> str:
    return f"{printed(value, 'length')} {display_of('m').unit}"
