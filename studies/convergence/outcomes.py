"""An outcome, 1 or 0, over resolutions and offsets: what all runs say that count, else open.

The runs that count are those of the three finest resolutions, at every offset. All of them have to say the same: no
number lies between a wall that holds and one that does not, so nothing is averaged or extrapolated. An outcome is open
too where one of them found neither, where the finest resolution says 0 with a flag by which it may become 1, and where
even that is too coarse. One resolution says nothing about the mesh. A run that failed is left out, and counted in the
reason.
"""

import math
from collections.abc import Iterable, Iterator, Sequence

from studies.convergence.richardson import Convergence, ConvergenceVerdict, Level, Sample, levels_of, notes_on_gaps
from studies.quantities.measured import ENOUGH_GRIDS, doubts_of


def agree(samples: Iterable[Sample], words: Sequence[str] = ("0", "1")) -> Convergence:
    """The outcome of a point by its runs, in any order; spacings are one over cells of some length.

    ``words`` say what 0 and 1 mean. The value is 0 or 1, and NaN where the outcome is open.
    """
    samples = list(samples)
    levels = levels_of(samples)
    counted = [level for level in levels if level.values or level.nothing][:ENOUGH_GRIDS]
    if not any(level.values for level in counted):
        return _outcome("no value", "no run has a value", math.nan, levels)
    said: dict[str, list[float]] = {}
    for level in counted:
        for word in _said(level, words):
            said.setdefault(word, []).append(level.spacing)
    if len(said) > 1:
        told = [f"{word} with {_cells(spacings)}" for word, spacings in said.items()]
        reason = "offsets of its one resolution disagree" if len(counted) == 1 else "; ".join(told)
        return _outcome("open", reason, math.nan, levels)
    if doubts := doubts_of(counted[0].value, counted[0].quality_flags):
        (word,) = said
        return _outcome("open", f"{word}, but {doubts} at the finest resolution", math.nan, levels)
    if len(counted) == 1:
        return _outcome("single grid", "one resolution says nothing about the mesh", counted[0].value, levels)
    return _outcome("grids agree", f"{len(counted)} grids agree", counted[0].value, levels)


def _said(level: Level, words: Sequence[str]) -> Iterator[str]:
    """What the runs of a resolution say: the word of each outcome, and that some found none."""
    if level.values and level.value < 1.0:
        yield words[0]
    if level.values and level.value > 0.0:
        yield words[1]
    if level.nothing:
        yield "undecided"


def _cells(spacings: Sequence[float]) -> str:
    """ "16 and 24 cells"."""
    *before, last = [f"{1.0 / spacing:g}" for spacing in sorted(spacings, reverse=True)]
    return f"{', '.join(before)} and {last} cells" if before else f"{last} cells"


def _outcome(verdict: ConvergenceVerdict, reason: str, value: float, levels: tuple[Level, ...]) -> Convergence:
    return Convergence(verdict, "; ".join([reason, *notes_on_gaps(levels)]), value, levels=levels)
