"""Contact of smoothed particles of different solids, without friction.

Particles of different solids take no part in each other's sums. A pair of them has the energy

    E = K V (W(r) / W(spacing))^4        with K = stiffness rho c^2, V = m / rho, each the mean of both

times the part of a whole particle that each is at planes of symmetry, where its images have the rest,
and repels each other by its gradient, which hardly acts beyond one and a half spacings: the contact potential of
Vignjevic, De Vuyst and Campbell (2007), ICCES 3, 107, with the power of Monaghan's artificial stress. Forces of a pair
are opposite. What they take from the kinetic energy is removed by contact, and comes back when bodies part.
"""

import numpy as np

from solver.jit import kernel
from solver.methods.sph.neighbours import coordinate
from solver.methods.sph.smoothing import SUPPORT, height, slope
from solver.methods.sph.tables import HEAVY, IMAGE, LENGTH, RHO, SOUND


def reached(place, solid, count):
    """The particles (k,) of the first ``count`` rows that stand in the support's reach of another solid's box."""
    length = place[:count, LENGTH]
    active = length > 0.0
    numbers = np.unique(solid[:count][active])
    near = np.zeros(count, bool)
    if numbers.size < 2:
        return np.flatnonzero(near)
    reach = SUPPORT * float(length.max())
    for number in numbers:
        own = place[:count, :3][active & (solid[:count] == number)]
        low, high = own.min(axis=0) - reach, own.max(axis=0) + reach
        inside = ((place[:count, :3] >= low) & (place[:count, :3] <= high)).all(axis=1)
        near |= active & inside & (solid[:count] != number)
    return np.flatnonzero(near)


@kernel
def repel(smoothing, dimensions, cells, place, other, solid, particles, pushed):
    """Accelerations by contact of some particles into ``pushed`` (n, 8), m/s2: by all, and then by images alone."""
    ratio = smoothing.ratio
    counts, begin, member, ordered = cells.counts, cells.begin, cells.member, cells.sorted
    whole = height(1.0 / ratio)
    for at in range(particles.size):
        i = particles[at]
        a, b = coordinate(cells, place, i, 0), coordinate(cells, place, i, 1)
        c = coordinate(cells, place, i, 2)
        for column in range(max(a - 1, 0), min(a + 2, counts[0])):
            for row in range(max(b - 1, 0), min(b + 2, counts[1])):
                cell = (column * counts[1] + row) * counts[2]
                for k in range(begin[cell + max(c - 1, 0)], begin[cell + min(c + 2, counts[2])]):
                    j = member[k]
                    if solid[j] == solid[i]:
                        continue
                    length = 0.5 * (place[i, LENGTH] + ordered[3, k])
                    d0, d1 = place[i, 0] - ordered[0, k], place[i, 1] - ordered[1, k]
                    d2 = place[i, 2] - ordered[2, k]
                    q = np.sqrt(d0 * d0 + d1 * d1 + d2 * d2) / length
                    if q >= SUPPORT:
                        continue
                    stiffness = other[i, RHO] * other[i, SOUND] * other[i, SOUND]
                    stiffness += other[j, RHO] * other[j, SOUND] * other[j, SOUND]
                    mine = (place[i, LENGTH] / ratio) ** dimensions
                    its = (place[j, LENGTH] / ratio) ** dimensions
                    volume = (mine + its) * min(place[i, HEAVY] / (other[i, RHO] * mine), 1.0)
                    volume *= min(place[j, HEAVY] / (other[j, RHO] * its), 1.0)
                    part = height(q) / whole
                    change = -4.0 * part * part * part * slope(q) / whole
                    size = 0.25 * smoothing.stiffness * stiffness * volume * change
                    size /= length * length * place[i, HEAVY]
                    for axis, along in enumerate((d0, d1, d2)):
                        pushed[i, axis] += size * along
                        pushed[i, 3 + axis] += other[j, IMAGE] * size * along
