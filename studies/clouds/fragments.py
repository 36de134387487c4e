"""The pieces of a debris cloud: those that the mesh made, and how fine Grady says that they would be.

Pieces are what the grid still joins of the matter behind the plate that came off (``cloud`` says which that is): two
particles belong together where their cells are the same or neighbours. So no piece is smaller than the mesh lets it be,
and where a cell is larger than the fragments would be, their number and the largest of them say nothing but the mesh:
they are flagged, and no verdict rests on them.

Nominal sizes are Grady's (``studies/debris/breakup.py``). The rate is that of the whole cloud at its original
density: along each axis the spread of its velocities over that of the places that its matter had *before the impact*
(standard deviations, mass-weighted), the three added. Matter that flies freely keeps it, at whatever time it is read;
v = k X has d = 3 k. Two other rates do not serve. That of a least-squares gradient over present places falls as one
over the time since the impact, and so makes a size that grows with the time that a user chooses. That of one over the
places before the impact tells growth from turning over: where the rear of a sphere overtakes its front, the terms
cancel (457/s at 4 km/s on t/d 0.2, of a cloud that flies apart).
"""

import math
from collections.abc import Callable

import numpy as np

from studies.clouds.cloud import OF_CLOUD, melted_share_behind
from studies.debris.breakup import Breakup, brittle, ductile, liquid
from studies.debris.cloud import FEW_PARTICLES, HALF, NOTHING_BEHIND, CloudView
from studies.measurements import Measurement, NoValue, Reading, measurement
from studies.measurements.distributions import Bins, Distribution
from studies.quantities.measured import COARSER_THAN_FRAGMENTS

# Pieces are flagged where the grid still joins flying matter to the plate: more than a hundredth of the mass behind,
# faster than a tenth of the impact speed.
JOINED, FLYING = 0.01, 0.1
NOT_SEPARATED, NOT_EXPANDING = "not_separated", "not_expanding"
SIZE_UNKNOWN = "fragment_size_unknown"

# ---- pieces of what came off, as the grid joins particles: the mesh decides, so three grids are asked ---------


def _came_off(view: CloudView) -> np.ndarray:
    return view.behind() & ~view.plate


def _pieces(view: CloudView) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass (kg) of each piece, its volume at the original density (m3), and how many of it the whole body has; (k,)."""
    came_off = _came_off(view)
    _, first, piece = np.unique(view.fragment[came_off], return_index=True, return_inverse=True)
    copies = view.copies[came_off][first]
    mass = view.mass[came_off]
    density = np.where(view.projectile[came_off], *(matter.density for matter in view.breakup))
    of_pieces = (np.bincount(piece.ravel(), weights) / copies for weights in (mass, mass / density))
    return (*of_pieces, copies)


def _fragments(
    name: str, title: str, unit: str, meaning: str, of: Callable[[np.ndarray, np.ndarray], float | None]
) -> Measurement:
    """A number of the pieces behind the plate, by the mass (k,) of each and how many of it the whole body has (k,)."""

    def read(view: CloudView) -> Reading:
        mass, _, copies = _pieces(view)
        value = of(mass, copies)
        if value is None:
            raise NoValue(NOTHING_BEHIND)
        # The grid still joins flying matter to the plate.
        behind = view.behind()
        joined = behind & view.plate & (view.axial_velocity > FLYING * view.speed)
        is_joined = view.mass[joined].sum() > JOINED * view.mass[behind].sum()
        return Reading(value, flags=(*((NOT_SEPARATED,) if is_joined else ()), *_coarser(view)))

    return Measurement(
        name=name,
        title=title,
        unit=unit,
        meaning=f"{meaning}: two particles belong together where their cells are the same or neighbours; rings in a "
        "body of revolution; mesh determined unless three grids are there, "
        "not separated where more than 1 % of the mass behind the plate is still connected to its rim and flies faster "
        "than a tenth of the impact speed; coarser than fragments where a cell of the mesh is larger than the nominal "
        "fragment, so that the mesh alone made the pieces, fragment size unknown where a constant for that has no "
        "source",
        version=2,
        definition=read,
        mesh_determined=True,
    )


FRAGMENTS = (
    _fragments(
        "fragments",
        "Fragments",
        "1",
        "number of connected pieces of matter behind the plate that came off",
        lambda masses, copies: float(copies.sum()),
    ),
    _fragments(
        "largest_fragment",
        "Largest fragment",
        "kg",
        "mass of the heaviest connected piece of matter behind the plate that came off",
        lambda masses, copies: float(masses.max()) if masses.size else None,
    ),
)

# ---- how fine fragments would be -----------------------------------------------------------------


@measurement(
    title="Rate of expansion of the cloud",
    unit="s-1",
    meaning="rate at which the volume of the matter that came off and is behind the plate grows, over its original "
    "volume: the sum, over the three axes, of the standard deviation of velocity over that of the place before impact",
)
def expansion_rate(view: CloudView) -> Reading:
    among = _came_off(view)
    if not among.any():
        raise NoValue(NOTHING_BEHIND)
    mass, depth, speed = (array[among] for array in (view.mass, view.initial_depth, view.axial_velocity))
    # Whole bodies are symmetric about the axis, so that nothing across it has a mean.
    across, outward = (float(mass @ array[among] ** 2) for array in (view.initial_radius, view.transverse_velocity))
    along = _spread(mass, depth)
    if not across or not along:
        raise NoValue(FEW_PARTICLES)
    return Reading(_spread(mass, speed) / along + 2.0 * math.sqrt(outward / across))


def _spread(mass: np.ndarray, values: np.ndarray) -> float:
    """Standard deviation of values (n,), weighted with the mass (n,); exactly zero of equal ones."""
    values = values - 0.5 * (values.min() + values.max())
    return math.sqrt(mass @ (values - mass @ values / mass.sum()) ** 2 / mass.sum())


# The ways to break, and the flag of matter that lacks the constant.
WAYS: dict[str, tuple[Callable[[Breakup, float], float | None], str]] = {
    "brittle": (brittle, "no_fracture_toughness"),
    "ductile": (ductile, "no_yield_stress"),
    "liquid": (liquid, "no_surface_tension"),
}


def _sizes(view: CloudView, ways: tuple[str, ...], rate: float) -> tuple[list[float], tuple[str, ...]]:
    """Sizes of the fragments of each matter behind the plate in some ways to break (m), and flags of those unknown."""
    came_off = _came_off(view)
    bodies = zip(view.breakup, (view.projectile, ~view.projectile), strict=True)
    kinds = [matter for matter, mine in bodies if mine[came_off].any()]
    sizes = {way: [WAYS[way][0](matter, rate) for matter in kinds] for way in ways}
    known = [size for of_way in sizes.values() for size in of_way if size is not None]
    return known, tuple(WAYS[way][1] for way, of_way in sizes.items() if None in of_way)


def _coarser(view: CloudView) -> tuple[str, ...]:
    """The flag of pieces that the mesh alone made; what is unknown could make fragments finer, and no coarser."""
    rate = expansion_rate.read(view).value
    if not rate > 0.0:
        return ()
    is_liquid = melted_share_behind.read(view).value > HALF
    known, unknown = _sizes(view, ("liquid",) if is_liquid else SOLID, rate)
    if any(size < view.cell for size in known):
        return (COARSER_THAN_FRAGMENTS,)
    return (SIZE_UNKNOWN,) if unknown else ()


SOLID = ("brittle", "ductile")


def _nominal(name: str, title: str, ways: tuple[str, ...], meaning: str) -> Measurement:
    """A nominal size: that of the matter that breaks finest, in the way that takes the least stress."""

    def read(view: CloudView) -> Reading:
        rate = expansion_rate.definition(view).value
        if not rate > 0.0:
            raise NoValue(NOT_EXPANDING)
        known, unknown = _sizes(view, ways, rate)
        if unknown:
            raise NoValue(*unknown)
        return Reading(min(known))

    flags = ", ".join(WAYS[way][1].replace("_", " ") for way in ways)
    return Measurement(
        name=f"fragment_size_{name}",
        title=title,
        unit="m",
        meaning=f"nominal size of fragments at the rate of expansion of the cloud, {meaning}, of the matter behind the "
        f"plate that breaks finest, Grady (1988); not expanding where that rate is not positive, {flags} where a "
        "material does not have that constant",
        definition=read,
    )


NOMINAL = (
    _nominal("brittle", "Size of brittle fragments", ("brittle",), "where toughness decides"),
    _nominal("ductile", "Size of ductile fragments", ("ductile",), "where flow stress decides"),
    _nominal("grady", "Size of fragments after Grady", SOLID, "of solid metal: the smaller of brittle and ductile"),
    _nominal("liquid", "Size of drops", ("liquid",), "of liquid metal, where surface tension decides"),
)

MEASUREMENT = (*FRAGMENTS, expansion_rate, *NOMINAL)

# ---- their distribution over size ----------------------------------------------------------------

SIZES = Bins(
    "fragment_size",
    "size of a fragment",
    "1",
    "decimal logarithm of the diameter of the sphere with the volume of a piece, over the projectile's diameter",
    0.1,
    35,
    -3.0,
)


def _over_size(of: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Callable[[CloudView], np.ndarray]:
    """What the pieces of the whole body bring into each bin, by the mass of each and how many there are (k,)."""

    def read(view: CloudView) -> np.ndarray:
        mass, volume, copies = _pieces(view)
        size = np.log10(np.cbrt(6.0 / math.pi * volume) / view.diameter)
        return np.bincount(SIZES.place(size), of(mass, copies), minlength=SIZES.count)

    return read


OF_PIECES = tuple(
    Distribution(
        name=name,
        title=title,
        unit=unit,
        meaning=f"{meaning} behind the plate that came off, over its size; the mesh makes none smaller than a particle",
        bins=(SIZES,),
        read=_over_size(of),
    )
    for name, title, unit, meaning, of in (
        ("fragments_over_size", "Fragments over size", "1", "number of pieces", lambda mass, copies: copies),
        ("fragment_mass_over_size", "Mass of fragments over size", "kg", "mass of pieces", np.multiply),
    )
)

DISTRIBUTIONS = (*OF_CLOUD, *OF_PIECES)
