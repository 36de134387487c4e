"""Cubes of unfinished sweeps, made from the sweep's document and the outcomes of its runs."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from service.api.errors import PartialCubeFailed
from service.api.made_files import MadeFiles, run_child
from service.files.artifacts import digest
from service.records.jobs import PublishedRun, State

# States of a run in a cube that differ from those of the queue.
CUBE_STATES = {State.QUEUED: "pending", State.CANCELLING: "running"}


class PartialCubes(MadeFiles):
    """The cache of partial cubes."""

    module, noun, suffix, failure = "service.api.partial_cubes", "partial cube", ".nc", PartialCubeFailed

    def file(
        self, document: Mapping[str, Any], outcomes: Sequence[PublishedRun], root: Path, state: str
    ) -> tuple[Path, str]:
        """The cube of the results so far, and its SHA-256; raises Busy, PartialCubeFailed."""
        runs = [outcome.as_json(root) for outcome in outcomes]
        return self.made_from({"document": document, "outcomes": runs, "state": state})


# --- in the child process -------------------------------------------------------------------------


def make(inputs: dict[str, Any], file: Path) -> None:
    """Make a partial cube."""
    from studies.reports.publish import write_partial

    outcomes = {run["run_id"]: _outcome(run) for run in inputs["outcomes"]}
    write_partial(inputs["document"], outcomes, file, state=inputs["state"])


def _outcome(run: Mapping[str, Any]) -> Mapping[str, Any]:
    """A run's result, or its state and reason if there is none."""
    if run["path"] is None:
        state = State(run["state"])
        return {"state": CUBE_STATES.get(state, state.value), "reason": run["reason"]}
    file = Path(run["path"])
    if not file.is_file() or digest(file) != run["sha256"]:
        return {"state": "failed", "reason": f"the result of the run is lost or damaged: {file.name}"}
    return json.loads(file.read_bytes())


if __name__ == "__main__":
    run_child(make)
