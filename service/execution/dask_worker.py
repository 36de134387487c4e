"""What makes a Dask worker a slot: it says what it computes with, and lets attempts leave when it must.

A worker loads this module with ``--preload service.execution.dask_worker``. It then offers one unit of the resource
``OFFER``, a name made of versions, and an attempt asks for one unit of its service's own: so work goes
to workers that compute the same numbers, one attempt at a time, and to no other worker of the cluster.
"""

import platform
from collections.abc import Callable, Mapping
from importlib import metadata
from typing import Any

from service.records.attempt import Attempt, Ending
from service.records.version import version
from service.workers.supervisor import LEAVE_SECONDS, Supervisor
from service.workers.warm import Slot
from solver import PHYSICS_VERSION

PROGRESS = "whipple-progress"  # topic under which workers tell the service
SOFTWARE = "whipple-software"  # where a worker's description says what it computes with


def software() -> dict[str, str]:
    """What decides the numbers, and what service and worker must share to understand each other."""
    return {
        "whipple": version(),
        "physics": str(PHYSICS_VERSION),
        "python": ".".join(platform.python_version_tuple()[:2]),
        **{name: metadata.version(name) for name in ("numba", "numpy")},
    }


OFFER = "whipple " + " ".join(f"{name}={value}" for name, value in software().items())


def differences(found: Mapping[str, str] | None) -> str:
    """Why a worker that says this of itself gets no work; empty if it gets some."""
    if found is None:
        return f"it was started without --preload {__name__}"
    own = software()
    names = [name for name in {**own, **found} if own.get(name) != found.get(name)]
    return "; ".join(f"{name} {found.get(name)}, here {own.get(name)}" for name in names)


_WORKERS: list[Any] = []  # of this process: one, unless a test starts more
_SLOT = Slot()  # of this worker, which has one thread
_UNDER_WAY: dict[str, Supervisor] = {}  # by key of the ticket


def dask_setup(worker: Any) -> None:
    """Called in a worker before it tells the scheduler of itself."""
    _WORKERS.append(worker)
    worker.startup_information[SOFTWARE] = _describe
    worker.state.total_resources[OFFER] = worker.state.available_resources[OFFER] = 1.0


def dask_teardown(worker: Any) -> None:
    """Called in a worker that was told to end, or has lost its scheduler; it waits for its thread."""
    leave(list(_UNDER_WAY))
    _SLOT.close()


def compute(ticket: Attempt) -> Ending:
    """The task that an attempt is for Dask: runs in the one thread of a worker."""
    worker = _WORKERS[-1]

    def tell(words: Mapping[str, Any]) -> None:
        worker.log_event(PROGRESS, {"key": ticket.key, **words})

    supervisor = _UNDER_WAY[ticket.key] = Supervisor(ticket, tell)
    try:
        return supervisor.run(_SLOT)
    finally:
        del _UNDER_WAY[ticket.key]


async def call(message: Callable[[list[str]], None], keys: list[str]) -> None:
    """Called in the loop of a worker, while its thread supervises."""
    message(keys)


def stop(keys: list[str]) -> None:
    """Stop these attempts, as far as they are under way in this process."""
    for supervisor in _chosen(keys):
        supervisor.stop()


def leave(keys: list[str]) -> None:
    """Let them write a checkpoint and leave; one that has not left in time is stopped."""
    for supervisor in _chosen(keys):
        supervisor.leave(LEAVE_SECONDS)


def _chosen(keys: list[str]) -> list[Supervisor]:
    under_way = _UNDER_WAY.copy()
    return [under_way[key] for key in keys if key in under_way]


async def _describe(worker: Any) -> dict[str, str]:
    return software()
