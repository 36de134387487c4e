"""Sizes of the pieces in which debris flies on, by the rate at which its matter parted (``solver/grid/pieces.py``)."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from studies.debris.breakup import Breakup, liquid, solid

if TYPE_CHECKING:
    import numpy as np

    from solver.grid.flight import Flight
    from solver.problem import Problem


def sizes_of_pieces(problem: "Problem", flight: "Flight", breakup: Sequence[Breakup]) -> "np.ndarray":
    """Size of the pieces that each arrival of a flight makes (k,), m; infinite of matter that has not parted.

    ``breakup`` says how the matter of each body of the problem breaks. Matter that melting has left no strength makes
    drops; what lacks the constants of its kind stays as it is.
    """
    import numpy as np

    from solver.matter.eos import reference_density
    from solver.matter.melting import coherence
    from solver.state import DENSITY, KELVIN, PARTED

    arrivals = flight.arrivals
    rate, sizes = arrivals.table[PARTED], np.full(arrivals.time.size, math.inf)
    for number, body in enumerate(problem.bodies):
        mine = np.flatnonzero((arrivals.body == number) & (rate > 0.0))
        ratio = arrivals.table[DENSITY, mine] / reference_density(body.matter.eos)
        coherent = coherence(body.matter, arrivals.table[KELVIN, mine], ratio)
        for among, size in ((coherent > 0.0, solid), (coherent <= 0.0, liquid)):
            known = {each: size(breakup[number], each) for each in np.unique(rate[mine[among]])}
            sizes[mine[among]] = [math.inf if known[each] is None else known[each] for each in rate[mine[among]]]
    return sizes
