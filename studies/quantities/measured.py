"""A measured number: its uncertainty by parts, its history, and the flags that say what it is worth."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

UNDER_RESOLVED = "under_resolved"  # flag of a run on fewer cells than its scenario asks for
# Flags of a value with an unknown error: no law is compared with it.
TOO_COARSE = "too_coarse"  # read on a grid with fewer than two cells through the plate
CLOSED_ON_AXIS = "closed_on_axis"  # a film of the plate still closes the hole
CLOSED_BY_FILM = "closed_by_film"  # a ligament thinner than a cell closes what would else be a hole
STILL_COMING = "still_coming"  # debris is on its way to what is measured
STILL_ATTACHED = "still_attached"  # what flies to it had not come off the sheet in front at the end of that one's stage
STILL_GROWING = "still_growing"  # it had not settled at the end
# Flags that leave an outcome of 0 undecided, because it may become 1 on another grid or later.
NOT_DECIDED = (CLOSED_BY_FILM, STILL_COMING, STILL_ATTACHED, STILL_GROWING)
WIDE_BAR = "wide_bar"  # the uncertainty exceeds ``Measurement.widest``
MESH_DETERMINED = "mesh_determined"  # read off one grid, which decides such a value
ENOUGH_GRIDS = 3  # of one point, that take the flags of one grid from its values: they show the mesh
# The mesh is coarser than the pieces would be of which a value speaks: it alone made them.
COARSER_THAN_FRAGMENTS = "coarser_than_fragments"
NOT_COMPARED = (TOO_COARSE, CLOSED_ON_AXIS, COARSER_THAN_FRAGMENTS)
# Nothing that is stated of a value says how far off it is. It doubts no value, and stands where there is no error bar.
ERROR_UNKNOWN = "error_unknown"
BY_ONE_GRID = (MESH_DETERMINED, ERROR_UNKNOWN)  # flags that enough grids take away
# The body has lost the particles that a measurement reads, so that the run has no answer; a flag of the run, too.
LOST_PARTICLES = "lost_particles"
# The flags of any scenario and of impacts: each has the same bit in every cube, so that cubes can be joined.
COMMON_FLAGS = (
    *(TOO_COARSE, CLOSED_ON_AXIS, CLOSED_BY_FILM, STILL_COMING, STILL_ATTACHED, STILL_GROWING, WIDE_BAR),
    *(MESH_DETERMINED, COARSER_THAN_FRAGMENTS, ERROR_UNKNOWN, LOST_PARTICLES),
    *("not_perforated", "not_contained", "near_rim", "lip_at_window", "before_maximum"),
)

# Part of the uncertainty where the mesh error is known from experience: half-width of 95 % of what is left of it.
MESH = "mesh"
SUB_CELL = "resolution"  # part of an uncertainty: what a single run cannot see, and offsets show
OF_MESH = (SUB_CELL, MESH)  # parts that offsets and resolutions show themselves
# Part of an uncertainty that no mesh makes: half of the difference between two definitions of a quantity, where it has
# a second. It stands beside the numerical uncertainty, which is what converges and what tests of coverage are about.
DEFINITION = "definition"

# Share of the initial energy that a run may lose track of before it is marked, a verification case fails or a recipe is
# out: the first rule of docs/recipe.md. The sum is kept by construction, so that a drift is an error of bookkeeping.
ENERGY_DRIFT_LIMIT = 0.01


@dataclass(frozen=True)
class Measured:
    """A number read off the state of a run."""

    value: float | None  # None where the flags say why
    # Of the reading, standard: root of the sum of squares of the numerical parts; None: too coarse, or not known.
    uncertainty: float | None
    parts: Mapping[str, float]  # resolution, azimuth, growth; definition: same unit as the value
    flags: tuple[str, ...]
    history: Mapping[str, list[float | None]]  # time (s) and value
    version: int  # of the definition
    # Bias and scale of the mesh error, where experience told them when the run ended: for pages of single runs.
    mesh_error: Mapping[str, float] | None = None


# Where the name of a flag does not say what it is.
FLAG_WORDS = {"beyond_hugoniot": "compressed more than the Hugoniot was measured"}


def flags_in_words(flags: Iterable[str]) -> list[str]:
    """Flags as people read them.

    >>> flags_in_words(["still_growing"])
    ['still growing']
    """
    return [FLAG_WORDS.get(flag, flag.replace("_", " ")) for flag in flags]


def doubting_flags(outcome: float, flags: Iterable[str]) -> tuple[str, ...]:
    """The flags that leave an outcome of a run open, 1 or 0."""
    doubting = (TOO_COARSE, *(NOT_DECIDED if outcome == 0.0 else ()))
    return tuple(flag for flag in flags if flag in doubting)


def doubts_of(outcome: float, flags: Iterable[str]) -> str:
    """The same in words; empty without any."""
    return " and ".join(flags_in_words(doubting_flags(outcome, flags)))


def numerical_parts(parts: Mapping[str, float]) -> dict[str, float]:
    """The parts of an uncertainty that the numerics make: all but that of the definition."""
    return {name: size for name, size in parts.items() if name != DEFINITION}
