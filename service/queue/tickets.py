"""From a claimed row to the order that goes to the engine."""

from collections.abc import Mapping
from typing import Any

from service.files.artifacts import Artifacts
from service.records.attempt import Attempt
from service.records.jobs import Claim, Kind
from service.records.settings import Settings
from service.store import Store


class Tickets:
    """Writes tickets: where an attempt works, on what, and within which limits."""

    def __init__(self, settings: Settings, store: Store, artifacts: Artifacts):
        self._settings = settings
        self._store = store
        self._artifacts = artifacts
        self._memory_limit = settings.memory_of_a_run

    def write(self, claim: Claim, *, threads: int = 1) -> Attempt:
        """The order for one attempt, below a folder that is there: a worker who misses it lacks the disk."""
        directory = self._artifacts.attempt_directory(claim)
        self._artifacts.make_folder(directory.parent)
        is_run = claim.kind is Kind.RUN
        return Attempt(
            key=claim.key,
            kind=claim.kind,
            directory=str(directory),
            spec=claim.spec if is_run else self._publication(claim),
            seconds_limit=self._settings.run_seconds_limit,
            targets=self._settings.targets_module,
            run=claim.id if is_run else None,
            keep=claim.keep,
            checkpoint=str(self._artifacts.checkpoint(claim.id)) if is_run else None,
            memory_limit=self._memory_limit,
            threads=threads,
        )

    def _publication(self, claim: Claim) -> Mapping[str, Any]:
        """What cube and report are made of."""
        assert claim.sweep_id is not None
        document, outcomes = self._store.question(claim.sweep_id)
        root = self._artifacts.root
        return {"document": document, "outcomes": [one.as_json(root) for one in outcomes]}
