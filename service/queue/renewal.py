"""Renewal after an upgrade: accepted sweeps of an older physics are expanded anew, before any run begins.

The leader looks for them when its term begins, and when a run was refused because another version alone can compute it
(as after a retry of a sweep that had ended). Each is expanded in a child process, the one that reads submissions, and
gets its new points in one transaction; so a kill at any time leaves it as it was or renewed. Meanwhile nothing begins.
"""

import logging
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING

from service.records.expansion import ExpandedSweep
from service.store import Store
from solver import PHYSICS_VERSION
from solver.errors import WhippleError
from studies.quantities.findings import InvalidInput

if TYPE_CHECKING:
    from studies.quantities.parameters import Plain

log = logging.getLogger(__name__)

Expand = Callable[["Mapping[str, Plain]"], ExpandedSweep]  # raises InvalidInput for a document that it refuses

MOST_TRIES = 3  # to expand a sweep, until it fails
REASON = f"accepted sweeps of an older physics are expanded anew, for physics {PHYSICS_VERSION}"


class Renewer:
    """Expands outdated sweeps anew, one after the other."""

    def __init__(self, store: Store, expand: Expand, wake: Callable[[], None]):
        self._store = store
        self._expand = expand
        self._wake = wake
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="renewal")
        self._running: tuple[str, Future[ExpandedSweep]] | None = None
        self.look_again()

    def look_again(self) -> None:
        """Let the next step look for outdated sweeps."""
        self._is_due = True
        self._tries: dict[str, int] = {}  # by sweep; in full for those that are done

    @property
    def reason(self) -> str | None:
        """The reason why nothing begins now."""
        return REASON if self._is_due else None

    def step(self) -> None:
        """Write what was expanded, and begin with the next sweep; called by the leader before anything begins."""
        if not self._is_due:
            return
        if self._running is not None:
            id, expanded = self._running
            if not expanded.done():
                return
            self._write(id, expanded)
            self._running = None
        outdated = self._store.renewals.outdated(PHYSICS_VERSION)
        left = [id for id in outdated if self._tries.get(id, 0) < MOST_TRIES]
        if not left:
            self._is_due = False
            return
        expanded = self._thread.submit(self._expand, self._store.sweeps.document(left[0]))
        self._running = left[0], expanded
        expanded.add_done_callback(lambda _: self._wake())

    def close(self) -> None:
        """Begin nothing more."""
        self._thread.shutdown(wait=False, cancel_futures=True)

    def _write(self, id: str, expanded: Future[ExpandedSweep]) -> None:
        """Write the outcome of an expansion; an error that is not of the document is tried again."""
        self._tries[id] = self._tries.get(id, 0) + 1
        error = expanded.exception()
        if error is None:
            is_renewed = self._store.renewals.renew(id, expanded.result(), PHYSICS_VERSION)
            log.info("the sweep %s %s", id, "is expanded anew" if is_renewed else "has the runs of this version")
            self._tries[id] = MOST_TRIES
        elif isinstance(error, InvalidInput) or self._tries[id] == MOST_TRIES:
            text = str(error) if isinstance(error, WhippleError) else f"{type(error).__name__}: {error}"
            reason = f"an older version accepted the sweep, and physics {PHYSICS_VERSION} cannot compute it: {text}"
            self._store.renewals.refuse(id, reason, PHYSICS_VERSION)
            log.warning("the sweep %s cannot be expanded anew: %s", id, text)
            self._tries[id] = MOST_TRIES
        else:
            log.warning("the sweep %s is not expanded yet, and is tried again: %s", id, error)
