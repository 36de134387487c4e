"""Captions of figures: what points, bars and lines are; their words are the templates in ``templates/captions``."""

from collections.abc import Iterable

import numpy as np

from studies.reports.figure import is_cut
from studies.reports.view import FigureView
from studies.reports.wording import in_words, text_template

# A history has dipped where it is below this share of an earlier value. Copper, 8 mm on 2 mm, 2 km/s, 32 cells: the
# plug, 18 mm behind the plate, is off at 14 us and on at 15 us.
DIP = 0.5


def of_laws(view: FigureView, name: str, kinds: set[str]) -> str:
    """The caption of simulation, laws and measured shots together, by the kinds of series that are drawn."""
    valued = np.isfinite(view.succeeded(name))
    return in_words(
        text_template("captions/laws.txt"),
        points=int(valued.sum()),
        unknown=int((valued & np.isnan(view.error_bars(name))).sum()),
        has_laws="law" in kinds,
        has_gaps="missing" in kinds,
        left_out=view.left_out,
    )


def of_growth(view: FigureView, name: str, histories: np.ndarray) -> str:
    """The caption of histories, (points, samples), with what makes a hole jump and dip where one does."""
    dips = name.startswith("hole_diameter") and any(map(_dips, histories))
    return in_words(text_template("captions/growth.txt"), refined=bool(view.refinements), dips=dips)


def _dips(history: np.ndarray) -> bool:
    """Whether a history falls below half of a value before it."""
    known = history[np.isfinite(history)]
    return bool((known < DIP * np.maximum.accumulate(known)).any()) if known.size else False


def of_cut_bars(bars: Iterable[tuple[float, float | None]]) -> str:
    """The sentence on bars that the frame cuts, of values with their bars; empty where there is none."""
    return in_words(text_template("captions/cut.txt"), bars=sum(is_cut(value, bar) for value, bar in bars))
