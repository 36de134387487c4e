"""Content of the figures of a report: points, lines and bands in SI, from the cube alone.

Its records are those of :mod:`studies.reports.figure`.
"""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from studies.convergence.richardson import Convergence
from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.points import Refined, axes_of, by_run, is_same, main_quantities, places_of, refined, refinements_of
from studies.cubes.variable import SYMBOLS
from studies.quantities.units import readable
from studies.reports import captions
from studies.reports.compare import Comparison
from studies.reports.figure import (
    CELL_OF_MESH,
    ERROR_BAR,
    EXTRAPOLATED,
    GRADY,
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
    numbers,
)
from studies.reports.matched import MatchedObservation
from studies.reports.view import MOST_PANELS, FigureView, Slice, judged_window, second_axis, spread, title_of, views_of
from studies.sweeps.reading import RESOLUTION

MOST_HISTORIES = 8  # lines in one panel
MOST_MAPS = 6  # panels of a map
TREND_POINTS = 24  # points of the curve through the three finest resolutions


def figures(cube: xr.Dataset, comparison: Comparison) -> tuple[Figure, ...]:
    """Figures of the points of a cube, the main ones first, and of their convergence."""
    points = comparison.points
    views, names = views_of(points), main_quantities(points)
    view = views[0]
    if (other := second_axis(view)) is not None:
        return tuple(_maps(view, other, names, comparison.observations))
    drawn = [
        *(against_laws(view, name, comparison.observations) for name in names),
        *(scatter(other, name, comparison.observations) for name in names for other in views[1:]),
        *(residuals(view, name) for name in names if cubes.LAW_LABEL.is_in(points, name)),
        *(overlay(view, name) for name in names if len(view.slices) > 1),
        *(companions(view, name) for name in names),
        *(growth(view, name) for name in names if cubes.HISTORY.is_in(points, name)),
        *(convergence(cube, view, name) for name in names if RESOLUTION in refinements_of(cube)),
    ]
    return tuple(
        replace(figure, caption=figure.caption + captions.of_cut_bars(_bars_of(figure)))
        for figure in drawn
        if any(panel.series for panel in figure.panels)
    )


def _bars_of(figure: Figure) -> Iterator[tuple[float, float | None]]:
    """Each value of a figure with its bar; figures whose panels have axes of their own show every bar."""
    for series in (each for panel in figure.panels for each in panel.series):
        if figure.scales == "shared" and series.uncertainty:
            for value, bar in zip(series.y, series.uncertainty, strict=True):
                if value is not None:
                    yield value, bar


# ---- points, laws and observations ---------------------------------------------------------------


def against_laws(view: FigureView, name: str, observations: Sequence[MatchedObservation]) -> Figure:
    """Simulation, laws and observations over the abscissa, a panel for each other value."""
    panels = tuple(
        Panel(
            piece.title,
            piece.at,
            (
                *_laws(view, name, piece),
                *simulation(view, name, piece),
                *_missing(view, name, piece),
                *_observed(view, name, piece, observations),
            ),
        )
        for piece in view.slices
    )
    kinds: set[str] = {series.kind for panel in panels for series in panel.series}
    shown = ["simulation"]
    shown += ["laws"] if kinds & {"law", "band"} else []
    shown += ["observations"] if "observation" in kinds else []
    listed = " and ".join([*filter(None, [", ".join(shown[:-1])]), shown[-1]])
    return Figure(
        name=f"{name}_laws",
        title=f"{_over(view, name)}: {listed}",
        caption=captions.of_laws(view, name, kinds),
        x=view.abscissa,
        y=view.scale_of(name),
        panels=panels,
    )


def scatter(view: FigureView, name: str, observations: Sequence[MatchedObservation]) -> Figure:
    """Simulation, laws and observations over another axis, all points in one panel."""
    drawn = against_laws(view, name, observations)
    return replace(drawn, name=f"{drawn.name}_over_{view.abscissa.name}", title=f"{drawn.title}, {view.abscissa.label}")


def overlay(view: FigureView, name: str) -> Figure:
    """The simulation of all panels in one, to show what the other axes do."""
    series = [
        replace(points, kind="quantity", label=piece.title)
        for piece in view.slices
        for points in simulation(view, name, piece)
    ]
    return Figure(
        name=f"{name}_overlay",
        title=f"{_over(view, name)}: simulation alone",
        caption=f"Every panel's points together. {captions.of_points(view, name)}",
        x=view.abscissa,
        y=view.scale_of(name),
        panels=(Panel("", {}, tuple(series)),),
    )


def companions(view: FigureView, name: str) -> Figure:
    """The other readings of the same thing, beside the one that laws are compared with."""
    unit = view.dataset[name].attrs["units"]
    others = [
        other
        for other in reading.quantities_of(view.dataset)
        if other.startswith(f"{name}_") and view.dataset[other].attrs["units"] == unit
    ]
    others = _distinct(view, name, others)
    panels = [
        Panel(
            piece.title,
            piece.at,
            tuple(
                replace(points, kind="quantity", label=_words(other))
                for other in [name, *others]
                for points in simulation(view, other, piece)
            ),
        )
        for piece in view.slices
        if others
    ]
    return Figure(
        name=f"{name}_companions",
        title=f"Other readings of {_words(name)}",
        caption=f"Laws are compared with the reading named {_words(name)}. {captions.of_points(view, name)}",
        x=view.abscissa,
        y=view.scale_of(name),
        panels=tuple(panels),
    )


def _distinct(view: FigureView, name: str, others: Sequence[str]) -> list[str]:
    """The readings that differ somewhere from those before them: largest and smallest do not in axial symmetry."""
    kept = {name: view.succeeded(name)}
    for other in others:
        values = view.succeeded(other)
        if not any(np.array_equal(values, each, equal_nan=True) for each in kept.values()):
            kept[other] = values
    return list(kept)[1:]


def growth(view: FigureView, name: str) -> Figure:
    """The quantity during the runs: whether they were stopped too early."""
    values = view.flat(cubes.HISTORY, name) / view.norm(name)[:, np.newaxis]
    times = view.flat(cubes.HISTORY_TIME)
    panels = [
        Panel(
            piece.title,
            piece.at,
            # A run without a history too, so that labels keep their order.
            tuple(
                Series(
                    "history",
                    _value_of(view, cell),
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
        title=f"Growth of {_words(name)} during the runs",
        caption=captions.of_growth(view, name, values),
        x=Scale("time", "time", "s"),
        y=view.scale_of(name),
        panels=tuple(panels),
    )


def _window(view: FigureView, cell: int, times: np.ndarray) -> Numbers:
    """The time in which growth of a run is judged: begin and end."""
    known = np.isfinite(times)
    if not known.any():
        return ()
    return judged_window(view.dataset, cell, float(times[known].max())) or ()


def simulation(view: FigureView, name: str, piece: Slice) -> Iterator[Series]:
    """The points of a panel with their error bars; none where no run has a value."""
    values = view.succeeded(name)[piece.cells]
    if np.isfinite(values).any():
        norm, doubts = view.norm(name)[piece.cells], view.doubts(name)
        bars = view.error_bars(name)[piece.cells]
        yield Series(
            "simulation",
            SIMULATION,
            view.xs(piece),
            numbers(values / norm),
            uncertainty=numbers(bars / norm),
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


def _laws(view: FigureView, name: str, piece: Slice) -> Iterator[Series]:
    """One line a law; over several stated variants a band from smallest to largest."""
    titles = view.drawn_laws(name)
    if not titles:
        return
    norm = view.norm(name)[piece.cells][:, np.newaxis]
    answers = view.flat(cubes.BY_LAW, name)[piece.cells] / norm
    inside = view.flat(cubes.BY_LAW_IN_RANGE, name)[piece.cells] == 1
    names = cubes.LAW_NAME.of(view.dataset, name).values.astype(str)
    shared = Counter(titles.values())
    for law, title in titles.items():
        mine = answers[:, names == law]
        if np.isfinite(mine).any():
            label = f"{title} ({law})" if shared[title] > 1 else title
            yield _law(label, view.xs(piece), mine, inside[:, names == law], piece.connected)


def _law(title: str, x: tuple[Any, ...], answers: np.ndarray, inside: np.ndarray, connected: bool) -> Series:
    if answers.shape[1] == 1:
        in_range = tuple(inside[:, 0].tolist())
        return Series("law", title, x, numbers(answers[:, 0]), in_range=in_range, connected=connected)
    finite = np.isfinite(answers)
    some = finite.any(axis=1)
    return Series(
        "band",
        f"{title}, all constants",
        x,
        low=numbers(np.where(some, np.where(finite, answers, np.inf).min(axis=1), np.nan)),
        high=numbers(np.where(some, np.where(finite, answers, -np.inf).max(axis=1), np.nan)),
        in_range=tuple(((inside | ~finite).all(axis=1) & some).tolist()),
        connected=connected,
    )


def _observed(
    view: FigureView, name: str, piece: Slice, observations: Sequence[MatchedObservation]
) -> Iterator[Series]:
    """The shots that meet the other axes of a panel."""
    mine = [
        (shot, (view.normed(name) and shot.diameter) or 1.0)
        for shot in observations
        if shot.quantity == name
        and shot.value is not None
        and view.abscissa.name in shot.at
        and not shot.elsewhere
        and all(axis in shot.at and is_same(shot.at[axis], value, captions.NEAR) for axis, value in piece.at.items())
    ]
    if mine:
        yield Series(
            "observation",
            OBSERVED,
            tuple(shot.at[view.abscissa.name] for shot, _ in mine),
            tuple(shot.observed / norm for shot, norm in mine),
            uncertainty=tuple(None if shot.uncertainty is None else shot.uncertainty / norm for shot, norm in mine),
            notes=tuple(shot.source for shot, _ in mine),
            connected=False,
        )


# ---- maps -----------------------------------------------------------------------------------------


def _maps(
    view: FigureView, other: Scale, names: Sequence[str], observations: Sequence[MatchedObservation]
) -> Iterator[Figure]:
    """Each quantity over two axes, what laws differ from it by, and growth of some runs."""
    for name in names:
        about: dict[str, Any] = {"x": view.abscissa, "y": other}
        over = f"over {view.abscissa.label} and {other.label}"
        pieces = list(_pieces(view, other.name))
        values = view.succeeded(name) / view.norm(name)
        panels = [_map(view, other, title, cells, values) for title, cells in spread(pieces, MOST_MAPS)]
        if not any(panel.series for panel in panels):
            continue
        left_out = len(pieces) - len(panels)
        caption = f"Colours say {_words(name)}; a run without a value has none." + (
            f" {left_out} further combinations of the other axes are in the cube." if left_out else ""
        )
        title = f"{_words(name).capitalize()} {over}"
        yield Figure(f"{name}_map", title, caption, panels=tuple(panels), z=view.scale_of(name), **about)
        reference = np.where(view.compared(name) == 0.0, np.nan, view.compared(name))
        title, cells = pieces[0]
        laws = [
            _map(
                view,
                other,
                law.label,
                cells,
                np.array(law.y, float) / (reference[cells] / view.norm(name)[cells]) - 1.0,
            )
            for law in _laws(view, name, Slice(title, {}, cells, connected=False))
            if law.kind == "law" and any(law.in_range)
        ]
        if laws := [panel for panel in laws if panel.series][:MOST_MAPS]:
            yield Figure(
                f"{name}_residuals_map",
                f"Law minus simulation, relative: {_words(name)} {over}",
                "Red: the law gives more than the simulation; blue: less. Answers outside of the range of a law too."
                + (f" At {title}." if title else ""),
                panels=tuple(laws),
                z=Scale("residual", "(law − simulation) / simulation", "1"),
                **about,
            )
        if cubes.HISTORY.is_in(view.dataset, name):
            whole = replace(view, slices=(Slice("", {}, np.arange(len(view.x)), connected=False),))
            yield growth(whole, name)


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
    groups: dict[tuple[Any, ...], list[int]] = {}
    for cell, place in enumerate(places_of(view.dataset)):
        groups.setdefault(tuple(place[axis] for axis in others), []).append(cell)
    for key, cells in groups.items():
        yield title_of(view.dataset, dict(zip(others, key, strict=True))), np.array(cells)


# ---- residuals -----------------------------------------------------------------------------------


def residuals(view: FigureView, name: str) -> Figure:
    """Law minus simulation, over the simulation, with its error bar as a band about zero."""
    values = view.compared(name)
    sized = np.where(values == 0.0, np.nan, values)  # nothing is relative to zero
    bars = view.error_bars(name) / np.abs(sized)
    panels = []
    for piece in view.slices:
        reference = (sized / view.norm(name))[piece.cells]
        laws = [_relative(law, reference) for law in _laws(view, name, piece)]
        bands = _bands(view.xs(piece), bars[piece.cells], piece.connected) if laws else ()
        panels.append(Panel(piece.title, piece.at, (*bands, *laws)))
    return Figure(
        name=f"{name}_residuals",
        title=f"Law minus simulation, relative: {_words(name)}",
        caption=captions.of_residuals(view, name),
        x=view.abscissa,
        y=Scale("residual", "(law − simulation) / simulation", "1"),
        panels=tuple(panels),
    )


def _relative(law: Series, reference: np.ndarray) -> Series:
    def over(values: Numbers) -> Numbers:
        return numbers(np.array(values, float) / reference - 1.0) if values else ()

    return replace(law, y=over(law.y), low=over(law.low), high=over(law.high))


def _bands(x: Sequence[float | str], bars: np.ndarray, connected: bool) -> Iterator[Series]:
    """The error bar about zero, in pieces: none reaches over a point that has no bar."""
    barred = np.flatnonzero(np.isfinite(bars))
    for places in np.split(barred, np.flatnonzero(np.diff(barred) > 1) + 1):
        if len(places):
            yield _error_bar(
                tuple(x[place] for place in places), numbers(-bars[places]), numbers(bars[places]), connected
            )


def _error_bar(x: tuple[float | str, ...], low: Numbers, high: Numbers, connected: bool = True) -> Series:
    in_range = (True,) * len(x)
    return Series("band", ERROR_BAR, x, low=low, high=high, in_range=in_range, connected=connected)


# ---- convergence ---------------------------------------------------------------------------------


def convergence(cube: xr.Dataset, view: FigureView, name: str) -> Figure:
    """A quantity against the size of a cell, one panel a point."""
    valued = [point for point in refined(cube, name) if math.isfinite(point.converged.value)]
    shown = spread(valued, MOST_PANELS)
    places, norms = places_of(view.dataset), view.norm(name)
    return Figure(
        name=f"{name}_convergence",
        title=f"{_words(name).capitalize()} against the size of a cell",
        caption=captions.of_convergence(
            offsets=any(_several_offsets(point) for point in shown[:1]),
            extrapolated=any(point.converged.verdict == "converging" for point in shown),
            left_out=len(valued) > len(shown),
        ),
        x=Scale("spacing", "cell size / projectile diameter", "1"),
        y=view.scale_of(name),
        panels=tuple(
            Panel(
                title_of(view.dataset, places[point.number]),
                places[point.number],
                tuple(_of_point(point, float(norms[point.number]))),
                _verdict(point.converged),
            )
            for point in shown
        ),
        scales="own",
    )


def _verdict(converged: Convergence) -> str:
    """The verdict, with the order where there is one: "converging, order 1.3"."""
    order = f", order {converged.order:.2g}" if converged.verdict == "converging" else ""
    return converged.verdict + order


def _several_offsets(point: Refined) -> bool:
    return len(point.values) > len(point.converged.levels)


def _of_point(point: Refined, norm: float) -> Iterator[Series]:
    converged = point.converged
    levels = [level for level in reversed(converged.levels) if level.values]
    if math.isfinite(converged.uncertainty):
        # From nothing to the coarsest resolution.
        low, high = (converged.value + sign * converged.uncertainty for sign in (-1.0, 1.0))
        coarsest = max(level.spacing for level in converged.levels)
        yield _error_bar((0.0, coarsest), (low / norm,) * 2, (high / norm,) * 2)
    if converged.verdict == "converging":
        yield _trend(converged, norm)
    if _several_offsets(point):
        finite = np.isfinite(point.values)
        x, y = point.spacings[finite].tolist(), (point.values[finite] / norm).tolist()
        yield Series("run", RUN, tuple(x), tuple(y), connected=False)
    yield Series(
        "level",
        MEAN if _several_offsets(point) else LEVEL,
        tuple(level.spacing for level in levels),
        tuple(level.value / norm for level in levels),
        numbers(level.scatter / norm for level in levels),
    )
    if converged.verdict == "converging":
        yield Series("limit", EXTRAPOLATED, (0.0,), (converged.extrapolated / norm,), connected=False)


def _trend(converged: Convergence, norm: float) -> Series:
    """f(0) + C h^p from nothing to the third finest resolution, through the two finest."""
    fine, _, coarse = [level for level in converged.levels if level.values][:3]
    x = np.linspace(0.0, coarse.spacing, TREND_POINTS)
    y = converged.extrapolated + (fine.value - converged.extrapolated) * (x / fine.spacing) ** converged.order
    return Series("trend", TREND, tuple(x.tolist()), tuple((y / norm).tolist()))


# ---- sizes of fragments ---------------------------------------------------------------------------


def fragment_sizes(cube: xr.Dataset, points: xr.Dataset) -> Iterator[Figure]:
    """Share of the pieces of a cloud, and of their mass, that are larger than a size; a panel a point."""
    if "fragments_over_size" not in points:
        return
    middles = points["fragment_size"].values
    edges = tuple((middles - 0.5 * (middles[1] - middles[0])).tolist())
    place = places_of(points)
    is_refined = RESOLUTION in refinements_of(cube)
    cells = np.full(len(place), cube[RESOLUTION][-1]) if is_refined else by_run(points, RESOLUTION).ravel()
    marks = {
        CELL_OF_MESH: 1.0 / cells,
        GRADY: (by_run(points, "fragment_size_grady") / by_run(points, "projectile_diameter")).ravel(),
    }
    panels = []
    for number in spread(range(len(place)), MOST_PANELS):
        series = []
        for label, name in (("number", "fragments_over_size"), ("mass", "fragment_mass_over_size")):
            amounts = points[name].values.reshape(-1, len(middles))[number]
            larger = amounts[::-1].cumsum()[::-1]
            if larger[0] > 0.0:
                first, last = np.flatnonzero(amounts)[[0, -1]]
                shown = slice(max(first - 1, 0), last + 2)
                series.append(Series("quantity", label, edges[shown], numbers(larger[shown] / larger[0])))
        for label, sizes in marks.items():
            if series and sizes[number] > 0.0:
                series.append(Series("trend", label, (math.log10(sizes[number]),) * 2, (0.0, 1.0)))
        panels.append(Panel(title_of(points, place[number]), place[number], tuple(series)))
    if any(panel.series for panel in panels):
        yield Figure(
            name="fragment_sizes",
            title="Size of fragments: share of their number and mass that is larger",
            caption=captions.OF_FRAGMENTS,
            x=Scale("fragment_size", "log10 (size / projectile diameter)", "1"),
            y=Scale("larger", "share that is larger", "1"),
            panels=tuple(panels),
        )


# ---- words and numbers ---------------------------------------------------------------------------


def _words(name: str) -> str:
    return name.replace("_", " ")


def _value_of(view: FigureView, cell: int) -> str:
    value = view.x[cell]
    return value if isinstance(value, str) else readable(value, view.abscissa.unit or "1")


def _over(view: FigureView, name: str) -> str:
    """Title of a quantity over the abscissa: "Crater depth, p/d against speed"."""
    symbol = f", {SYMBOLS[name]}" if name in SYMBOLS and view.normed(name) else ""
    return f"{_words(name).capitalize()}{symbol} against {view.abscissa.label}"
