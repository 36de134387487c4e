"""Error bars of the points of a figure: which parts they hold, where they judge, and how a caption says so."""

from collections.abc import Iterator

import numpy as np

from studies.cubes.variables import VERDICT_WORDS
from studies.reports.view import FigureView
from studies.sweeps.sweep import OFFSET, RESOLUTION


def over_resolutions(view: FigureView) -> bool:
    """Whether points were asked for at several resolutions."""
    return RESOLUTION in _refinements(view)


def judging(view: FigureView, name: str) -> np.ndarray:
    """Error bars (points,) that hold the mesh's part, NaN elsewhere: no other bar judges a residual."""
    return np.where(
        np.isfinite(_part(view, name, "mesh")), view.succeeded(f"{name}_uncertainty"), np.nan
    )


def points_in_words(view: FigureView, name: str) -> str:
    """What the points of a figure are, and their bars and open marks."""
    words = name.replace("_", " ")
    if not view.refined:
        return (
            f"Points are runs; bars are the uncertainty of {words} that one run states, without a "
            "part for the mesh; open points carry a flag."
        )
    if not over_resolutions(view):
        return f"Points are {words}, the mean over offsets; {_bars(view, name)}. Open points carry a flag."
    several = "resolutions and offsets" if OFFSET in _refinements(view) else "resolutions"
    verdicts = view.flat(f"{name}_converged_verdict")
    extrapolated = (verdicts == VERDICT_WORDS.index("converging")).any()
    finest = (
        "extrapolated where it converges, else of the finest" if extrapolated else "of the finest"
    )
    return (
        f"Points are {words} over all {several}, {finest} resolution; {_bars(view, name)}. Open "
        "points carry a flag, or are not known to converge and have the value of the finest resolution."
    )


def _bars(view: FigureView, name: str) -> str:
    """Which parts bars hold: "bars are their uncertainty: mesh, scatter over offsets"."""
    parts = list(_parts(view, name))
    if not parts:
        return "no uncertainty of theirs is known"
    words = f"bars are their uncertainty: {', '.join(parts)}"
    return words if parts[0].startswith("mesh") else f"{words}, without a part for the mesh"


def _parts(view: FigureView, name: str) -> Iterator[str]:
    """The parts that any bar holds, in words."""
    valued = np.isfinite(view.succeeded(name))
    unknown = valued & np.isnan(judging(view, name))
    if unknown.sum() < valued.sum():
        yield (
            f"mesh (unknown at {unknown.sum()} of {valued.sum()} points)"
            if unknown.any()
            else "mesh"
        )
    offsets = _part(view, name, "offsets")
    if OFFSET in _refinements(view) and np.isfinite(offsets).any():
        yield "scatter over offsets"
    elif (offsets > 0.0).any():
        yield "what one offset cannot see"
    if (_part(view, name, "measurement") > 0.0).any():
        yield "measurement"


def _part(view: FigureView, name: str, part: str) -> np.ndarray:
    """A part of the error bars (points,); NaN where a cube does not tell it."""
    variable = f"{name}_converged_uncertainty_{part}"
    if variable not in view.dataset:
        return np.full(len(view.x), np.nan)
    return view.flat(variable)


def _refinements(view: FigureView) -> list[str]:
    return str(view.dataset.attrs.get("refinements", "")).split()
