"""What the interface answers about the queue as a whole, and what it tells in event streams."""

from datetime import datetime
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from service.api.schemas import Answer
from service.records.jobs import PRIORITIES, Event, QueueRow, RunRow, State


class EventModel(Answer):
    """Something that happened; it never changes."""

    number: int = Field(description="grows; the `id` in an event stream")
    time: datetime
    kind: str = Field(description="accepted, started, requeued, succeeded, failed, published ...")
    sweep_id: str | None
    run_id: str | None = Field(description="of a run, or of the publication of the sweep")
    body: dict[str, Any] = Field(description="what is to be said about it: cause, reason, attempt")

    @classmethod
    def of(cls, event: Event) -> "EventModel":
        """An event of the store."""
        known = {name: value for name, value in vars(event).items() if name != "job_id"}
        return cls(**known, run_id=event.job_id)


class EventPage(Answer):
    """What happened, the oldest first."""

    items: list[EventModel]
    next_cursor: str | None = Field(description="give it back as `cursor`; null: the last page")


class ProgressModel(Answer):
    """How far a running run is."""

    run_id: str
    attempt: int
    fraction: float | None = Field(description="0 to 1")
    seconds: float | None = Field(description="of this attempt until now")
    time: float | None = Field(description="simulated, in seconds")
    end_time: float | None = Field(description="simulated time at which it stops at the latest")
    step: int | None
    eta_seconds: float | None = Field(description="time left, in seconds")
    measured: dict[str, float | None] = Field(description="measured values so far, SI")

    @classmethod
    def of(cls, row: RunRow) -> "ProgressModel | None":
        """What a running row says; None before its first word."""
        if row.progress is None:
            return None
        said = {
            name: row.progress.get(name) for name in ("time", "end_time", "step", "eta_seconds")
        }
        return cls(
            run_id=row.id,
            attempt=row.attempt,
            fraction=row.fraction,
            seconds=row.seconds,
            measured=row.progress.get("measured") or {},
            **said,
        )


class QueueModel(Answer):
    """The queue as a whole."""

    paused: datetime | None = Field(
        description="since when no run is begun; null: it is not paused"
    )
    blocked_reason: str | None = Field(description="why nothing is begun although there is work")
    counts: dict[str, int] = Field(description="runs and publications by state")
    oldest_queued: datetime | None = Field(description="since when the first of them has waited")
    leader: str | None = Field(description="which process gives the work out; null: none does")
    links: dict[str, str]

    @classmethod
    def of(cls, row: QueueRow) -> "QueueModel":
        """A row of the store, and what can be done."""
        here = "/v1/queue"
        order = "pause" if row.paused is None else "resume"
        return cls(
            paused=row.paused,
            blocked_reason=row.blocked_reason,
            counts={state.value: row.states.get(state, 0) for state in State},
            oldest_queued=row.oldest_queued,
            leader=row.leader,
            links={"self": here, order: f"{here}/{order}", "events": f"{here}/events"},
        )


class Change(BaseModel):
    """What may be changed of a sweep."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    priority: int = Field(ge=PRIORITIES[0], le=PRIORITIES[-1], description="smaller is sooner")
