"""Sod's tube and Noh's plane implosion by smoothed particles, held to the gates of ``sod`` and ``noh``."""

from collections.abc import Iterator

from solver.errors import UnphysicalState
from solver.simulation import simulate
from studies.values.recipes import Recipe
from studies.verification import Case, Row, at_least, observed_order, reported, sod
from studies.verification._column import profile
from studies.verification._gas import SOD, SOD_GAMMA, riemann
from studies.verification._smoothed import LINE, PLAIN, smoothed
from studies.verification.noh import plane, plane_rows

# Particles in a length of 1, coarse to fine; gates are those of the grid, at the finest.
SOD_PARTICLES, NOH_PARTICLES = (200, 400, 800), (100, 200, 400)
# At a shock and a contact the error is one of places, and so of the order 1; a little less is usual.
ORDER = 0.7


def _sod(recipe: Recipe) -> Iterator[Row]:
    exact = riemann(*SOD, SOD_GAMMA)
    errors = []
    for particles in SOD_PARTICLES:
        gases = sod.gases(smoothed(sod.tube(particles, LINE)))
        errors.append(sod.density_error(gases, exact, 1.0))
        yield reported(f"Sod, {particles} cells: L1 error of the density", errors[-1])
    yield from sod.rows(gases, exact, particles)
    order = observed_order(errors)
    yield at_least("Sod: observed order of the L1 error", limit=ORDER, got=order)
    yield _plain()


def _plain() -> Row:
    """With plain gradients particles beside one of an eighth of their mass do not see it enough, and run away."""
    claim = "Sod, plain gradients: the run ends with"
    try:
        sod.gases(smoothed(sod.tube(SOD_PARTICLES[0], LINE), PLAIN))
    except UnphysicalState as error:
        return Row(claim, "", str(error), None)
    return Row(claim, "", "the end of its time", None)


def _noh(recipe: Recipe) -> Iterator[Row]:
    for particles in NOH_PARTICLES:
        problem = smoothed(plane(particles, LINE))
        rows = plane_rows(profile(simulate(problem).snapshot, 0), particles)
        for row in rows:
            yield row if particles == NOH_PARTICLES[-1] else row.ungated()


CASE = (
    Case(
        name="sph-sod",
        says="smoothed particles hold the gates of Sod's tube, and converge with an order of 1",
        source="Sod (1978), J. Comput. Phys. 27, 1; exact solution: Toro (2009), section 4.2",
        run=_sod,
        quick=False,
    ),
    Case(
        name="sph-noh",
        says="smoothed particles hold the gates of Noh's plane implosion: front within 3 %, plateau within 5 %",
        source="Noh (1987), J. Comput. Phys. 72, 78; gamma 5/3",
        run=_noh,
        quick=False,
    ),
)
