"""States and records of the queue: pure, no database, no engine.

A *job* is one row of the queue: a ``run`` (one simulation) or a ``publish`` (cube and report of one
sweep). The row is the truth; the process that computes it may die at any moment.

::

    waiting --> queued --> running --> succeeded
                  |  ^        |  `---> failed
                  |  `--------|  (lost or crashed: again)
                  |           v
                  `--> cancelled <-- cancelling

``waiting`` is a publication whose runs are not all done. A solver's verdict ("this state is
unphysical") is a result: ``failed`` with cause ``verdict``, shared like a success. A run that has a
result may be queued again, for a file that was not kept, or a verdict on request: the result stays
until it is replaced, and the run goes back to it if the new attempt fails.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum
from typing import TYPE_CHECKING, Any, Generic, Self, TypedDict, TypeVar

from solver.errors import WhippleError
from studies.quantities.files import FILM, RESULT, SECTIONS, STATE

if TYPE_CHECKING:
    from service.records.expansion import ExpandedSweep
    from studies.quantities.findings import Finding
    from studies.runs.run import RunSpec
    from studies.sweeps.sweep import Sweep

Item = TypeVar("Item")

KEY_VARIABLE = "WHIPPLE_API_KEY"  # environment of clients
PRIORITIES = range(-100, 101)  # priorities of sweeps; smaller is sooner, as with nice
USUAL_PRIORITIES = range(PRIORITIES.stop)  # those that a key without the scope ``admin`` may ask for


# Edges in seconds between which runs with a result are counted, three a decade: a second to a week.
RUN_SECONDS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4, 3e4, 1e5, 3e5)


class Kind(StrEnum):
    """The kind of a job: a run or a publication."""

    RUN = "run"
    PUBLISH = "publish"


class State(StrEnum):
    """The state of a job."""

    WAITING = "waiting"
    QUEUED = "queued"
    RUNNING = "running"
    CANCELLING = "cancelling"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELLED = "cancelled"


class SweepState(StrEnum):
    """The state of a sweep, derived from its runs and its publication, never stored."""

    QUEUED = "queued"  # no run has begun
    RUNNING = "running"
    PUBLISHING = "publishing"  # every run is done, cube and report are being made
    CANCELLING = "cancelling"  # runs are being stopped, then what there is gets published
    SUCCEEDED = "succeeded"  # cube and report are there; counts say how many runs failed
    FAILED = "failed"  # cube and report could not be made
    CANCELLED = "cancelled"


class Cause(StrEnum):
    """The cause of an unsuccessful attempt; each cause has its own budget (``service.queue.retry``)."""

    VERDICT = "verdict"  # the run ended with an error of its own, such as an unphysical state: a result
    CRASH = "crash"  # the process died, and the service had not killed it
    MEMORY_LIMIT = "memory_limit"  # it asked for more than the service allows
    TIME_LIMIT = "time_limit"  # the wall clock limit of the service
    STALLED = "stalled"  # its process was frozen, or went on without a step
    ERROR = "error"  # an unexpected exception
    LOST = "lost"  # service, scheduler or worker went away; the run is not charged


class Keep(StrEnum):
    """The retention of a run's files, least first; not part of the identity of the run."""

    NUMBERS = "numbers"  # result.json, and the sections that reports show
    FINAL = "final"  # and the final state
    FILM = "film"  # and the frames


# Files of a run that only some sweeps keep, and the least retention that includes them.
KEPT_BY = {STATE: Keep.FINAL, FILM: Keep.FILM}
# The views of a run that pages draw, and the files from which each is made: any one of them will do, the first best.
VIEWS: Mapping[str, tuple[str, ...]] = {"film": (FILM, SECTIONS), "cloud": (STATE,), "radiograph": (STATE, SECTIONS)}


class Scope(StrEnum):
    """The scope of an API key: the requests that it allows."""

    READ = "read"
    SUBMIT = "submit"
    ADMIN = "admin"


TERMINAL = frozenset({State.SUCCEEDED, State.FAILED, State.CANCELLED})
ACTIVE = frozenset(State) - TERMINAL
UNSUCCESSFUL = tuple(state for state in State if state is not State.SUCCEEDED)  # which the queue counts
RUN_STATES = tuple(state for state in State if state is not State.WAITING)
SWEEP_TERMINAL = frozenset({SweepState.SUCCEEDED, SweepState.FAILED, SweepState.CANCELLED})


def at_least(keep: Keep) -> frozenset[Keep]:
    """This retention, and every retention that keeps more files."""
    return frozenset(list(Keep)[list(Keep).index(keep) :])


class NotFound(WhippleError):
    """Unknown sweep, run or file."""

    def __init__(self, kind: str, id: str, cure: str = ""):
        super().__init__(f"no {kind} {id!r}" + (f"; {cure}" if cure else ""))
        self.kind = kind
        self.id = id


class Conflict(WhippleError):
    """The state of a sweep or run does not allow the command."""


class KeyReused(WhippleError):
    """An Idempotency-Key was used before, with another body."""


class QuotaExceeded(WhippleError):
    """An owner has too much under way, or kept, for another sweep; a later try may succeed."""

    def __init__(self, text: str, seconds: int):
        super().__init__(text)
        self.seconds = seconds  # until another try is worth while


class StoreUnavailable(WhippleError):
    """The database is locked, away or full; nothing was changed, and a later try may succeed."""


class StoreDamaged(StoreUnavailable):
    """The file of the database is damaged, or no database; no later try succeeds."""


@dataclass(frozen=True)
class Page(Generic[Item]):
    items: tuple[Item, ...]
    next_cursor: str | None  # ``cursor`` of the next page; None: this is the last


@dataclass(frozen=True)
class Submission:
    """A sweep with the options of its owner, which are not part of a run's identity."""

    sweep: "Sweep | ExpandedSweep"
    owner: str = ""  # name of an API key; empty on the loopback
    priority: int = 0  # one of PRIORITIES
    keep: Keep = Keep.FINAL
    idempotency: tuple[str, str] | None = None  # the owner's key, SHA-256 of the body
    quota: "Quota | None" = None  # of the owner
    findings: "tuple[Finding, ...]" = ()  # why it is refused, unless it was accepted before


@dataclass(frozen=True)
class Quota:
    """The most that one owner may have: sweeps and runs that have not ended, and bytes of files."""

    sweeps: int
    runs: int
    bytes: int


def described(sentence: str) -> Mapping[str, str]:
    """Metadata of a field that the API serves: its sentence in the API's documentation."""
    return {"description": sentence}


@dataclass(frozen=True)
class SweepStatus:
    """A sweep at one moment: read from its rows, served by the API, returned by the client."""

    id: str = field(metadata=described("32 hex digits, made by the service"))
    name: str
    title: str
    scenario: str
    owner: str = field(metadata=described("name of the API key of the submission; empty: without a key"))
    priority: int = field(metadata=described("-100 to 100; sweeps of smaller numbers are computed first"))
    keep: Keep = field(metadata=described("files kept for each run besides its measurements"))
    state: SweepState
    reason: str | None = field(metadata=described("reason why the cube and the report could not be made"))
    headline: str | None = field(metadata=described("headline of the report; null before there is one"))
    planned: int = field(metadata=described("runs of the sweep: points times resolutions and offsets"))
    reused: int = field(
        metadata=described("runs that were computed before or already running when the sweep was accepted")
    )
    new: int = field(metadata=described("runs that were queued for this sweep"))
    counts: Mapping[str, int] = field(metadata=described("points by state of their runs"))
    lost_answers: int = field(metadata=described("runs that succeeded and lack a value: their reason says which"))
    progress: float = field(
        metadata=described("0 to 1: computed part of the estimated cost; below 1 where runs were cancelled")
    )
    eta_seconds: float | None = field(metadata=described("time left, in seconds; null before the first measured run"))
    created: datetime
    cancelled: datetime | None = field(metadata=described("when the cancel was requested"))
    pinned: datetime | None = field(metadata=described("when it was pinned; a pinned sweep is not deleted"))
    finished: datetime | None
    physics: int = field(metadata=described("version of the physics that computes it"))
    renewed: datetime | None = field(
        metadata=described("when it was expanded anew: a newer physics computes all its points")
    )
    older: str | None = field(metadata=described("id of the sweep that has its results of an older physics"))

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Self:
        """The record in a response of the API; its links are left out."""
        moments = {
            name: datetime.fromisoformat(body[name]) if body[name] else None
            for name in ("created", "cancelled", "pinned", "finished", "renewed")
        }
        typed = {"keep": Keep(body["keep"]), "state": SweepState(body["state"]), **moments}
        return cls(**{name: body[name] for name in cls.__dataclass_fields__} | typed)

    @property
    def tally(self) -> str:
        """Runs by state, without zeros: "17 succeeded (2 of them lack a value), 1 failed"."""
        lack = "lacks" if self.lost_answers == 1 else "lack"
        lost = f" ({self.lost_answers} of them {lack} a value)" if self.lost_answers else ""
        return ", ".join(
            f"{count} {state}{lost if state == State.SUCCEEDED else ''}"
            for state, count in self.counts.items()
            if count
        )

    @property
    def renewal(self) -> str:
        """By which physics a sweep is computed anew, and where its older results are; empty: it is not."""
        if self.renewed is None:
            return ""
        where = f"; its older results are in the sweep {self.older}" if self.older else ""
        return f"expanded anew on {self.renewed:%Y-%m-%d}: physics {self.physics} computes all its points{where}"

    @property
    def is_terminal(self) -> bool:
        """The sweep has ended; only a retry changes it."""
        return self.state in SWEEP_TERMINAL


@dataclass(frozen=True)
class RunRow:
    """A run at one moment: read from its row, served by the API."""

    id: str = field(metadata=described("Digest of the run's parameters: equal runs have equal ids"))
    scenario: str
    state: State
    attempt: int = field(metadata=described("Number of attempts"))
    crashes: int = field(metadata=described("Attempts whose process died at the same checkpoint"))
    priority: int = field(metadata=described("Priority of the most urgent sweep that waits for it"))
    keep: Keep = field(metadata=described("Files kept, for the most demanding sweep"))
    checkpoint: int | None = field(metadata=described("Step of the last checkpoint; the next attempt starts there"))
    fraction: float | None = field(metadata=described("Completed part of the running attempt, 0 to 1"))
    progress: Mapping[str, Any] | None = field(metadata=described("Simulated time, step, values so far"))
    cause: str | None = field(metadata=described("Cause of the failure: `verdict` of the solver, or an accident"))
    failure: str | None = field(metadata=described("Kind of the failure"))
    reason: str | None = field(metadata=described("Description of the failure"))
    summary: Mapping[str, Any] | None = field(metadata=described("Measurements, flags and audit"))
    sha256: str | None = field(metadata=described("Digest of the result file"))
    cost: float = field(metadata=described("Estimated core seconds"))
    seconds: float | None = field(metadata=described("Measured seconds of the attempt that counts"))
    created: datetime
    started: datetime | None  # the last attempt
    finished: datetime | None


@dataclass(frozen=True)
class PointRow:
    """A point of a sweep, and its run."""

    ordinal: int = field(metadata=described("Position in the order of the sweep"))
    index: tuple[int, ...] = field(
        metadata=described("Position on each axis, and among the resolutions and offsets if several")
    )
    coordinates: Mapping[str, float | str] = field(
        metadata=described("Value on each of these axes, SI; of a run that screens the models, `screening` alone")
    )
    state: State = field(metadata=described("State of the run; `cancelled` if this sweep no longer waits for it"))
    run: RunRow


@dataclass(frozen=True)
class RunPlace:
    """Where a run stands in a sweep."""

    sweep_id: str
    title: str
    owner: str
    coordinates: Mapping[str, float | str]  # SI


@dataclass(frozen=True)
class GridCell:
    """A point of a sweep as a grid of them shows it."""

    ordinal: int
    run_id: str
    coordinates: Mapping[str, float | str]  # SI
    state: State  # as in PointRow
    fraction: float | None  # of the running attempt, 0 to 1
    value: float | None  # of the quantity that the grid shows, SI
    uncertainty: float | None


class Outcome(TypedDict):
    """A run of a sweep as a process gets it that makes files of it."""

    run_id: str
    state: str
    reason: str | None
    path: str | None  # absolute, of its result (a verdict has one too); None: there is none, or it is queued again
    sha256: str | None


@dataclass(frozen=True)
class Stored:
    """A complete file: path, size and digest."""

    name: str  # "cube.nc", "result.json"
    path: str  # relative to the data directory
    size: int  # bytes
    sha256: str


@dataclass(frozen=True)
class ExpiredSweep:
    """A sweep that a rule of retention deletes."""

    id: str
    name: str
    owner: str
    finished: datetime
    size: int  # bytes of the files that go with it


@dataclass(frozen=True)
class Scrub:
    """How far the comparison of all registered files with their digests is."""

    began: float = 0.0  # of the last pass, seconds since the epoch
    job_id: str = ""  # with the name: of the file that was read last; empty: no pass is under way
    name: str = ""
    files: int = 0  # so far
    damaged: int = 0  # of these; lost ones too
    whole: Sequence[float] = ()  # of the last pass that ended: when, its files, and the damaged ones


class MeasurementSummary(TypedDict, total=False):
    """What the row of a run keeps of a measurement."""

    value: float | None  # without its mesh error, where that is known
    uncertainty: float | None
    flags: Sequence[str]
    version: int  # of the definition
    raw: float | None  # as it was read, where ``value`` is without its mesh error


class Summary(TypedDict, total=False):
    """What the row of a run keeps of its result."""

    measurements: Mapping[str, MeasurementSummary]
    flags: Sequence[str]
    numbers: Mapping[str, float | None]
    stop: str | None


@dataclass(frozen=True)
class MeasuredRun:
    """A run with its measurements, and the final state that they can be read off again."""

    id: str
    scenario: str
    state: State
    summary: Summary | None
    kept: Stored | None  # STATE


@dataclass(frozen=True)
class Event:
    """A change of state; never changed, never removed."""

    number: int = field(metadata=described("Increasing; the `id` in an event stream"))
    time: datetime
    kind: str = field(metadata=described("accepted, started, requeued, succeeded, failed, published ..."))
    sweep_id: str | None
    run_id: str | None = field(metadata=described("Id of a run, or of the publication of the sweep"))
    body: Mapping[str, Any] = field(metadata=described("Details: cause, reason, attempt"))


@dataclass(frozen=True)
class Lease:
    """The right to compute one attempt of a job; it ends when the attempt does."""

    id: str  # of the job
    kind: Kind
    attempt: int
    term: int  # term of leadership in which the lease was given
    token: str  # random, in the name of the attempt's directory
    crashes: int  # earlier attempts that died at ``crash_step``
    crash_step: int | None  # step of their last checkpoint; None: they wrote none
    priority: int
    keep: Keep
    state: State  # running, or cancelling after a request to stop it
    spec: "RunSpec | None"  # of a run
    sweep_id: str | None  # of a publication

    @property
    def key(self) -> str:
        """Name of the attempt for the engine; an adopted attempt keeps it."""
        return f"{self.id}-{self.attempt}-{self.token}"


class AttemptProgress(TypedDict, total=False):
    """How far an attempt is: what ``studies.runs.results.Progress`` says, and more."""

    time: float
    end_time: float
    step: int
    fraction: float
    eta_seconds: float | None
    measured: Mapping[str, float | None]
    seconds: float  # wall clock
    checkpoint: int  # step of the last one


@dataclass(frozen=True)
class CrashCount:
    """Attempts of a job that died at the same checkpoint."""

    crashes: int
    step: int  # of that checkpoint; 0: there was none


@dataclass(frozen=True)
class LastAttempt:
    """The last attempt of a job: whose files count, and whether it is over."""

    attempt: int
    token: str | None  # None: no attempt has begun
    state: State


@dataclass(frozen=True)
class Result:
    """A finished run, ready to be registered."""

    files: tuple[Stored, ...]  # RESULT, and what is kept beside it
    succeeded: bool  # False: the solver's verdict
    reason: str | None
    failure: str | None
    summary: Summary
    seconds: float

    @property
    def answer(self) -> Stored:
        """The file that the run's row points to."""
        return next(file for file in self.files if file.name == RESULT)


@dataclass(frozen=True)
class QueueHead:
    """The queue as a whole at one moment, without its jobs."""

    paused: datetime | None  # since when no run is begun
    blocked_reason: str | None  # why nothing is begun although there is work
    deletion_paused: str | None  # why nothing is deleted by age
    term: int  # the youngest term of leadership; 0: there was none
    leader: str | None  # owner of the term; None: no service leads


@dataclass(frozen=True)
class QueueRow(QueueHead):
    """The queue as a whole at one moment."""

    jobs: Mapping[tuple[Kind, State], int]  # of each kind in each state but "succeeded"
    oldest_queued: datetime | None  # since when the run that waits longest is in the queue

    @property
    def states(self) -> Mapping[State, int]:
        """Jobs in each state but "succeeded", publications included."""
        return {state: sum(self.jobs.get((kind, state), 0) for kind in Kind) for state in UNSUCCESSFUL}


@dataclass(frozen=True)
class KeyRow:
    """An API key; the secret itself is not stored."""

    id: str
    name: str  # the owner of what is submitted with it
    prefix: str  # first letters of the secret, for people
    scopes: frozenset[Scope]
    created: datetime
    expires: datetime | None  # None: never
    used: datetime | None  # to a minute
    revoked: datetime | None

    def is_usable(self, moment: datetime) -> bool:
        """Whether it is neither revoked nor expired."""
        return self.revoked is None and (self.expires is None or self.expires > moment)


@dataclass(frozen=True)
class AuditEntry:
    """An order, or a refused key: who gave it, from where, and what came of it."""

    time: datetime
    key_id: str | None
    owner: str  # name of the key, or of the local user; empty without either
    address: str  # of the peer; of a local user "uid 1000"
    action: str
    subject: str  # id of the sweep, run or key that it is about; empty without one
    outcome: str  # HTTP status; of a command on this machine "done"


@dataclass(frozen=True)
class RunTally:
    """Number of attempts that succeeded within a range of seconds."""

    bucket: int  # number of edges of RUN_SECONDS below
    attempts: int
    seconds: float  # of all of them
