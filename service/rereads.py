"""Results that were read again, on their way from the process that reads to the rows; what rows keep."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from service.jobs import Stored

REREADS = "remeasured.json"  # beside the cube that was made of them


@dataclass(frozen=True)
class Reread:
    """A result of a run in place of an earlier one."""

    run_id: str
    was: str  # SHA-256 of the result that was read again; counts only while the row has that one
    answer: Stored
    summary: Mapping[str, Any]  # what the row keeps of it


@dataclass(frozen=True)
class Rereads:
    """What became of the runs of a sweep that were to be read again."""

    runs: tuple[Reread, ...] = ()
    unreadable: Mapping[str, str] | None = None  # run id: why it stayed as it was

    def as_json(self) -> dict[str, Any]:
        """As plain objects."""
        return {
            "runs": [asdict(one) for one in self.runs],
            "unreadable": dict(self.unreadable or {}),
        }

    @staticmethod
    def from_json(plain: Mapping[str, Any]) -> "Rereads":
        """What ``as_json`` wrote."""
        runs: Iterable[Mapping[str, Any]] = plain["runs"]
        read = (Reread(**{**one, "answer": Stored(**one["answer"])}) for one in runs)
        return Rereads(tuple(read), plain["unreadable"])


def summary_of(answer: Mapping[str, Any]) -> dict[str, Any]:
    """What rows keep of a result (``RunResult.as_json``): everything but histories."""
    words = ("value", "uncertainty", "flags", "version")
    measured = {
        name: {word: one[word] for word in words if word in one}
        for name, one in answer["measurements"].items()
    }
    told = {key: answer[key] for key in ("flags", "numbers", "stop") if key in answer}
    return {"measurements": measured, **told}
