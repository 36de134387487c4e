"""Results that a publication found lost or damaged, on their way from its process to the rows.

It leaves their list in its folder and ends; the service looks at the files itself, and has those runs
computed again that it cannot read either.
"""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from service.files.artifacts import digest
from solver.errors import WhippleError
from studies.values.files import write_text

LOSSES = "losses.json"


class ResultsLost(WhippleError):
    """Results of runs that are registered are not there, or are not what was registered."""


class TooManyLost(WhippleError):
    """More results would be forgotten than a disk loses now and then: most likely part of it is away."""


@dataclass(frozen=True)
class Loss:
    """A registered result that cannot be read."""

    run_id: str
    path: str  # absolute
    sha256: str  # as registered

    def is_real(self) -> bool:
        """Whether it cannot be read here and now either."""
        file = Path(self.path)
        return not file.is_file() or digest(file) != self.sha256


def leave_list(losses: Sequence[Loss], directory: Path) -> None:
    """Write the list and raise ResultsLost."""
    write_text(directory / LOSSES, json.dumps([asdict(one) for one in losses]))
    raise ResultsLost(f"the results of runs are lost or damaged: {some(losses)}")


def some(losses: Sequence[Loss]) -> str:
    """The first runs by name, and how many more there are."""
    names = ", ".join(one.run_id for one in losses[:3])
    return f"{names} and {len(losses) - 3} more" if len(losses) > 3 else names


def list_in(directory: Path) -> tuple[Loss, ...]:
    """The list that an attempt left; none: it lost nothing."""
    file = directory / LOSSES
    if not file.is_file():
        return ()
    return tuple(Loss(**one) for one in json.loads(file.read_bytes()))
