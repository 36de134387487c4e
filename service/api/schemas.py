"""Response models: one for each record of ``service.records``, with the descriptions of the documentation.

Models are made from records of the store and of the studies; only links are added here.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any, Generic, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, JsonValue, field_validator
from pydantic_core import to_jsonable_python

from service.records.jobs import (
    PRIORITIES,
    Event,
    PointRow,
    QueueRow,
    RunRow,
    Stored,
    SweepState,
    SweepStatus,
    described,
)
from studies.quantities.files import ARCHIVE, SWEEP_FILES
from studies.quantities.parameters import Plain
from studies.sweeps import examples
from studies.sweeps.document import read_yaml

Listed = TypeVar("Listed")


class Answer(BaseModel):
    """Base of all response models."""

    model_config = ConfigDict(frozen=True)


class Items(Answer, Generic[Listed]):
    """A complete list."""

    items: list[Listed]

    @classmethod
    def model_parametrized_name(cls, params: tuple[Any, ...]) -> str:
        """Name of the schema in OpenAPI: ``SweepPage`` for ``PageOf[SweepModel]``."""
        return params[0].__name__.removesuffix("Model") + cls.__name__.removesuffix("Of")


class PageOf(Items[Listed], Generic[Listed]):
    """A page of a list."""

    next_cursor: str | None = Field(description="Value of `cursor` for the next page; null on the last page")


COMPONENTS = "#/components/schemas/"
REPORT = "Report"  # the component of report.json
REPORT_SCHEMA = {"$ref": f"{COMPONENTS}{REPORT}"}


@dataclass(frozen=True)
class SweepModel(SweepStatus):
    """A sweep: its state, progress and links."""

    links: Mapping[str, str]

    @classmethod
    def of(cls, row: SweepStatus, files: Iterable[str] | None = None) -> Self:
        """A sweep with its links; without ``files``, to those that its state implies."""
        if files is None:
            files = SWEEP_FILES if row.state is SweepState.SUCCEEDED else ()
        here = f"/v1/sweeps/{row.id}"
        action = "retry" if row.is_terminal else "cancel"
        files = [name for name in files if name in SWEEP_FILES]
        made = [ARCHIVE] if row.is_terminal else []
        names = ("runs", "events", "history", "document", "pin", action, *files, *made)
        return cls(**vars(row), links={"self": here, **{name: f"{here}/{name}" for name in names}})


@dataclass(frozen=True)
class AcceptedSweepModel(SweepModel):
    """A sweep that was accepted, and what is doubtful about it."""

    warnings: tuple[str, ...] = field(
        default=(), metadata=described("Doubts about points and constants that are allowed and hardly useful")
    )


class SweepChange(BaseModel):
    """The fields of a sweep that may be changed."""

    model_config = ConfigDict(
        strict=True, extra="forbid", frozen=True, json_schema_extra={"examples": [{"priority": -10}]}
    )

    priority: int = Field(
        ge=PRIORITIES[0], le=PRIORITIES[-1], description="Sweeps of smaller numbers are computed first"
    )


@dataclass(frozen=True)
class RunModel(RunRow):
    """A run: one simulation, its state and its measurements."""

    links: Mapping[str, str]

    @classmethod
    def of(cls, row: RunRow) -> "RunModel":
        here = f"/v1/runs/{row.id}"
        names = ("events", "history", "log", "files")
        return cls(**vars(row), links={"self": here, **{name: f"{here}/{name}" for name in names}})


@dataclass(frozen=True)
class RunQuestion(RunModel):
    """A run with its complete parameters: every default filled in, SI."""

    question: Mapping[str, JsonValue] = field(metadata=described("Scenario, parameters and materials"))


@dataclass(frozen=True)
class PointModel(PointRow):
    """A point of a sweep, and its run."""

    run: RunModel

    @classmethod
    def of(cls, row: PointRow) -> "PointModel":
        return cls(**{**vars(row), "run": RunModel.of(row.run)})


class FileModel(Answer):
    """A stored file."""

    name: str
    size: int = Field(description="Bytes")
    sha256: str
    href: str

    @classmethod
    def of(cls, run_id: str, file: Stored) -> "FileModel":
        href = f"/v1/runs/{run_id}/files/{file.name}"
        return cls(name=file.name, size=file.size, sha256=file.sha256, href=href)


@dataclass(frozen=True)
class EventModel(Event):
    """A change of state; events are permanent."""


class ProgressModel(Answer):
    """The progress of a running run."""

    run_id: str
    attempt: int
    fraction: float | None = Field(description="0 to 1")
    seconds: float | None = Field(description="Duration of this attempt so far")
    time: float | None = Field(description="Simulated time in seconds")
    end_time: float | None = Field(description="Latest simulated time at which the run ends")
    step: int | None
    eta_seconds: float | None = Field(description="Estimated time left in seconds")
    measured: dict[str, float | None] = Field(description="Measured values so far, SI")

    @classmethod
    def of(cls, row: RunRow) -> "ProgressModel | None":
        """The progress of a run; None before its first report."""
        if row.progress is None:
            return None
        names = ("time", "end_time", "step", "eta_seconds")
        return cls(
            run_id=row.id,
            attempt=row.attempt,
            fraction=row.fraction,
            seconds=row.seconds,
            measured=row.progress.get("measured") or {},
            **{name: row.progress.get(name) for name in names},
        )


class QueueModel(Answer):
    """The queue as a whole."""

    paused: datetime | None = Field(description="Start of the pause; null: not paused")
    blocked_reason: str | None = Field(description="Why no run starts although runs are queued")
    deletion_paused: str | None = Field(description="Why nothing is deleted by age: the clock has jumped")
    counts: dict[str, int] = Field(description="Runs and publications by state, but for those that succeeded")
    oldest_queued: datetime | None = Field(description="When the longest waiting run was queued")
    leader: str | None = Field(description="Process that assigns the work; null: no process leads")
    links: dict[str, str]

    @classmethod
    def of(cls, row: QueueRow, blocked_reason: str | None = None) -> "QueueModel":
        """The queue with its links, and the reason of this service why nothing begins."""
        here = "/v1/queue"
        action = "pause" if row.paused is None else "resume"
        return cls(
            paused=row.paused,
            blocked_reason=blocked_reason or row.blocked_reason,
            deletion_paused=row.deletion_paused,
            counts={state.value: count for state, count in row.states.items()},
            oldest_queued=row.oldest_queued,
            leader=row.leader,
            links={"self": here, action: f"{here}/{action}", "events": f"{here}/events"},
        )


class ParameterModel(Answer):
    """A parameter of a scenario."""

    name: str
    kind: str = Field(description="quantity, integer, boolean, text, choice or material")
    unit: str | None = Field(description="SI symbol; a quantity is given with a unit")
    meaning: str
    minimum: float | None = Field(description="SI, inclusive")
    maximum: float | None = Field(description="SI, inclusive")
    choices: tuple[str, ...]
    longest: int = Field(description="Characters of a text")
    optional: bool = Field(description="Whether null is allowed")
    required: bool = Field(description="Whether a value must be given")
    default: float | int | bool | str | None = Field(description="SI")
    limit: str = Field(description="Description of the allowed values")


class ScenarioModel(Answer):
    """A physical set-up, with its parameters."""

    name: str
    title: str
    description: str
    materials: tuple[str, ...] = Field(description="Parameters that name a material")
    measurements: tuple[str, ...] = Field(description="Measured variables of the cube")
    parameters: list[ParameterModel]


class LimitModel(Answer):
    """A limit of a law's range."""

    words: str
    code: str
    symbol: str = Field(description="Of a number between bounds")
    low: float | None
    high: float | None
    unit: str = Field(description="SI symbol")
    names: tuple[str, ...] = Field(description="Families or materials")
    source: str
    machine_checked: bool = Field(description="Whether a shot is checked against it, or the reader is told alone")


class LawModel(Answer):
    """A law."""

    name: str
    title: str
    quantity: str
    equation: str
    latex: str
    source: str
    confidence: str
    use: str = Field(description="`verdict`, or `drawn only` with the reason")
    scatter: float | None = Field(description="Relative standard deviation of measured values about it, as published")
    size_exponent: float | None = Field(description="Of the value as a power of the size of the whole shot")
    largest_obliquity: float = Field(description="Radian; 0: for normal impact")
    range: list[LimitModel]


class CatalogueModel(Answer):
    """Entries that ship with the service, each as its own file describes it."""

    items: list[dict[str, JsonValue]]

    @field_validator("items", mode="before")
    @classmethod
    def _as_json(cls, items: Iterable[Mapping[str, JsonValue]]) -> list[dict[str, JsonValue]]:
        """Records have tuples, which are lists in JSON."""
        listed: list[dict[str, JsonValue]] = to_jsonable_python(items)
        return listed


class Health(Answer):
    """The service responds."""

    status: str


class Readiness(Answer):
    """The service can compute."""

    status: str
    checks: dict[str, str] = Field(description="Outcome of each check")


class VersionModel(Answer):
    """Versions of the service."""

    version: str
    physics_version: int = Field(description="Version of the physics; results of different versions stay separate")
    python: str


def example_sweeps() -> dict[str, Plain]:
    """The sweeps that ship, as named examples of OpenAPI."""
    documents = {name: read_yaml(examples.text(name), name) for name in examples.names()}
    return {name: {"summary": document["title"], "value": document} for name, document in documents.items()}
