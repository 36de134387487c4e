"""Scenarios: a physical set-up with parameters, made into a ``Problem`` for the solver.

How to add one: a module here that offers a ``Scenario`` as ``SCENARIO``; modules whose name starts with an underscore
are shared by several. Its parameters are a frozen dataclass: annotations give units, meaning and bounds
(``Described``), and so the API, the checks at the door, the cube and the documentation follow. Nothing here is heavy to
import: ``build`` alone reaches for the solver, in the process that runs it. The contract tests build it at its
corners, weigh its bodies and audit ten steps; give it small parameters there.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from solver.registry import entries
from studies.values.errors import Finding
from studies.values.nearest import nearest_cure
from studies.values.parameters import declared, describe
from studies.values.quantities import refusal

if TYPE_CHECKING:
    from solver.problem import Problem
    from studies.films.section import SectionOptions
    from studies.materials import Material

Materials = Mapping[str, "Material"]  # by the name of the parameter that names it: "target"


OBSERVATIONS_PER_WINDOW = 5  # observations in the time over which growth is judged


@dataclass(frozen=True)
class Size:
    """Expected work of a run."""

    particles: int
    steps: int


@dataclass(frozen=True)
class Setting:
    """A problem; each family of scenarios adds what its view of a state needs to know."""

    problem: "Problem"
    sector: float  # angle that the model covers about its axis, rad; 1 in axisymmetry, where all is per radian


@dataclass(frozen=True)
class ImpactSetting(Setting):
    """An impact as its observer needs to know it."""

    target: str  # name of the body that is measured
    projectile_diameter: float  # m
    thickness: float  # of the target along the line of flight, m
    radius: float  # of the target, m: half its width where it is square
    speed: float  # of the projectile, m/s


@dataclass(frozen=True)
class Melting:
    """Constants with which the residual energy of matter says how much of it is molten at no pressure."""

    heat_capacity: float  # J/(kg K)
    room_temperature: float  # K
    melt_temperature: float  # K
    latent_heat: float  # J/kg


@dataclass(frozen=True)
class CloudSetting(ImpactSetting):
    """An impact whose debris is measured."""

    melting: tuple[Melting | str, ...]  # of each body, or the flag that says why it has none


@dataclass(frozen=True)
class ObservationRate:
    """Rate at which a run is observed, and the growth below which it counts as settled."""

    interval: float  # s between observations
    window: float = math.inf  # s over which growth is judged; without one, it is not
    growth: float = 0.0  # relative, within a window, below which a measurement has settled
    early: bool = False  # whether the run ends once all that must settle has settled

    @staticmethod
    def settling(parameters: Any, window: float) -> "ObservationRate":
        """Several observations in a window (s) over which growth is judged, as ``settled_growth`` and ``stop`` say."""
        return ObservationRate(
            interval=window / OBSERVATIONS_PER_WINDOW,
            window=window,
            growth=parameters.settled_growth,
            early=parameters.stop == "settled",
        )


def _no_numbers(view: Any) -> dict[str, float]:
    return {}


def _end_alone(parameters: Any, setting: Any) -> "SectionOptions":
    from studies.films.section import SectionOptions

    return SectionOptions()


def _no_parts(parameters: Any, name: str) -> dict[str, float]:
    return {}


@dataclass(frozen=True)
class ObserverOptions:
    """Observer's options for the runs of a family of scenarios."""

    rate: Callable[[Any, Setting], ObservationRate]  # of the parameters and the built setting
    view: Callable[[Any, Any], Any]  # of a Setting and a Snapshot in it, for measurements
    numbers: Callable[[Any], dict[str, float]] = _no_numbers  # that a last view says of its run
    # Of the parameters and the built setting: the times at which sections are kept, beside the end.
    sections: Callable[[Any, Any], "SectionOptions"] = _end_alone
    # Parts of the uncertainty of a measurement, relative, that parameters tell and no state shows.
    parts: Callable[[Any, str], Mapping[str, float]] = _no_parts
    least_cells: Mapping[str, float] = field(default_factory=dict)  # below: "under_resolved"
    fewest_cells: Mapping[str, float] = field(default_factory=dict)  # below: "too_coarse"

    def too_coarse(self, cells: Mapping[str, float]) -> bool:
        """True for a grid so coarse that the error of its measurements is unknown."""
        return any(cells[name] < fewest for name, fewest in self.fewest_cells.items())

    def all_parts(self, parameters: Any, name: str, value: float, parts: Mapping[str, float]) -> dict[str, float]:
        """The parts of the uncertainty of a value: those of its reading, and those that the parameters tell."""
        told = self.parts(parameters, name)
        return {**parts, **{part: share * abs(value) for part, share in told.items()}}


@dataclass(frozen=True)
class Shape:
    """The outline of a body before a run: a box or a disc in the plane through the axis, m."""

    body: str  # the parameter that names its material; "wall" of what has none
    left: float
    right: float
    top: float  # along the line of flight, towards which the projectile flies
    bottom: float
    is_disc: bool = False
    heading: tuple[float, float] | None = None  # direction of its flight, across and along


@dataclass(frozen=True)
class Dimension:
    """A length of the set-up with its two ends (across, along), m."""

    parameter: str
    begin: tuple[float, float]
    end: tuple[float, float]


@dataclass(frozen=True)
class Outline:
    """The set-up before a run, to scale, in the plane through the axis."""

    shapes: tuple[Shape, ...]
    dimensions: tuple[Dimension, ...]


def _no_outline(values: Mapping[str, Any]) -> None:
    return None


@dataclass(frozen=True)
class Scenario:
    """A physical set-up: its parameters, what is measured on it, and how it becomes a problem."""

    name: str
    title: str
    description: str
    parameters: type  # frozen dataclass, keyword-only
    materials: tuple[str, ...]  # parameters that name a material
    measurements: tuple[str, ...]  # quantities read off its runs
    settles: tuple[str, ...]  # the measurements that should have stopped growing at the end
    fill: Callable[[Any], Any]  # the same parameters with the defaults that follow from others
    check: Callable[[Any, Materials], list[Finding]]  # of several fields together
    build: Callable[[Any, Materials], Setting]
    estimate: Callable[[Any, Materials], Size]
    cells: Callable[[Any], dict[str, float]]  # across the diameter, through the thickness
    observer: ObserverOptions
    # Paths of constants of materials that its measurements read, and no simulation: they are part of a run's identity.
    measured_with: tuple[str, ...] = ()
    # Of its parameters those that its runs do not use: they are no part of a run's identity.
    unused: tuple[str, ...] = ()
    distributions: tuple[str, ...] = ()  # read off the final state of its runs
    # Of the parameters of a run by name; None without those that it needs.
    outline: Callable[[Mapping[str, Any]], Outline | None] = _no_outline

    def describe(self) -> dict[str, Any]:
        """The scenario as plain values, for a catalogue."""
        return {
            "name": self.name,
            "title": self.title,
            "description": self.description,
            "materials": self.materials,
            "measurements": self.measurements,
            "parameters": describe(declared(self.parameters).values()),
        }


def names() -> list[str]:
    """All scenarios, sorted."""
    return list(entries(__name__, "SCENARIO"))


def load(name: object) -> Scenario:
    """The scenario of a name; raises InvalidInput with the nearest one."""
    members: Mapping[str, Scenario] = entries(__name__, "SCENARIO")
    if not isinstance(name, str) or name not in members:
        raise refusal("scenario", name, "one of " + ", ".join(members), nearest_cure(name, members))
    return members[name]
