"""docs/plugging.png: a plug at 285.4 m/s by material points, and by smoothed particles coupled to elements.

``python -m docs.plugging`` computes both anew at 1 mm, at moments of Fig. 6 of Zhang, Qiang and Gao (2011),
in some minutes of one core.
"""

from pathlib import Path
from typing import Any

from solver.simulation import simulate
from studies.films.section import SectionOptions, SectionRecorder, Sections
from studies.reports.drawing.pixels import coloured, nearest
from studies.reports.sections.pictures import Frame
from studies.runs.execution import observer_of
from studies.runs.run import resolve
from tests.cases.test_plugging import DIAMETER, SPACING, SPEED

FILE = Path(__file__).parent / "plugging.png"
MOMENTS = (7e-6, 30e-6, 60e-6, 120e-6)  # s: contact, the plate bulges, the plug moves, and is out
METHODS: dict[str, dict[str, Any]] = {
    "material points, body of revolution": {},
    "smoothed particles and elements": {"method": "sph-fem", "geometry": "quarter"},
}
FRAME = Frame(-0.032, 0.032, -0.03, 0.042)  # m
STRAINS = (0.0, 1.0)  # ends of the colours
WIDTH, GAP, HEAD = 240, 10, 18  # px of a panel, between panels, and of a line of text


def sections(parameters: dict[str, Any]) -> Sections:
    """The sections of the shot at the moments, by the method of some parameters."""
    shot = {"speed": SPEED, "cells_per_diameter": DIAMETER / SPACING, **parameters}
    setting = observer_of(resolve("plugging", shot)).setting
    end = MOMENTS[-1]
    interval = 0.01 * end
    options = SectionOptions(moments=MOMENTS, reach=4.0 * DIAMETER)
    recorder = SectionRecorder(setting.problem, options, interval)

    def watch(snapshot: Any) -> str | None:
        recorder.add(snapshot)
        return "end" if snapshot.time >= end else None

    simulate(setting.problem, watch, interval=interval)
    return Sections(
        bodies=tuple(body.name for body in setting.problem.bodies),
        spacing=recorder.spacing,
        mirrored=True,
        moments=MOMENTS,
        states=tuple(recorder.states),
    )


def write(columns: dict[str, Sections]) -> None:
    """Write the picture: a column for each method, a row for each moment, flight downwards, plastic strain 0 to 1."""
    from PIL import Image, ImageDraw

    height = round(WIDTH * FRAME.height / FRAME.width)
    step = height + HEAD + GAP
    size = ((WIDTH + GAP) * len(MOMENTS) - GAP, (step + HEAD) * len(columns) - GAP)
    sheet = Image.new("RGBA", size, "white")
    text = ImageDraw.Draw(sheet)
    for row, (title, stored) in enumerate(columns.items()):
        top = row * (step + HEAD)
        text.text((0, top), f"{title}, {SPACING * 1e3:g} mm", fill="black")
        for column, moment in enumerate(MOMENTS):
            left = column * (WIDTH + GAP)
            text.text((left, top + HEAD), f"{moment * 1e6:g} us", fill="black")
            state = stored.at(column)
            if state is None:
                continue
            shown = nearest(stored, state, FRAME, WIDTH)
            panel = coloured(shown, state.fields["plastic_strain"], STRAINS, "plastic_strain")
            sheet.alpha_composite(Image.fromarray(panel), (left, top + 2 * HEAD))
    sheet.convert("RGB").quantize(96).save(FILE, optimize=True)


if __name__ == "__main__":
    write({title: sections(parameters) for title, parameters in METHODS.items()})
