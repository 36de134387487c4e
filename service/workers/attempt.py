"""An attempt as an engine receives it, and the messages that the engine sends about it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from queue import SimpleQueue
from typing import TYPE_CHECKING, NotRequired, Self, TypedDict, final

from service.records.jobs import AttemptProgress, Cause, Keep, Kind, Outcome, Stored

if TYPE_CHECKING:
    from pydantic import JsonValue

    from studies.runs.run import RunSpec

LONGEST_REASON = 4000  # characters in a row


def legible(text: str) -> str:
    """A text that every database stores: shortened, of whole characters, without NUL.

    >>> legible("cannot read 'caf\\udce9.toml'\\0")
    "cannot read 'caf\ufffd.toml'\ufffd"
    """
    text = text.replace("\0", "\ufffd")
    whole = text.encode("utf-16", "surrogatepass").decode("utf-16", "replace")
    if len(whole) <= LONGEST_REASON:
        return whole
    return f"{whole[: LONGEST_REASON // 2]} ... {whole[-LONGEST_REASON // 2 :]}"


@final
class Publication(TypedDict):
    """What the cube and the report of a sweep are made of."""

    document: "Mapping[str, JsonValue]"
    outcomes: Sequence[Outcome]
    # The coordinates of each point and the id of its run, where another physics expanded the sweep.
    places: NotRequired[Sequence[tuple[Mapping[str, float | str], str]]]


@dataclass(frozen=True)
class Attempt:
    """One attempt at a job: where it is computed, from what, and within which limits."""

    key: str  # key of the lease: the attempt's name for the engine
    kind: Kind
    directory: str  # of the attempt; files go here
    spec: "RunSpec | Publication"
    seconds_limit: float  # wall clock
    targets: str | None  # a module in place of ``warm_process.TARGETS``
    run: str | None = None  # id of the run as submitted; another version of the code may differ
    keep: Keep = Keep.FINAL  # what a run leaves behind
    checkpoint: str | None = None  # file that a run goes on from, and writes as it goes
    memory_limit: int | None = None  # bytes of data that its process may hold
    threads: int = 1  # that a run may use: they change no number
    stall_seconds: float = 60.0  # least time without progress, until it has stalled


@dataclass(frozen=True)
class Ending:
    cause: Cause | None  # None: its files are complete
    failure: str  # short kind: "SIGABRT", "MemoryError"; "" for none
    reason: str  # for people
    files: tuple[Stored, ...]  # absolute paths
    seconds: float  # wall clock
    checkpoint: int | None = None  # step of the last one that it wrote or went on from
    free: int | None = None  # bytes on its disk at that moment; None: unknown

    @classmethod
    def lost(cls, failure: str, reason: str) -> Self:
        """The end of an attempt that went away with its engine or a part of it; the run is not charged."""
        return cls(Cause.LOST, failure, reason, (), 0.0)


@dataclass(frozen=True)
class Ended:
    """An attempt has ended, or the engine lost it."""

    key: str
    ending: Ending


@dataclass(frozen=True)
class ProgressMessage:
    key: str
    progress: AttemptProgress


@dataclass(frozen=True)
class Away:
    """The scheduler cannot be reached; the state of the attempts is unknown."""

    reason: str


@dataclass(frozen=True)
class Back:
    """The scheduler can be reached again; attempts that it no longer has are ``Ended``."""


Message = Ended | ProgressMessage | Away | Back
Inbox = SimpleQueue[Message | None]


class ErrorReport(TypedDict):
    """An exception that ended an attempt."""

    failure: str  # its class
    reason: str
    errno: int | None
    memory: bool  # whether it is a lack of memory


class Report(TypedDict, total=False):
    """A message of a warm process, as ``service.workers.warm_process`` describes it."""

    accepted: str
    progress: AttemptProgress
    stepped: bool
    done: bool
    left: bool
    error: ErrorReport
    dirty: bool


class Order(TypedDict, total=False):
    """A message to a warm process."""

    attempt: Attempt
    stop: bool
    leave: bool
