"""Pictures of runs and of their set-up: which runs a report shows, and what each picture says.

:func:`part_of` makes their part of the report's document: frames, colour limits, measured lengths and texts, so
that ``studies.reports.drawing.sections`` has nothing left to decide. Pictures of a kind share their scale and their
colours, so that runs compare.
"""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
import xarray as xr

from studies import scenarios
from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.points import axes_of, by_run, places_of, plain, refinements_of, simulated_values
from studies.cubes.variable import variable_name
from studies.pictures.section import DrawnSetUp, PicturedRun, Pictures
from studies.quantities.display import MESH_UNKNOWN, digits, display_of, elapsed, printed
from studies.quantities.parameters import Value, declared
from studies.quantities.units import readable
from studies.reports.picture import Frame, Length, Picture, rounded_up
from studies.reports.section import Part, Source
from studies.reports.view import spread, title_of
from studies.reports.wording import words
from studies.sections.radiograph import AREAL_DENSITY, Radiograph
from studies.sections.section import END, FIELDS, UNITS, Section, Sections, read_sections
from studies.sweeps.reading import OFFSET, RESOLUTION

# Of the densest pixel, which is in the plate seen edge on: where the colours of a radiograph end.
CLOUD = 0.03

MOST_RUNS = 30  # thumbnails; beyond, runs of the finest resolution, evenly
MOST_FULL = 4  # runs in full size
MOST_DEBRIS = 2  # states before the end

THUMBNAIL_FIELDS = {"debris": "speed", "end": "plastic_strain"}

# Measured lengths that a picture shows: across the axis, or along it from the original surface or the wall.
ACROSS = ("hole_diameter", "crater_diameter", "mushroom_diameter")
ALONG = ("crater_depth", "final_length")


# Shares of the moved matter below (and above) which colours end: single particles do not set the scale.
OUTLIERS = 0.05
STRAINED = 0.01  # plastic strain of matter that an impact has moved
STRAY = 0.004  # share of moved matter that a frame may leave out at each end
BELOW = 1.5  # lower end of a frame, in measured depths
BESIDE = 1.4  # half width of a frame, in measured radii
DEBRIS_HALF_WIDTH = 2.25  # of a frame of debris, in projectile diameters
TALLEST, FLATTEST = {"end": 0.75, "debris": 1.3}, 0.3  # of a frame, in its width
SAME_SCALE = 3.0  # ratio of the widest to the narrowest run that still share a scale


@dataclass(frozen=True)
class Shown:
    """A run that the report shows."""

    number: int  # of the run
    title: str
    sections: Sections | None
    missing: str  # why there are no sections
    lengths: Mapping[str, float]  # measured, m, by quantity
    diameter: float  # of the projectile, m; NaN where there is none
    sign: float  # -1 where the line of flight points up


def part_of(source: Source) -> Part:
    """Pictures of the runs of a cube, from the files of their sections."""
    dataset, files = source.dataset, source.files
    setup, finest, count = setup_of(dataset), _finest(dataset), dataset.run_state.size
    chosen = spread(range(count) if count <= MOST_RUNS else finest, MOST_RUNS)
    shown = [_shown(dataset, number, files, setup.outline.upward if setup else 1.0) for number in chosen]
    kept = [run for run in shown if run.sections]
    full = [run.number for run in spread([run for run in kept if run.number in finest], MOST_FULL)]
    frames = {kind: _frames(kept, kind) for kind in ("end", "debris")}
    limits = {kind: _limits(kept, kind) for kind in ("end", "debris")}
    runs = tuple(
        PicturedRun(
            run=run.number,
            title=run.title,
            missing=run.missing or None,
            full=run.number in full,
            finest=run.number in finest,
            pictures=tuple(_pictures(run, frames, limits, full=run.number in full)),
        )
        for run in shown
    )
    return Part(Pictures(setup, runs, count - len(runs)))


def picture_of_end(sections: Sections, lengths: Mapping[str, float], *, diameter: float, sign: float) -> Picture | None:
    """The picture of the end of a run alone, with what it measured (m, by quantity); None of a run without an end.

    ``diameter`` of the projectile (m), NaN where there is none; ``sign`` is -1 where the line of flight points up.
    """
    shown = {name: value for name, value in lengths.items() if name in (*ACROSS, *ALONG) and math.isfinite(value)}
    run, end = Shown(0, "", sections, "", shown, diameter, sign), sections.at(END)
    if end is None:
        return None
    field = THUMBNAIL_FIELDS["end"]
    return _picture(run, end, "end", field, _frames([run], "end")[0], _limits([run], "end")[field])


def first_of_kinds(pictures: Pictures) -> list[Picture]:
    """The first thumbnail of each kind, end before debris; colours are the same in all."""
    shown = [picture for run in pictures.runs for picture in run.pictures if not picture.missing]
    thumbnails = [picture for picture in shown if picture.field == THUMBNAIL_FIELDS[picture.kind]]
    firsts = {picture.kind: picture for picture in reversed(thumbnails)}
    return [firsts[kind] for kind in ("end", "debris") if kind in firsts]


# ---- which runs ----------------------------------------------------------------------------------


def _finest(dataset: xr.Dataset) -> list[int]:
    """Numbers of the runs of the finest resolution, without offset."""
    numbers = dataset.run_state.copy(data=np.arange(dataset.run_state.size).reshape(dataset.run_state.shape))
    refined = refinements_of(dataset)
    last = {name: place for name, place in ((RESOLUTION, -1), (OFFSET, 0)) if name in refined}
    return [int(number) for number in numbers.isel(last).values.ravel()]


def _shown(dataset: xr.Dataset, number: int, files: Mapping[str, Path], sign: float) -> Shown:
    place = places_of(dataset)[number]
    sections, missing = _sections(dataset, number, files)
    values = {
        name: float(simulated_values(dataset, name).ravel()[number])
        for name in (*ACROSS, *ALONG)
        if name in reading.quantities_of(dataset)
    }
    diameter = cubes.EQUIVALENT_DIAMETER.name
    return Shown(
        number=number,
        title=title_of(dataset, place) if axes_of(dataset) else "",
        sections=sections,
        missing=missing,
        lengths={name: value for name, value in values.items() if math.isfinite(value)},
        diameter=float(by_run(dataset, diameter)[number]) if diameter in dataset else math.nan,
        sign=sign,
    )


def _sections(dataset: xr.Dataset, number: int, files: Mapping[str, Path]) -> tuple[Sections | None, str]:
    """The stored sections of a run, or the reason why there are none."""
    state = cubes.STATES[int(dataset.run_state.values.ravel()[number])]
    if state != "succeeded":
        return None, f"no picture: the run is {state}"
    file = files.get(str(cubes.RUN_ID.of(dataset).values.ravel()[number]))
    if file is None:
        return None, "no picture: no section was kept with this run"
    try:
        return read_sections(file), ""
    except (OSError, EOFError, KeyError, ValueError, BadZipFile) as error:
        return None, f"no picture: the file of its sections cannot be read ({type(error).__name__})"


# ---- what a picture says -------------------------------------------------------------------------


def _pictures(
    run: Shown,
    frames: Mapping[str, Mapping[int, Frame]],
    limits: Mapping[str, Mapping[str, tuple[float, float]]],
    *,
    full: bool,
) -> Iterator[Picture]:
    """The pictures of a run: debris in the order of time, then the end, in all fields where it is shown in full."""
    if run.sections is None:
        return
    for moment, asked in [*enumerate(run.sections.moments[:MOST_DEBRIS]), (END, math.nan)]:
        kind = "end" if moment == END else "debris"
        section = run.sections.at(moment)
        if section is None:
            end = run.sections.at(END)
            why = f"the state at {elapsed(asked)} was not kept when the run was resumed"
            if end and end.time < asked:
                why = f"the run ended before {elapsed(asked)}"
            yield Picture(kind, f"no picture: {why}")
            continue
        for field in FIELDS if full and kind == "end" else (THUMBNAIL_FIELDS[kind],):
            yield _picture(run, section, kind, field, frames[kind][run.number], limits[kind][field])
    if full and run.sections.radiograph and (end := run.sections.at(END)):
        frame = _frame_of_radiograph(run.sections.radiograph, run.sign)
        densest = float(run.sections.radiograph.density.max())
        yield _picture(run, end, "end", AREAL_DENSITY, frame, (0.0, rounded_up(CLOUD * densest)))


def _frame_of_radiograph(taken: Radiograph, sign: float) -> Frame:
    """The pixels that show matter."""
    rows, columns = (np.flatnonzero((taken.density > 0.0).any(axis=axis)) for axis in (1, 0))
    half = (columns[-1] + 1) * taken.pixel
    ends = [sign * (taken.origin + row * taken.pixel) for row in (rows[0], rows[-1] + 1)]
    return Frame(-half, half, min(ends), max(ends))


def _picture(run: Shown, section: Section, kind: str, field: str, frame: Frame, limits: tuple[float, float]) -> Picture:
    lengths = run.lengths if kind == "end" else {}
    display, label = display_of(UNITS[field]), words(field)
    low, high = (digits(float(f"{limit * display.factor:.6g}")) for limit in limits)
    measured = "; ".join(
        f"{words(name)} {printed(value, 'length')} {display_of('m').unit}" for name, value in lengths.items()
    )
    scene = "Section at the end" if kind == "end" else "Section of the debris"
    if field == AREAL_DENSITY:
        scene = "Radiograph of the end, seen from the side"
    where = f", {run.title}" if run.title else ""
    alt = (
        f"{scene} ({elapsed(section.time)}){where}, coloured by {label} from {low} to {high} {display.unit}".rstrip()
        + (f"; {measured} (one grid: {MESH_UNKNOWN})" if measured else "")
    )
    return Picture(
        kind=kind,
        moment=section.moment,
        time=section.time,
        field=field,
        label=label,
        unit=display.unit,
        factor=display.factor,
        limits=limits,
        frame=frame,
        middle=_middle(run),
        across=tuple(Length(name, words(name), lengths[name]) for name in ACROSS if name in lengths),
        along=tuple(Length(name, words(name), lengths[name]) for name in ALONG if name in lengths),
        alt=f"{alt}.",
        sign=run.sign,
    )


def _middle(run: Shown) -> float:
    """The middle of what is measured across at the end (m): of the widest gap in the last body, or the axis."""
    end = run.sections.at(END) if run.sections else None
    if run.sections is None or run.sections.mirrored or end is None:
        return 0.0
    across = np.sort(end.position[end.body == len(run.sections.bodies) - 1, 0])
    if across.size < 2:
        return 0.0
    widest = int(np.argmax(np.diff(across)))
    return float(0.5 * (across[widest] + across[widest + 1]))


# ---- frames and colours --------------------------------------------------------------------------


def _frames(runs: Sequence[Shown], kind: str) -> dict[int, Frame]:
    """The frame of each run for a kind of picture: one for all, unless their sizes differ too much."""
    frames = {run.number: frame for run in runs if (frame := _frame(run, kind))}
    widths = [frame.width for frame in frames.values()]
    if not frames or max(widths) > SAME_SCALE * min(widths):
        return frames
    same = Frame(
        left=min(frame.left for frame in frames.values()),
        right=max(frame.right for frame in frames.values()),
        top=min(frame.top for frame in frames.values()),
        bottom=max(frame.bottom for frame in frames.values()),
    )
    return dict.fromkeys(frames, same)


def _frame(run: Shown, kind: str) -> Frame | None:
    """The part of a run's sections that pictures of a kind show."""
    assert run.sections
    sign, every = run.sign, run.sections.states
    states = [state for state in every if (state.moment == END) == (kind == "end") and len(state.position)]
    if not states:
        return None
    middle = _middle(run) if kind == "end" else 0.0
    across = np.concatenate([np.abs(state.position[:, 0] - middle) for state in states])
    along = sign * np.concatenate([state.position[:, 1] for state in states])
    strained = np.concatenate([state.fields["plastic_strain"] for state in states]) > STRAINED
    half = 1.05 * float(across.max())
    if kind == "debris" and math.isfinite(run.diameter):
        half = min(half, DEBRIS_HALF_WIDTH * run.diameter)
    elif radii := [0.5 * run.lengths[name] for name in ACROSS if name in run.lengths]:
        half = min(half, BESIDE * max(radii))
    moved = along[(across < half) & strained]
    if not moved.size:
        moved = along[across < half]
    ends = [float(at) for at in np.quantile(moved, [STRAY, 1.0 - STRAY])]
    lengths = [run.lengths[name] for name in ALONG if name in run.lengths and kind == "end"]
    width, margin = 2.0 * half, 0.08 * half
    top, bottom = min(ends) - margin, max(ends) + margin
    bottom = min(bottom, BELOW * max(lengths) if lengths else top + TALLEST[kind] * width)
    # Measured lengths are whole.
    top = min([top, *(sign * length - margin for length in lengths)])
    bottom = max([bottom, *(sign * length + margin for length in lengths)])
    missing = max(0.0, FLATTEST * width - (bottom - top))
    return Frame(middle - half, middle + half, top - 0.5 * missing, bottom + 0.5 * missing)


def _limits(runs: Sequence[Shown], kind: str) -> dict[str, tuple[float, float]]:
    """The ends of the colours of each field, for all runs; at the end those of the body that was hit, not of debris."""
    shown = [
        {field: values[_coloured(run.sections, state)] for field, values in state.fields.items()}
        for run in runs
        if run.sections
        for state in run.sections.states
        if (state.moment == END) == (kind == "end")
    ]
    return {field: _limits_of(field, shown) for field in FIELDS}


def _coloured(sections: Sections, state: Section) -> np.ndarray | slice:
    """The particles of a state whose values set the colours."""
    hit = state.body == len(sections.bodies) - 1
    return hit if state.moment == END and hit.any() else slice(None)


def _limits_of(field: str, states: Sequence[Mapping[str, np.ndarray]]) -> tuple[float, float]:
    moved = [state["plastic_strain"] > STRAINED for state in states]
    values = [state[field][of] for state, of in zip(states, moved, strict=True)]
    values = values if any(of.any() for of in moved) else [state[field] for state in states]
    values = [column[np.isfinite(column)] for column in values if np.isfinite(column).any()]
    if not values:
        return (0.0, 1.0)
    lowest, low, high = (
        float(of(np.quantile(column, share) for column in values))
        for of, share in ((min, 0.0), (min, OUTLIERS), (max, 1.0 - OUTLIERS))
    )
    if field == "pressure":
        most = rounded_up(max(high, -low))
        return (-most, most)
    if field == "temperature":
        low = float(f"{lowest:.3g}")
        return (low, max(rounded_up(high), low + 1.0))
    if field == "density":
        step = rounded_up(high / 20.0)
        low = math.floor(low / step) * step
        return (low, max(math.ceil(high / step), low / step + 1.0) * step)
    return (0.0, rounded_up(high))


# ---- the set-up ------------------------------------------------------------------------------------


def setup_of(dataset: xr.Dataset) -> DrawnSetUp | None:
    """The set-up of the first run: outlines, dimensions, speed and materials; None where the scenario draws none."""
    if dataset.attrs["scenario"] not in scenarios.names():  # of a feature that is gone
        return None
    values = {name: _values_of(dataset, name) for name in json.loads(dataset.attrs["vocabulary"])["parameters"]}
    return setup(scenarios.load(dataset.attrs["scenario"]), values)


def setup(scenario: scenarios.Scenario, values: Mapping[str, Sequence[Value]]) -> DrawnSetUp | None:
    """The set-up of the first of the values (SI) of each parameter, as ``setup_of`` gives it."""
    outline = scenario.parameters.outline({name: several[0] for name, several in values.items() if several})
    if outline is None:
        return None
    units = {name: parameter.unit or "1" for name, parameter in declared(scenario.parameters).items()}
    names = dict.fromkeys([d.parameter for d in outline.dimensions])
    labels = {name: _label(units[name], values[name]) for name in (*names, "speed") if values.get(name)}
    bodies = [shape.body for shape in outline.shapes if shape.body in scenario.materials]
    materials = {
        body: ", ".join([*map(str, values[body][:3]), *(["…"] if len(values[body]) > 3 else [])])
        for body in bodies
        if values.get(body)
    }
    spoken = [f"{words(name)} {label}" for name, label in labels.items()]
    spoken += [f"{body} of {text}" for body, text in materials.items()]
    return DrawnSetUp(outline, labels, materials, f"The set-up of the first run, to scale: {'; '.join(spoken)}.")


def _values_of(dataset: xr.Dataset, parameter: str) -> list[float | str]:
    """The values of a parameter over the runs, each once, the first run's first; none where no run has it."""
    name = variable_name(parameter)
    if name not in dataset.variables:
        return []
    values = [plain(value) for value in by_run(dataset, name)]
    return [value for value in dict.fromkeys(values) if value not in ("", "nan") and value == value]


def _label(unit: str, values: Sequence[Value]) -> str:
    """A length or a speed in the unit that people read, to four digits, with its range where the sweep varies it."""
    numbers = [float(value) for value in values if value is not None]
    low, high = (readable(float(f"{end:.4g}"), unit) for end in (min(numbers), max(numbers)))
    if low == high:
        return low
    number, _, name = low.partition(" ")
    return f"{number if high.endswith(f' {name}') else low} to {high}"
