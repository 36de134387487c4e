"""Records that reports share: how laws do, measured shots, and what was not checked. Nothing heavy is imported."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Literal

from studies.laws import RangeStatus

Place = Mapping[str, float | str]  # axis -> value, SI
Reference = Literal["simulation", "observation"]
IN_RANGE = (RangeStatus.INSIDE, RangeStatus.FITTED)


class Outcome(StrEnum):
    """How a law does beside its reference, at a point or over several."""

    WITHIN = "within"  # inside the joint uncertainty
    LOW = "low"
    HIGH = "high"
    NOT_COMPARABLE = "not_comparable"


class Reason(StrEnum):
    """Why a law is not comparable."""

    OUTSIDE = "outside"  # of the range that its source states, everywhere
    OTHER_MATERIAL = "other_material"
    NO_ANSWER = "no_answer"
    FLAGGED = "flagged"  # or without a value: nothing to compare with
    FITTED = "fitted"  # a constant of the law is fitted to the shots
    NO_BAR = "no_bar"  # the mesh error, or the error of the shots, is unknown


@dataclass(frozen=True)
class PointJudgement:
    """A law at one point, in SI; None where there is no number."""

    at: Place
    law: float | None
    reference: float | None
    difference: float | None  # over the reference
    bar: float | None  # joint uncertainty over the reference; None where it is no test
    outcome: Outcome  # of nothing where there is no such bar
    status: RangeStatus  # how the law's answer stands to its range
    outside: str  # why it is outside the range of the law, or the law has no answer
    unjudged: str  # why the reference judges nothing: no value, or a flag
    hangs_on: tuple[str, ...]  # failures that alone decide whether the law agrees

    @property
    def state(self) -> Literal["judged", "outside", "unjudged"]:
        """Whether the law is compared here."""
        if self.status not in IN_RANGE:
            return "outside"
        return "unjudged" if self.unjudged else "judged"


@dataclass(frozen=True)
class StatedRange:
    """The range that the source of a law states; None where it states no such end."""

    is_stated: bool
    speeds: tuple[float | None, float | None] = (None, None)  # m s-1
    thickness_ratios: tuple[float | None, float | None] = (None, None)  # t/d


@dataclass(frozen=True)
class Judgement:
    """A law, or the simulation, beside one reference."""

    quantity: str
    law: str  # label, or "simulation"
    title: str  # with the variant
    name: str  # short
    reference: Reference
    range: StatedRange | None  # None of the simulation
    drawn_only: str  # why the law enters no headline; empty where it does
    points: tuple[PointJudgement, ...]
    of: int  # points
    in_range: int  # of these, inside its range
    compared: int  # points inside its range whose reference has a value without a flag
    tested: int  # of these, with an error bar that is a test
    within: int  # of these, with the difference inside the joint uncertainty
    # Of the points that are compared; without any of those in its range, else of all that have both numbers.
    smallest: float | None  # of the law's values, SI
    largest: float | None
    low: float | None  # smallest difference over the reference
    high: float | None
    bar: float | None  # largest joint uncertainty that is a test, over the reference
    outcome: Outcome
    reason: Reason | None  # of what is not comparable

    @property
    def worst(self) -> float:
        """The largest difference, without its sign; infinite without any."""
        return math.inf if self.low is None or self.high is None else max(-self.low, self.high)


class Doubt(StrEnum):
    """What is doubtful about a measured shot."""

    SECOND_HAND = "second_hand"  # nobody here read its source
    UNKNOWN_ALLOY = "unknown_alloy"
    OTHER_SIZE = "other_size"  # a number that is fixed in the sweep is another one, by up to a tenth


@dataclass(frozen=True)
class StatedShot:
    """A measured value of a quantity as its source states it, in SI."""

    quantity: str
    unit: str
    at: Place  # the parameters that it states
    value: float | None  # None of a range
    uncertainty: float | None
    lower: float | None  # of a range; None where it is open
    upper: float | None
    source: str
    confidence: str  # one of ``studies.materials.schema.CONFIDENCES``

    @property
    def ends(self) -> tuple[float, float]:
        """From where to where the measured value may be."""
        if self.value is not None:
            return self.value, self.value
        return self.lower or 0.0, math.inf if self.upper is None else self.upper


@dataclass(frozen=True)
class MeasuredShot(StatedShot):
    """A measured shot beside the nearest point of a sweep."""

    point: Place  # the axes of that point
    doubts: tuple[Doubt, ...]
    simulation: float | None  # between the points; None beyond the axes
    simulation_bar: float | None


class Where(StrEnum):
    """Where a shot lies among the runs of a sweep."""

    AMONG = "among"  # at a run or between runs, with or without a value there
    BEYOND_AXES = "beyond_axes"
    ELSEWHERE = "elsewhere"  # it is of another set-up than any run
    UNKNOWN = "unknown"  # it does not state an axis, or no run has its parameters


@dataclass(frozen=True)
class MatchedObservation(StatedShot):
    """A shot of a sweep's own table, with what the simulation gives for it."""

    observation: int  # row of the table
    diameter: float | None  # of the equivalent sphere, m
    simulation: float | None
    simulation_uncertainty: float | None  # between runs with the interpolation's part
    how: str  # how the simulation was brought to the shot's parameters, or why it could not be
    where: Where
    # Whether it has a value, and the materials and the shape of some run; no other shot judges anything of this sweep.
    is_alike: bool


class Code(StrEnum):
    """What was not checked."""

    DOUBTFUL_SHOTS = "doubtful_shots"
    MESH = "mesh"
    DEFINITION = "definition"
    MODELS = "models"
    OTHER_ALLOY = "other_alloy"
    DISTANT_MODELS = "distant_models"
    SCATTER = "scatter"
    FLAGGED = "flagged"
    RECALLED = "recalled"


@dataclass(frozen=True)
class Unchecked:
    """One thing that was not checked, of some quantities."""

    code: Code
    quantities: tuple[str, ...]
    count: int = 0  # points, or shots
    of: int = 0
    names: tuple[str, ...] = ()  # alloys, flags or laws
    factor: float = 1.0  # by which points are outside of where models were varied


@dataclass(frozen=True)
class Mixed:
    """A quantity that several versions of its definition measured: nothing is compared with it."""

    quantity: str
    versions: tuple[int, ...]
