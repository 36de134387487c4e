"""Lost or damaged results, as the process of a publication reports them to the service.

The process leaves a list of them in its folder and ends; the service reads the files itself, and has
those runs computed again whose results it cannot read either.
"""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from service.files.artifacts import digest
from solver.errors import WhippleError
from studies.quantities.files import write_text

LOSSES = "losses.json"


class ResultsLost(WhippleError):
    """Registered results of runs are missing or damaged."""


class TooManyLost(WhippleError):
    """More results are lost than a disk loses now and then: most likely part of it is not mounted."""


@dataclass(frozen=True)
class Loss:
    """A registered result that cannot be read."""

    run_id: str
    path: str  # absolute
    sha256: str  # as registered

    def is_real(self) -> bool:
        """Whether the file is missing or damaged here and now too."""
        file = Path(self.path)
        return not file.is_file() or digest(file) != self.sha256


def leave_list(losses: Sequence[Loss], directory: Path) -> None:
    """Write the list and raise ResultsLost."""
    write_text(directory / LOSSES, json.dumps([asdict(loss) for loss in losses]))
    raise ResultsLost(f"the results of runs are lost or damaged: {first_runs(losses)}")


def first_runs(losses: Sequence[Loss]) -> str:
    """Ids of the first runs, and the number of the others."""
    names = ", ".join(loss.run_id for loss in losses[:3])
    return f"{names} and {len(losses) - 3} more" if len(losses) > 3 else names


def list_in(directory: Path) -> tuple[Loss, ...]:
    """The list in the folder of an attempt; empty without one."""
    file = directory / LOSSES
    if not file.is_file():
        return ()
    return tuple(Loss(**loss) for loss in json.loads(file.read_bytes()))
