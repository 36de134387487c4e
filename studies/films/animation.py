"""The film of a run as a moving picture: GIF by Pillow, or MP4 by ffmpeg: the program, or that of imageio-ffmpeg."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib import rcParams
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from xarray import Dataset

from studies.films.film_dataset import open_film
from studies.films.film_section import sections_of
from studies.quantities.display import display_of, elapsed
from studies.quantities.files import FILM, write_atomically
from studies.quantities.findings import MissingExtra, nearest_cure, refusal
from studies.reports.drawing.canvas import drawn_in_style
from studies.reports.drawing.pixels import coloured, nearest
from studies.reports.drawing.sections import FULL, LEFT, RIGHT, SHARP, full_size
from studies.reports.picture import Frame, Picture
from studies.sections.section import Sections

SPEED = "speed"  # the field that is shown where none is named
FRAMES_PER_SECOND = 10
WRITERS: dict[str, type[PillowWriter | FFMpegWriter]] = {".gif": PillowWriter, ".mp4": FFMpegWriter}
TITLE, GAP = 22.0, 4.0  # points: above a frame, and above the title
DPI = 144  # two pixels in a point
# Per cent of the particles, over all frames, that the picture and the colours leave out at each end: single fragments
# that fly far ahead or are far hotter than all others.
LEFT_OUT = 0.5


def animate(film: Dataset, file: Path, field: str = SPEED, frames_per_second: int = FRAMES_PER_SECOND) -> Path:
    """Write a film into a file, whose ending is its format; colours and axes are the same in all frames.

    Raises InvalidInput for another ending and an unknown field, MissingExtra for an MP4 without ffmpeg.
    """
    writer_of = WRITERS.get(file.suffix.lower())
    if writer_of is None:
        raise refusal("--movie", str(file), " or ".join(WRITERS), "name a file with one of these endings")
    if writer_of is FFMpegWriter:
        _find_ffmpeg()
    fields = [str(name) for name in film if name != "position"]
    if field not in fields:
        raise refusal("--field", field, "a number of the film", nearest_cure(field, fields))
    writer = writer_of(fps=frames_per_second)

    def fill(part: Path) -> None:
        made = part.with_suffix(file.suffix)  # both writers choose the format by it
        try:
            _write(film, field, writer, made)
            made.replace(part)
        finally:
            made.unlink(missing_ok=True)

    return write_atomically(file, fill)


def _find_ffmpeg() -> None:
    """Let Matplotlib find the program, which the extra ``video`` brings; raises MissingExtra."""
    if FFMpegWriter.isAvailable():
        return
    try:
        from imageio_ffmpeg import get_ffmpeg_exe
    except ImportError as error:
        cure = "pip install 'whipple[video]', or install ffmpeg; a GIF needs neither"
        raise MissingExtra(f"an MP4 needs more ({error}): {cure}") from None
    rcParams["animation.ffmpeg_path"] = get_ffmpeg_exe()


def _write(film: Dataset, field: str, writer: AbstractMovieWriter, file: Path) -> None:
    sections = sections_of(film)
    frame = _frame(sections)
    display, label = display_of(film[field].attrs["units"]), film[field].attrs["long_name"]
    values = np.concatenate([state.fields[field] for state in sections.states])
    low, high = (float(end) for end in np.nanpercentile(values, (LEFT_OUT, 100.0 - LEFT_OUT)))
    limits = low, max(high, low + 1e-12)
    picture = Picture("film", field=field, label=label, unit=display.unit, factor=display.factor, limits=limits)
    columns = 2 * round(0.5 * SHARP * (FULL - LEFT - RIGHT))
    with drawn_in_style():
        drawing = full_size(picture, frame, np.zeros((1, 1, 4), np.uint8), above=TITLE)
        drawing.set_facecolor("white")
        image = drawing.axes[0].images[0]
        title = drawing.text(LEFT / FULL, 1.0 - GAP / (72.0 * drawing.get_figheight()), "", va="top", weight="bold")
        with writer.saving(drawing, str(file), DPI):
            for state in sections.states:
                pixels = nearest(sections, state, frame, columns)
                image.set_data(coloured(pixels, state.fields[field], limits, field))
                title.set_text(elapsed(state.time))
                writer.grab_frame()


def _frame(sections: Sections) -> Frame:
    """The part of the sections with all particles of the first frame and nearly all of the others."""
    every, first = np.concatenate([state.position for state in sections.states]), sections.states[0].position
    corners = [*np.percentile(every, (LEFT_OUT, 100.0 - LEFT_OUT), axis=0), first.min(axis=0), first.max(axis=0)]
    margin = float(sections.spacing.max())
    left, top = (float(value) - margin for value in np.min(corners, axis=0))
    right, bottom = (float(value) + margin for value in np.max(corners, axis=0))
    return Frame(-right if sections.mirrored else left, right, top, bottom)


def film_in(folder: Path, run: str, field: str) -> bytes:
    """The film of a run of a sweep's folder as a GIF: of the first one whose id begins so. Raises InvalidInput."""
    films = sorted(folder.glob(f"runs/{run}*/{FILM}"))
    if not films:
        raise refusal("run", run, "a run with a film", "compute the sweep with keep: film")
    with TemporaryDirectory() as place:
        return animate(open_film(films[0]), Path(place) / "film.gif", field).read_bytes()
