"""Views of a run from its files, for a screen: its section over time, its matter in space, its radiograph.

Each is named by what a page calls it, takes a run and one of its files, and gives ``studies.films.packed.View``.
"""

import math
from pathlib import Path

import numpy as np

from solver.grid.debris import flown
from solver.problem import Face
from solver.problem.geometry import impact_axis
from studies import scenarios
from studies.films.film_dataset import open_film
from studies.films.film_section import sections_of
from studies.films.packed import FrameOfPoints, View
from studies.quantities.display import printed_alone
from studies.quantities.files import FILM, STATE
from studies.runs.remeasure import end_of
from studies.runs.run import Run
from studies.scenarios.parts.impact import ImpactSetting
from studies.sections.radiograph import AREAL_DENSITY, PIXELS
from studies.sections.radiograph import radiograph as taken_of
from studies.sections.section import read_sections

# Points of a view in space: each body has the same share of them, so that debris is not lost beside a large plate.
MOST_POINTS = 60_000
CARRIED = ("temperature", "plastic_strain", "damage")  # what departed keeps as it was


def film(run: Run, file: Path) -> View:
    """The section of a run over time: each frame of its film, or the few states that every run keeps."""
    sections = sections_of(open_film(file)) if file.name == FILM else read_sections(file)
    sign = _downward(run)
    frames = sorted(sections.states, key=lambda state: state.time)
    return View(
        bodies=sections.bodies,
        width=tuple(sections.spacing.max(axis=1).tolist()),
        mirrored=sections.mirrored,
        frames=tuple(FrameOfPoints(s.time, s.position * (1.0, sign), s.body, s.fields) for s in frames),
        note="",
    )


def radiograph(run: Run, file: Path) -> View:
    """The areal density of all matter at the end, seen from the side; no frame for a run without one.

    It is taken of the final state of an impact, or is the one that the run took of it, in a file of sections.
    """
    if file.name == STATE:
        setting, snapshot = end_of(run, file)
        time, whole = snapshot.time, 2.0 * math.pi / setting.sector
        taken = None
        if isinstance(setting, ImpactSetting):
            taken = taken_of(setting.problem, snapshot, pixel=setting.projectile_diameter / PIXELS, whole=whole)
    else:
        sections = read_sections(file)
        time, taken = sections.states[-1].time, sections.radiograph
    if taken is None:
        note = f"This run of {run.scenario} has no radiograph; impacts that keep their final state do."
        return View((), (), mirrored=False, frames=(), note=note)
    row, column = np.nonzero(taken.density > 0.0)
    along = taken.origin + (row + 0.5) * taken.pixel
    return View(
        bodies=("all matter",),
        width=(taken.pixel,),
        mirrored=True,
        frames=(
            FrameOfPoints(
                time,
                np.stack([(column + 0.5) * taken.pixel, along * _downward(run)], axis=1),
                np.zeros(row.size, np.uint8),
                {AREAL_DENSITY: taken.density[row, column].astype(float)},
            ),
        ),
        note="Colours are logarithmic.",
    )


def cloud(run: Run, file: Path) -> View:
    """The final state in space, with what has left the grid: points of equal mass for each body.

    A body of revolution is turned about its axis, a quarter or half of a body has its mirror images.
    """
    setting, snapshot = end_of(run, file)
    problem, particles, departed = setting.problem, snapshot.particles, snapshot.departed
    position = np.concatenate([particles.position, flown(problem, departed, snapshot.time)])
    body = np.concatenate([snapshot.body, departed.body]).astype(int)
    mass = np.concatenate([particles.mass, departed.mass])
    fields = {
        "speed": np.linalg.norm(np.concatenate([particles.velocity, departed.velocity]), axis=1),
        "pressure": np.concatenate([particles.pressure, np.zeros(departed.mass.size)]),
        **{name: np.concatenate([getattr(particles, name), getattr(departed, name)]) for name in CARRIED},
    }
    names = tuple(one.name for one in problem.bodies)
    axis = impact_axis(problem.geometry)
    mirrors = [k for k in range(axis) if problem.faces[k][0] == Face.SYMMETRIC] if axis == 2 else []
    random = np.random.default_rng(0)
    chosen: list[np.ndarray] = []
    notes = []
    for number, name in enumerate(names):
        mine = np.flatnonzero(body == number)
        if not mine.size:
            continue
        most = MOST_POINTS // len(names)
        count = most if axis == 1 else min(most, mine.size * 2 ** len(mirrors))
        share = np.cumsum(mass[mine])
        chosen.append(mine[np.searchsorted(share, (np.arange(count) + 0.5) / count * share[-1])])
        whole = 2.0 * math.pi / setting.sector * float(share[-1]) / count
        notes.append(f"a point of {name} is {printed_alone(whole * 1e6, '1')} mg ({mine.size} particles were computed)")
    shown = np.concatenate(chosen)
    place = position[shown]
    if axis == 1:
        angle = random.random(shown.size) * 2.0 * math.pi
        place = np.stack([place[:, 0] * np.cos(angle), place[:, 0] * np.sin(angle), place[:, 1]], axis=1)
    for k in mirrors:
        place[:, k] *= random.choice((-1.0, 1.0), shown.size)
    place[:, 2] *= _downward(run)
    return View(
        bodies=names,
        width=(0.0,) * len(names),
        mirrored=False,
        frames=(
            FrameOfPoints(snapshot.time, place, body[shown], {name: values[shown] for name, values in fields.items()}),
        ),
        note=f"Points have the same mass: {', '.join(notes)}.",
    )


def _downward(run: Run) -> float:
    """-1 where a body flies against the coordinate along the line of flight, so that it flies down on the screen."""
    outline = scenarios.load(run.scenario).parameters.outline(run.parameters)
    return outline.upward if outline else 1.0
