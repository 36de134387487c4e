"""What the figures of a report show: points, lines and bands in SI, from the cube alone.

A figure is panels side by side; a panel is series. Nothing here knows how it is drawn
(:mod:`studies.reports.plot`), and the report's JSON twin carries exactly these records.
"""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from studies.cubes.variables import STATES
from studies.reports.compare import Comparison
from studies.reports.error_bars import over_resolutions, points_in_words
from studies.reports.places import Place
from studies.reports.sightings import Sighting
from studies.reports.view import FigureView, Scale, Slice, flag_words
from studies.values.quantities import readable

Kind = Literal[
    "simulation",
    "law",
    "band",
    "observation",
    "missing",
    "history",
    "quantity",
    "run",
    "level",
    "trend",
    "limit",
]
Scales = Literal["shared", "own"]

MOST_HISTORIES = 8  # lines in one panel
NEAR = (
    0.05  # relative: an observed shot belongs to the panel whose other axes it meets this closely
)
SYMBOLS = {
    "hole_diameter": "D/d",
    "crater_depth": "p/d",
    "crater_diameter": "D/d",
}  # as the field writes them

Numbers = tuple[float | None, ...]


@dataclass(frozen=True)
class Series:
    """Points of one kind; every list has one entry a point, None where there is none."""

    kind: Kind
    label: str
    x: tuple[float | str | None, ...]
    y: Numbers = ()
    uncertainty: Numbers = ()  # half length of the error bar
    low: Numbers = ()  # of a band
    high: Numbers = ()
    in_range: tuple[bool, ...] = ()  # of a law
    flagged: tuple[bool, ...] = ()  # of a simulation: drawn open
    notes: tuple[str, ...] = ()  # words for a point
    connected: bool = True  # whether a line through the points means anything


@dataclass(frozen=True)
class Panel:
    """One picture: the points that share every axis but the abscissa, or one point."""

    title: str
    at: Place
    series: tuple[Series, ...]
    note: str = ""  # a second line under the title


@dataclass(frozen=True)
class Figure:
    """Panels side by side."""

    name: str
    title: str
    caption: str
    x: Scale
    y: Scale
    panels: tuple[Panel, ...]
    scales: Scales = "shared"  # own: each about its own middle, all as high in per cent

    def as_json(self) -> dict[str, Any]:
        """The figure as plain objects."""
        return asdict(self)


# ---- figures -------------------------------------------------------------------------------------


def against_laws(view: FigureView, name: str, comparison: Comparison) -> Figure:
    """Simulation, laws and observations over the abscissa, a panel for each other value."""
    panels = tuple(
        Panel(
            piece.title,
            piece.at,
            (
                *laws_of(view, name, piece),
                *_simulation(view, name, piece),
                *_missing(view, name, piece),
                *_observations(view, name, piece, comparison.sightings),
            ),
        )
        for piece in view.slices
    )
    kinds = {series.kind for panel in panels for series in panel.series}
    return Figure(
        name=f"{name}_laws",
        title=f"{_over(view, name)}: {_enumerated(kinds)}",
        caption=_caption(view, name, kinds),
        x=view.abscissa,
        y=ratio_scale(view, name),
        panels=panels,
    )


def overlay(view: FigureView, name: str) -> Figure:
    """The simulation of all panels in one, to show what the other axes do."""
    series = [
        Series(**{**vars(one), "kind": "quantity", "label": piece.title})
        for piece in view.slices
        for one in _simulation(view, name, piece)
    ]
    return Figure(
        name=f"{name}_overlay",
        title=f"{_over(view, name)}: simulation alone",
        caption=f"Every panel's points together. {points_in_words(view, name)}",
        x=view.abscissa,
        y=ratio_scale(view, name),
        panels=(Panel("", {}, tuple(series)),),
    )


def companions(view: FigureView, name: str) -> Figure:
    """The other readings of the same thing, beside the one that laws are compared with."""
    unit = view.dataset[name].attrs["units"]
    names = [
        other
        for other in str(view.dataset.attrs["quantities"]).split()
        if other.startswith(f"{name}_") and view.dataset[other].attrs["units"] == unit
    ]

    def panel(piece: Slice) -> Panel:
        series = [
            Series(**{**vars(one), "kind": "quantity", "label": _words(other)})
            for other in [name, *names]
            for one in _simulation(view, other, piece)
        ]
        return Panel(piece.title, piece.at, tuple(series))

    return Figure(
        name=f"{name}_companions",
        title=f"What is measured beside {_words(name)}",
        caption=f"Laws are compared with the reading named {_words(name)}. {points_in_words(view, name)}",
        x=view.abscissa,
        y=ratio_scale(view, name),
        panels=tuple(panel(piece) for piece in view.slices) if names else (),
    )


def growth(view: FigureView, name: str) -> Figure:
    """How the quantity grew during the runs: whether they were stopped too early."""
    values = view.flat(f"{name}_history") / view.norm(name)[:, np.newaxis]
    times = view.flat(f"{name}_history_time")

    def panel(piece: Slice) -> Panel:
        chosen = piece.cells[_spaced(len(piece.cells), MOST_HISTORIES)]
        series = [
            Series("history", _value_of(view, cell), numbers(times[cell]), numbers(values[cell]))
            for cell in chosen  # a run without a history too, so that labels keep their order
        ]
        return Panel(piece.title, piece.at, tuple(series))

    return Figure(
        name=f"{name}_growth",
        title=f"Growth of {_words(name)} during the runs",
        caption="A run ends when growth has stopped, or at a cap: a line that still climbs was cut."
        + (" Runs of the finest resolution, without offset." if view.refined else ""),
        x=Scale("time", "time", "s"),
        y=ratio_scale(view, name),
        panels=tuple(panel(piece) for piece in view.slices),
    )


# ---- series --------------------------------------------------------------------------------------


def _simulation(view: FigureView, name: str, piece: Slice) -> Iterator[Series]:
    values = view.succeeded(name)[piece.cells]
    if np.isfinite(values).any():
        norm = view.norm(name)[piece.cells]
        flagged = _open(view, name)[piece.cells]
        yield Series(
            kind="simulation",
            label="simulation",
            x=view.xs(piece),
            y=numbers(values / norm),
            uncertainty=numbers(view.succeeded(f"{name}_uncertainty")[piece.cells] / norm),
            flagged=tuple(bool(flag) for flag in flagged),
            connected=piece.connected,
        )


def _open(view: FigureView, name: str) -> np.ndarray:
    """Whether a point (points,) is drawn open: it carries a flag, or resolutions did not settle its value."""
    flagged: np.ndarray = (view.flat("run_flags") | view.flat(f"{name}_flags")) != 0
    return flagged | view.unsettled(name) if over_resolutions(view) else flagged


def _missing(view: FigureView, name: str, piece: Slice) -> Iterator[Series]:
    """Where a run gave no number: a gap is not a question that was never asked."""
    values = view.succeeded(name)
    cells = [cell for cell in piece.cells if not np.isfinite(values[cell])]
    if cells:
        states, reasons = view.flat("run_state"), view.flat("run_reason")
        flags = flag_words(view.dataset, f"{name}_flags")
        yield Series(
            kind="missing",
            label="run without a value",
            x=tuple(view.x[cell] for cell in cells),
            notes=tuple(
                f"{STATES[states[cell]]} {reasons[cell]} {' '.join(flags[cell])}".strip()
                for cell in cells
            ),
            connected=False,
        )


def laws_of(view: FigureView, name: str, piece: Slice) -> Iterator[Series]:
    """One line a law; over several stated variants a band from smallest to largest."""
    if f"{name}_law" not in view.dataset:
        return
    norm = view.norm(name)[piece.cells][:, np.newaxis]
    answers = view.flat(f"{name}_by_law")[piece.cells] / norm
    inside = view.flat(f"{name}_by_law_in_range")[piece.cells] == 1
    titles = _titles(view, name)
    for law, columns in _by_law(view.law_words(name, "name")).items():
        mine = answers[:, columns]
        if np.isfinite(mine).any():
            yield _law(titles[law], view.xs(piece), mine, inside[:, columns], piece.connected)


def _titles(view: FigureView, name: str) -> dict[str, str]:
    """The title of each law; with its name where two share a title."""
    titles = dict(zip(view.law_words(name, "name"), view.law_words(name, "title"), strict=True))
    shared = {title for title, count in Counter(titles.values()).items() if count > 1}
    return {law: f"{title} ({law})" if title in shared else title for law, title in titles.items()}


def _by_law(names: Iterable[str]) -> dict[str, list[int]]:
    found: dict[str, list[int]] = {}
    for column, name in enumerate(names):
        found.setdefault(name, []).append(column)
    return found


def _law(
    title: str, x: tuple[Any, ...], answers: np.ndarray, inside: np.ndarray, connected: bool
) -> Series:
    if answers.shape[1] == 1:
        in_range = tuple(bool(one) for one in inside[:, 0])
        return Series(
            "law", title, x, y=numbers(answers[:, 0]), in_range=in_range, connected=connected
        )
    known = np.isfinite(answers)
    some = known.any(axis=1)
    low = np.where(some, np.where(known, answers, np.inf).min(axis=1), np.nan)
    high = np.where(some, np.where(known, answers, -np.inf).max(axis=1), np.nan)
    return Series(
        kind="band",
        label=f"{title}: band of the stated constants",
        x=x,
        low=numbers(low),
        high=numbers(high),
        in_range=tuple(bool(one) for one in (inside | ~known).all(axis=1) & some),
        connected=connected,
    )


def _observations(
    view: FigureView, name: str, piece: Slice, sightings: Sequence[Sighting]
) -> Iterator[Series]:
    mine = [
        sighting
        for sighting in sightings
        if sighting.quantity == name
        and view.abscissa.name in sighting.at
        and not sighting.elsewhere
        and _near(sighting.at, piece.at)
    ]
    if mine:
        norms = [(view.normed(name) and sighting.diameter) or 1.0 for sighting in mine]
        bars = [sighting.uncertainty for sighting in mine]
        yield Series(
            kind="observation",
            label="observed",
            x=tuple(sighting.at[view.abscissa.name] for sighting in mine),
            y=tuple(sighting.value / norm for sighting, norm in zip(mine, norms, strict=True)),
            uncertainty=tuple(
                bar / norm if bar is not None else None
                for bar, norm in zip(bars, norms, strict=True)
            ),
            notes=tuple(sighting.source for sighting in mine),
            connected=False,
        )


def _near(shot: Place, panel: Place) -> bool:
    return all(_meets(shot.get(axis), value) for axis, value in panel.items())


def _meets(one: float | str | None, other: float | str) -> bool:
    if one is None or isinstance(one, str) or isinstance(other, str):
        return one == other
    return math.isclose(one, other, rel_tol=NEAR)


# ---- words and numbers ---------------------------------------------------------------------------


def _words(name: str) -> str:
    return name.replace("_", " ")


def ratio_scale(view: FigureView, name: str) -> Scale:
    """Over the projectile's diameter where that makes sense, else in its own unit."""
    if view.normed(name):
        return Scale("ratio", f"{_words(name)} / projectile diameter", "1")
    return Scale(name, _words(name), view.dataset[name].attrs["units"])


def _value_of(view: FigureView, cell: int) -> str:
    value = view.x[cell]
    return value if isinstance(value, str) else readable(value, view.abscissa.unit or "1")


def _over(view: FigureView, name: str) -> str:
    """What is drawn over what: "Crater depth, p/d against speed"."""
    symbol = f", {SYMBOLS[name]}" if name in SYMBOLS and view.normed(name) else ""
    return f"{_words(name).capitalize()}{symbol} against {view.abscissa.label}"


def _enumerated(kinds: set[Kind]) -> str:
    words = ["simulation"]
    words += ["laws"] if kinds & {"law", "band"} else []
    words += ["observations"] if "observation" in kinds else []
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else words[0]


def _caption(view: FigureView, name: str, kinds: set[Kind]) -> str:
    words = [points_in_words(view, name)]
    if kinds & {"law", "band"}:
        words.append(
            "Laws: solid lines and filled marks inside the range that their source states, "
            "dotted lines and open marks outside."
        )
    if "band" in kinds:
        words.append(
            "A shaded band spans the smallest to the largest answer over the constants "
            "stated for that law, nothing else."
        )
    if "missing" in kinds:
        words.append("A grey cross on the base line is a run that gave no value.")
    if "observation" in kinds:
        words.append(
            f"An observed shot stands in the panel whose other axes it meets within {NEAR:.0%}."
        )
    if view.left_out:
        words.append("Not all panels are drawn; the cube has all.")
    return " ".join(words)


def _spaced(count: int, most: int) -> np.ndarray:
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))


def numbers(values: Iterable[float]) -> Numbers:
    """Numbers of a series, None where there is none."""
    return tuple(float(value) if math.isfinite(value) else None for value in values)
