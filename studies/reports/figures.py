"""Content of the figures of a report: points, lines and bands in SI, from the cube alone.

Its records are those of :mod:`studies.reports.figure`.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.points import Refined, axes_of, by_run, is_same, main_quantities, places_of, refined, refinements_of
from studies.cubes.variable import SYMBOLS
from studies.reports.compare import Comparison
from studies.reports.evidence import Evidence
from studies.reports.figure import (
    ERROR_BAR,
    EXTRAPOLATED,
    LEVEL,
    MEAN,
    MISSING,
    OBSERVED,
    RUN,
    SIMULATION,
    TREND,
    Figure,
    Numbers,
    Panel,
    Scale,
    Series,
    is_cut,
    numbers,
)
from studies.reports.judgement import full_title, nearest, short_names
from studies.reports.records import Judgement, MatchedObservation, MeasuredShot, Where
from studies.reports.view import (
    MOST_PANELS,
    PREFERRED,
    FigureView,
    Slice,
    groups_of,
    second_axis,
    spread,
    title_of,
    told,
    view_of,
    views_of,
)
from studies.reports.wording import in_words, text_template, words
from studies.sweeps.reading import RESOLUTION

NEAREST = 2  # laws in colour
NEAR = 0.05  # relative: an observed shot belongs to the panel whose other axes it meets this closely
WINDOW = "settled_window"  # the parameter: time over which growth is judged
MOST_HISTORIES = 8  # lines in one panel
MOST_MAPS = 6  # panels of a map
TREND_POINTS = 24  # points of the curve through the three finest resolutions
# A history has dipped where it is below this share of an earlier value. Copper, 8 mm on 2 mm, 2 km/s, 32 cells: the
# plug, 18 mm behind the plate, is off at 14 us and on at 15 us.
DIP = 0.5


def figures(comparison: Comparison, names: Sequence[str]) -> tuple[Figure, ...]:
    """Figures of some quantities of a cube, the one that the headline is about first; SI."""
    points = comparison.points
    views = views_of(points)
    view = views[0]
    if (other := second_axis(view)) is not None:
        drawn = [figure for name in names for figure in _maps(view, other, name, comparison)]
    else:
        drawn = [against_laws(view, name, comparison) for name in names for view in views]
        # Lengths in diameters, behind a switch.
        drawn += [in_diameters(view, name, comparison) for name in names if view.is_length(name)]
    return tuple(_with_cut_bars(figure) for figure in drawn if any(panel.series for panel in figure.panels))


def of_runs(cube: xr.Dataset, comparison: Comparison) -> tuple[Figure, ...]:
    """Figures of the appendix: growth during the runs, and values against the size of a cell."""
    view, names = view_of(comparison.points), main_quantities(comparison.points)
    drawn = [growth(view, name) for name in names if cubes.HISTORY.is_in(view.dataset, name)]
    drawn += [convergence(cube, view, name) for name in names if RESOLUTION in refinements_of(cube)]
    return tuple(replace(figure, where="appendix") for figure in drawn if any(panel.series for panel in figure.panels))


def _with_cut_bars(figure: Figure) -> Figure:
    """With a sentence on the bars that the frame cuts."""
    bars = sum(
        value is not None and is_cut(value, bar)
        for panel in figure.panels
        for series in panel.series
        for value, bar in zip(series.y, series.outer or series.uncertainty, strict=False)
    )
    return replace(figure, caption=f"{figure.caption} {_caption('cut', bars=bars)}".rstrip())


def _caption(name: str, **told: int) -> str:
    """The caption of a figure by its template: what points, bars and lines are."""
    return in_words(text_template(f"captions/{name}.txt"), **told)


# ---- points, laws and measured shots -------------------------------------------------------------


def against_laws(view: FigureView, name: str, comparison: Comparison) -> Figure:
    """Simulation, laws and measured shots over the abscissa, a panel for each other value."""
    alone = _alone(comparison, name)
    near = list(dict.fromkeys([*alone, *(law.law for law in _nearest(comparison, name))]))[:NEAREST]
    panels = tuple(
        Panel(
            piece.title,
            piece.at,
            (
                *_laws(view, name, piece, near),
                *simulation(view, name, piece),
                *_missing(view, name, piece),
                *_measured(view, name, piece, comparison),
            ),
        )
        for piece in view.slices
    )
    kinds = {series.kind for panel in panels for series in panel.series}
    valued = np.isfinite(view.succeeded(name))
    over = "" if view.abscissa.name == PREFERRED else f"_over_{view.abscissa.name}"
    return Figure(
        name=f"{name}_laws{over}",
        title=f"{words(name).capitalize()} against {view.abscissa.label}",
        caption=_caption(
            "laws",
            points=int(valued.sum()),
            unknown=int((valued & np.isnan(view.error_bars(name))).sum()),
            has_laws="law" in kinds,
            is_alone=bool(alone),
            has_gaps="missing" in kinds,
            left_out=view.left_out,
        ),
        x=view.abscissa,
        y=view.scale_of(name),
        panels=panels,
    )


def _alone(comparison: Comparison, name: str) -> list[str]:
    """The label of the only law that gives what was measured; none where several do, or no shot was measured."""
    reaching = {
        law.law
        for shot in comparison.shots
        if shot.quantity == name
        for law in _nearest(comparison, name)
        for at in law.points
        if at.at == shot.point and at.law is not None and shot.ends[0] <= at.law <= shot.ends[1]
    }
    return [*reaching] if len(reaching) == 1 else []


def _nearest(comparison: Comparison, name: str) -> list[Judgement]:
    """The laws of a quantity, nearest to the simulation first."""
    return nearest([law for law in comparison.judgements if law.quantity == name], "simulation")


def in_diameters(view: FigureView, name: str, comparison: Comparison) -> Figure:
    """The same over the diameter of the projectile."""
    drawn = against_laws(replace(view, in_diameters=True), name, comparison)
    symbol = f", {SYMBOLS[name]}" if name in SYMBOLS else ""
    title = f"{words(name).capitalize()}{symbol} against {view.abscissa.label}"
    return replace(drawn, name=f"{drawn.name}_ratio", title=title, where="ratio")


def growth(view: FigureView, name: str) -> Figure:
    """The quantity during the runs: whether they were stopped too early."""
    values = view.flat(cubes.HISTORY, name)
    times = view.flat(cubes.HISTORY_TIME)
    panels = [
        Panel(
            piece.title,
            piece.at,
            # A run without a history too, so that labels keep their order.
            tuple(
                Series(
                    "history",
                    told(view.x[cell], view.abscissa.unit),
                    numbers(times[cell]),
                    numbers(values[cell]),
                    window=_window(view, cell, times[cell]),
                )
                for cell in spread(piece.cells.tolist(), MOST_HISTORIES)
            ),
        )
        for piece in view.slices
    ]
    return Figure(
        name=f"{name}_growth",
        title=f"Growth of {words(name)} during the runs",
        caption=_caption(
            "growth", refined=bool(view.refinements), dips=name.startswith("hole_diameter") and any(map(_dips, values))
        ),
        x=Scale("time", "time", "s"),
        y=view.scale_of(name),
        panels=tuple(panels),
    )


def _dips(history: np.ndarray) -> bool:
    """Whether a history falls below a share of a value before it."""
    known = history[np.isfinite(history)]
    return bool((known < DIP * np.maximum.accumulate(known)).any())


def _window(view: FigureView, cell: int, times: np.ndarray) -> Numbers:
    """The time (s) in which growth of a run is judged: begin and end; none where the cube states none."""
    known = times[np.isfinite(times)]
    length = float(by_run(view.dataset, WINDOW)[cell]) if WINDOW in view.dataset else math.nan
    if not known.size or math.isnan(length):
        return ()
    end = float(known.max())
    return max(0.0, end - length), end


def simulation(view: FigureView, name: str, piece: Slice) -> Iterator[Series]:
    """The points of a panel with their error bars; none where no run has a value."""
    values = view.succeeded(name)[piece.cells]
    if np.isfinite(values).any():
        norm, doubts = view.norm(name)[piece.cells], view.doubts(name)
        bars = view.error_bars(name)[piece.cells]
        outer = np.where(np.isfinite(bars), Evidence(view.dataset, name).bars()[piece.cells], np.nan)
        yield Series(
            "simulation",
            SIMULATION,
            view.xs(piece),
            numbers(values / norm),
            uncertainty=numbers(bars / norm),
            outer=numbers(outer / norm),
            flagged=tuple(view.is_open(name)[piece.cells].tolist()),
            doubts=tuple(doubts[cell] for cell in piece.cells),
            connected=piece.connected,
        )


def _missing(view: FigureView, name: str, piece: Slice) -> Iterator[Series]:
    """Marks for runs without a number, which tells them from points that were never computed."""
    values = view.succeeded(name)
    cells = [cell for cell in piece.cells if not np.isfinite(values[cell])]
    if cells:
        states, reasons = view.flat(cubes.RUN_STATE), view.flat(cubes.RUN_REASON)
        flags = reading.flag_words(cubes.FLAGS.of(view.dataset, name))
        notes = (f"{cubes.STATES[states[cell]]} {reasons[cell]} {' '.join(flags[cell])}".strip() for cell in cells)
        x = tuple(view.x[cell] for cell in cells)
        yield Series("missing", MISSING, x, notes=tuple(notes), connected=False)


def _laws(view: FigureView, name: str, piece: Slice, near: Sequence[str]) -> Iterator[Series]:
    """A line for each law with each of its variants, the nearest last and in colour."""
    if not cubes.LAW_LABEL.is_in(view.dataset, name):
        return
    norm = view.norm(name)[piece.cells]
    answers = view.flat(cubes.BY_LAW, name)[piece.cells]
    inside = view.flat(cubes.BY_LAW_IN_RANGE, name)[piece.cells] == 1
    labels, titles = (
        variable.of(view.dataset, name).values.astype(str) for variable in (cubes.LAW_LABEL, cubes.LAW_TITLE)
    )
    names = short_names({label: full_title(label, title) for label, title in zip(labels, titles, strict=True)})
    for column in sorted(range(len(labels)), key=lambda place: labels[place] in near):
        values = answers[:, column] / norm
        if np.isfinite(values).any():
            label = str(labels[column])
            is_near = label in near
            yield Series(
                "law",
                names[label],
                view.xs(piece),
                numbers(values),
                in_range=tuple(inside[:, column].tolist()),
                muted=not is_near,
                connected=piece.connected,
            )


def _measured(view: FigureView, name: str, piece: Slice, comparison: Comparison) -> Iterator[Series]:
    """The measured shots of a panel: those that a point repeats, and others of the sweep that meet its other axes."""
    shots: dict[tuple[float | str | None, ...], tuple[float | str, MeasuredShot | MatchedObservation]] = {}
    for shot in comparison.shots:
        if shot.quantity == name and all(shot.point[axis] == value for axis, value in piece.at.items()):
            x = shot.at.get(view.abscissa.name, shot.point[view.abscissa.name])
            shots[x, shot.value, shot.lower, shot.upper] = x, shot
    for seen in comparison.observations:
        near = (axis in seen.at and is_same(seen.at[axis], value, NEAR) for axis, value in piece.at.items())
        is_here = seen.quantity == name and seen.where is not Where.ELSEWHERE and view.abscissa.name in seen.at
        if is_here and all(near):
            x = seen.at[view.abscissa.name]
            shots.setdefault((x, seen.value, seen.lower, seen.upper), (x, seen))
    if not shots:
        return
    mine = [(x, shot, _norm_of(view, name, shot)) for x, shot in shots.values()]
    yield Series(
        "observation",
        OBSERVED,
        tuple(x for x, _, _ in mine),
        tuple(None if shot.value is None else shot.value / norm for _, shot, norm in mine),
        uncertainty=tuple(None if shot.uncertainty is None else shot.uncertainty / norm for _, shot, norm in mine),
        low=tuple(None if shot.lower is None else shot.lower / norm for _, shot, norm in mine),
        high=tuple(None if shot.upper is None else shot.upper / norm for _, shot, norm in mine),
        notes=tuple(shot.source for _, shot, _ in mine),
        connected=False,
    )


def _norm_of(view: FigureView, name: str, shot: MeasuredShot | MatchedObservation) -> float:
    """The diameter by which lengths of a shot are shown, or 1: its own, or that of the sweep."""
    if not view.normed(name):
        return 1.0
    own = shot.diameter if isinstance(shot, MatchedObservation) else shot.at.get("projectile_diameter")
    return float(own) if own else float(view.diameter[0])


# ---- maps -----------------------------------------------------------------------------------------


def _maps(view: FigureView, other: Scale, name: str, comparison: Comparison) -> Iterator[Figure]:
    """A quantity over two axes, and by how much the nearest laws differ from it."""
    over = f"over {view.abscissa.label} and {other.label}"
    pieces = list(_pieces(view, other.name))
    values = view.succeeded(name)
    panels = [_map(view, other, title, cells, values) for title, cells in spread(pieces, MOST_MAPS)]
    left_out = len(pieces) - len(panels)
    caption = f"Colours say {words(name)}; a run without a value has none." + (
        f" {left_out} further combinations of the other axes are in the cube." if left_out else ""
    )
    title = f"{words(name).capitalize()} {over}"
    x, y = view.abscissa, other
    yield Figure(f"{name}_map", title, caption, x, y, tuple(panels), z=view.scale_of(name))
    near = _nearest(comparison, name)[:NEAREST]
    title, cells = pieces[0]
    laws = []
    for law in near:
        differences = np.array([math.nan if at.difference is None else at.difference for at in law.points])
        laws.append(_map(view, other, law.name, cells, differences))
    if any(panel.series for panel in laws):
        yield Figure(
            f"{name}_laws_map",
            f"Law minus simulation, relative: {words(name)} {over}",
            "Red: the law gives more than the simulation; blue: less. Answers outside of the range of a law too."
            + (f" At {title}." if title else ""),
            x,
            y,
            tuple(laws),
            z=Scale("residual", "(law − simulation) / simulation", "1"),
        )


def _map(view: FigureView, other: Scale, title: str, cells: np.ndarray, values: np.ndarray) -> Panel:
    """A panel of some points, with values of all points or of these."""
    mine = values if len(values) == len(cells) else values[cells]
    if not np.isfinite(mine).any():
        return Panel(title, {}, ())
    y = by_run(view.dataset, other.name)[cells]
    x = tuple(view.x[cell] for cell in cells)
    return Panel(title, {}, (Series("map", title, x, numbers(y), z=numbers(mine), connected=False),))


def _pieces(view: FigureView, other: str) -> Iterator[tuple[str, np.ndarray]]:
    """The points that share every axis but two, with a title; all of a list, whose points share hardly any."""
    others = [axis for axis in axes_of(view.dataset) if axis not in (view.abscissa.name, other)]
    if "run" in view.dataset.dims or not others:
        yield "", np.arange(len(view.x))
        return
    for key, cells in groups_of(places_of(view.dataset), others).items():
        yield title_of(view.dataset, dict(zip(others, key, strict=True))), np.array(cells)


# ---- convergence ---------------------------------------------------------------------------------


def convergence(cube: xr.Dataset, view: FigureView, name: str) -> Figure:
    """A quantity against the size of a cell, one panel a point."""
    valued = [point for point in refined(cube, name) if math.isfinite(point.converged.value)]
    shown = spread(valued, MOST_PANELS)
    places = places_of(view.dataset)
    return Figure(
        name=f"{name}_convergence",
        title=f"{words(name).capitalize()} against the size of a cell",
        caption=_caption(
            "convergence",
            offsets=any(_several_offsets(point) for point in shown[:1]),
            extrapolated=any(map(_is_converging, shown)),
            left_out=len(valued) > len(shown),
        ),
        x=Scale("spacing", "cell size / projectile diameter", "1"),
        y=view.scale_of(name),
        panels=tuple(
            Panel(
                title_of(view.dataset, places[point.number]),
                places[point.number],
                tuple(_of_point(point)),
                # With the order where there is one: "converging, order 1.3".
                f"{point.converged.verdict}{f', order {point.converged.order:.2g}' if _is_converging(point) else ''}",
            )
            for point in shown
        ),
        scales="own",
    )


def _is_converging(point: Refined) -> bool:
    return point.converged.verdict == "converging"


def _several_offsets(point: Refined) -> bool:
    return len(point.values) > len(point.converged.levels)


def _of_point(point: Refined) -> Iterator[Series]:
    converged = point.converged
    levels = [level for level in reversed(converged.levels) if level.values]
    if math.isfinite(converged.uncertainty):
        # From nothing to the coarsest resolution.
        low, high = (converged.value + sign * converged.uncertainty for sign in (-1.0, 1.0))
        coarsest = max(level.spacing for level in converged.levels)
        yield Series("band", ERROR_BAR, (0.0, coarsest), low=(low,) * 2, high=(high,) * 2, in_range=(True,) * 2)
    if _is_converging(point):
        # f(0) + C h^p from nothing to the third finest resolution, through the two finest.
        fine, _, coarse = [level for level in converged.levels if level.values][:3]
        sizes = np.linspace(0.0, coarse.spacing, TREND_POINTS)
        at_zero, order = converged.extrapolated, converged.order
        trend = at_zero + (fine.value - at_zero) * (sizes / fine.spacing) ** order
        yield Series("trend", TREND, tuple(sizes.tolist()), tuple(trend.tolist()))
    if _several_offsets(point):
        finite = np.isfinite(point.values)
        x, y = point.spacings[finite].tolist(), point.values[finite].tolist()
        yield Series("run", RUN, tuple(x), tuple(y), connected=False)
    yield Series(
        "level",
        MEAN if _several_offsets(point) else LEVEL,
        tuple(level.spacing for level in levels),
        tuple(level.value for level in levels),
        numbers(level.scatter for level in levels),
    )
    if _is_converging(point):
        yield Series("limit", EXTRAPOLATED, (0.0,), (converged.extrapolated,), connected=False)
