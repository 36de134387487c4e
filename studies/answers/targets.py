"""What answers need of each target: its parameters, what laws predict of it, and what it adds to them.

How to add one: an ``AnsweredTarget``, of the name of a target of laws (``studies.laws.targets``), through the
entry-point group ``whipple.studies.answers.targets``. Nothing heavy is imported where it stands.
"""

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Self, TypeAlias

from solver.registry import entries
from studies.laws import Shot, shot_from, target_of
from studies.laws.targets import Stated
from studies.materials import Material
from studies.quantities.findings import Finding
from studies.quantities.parameters import Parameter, Plain, declared, grouped, lists_of, missing
from studies.reports.figure import Figure

if TYPE_CHECKING:
    import numpy as np

# Dimensions, values and attributes.
Variable: TypeAlias = "tuple[tuple[str, ...] | str, np.ndarray | Sequence[Plain], Mapping[str, str | np.ndarray]]"
Variables = Mapping[str, Variable]


@dataclass(frozen=True)
class Told:
    """An addition as people read it: lines, and a table."""

    lines: tuple[str, ...]
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Addition(ABC):
    """What a target says of a shot besides its laws; its fields stand in the document."""

    @property
    @abstractmethod
    def sentence(self) -> str:
        """The headline, in at most twenty words."""

    @property
    @abstractmethod
    def told(self) -> Told:
        """The headline first."""

    @classmethod
    @abstractmethod
    def of(cls, shot: Shot) -> Self:
        """What is said of a shot."""

    @staticmethod
    @abstractmethod
    def variables(
        additions: "Sequence[Addition]", axes: tuple[str, ...], shape: tuple[int, ...]
    ) -> tuple[Variables, Variables]:
        """Coordinates and variables over axes, of what is said of each shot, the last axis fastest."""


@dataclass(frozen=True, kw_only=True)
class AnsweredTarget:
    """A target with what laws predict of it; a feature overrides what it adds."""

    name: str
    quantities: tuple[str, ...]
    drawn: tuple[str, str] = ("", "")  # the quantity of its picture, and the symbol of it over the diameter
    table: tuple[str, str] | None = None  # of published shots, and their scenario
    parameters: type | None = None  # a record of parameters of its own
    own: tuple[str, ...] = ()  # those of every shot that tell it from others, where it has no record
    roles: tuple[str, ...] = ("projectile", "target")  # parameters that name a material
    example: Path | None = None  # a question that ships
    adds: str = ""  # the record of its additions, "module:name": nothing is imported here
    untold: tuple[str, ...] = ()  # quantities that its page tells without the laws' table
    # Templates of a page: beside its first line, behind its picture, and before the sources.
    templates: Mapping[str, str] = field(default_factory=dict)

    @property
    def stated(self) -> tuple[str, ...]:
        """The parameters that a document has of it besides those of every shot."""
        if not self.parameters:
            return self.own
        return (*grouped(self.parameters)[""], *lists_of(self.parameters))

    def missing(self, document: Mapping[str, Plain], parameters: Mapping[str, Parameter]) -> Iterator[Finding]:
        """A finding for each parameter that the target needs, or that contradicts it."""
        if document.get("target") is None:
            yield missing(parameters["target"])

    def shot(self, stated: Stated, materials: Mapping[str, Material]) -> Shot:
        """The shot of stated parameters and materials by name; raises InvalidInput."""
        return shot_from(stated, {role: materials[str(stated[role])] for role in self.roles if role in stated})

    @property
    def addition(self) -> type[Addition] | None:
        """The record of what it says of a shot besides the laws."""
        record: type[Addition] | None = resolve_name(self.adds) if self.adds else None
        return record

    def picture(self, shot: Shot) -> Figure | None:
        """A picture of its own; None for that of its laws over the speed."""
        return None

    def sizes(self, shot: Shot) -> Sequence[tuple[str, float]]:
        """Sizes of a shot at it besides the plate's thickness: a word or none, and m."""
        return ()


@cache
def targets() -> Mapping[str, AnsweredTarget]:
    """All targets by name."""
    known: Mapping[str, AnsweredTarget] = entries(__name__, "TARGET")
    return known


def meant(stated: Collection[str]) -> AnsweredTarget:
    """The target that parameters of a question mean, complete or not."""
    with_own = ((target, target.parameters) for target in targets().values() if target.parameters)
    own = (target for target, record in with_own if {*declared(record)} & {*stated})
    return next(own, targets()[target_of(stated).name])


TARGET = (
    AnsweredTarget(
        name="plate",
        own=("target", "plate_thickness"),
        quantities=(
            *("hole_diameter", "plate_critical_diameter", "perforation_thickness", "detached_spall_thickness"),
            "spall_thickness",
        ),
        drawn=("hole_diameter", "D/d"),
        table=("holes", "thin_plate"),
    ),
    AnsweredTarget(
        name="block",
        own=("target",),
        quantities=("crater_depth", "crater_diameter", "crater_volume", "perforation_thickness", "spall_thickness"),
        drawn=("crater_depth", "p/d"),
        table=("craters", "thick_plate"),
    ),
)
