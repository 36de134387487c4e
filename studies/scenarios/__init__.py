"""Scenarios: a physical set-up with parameters, made into a ``Problem`` for the solver.

How to add one: a module here that offers a ``Scenario`` as ``SCENARIO``. Its parameters are a ``SetUp``, a frozen
dataclass: annotations give units, meaning and bounds (``Described``), and so the API, the checks at the door, the cube
and the documentation follow. Parameters that several scenarios share are a record of ``parts/``, which each of them
holds in a field. NumPy and the solver, which compiles for seconds, are imported by the functions that build a problem.
The contract tests build it at its corners and audit ten steps; give it small parameters there.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from typing import TYPE_CHECKING, ClassVar, Generic, Self, TypeVar

from solver.registry import entries
from studies.convergence.experience import MeshGrid
from studies.measurements._settings import Setting
from studies.quantities.findings import Doubt, Finding, nearest_cure, refusal
from studies.quantities.parameters import Plain, Value, declared, describe, flat, nested
from studies.scenarios.parts.outline import Outline

if TYPE_CHECKING:
    from solver.simulation import Outcome
    from solver.state import Snapshot
    from studies.materials import Material
    from studies.sections.section import SectionOptions

Materials = Mapping[str, "Material"]  # by the name of the parameter that names it: "target"

ROUND_OFF = 1e-9  # relative: a default that follows from a rounded parameter differs by less
OBSERVATIONS_PER_WINDOW = 5  # observations in the time over which growth is judged


@dataclass(frozen=True)
class Size:
    """Expected work of a run."""

    particles: int
    steps: int


@dataclass(frozen=True)
class ObservationRate:
    """Rate at which a run is observed, and the growth below which it counts as settled."""

    interval: float  # s between observations
    window: float = math.inf  # s over which growth is judged; without one, it is not
    growth: float = 0.0  # relative, within a window, below which a measurement has settled
    early: bool = False  # whether the run ends once all that must settle has settled
    decided: bool = False  # whether it ends as well once an outcome has been 1 for a window

    @staticmethod
    def settling(window: float, *, growth: float, stop: str) -> "ObservationRate":
        """Several observations in a window (s) over which growth is judged; ``stop`` says when a run ends."""
        interval = window / OBSERVATIONS_PER_WINDOW
        return ObservationRate(interval, window, growth, early=stop != "end_time", decided=stop == "decided")


StageSetting = TypeVar("StageSetting", bound=Setting)
View = TypeVar("View")


class SetUp(ABC, Generic[StageSetting, View]):
    """Parameters of a scenario, and what follows from them; every method but ``filled`` needs filled parameters."""

    # The measurements whose mesh error is known from experience, each with the quantity of the ensemble.
    experienced: ClassVar[Mapping[str, str]] = {}

    @abstractmethod
    def filled(self, materials: Materials) -> Self:
        """The same with the defaults that follow from others, at 12 digits; what does not act is None."""

    @abstractmethod
    def check(self, materials: Materials) -> list[Finding]:
        """Findings of several parameters together."""

    @staticmethod
    def lacking(values: Mapping[str, Value]) -> Collection[str]:
        """The parameters that name the material of a body that a run with these values does not have."""
        return ()

    @staticmethod
    def doubts(values: Mapping[str, Value]) -> Iterator[Doubt]:
        """The doubts about constants in a text among the values, such as a deck."""
        yield from ()

    @abstractmethod
    def build(self, materials: Materials) -> Setting:
        """The problem, and what its observer needs to know."""

    @abstractmethod
    def size(self, materials: Materials) -> Size:
        """Particles and steps, about."""

    @abstractmethod
    def cells(self) -> dict[str, float]:
        """Cells across the diameter and through the thickness."""

    @abstractmethod
    def rate(self, setting: StageSetting) -> ObservationRate:
        """How often the built problem is observed."""

    @staticmethod
    @abstractmethod
    def view(setting: StageSetting, snapshot: "Snapshot") -> View:
        """A state as the measurements see it; the module that makes it loads the solver."""

    @staticmethod
    def numbers(view: View) -> dict[str, float]:
        """Numbers of a run that its last view tells."""
        return {}

    @property
    def stages(self) -> int:
        """Problems that are computed one after another."""
        return 1

    def next_stage(self, setting: StageSetting, outcome: "Outcome", materials: Materials) -> StageSetting | None:
        """The problem that follows a stage, the same bits from the same arguments; None after the last stage."""
        return None

    def sections(self, setting: StageSetting) -> "SectionOptions":
        """The times at which sections are kept, beside the end."""
        from studies.sections.section import SectionOptions

        return SectionOptions()

    def uncertainty_parts(self, measurement: str) -> Mapping[str, float]:
        """Parts of the relative uncertainty of a measurement that follow from the parameters alone."""
        return {}

    def mesh_grids(self, materials: Materials) -> dict[str, MeshGrid]:
        """The grid that the mesh error of a measurement depends on, for those of which it is known from experience."""
        return {}

    def has_defaults(self, materials: Materials, but_for: Collection[str]) -> bool:
        """Whether all parameters, but for some, have the values that they get where they are left out."""
        values = flat(self)
        given = {name: values[name] for name in but_for if name in values}
        filled = flat(nested(type(self), given).filled(materials))
        return all(_is_same(value, filled[name]) for name, value in values.items())

    @staticmethod
    def outline(values: Mapping[str, Plain]) -> Outline | None:
        """The set-up before a run; None where a parameter that it needs is missing."""
        return None


@dataclass(frozen=True)
class Scenario:
    """A physical set-up: its parameters, and what is measured on it."""

    name: str
    title: str
    description: str
    parameters: type[SetUp]
    materials: tuple[str, ...]  # parameters that name a material; of a body that a run may lack, where they act
    measurements: tuple[str, ...]  # quantities read off its runs
    # Those at the root of a cube; where none is named, the first that are no other reading of one.
    first: tuple[str, ...] = ()
    # Measurements of a body that a run may lack, each with the parameter that names the body's material.
    of_role: Mapping[str, str] = field(default_factory=dict)
    # Measurements that a run has where it states some parameters, each with these parameters.
    asked_by: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    settles: tuple[str, ...] = ()  # the measurements that should have stopped growing at the end
    accurate: tuple[str, ...] = ()  # the measurements whose mesh error an accuracy is about
    distributions: tuple[str, ...] = ()  # read off the final state of its runs
    least_cells: Mapping[str, float] = field(default_factory=dict)  # below: "under_resolved"
    fewest_cells: Mapping[str, float] = field(default_factory=dict)  # below: "too_coarse"
    question: str = ""  # what people ask who want it
    place: int = 100  # among the questions

    @property
    def drawing(self) -> str:
        """A small drawing of it (SVG without colours): the file of its name beside its parameters; empty for none."""
        package, _, _ = self.parameters.__module__.rpartition(".")
        file = files(package).joinpath(f"{self.name}.svg")
        return file.read_text(encoding="utf-8") if file.is_file() else ""

    def record(self, values: Mapping[str, Value]) -> SetUp:
        """The parameters of values by name (SI)."""
        return nested(self.parameters, values)

    def roles(self, values: Mapping[str, Value]) -> tuple[str, ...]:
        """The parameters that name a material of a run with these values by name, defaults filled in."""
        lacking = self.parameters.lacking(values)
        return tuple(name for name in self.materials if name not in lacking)

    def measured(self, roles: Collection[str]) -> tuple[str, ...]:
        """The measurements of a run, or of a sweep, that has these roles."""
        return tuple(name for name in self.measurements if name not in self.of_role or self.of_role[name] in roles)

    def measured_in(self, values: Mapping[str, Value]) -> tuple[str, ...]:
        """The measurements of a run with these values by name, defaults filled in."""
        stated = [name for name, value in values.items() if value is not None]
        return tuple(name for name in self.measured(self.roles(values)) if self.is_asked(name, stated))

    def is_asked(self, measurement: str, stated: Collection[str]) -> bool:
        """Whether a measurement is asked for where these parameters are stated."""
        return {*self.asked_by.get(measurement, ())} <= {*stated}

    def too_coarse(self, cells: Mapping[str, float]) -> bool:
        """True for a grid so coarse that the error of its measurements is unknown."""
        return any(cells[name] < fewest for name, fewest in self.fewest_cells.items())

    def describe(self) -> dict[str, Plain]:
        """The scenario as plain values, for a catalogue."""
        return {
            "name": self.name,
            "title": self.title,
            "description": self.description,
            "materials": self.materials,
            "measurements": self.measurements,
            "parameters": describe(declared(self.parameters).values()),
        }


def _is_same(value: Value, other: Value) -> bool:
    """Whether two values are equal, numbers but for what follows from rounded ones."""
    if isinstance(value, float) and isinstance(other, float):
        return math.isclose(value, other, rel_tol=ROUND_OFF)
    return bool(value == other)


def names() -> list[str]:
    """All scenarios, sorted."""
    return list(entries(__name__, "SCENARIO"))


def load(name: object) -> Scenario:
    """The scenario of a name; raises InvalidInput with the nearest one."""
    members: Mapping[str, Scenario] = entries(__name__, "SCENARIO")
    if not isinstance(name, str) or name not in members:
        raise refusal("scenario", name, "one of " + ", ".join(members), nearest_cure(name, members))
    return members[name]
