"""What the interface answers: one model for each record, with the words of the documentation.

Models are made from the records of ``jobs.py`` and of the studies; nothing is computed here but links.
"""

from collections.abc import Iterable
from datetime import datetime
from typing import Any

from pydantic import BaseModel, ConfigDict, Field
from pydantic.json_schema import models_json_schema

from service.records.jobs import (
    Keep,
    Page,
    PointRow,
    RunRow,
    State,
    Stored,
    SweepState,
    SweepStatus,
)
from studies import examples
from studies.sweeps.cost import PresetCost
from studies.sweeps.document import read_yaml
from studies.values.files import CUBE, REPORT_HTML, REPORT_JSON

FILES = {
    CUBE: "application/x-netcdf",
    REPORT_HTML: "text/html; charset=utf-8",
    REPORT_JSON: "application/json",
}


class Answer(BaseModel):
    """Anything that is answered."""

    model_config = ConfigDict(frozen=True)


class ErrorItem(Answer):
    """One thing wrong with an input."""

    field: str = Field(description="dotted path into the document", examples=["axes.speed[2]"])
    value: str = Field(description="what was given, shortened")
    limit: str = Field(description="what is allowed")
    cure: str = Field(description="what to do")
    pointer: str = Field(description="JSON pointer (RFC 6901) to the place in what was sent")


class ProblemDocument(Answer):
    """An error (RFC 9457)."""

    type: str = Field(
        description="which kind of problem; stable", examples=["/docs#problem-not-found"]
    )
    title: str
    status: int
    detail: str
    instance: str = Field(description="the path that was asked for")
    request_id: str | None = Field(description="look for it in the log of the service")
    errors: list[ErrorItem] | None = Field(
        None, description="the first findings, for refused input"
    )
    more_errors: int | None = Field(
        None, description="findings that are not in `errors`; 200 in all end the reading"
    )


class SweepModel(Answer):
    """A sweep: what was asked for, and how far it is."""

    id: str
    name: str
    title: str
    scenario: str
    owner: str = Field(description="name of the API key it was submitted with; empty: without one")
    priority: int = Field(description="smaller is sooner, -100 to 100")
    keep: Keep = Field(description="what is kept of each run beside its numbers")
    state: SweepState
    reason: str | None = Field(description="why cube and report could not be made")
    planned: int = Field(description="runs of the sweep: points times resolutions and offsets")
    reused: int = Field(description="of these, computed before or already under way when accepted")
    new: int = Field(description="of these, queued for this sweep")
    counts: dict[str, int] = Field(description="points by state")
    progress: float = Field(
        description="0 to 1: computed part of the estimated cost; below 1 where runs were cancelled"
    )
    eta_seconds: float | None = Field(description="time left, in seconds; null: nothing to go by")
    created: datetime
    cancelled: datetime | None
    finished: datetime | None
    links: dict[str, str]

    @classmethod
    def of(cls, row: SweepStatus, files: Iterable[str] | None = None) -> "SweepModel":
        """A row with its links; without ``files``, those that its state promises."""
        return cls(
            **vars(row), links=links_of(row, promised_files(row) if files is None else files)
        )


class SweepPage(Answer):
    """A page of sweeps, the youngest first."""

    items: list[SweepModel]
    next_cursor: str | None = Field(description="give it back as `cursor`; null: the last page")

    @classmethod
    def of(cls, page: Page[SweepStatus]) -> "SweepPage":
        """A page of the store."""
        items = [SweepModel.of(row) for row in page.items]
        return cls(items=items, next_cursor=page.next_cursor)


class RunModel(Answer):
    """A run: one simulation, its state and what it measured."""

    id: str = Field(description="digest of the question: the same question has the same id")
    scenario: str
    state: State
    attempt: int = Field(description="attempts begun")
    crashes: int = Field(description="attempts whose process died at the same checkpoint")
    priority: int = Field(description="of the most urgent sweep that waits for it")
    keep: Keep = Field(description="the most that any sweep asked for")
    checkpoint: int | None = Field(description="step of the last one; a next attempt begins there")
    fraction: float | None = Field(description="0 to 1, of the running attempt")
    progress: dict[str, Any] | None = Field(description="simulated time, step, value so far")
    cause: str | None = Field(description="why it failed: the solver's verdict, or an accident")
    failure: str | None = Field(description="short kind of the failure")
    reason: str | None = Field(description="the failure in words")
    summary: dict[str, Any] | None = Field(description="measurements, flags and audit")
    sha256: str | None = Field(description="digest of the result file")
    cost: float = Field(description="estimated core seconds")
    seconds: float | None = Field(description="measured seconds of the attempt that counts")
    created: datetime
    started: datetime | None
    finished: datetime | None
    links: dict[str, str]

    @classmethod
    def of(cls, row: RunRow) -> "RunModel":
        """A row with its links."""
        here = f"/v1/runs/{row.id}"
        names = ("events", "history", "log", "files")
        links = {"self": here, **{name: f"{here}/{name}" for name in names}}
        return cls(**vars(row), links=links)


class RunQuestion(RunModel):
    """A run with its question, complete: every default filled in, SI."""

    question: dict[str, Any] = Field(description="scenario, parameters and materials")


class PointModel(Answer):
    """A point of a sweep, and its run."""

    ordinal: int = Field(description="place in the sweep's own order")
    index: tuple[int, ...] = Field(
        description="place on each axis, and among several resolutions and offsets"
    )
    coordinates: dict[str, float | str] = Field(description="value on each of these, SI")
    state: State = Field(description="the run's; `cancelled` if this sweep no longer waits for it")
    run: RunModel

    @classmethod
    def of(cls, row: PointRow) -> "PointModel":
        """A row of the store."""
        return cls(**{**vars(row), "run": RunModel.of(row.run)})


class PointPage(Answer):
    """A page of the points of a sweep, in its own order."""

    items: list[PointModel]
    next_cursor: str | None = Field(description="give it back as `cursor`; null: the last page")

    @classmethod
    def of(cls, page: Page[PointRow]) -> "PointPage":
        """A page of the store."""
        return cls(items=[PointModel.of(row) for row in page.items], next_cursor=page.next_cursor)


class FileModel(Answer):
    """A file that is kept."""

    name: str
    size: int = Field(description="bytes")
    sha256: str
    href: str


class FileList(Answer):
    """The files of a run."""

    items: list[FileModel]

    @classmethod
    def of(cls, run_id: str, files: Iterable[Stored]) -> "FileList":
        """Rows of the store with their addresses."""
        here = f"/v1/runs/{run_id}/files"
        items = [
            FileModel(name=one.name, size=one.size, sha256=one.sha256, href=f"{here}/{one.name}")
            for one in files
        ]
        return cls(items=items)


class PresetModel(Answer):
    """The same sweep at the accuracy of a preset: write `accuracy: name` for `resolution`."""

    name: str
    meaning: str
    resolutions: tuple[float, ...] = Field(description="cells across the projectile's diameter")
    offsets: int = Field(description="sub-cell positions of the grid at each resolution")
    runs: int = Field(description="points of the sweep, times resolutions and offsets")
    core_seconds: float | None = Field(description="of all of them; null: see reason")
    bytes: int | None = Field(description="that their results would take")
    reason: str = Field(description="why it is not offered for this sweep; else empty")

    @classmethod
    def of(cls, preset: PresetCost, pace: float) -> "PresetModel":
        """A preset, its time at the measured pace of this service."""
        known = {name: value for name, value in vars(preset).items() if name != "cost"}
        cost = preset.cost
        return cls(
            **known,
            core_seconds=None if cost is None else cost.core_seconds * pace,
            bytes=None if cost is None else cost.bytes,
        )


class EstimateModel(Answer):
    """What a sweep would cost; nothing was stored."""

    runs: int = Field(description="points of the sweep, times resolutions and offsets")
    reused: int = Field(description="different runs that are computed or under way already")
    core_seconds: float = Field(description="of the runs that are not there yet")
    seconds: float = Field(description="the same on the workers of this service")
    bytes: int = Field(description="that their results would take")
    is_measured: bool = Field(description="whether times are those measured here for this scenario")
    presets: list[PresetModel] = Field(description="the same at each accuracy that is offered")


class ParameterModel(Answer):
    """A parameter that a person may set."""

    name: str
    kind: str = Field(description="quantity, integer, boolean, text, choice or material")
    unit: str | None = Field(description="SI symbol; a quantity is given with a unit")
    meaning: str
    minimum: float | None = Field(description="SI, inclusive")
    maximum: float | None = Field(description="SI, inclusive")
    choices: tuple[str, ...]
    optional: bool = Field(description="null is an answer")
    required: bool = Field(description="there is no default")
    default: float | int | bool | str | None = Field(description="SI")
    limit: str = Field(description="what is allowed, in words")


class ScenarioModel(Answer):
    """A physical set-up, with its parameters."""

    name: str
    title: str
    description: str
    materials: tuple[str, ...] = Field(description="parameters that hold a material's name")
    measurements: tuple[str, ...] = Field(description="what is measured: variables of the cube")
    parameters: list[ParameterModel]


class CatalogueModel(Answer):
    """Things that ship, each as its own file describes it."""

    items: list[dict[str, Any]]


class ScenarioCatalogue(Answer):
    """Every scenario."""

    items: list[ScenarioModel]


class Health(Answer):
    """The service answers."""

    status: str


class Readiness(Answer):
    """The service can do its work."""

    status: str
    checks: dict[str, str] = Field(description="what was looked at, and what was seen")


class VersionModel(Answer):
    """What is running."""

    version: str
    physics_version: int = Field(description="results of different physics are never mixed")
    python: str


def example_sweeps() -> dict[str, dict[str, Any]]:
    """The sweeps that ship, as named examples of OpenAPI."""
    documents = {name: read_yaml(examples.text(name), name) for name in examples.names()}
    return {
        name: {"summary": document["title"], "value": document}
        for name, document in documents.items()
    }


def problem_schemas() -> dict[str, Any]:
    """The schemas of a problem document, for the components of OpenAPI."""
    place = "#/components/schemas/{model}"
    return models_json_schema([(ProblemDocument, "serialization")], ref_template=place)[1]["$defs"]


def promised_files(row: SweepStatus) -> Iterable[str]:
    """The files that a sweep in this state has."""
    return FILES if row.state is SweepState.SUCCEEDED else ()


def links_of(row: SweepStatus, files: Iterable[str]) -> dict[str, str]:
    """Where to go from a sweep."""
    here = f"/v1/sweeps/{row.id}"
    links = {name: f"{here}/{name}" for name in ("runs", "events", "history", "document")}
    links = {"self": here, **links}
    if row.is_terminal:
        links["retry"] = f"{here}/retry"
    else:
        links |= {"cancel": f"{here}/cancel"}
    return links | {name: f"{here}/{name}" for name in files if name in FILES}
