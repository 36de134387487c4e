"""A slot in a Dask worker: it describes the software that it computes with, and supervises attempts.

A worker loads this module with ``--preload service.dask.worker``. It then offers one unit of the resource
``OFFER``, a name made of versions, and an attempt asks for one unit of its service's own offer: so work goes to workers
that compute the same numbers, one attempt at a time, and to no other worker of the cluster.
"""

import platform
from collections.abc import Callable, Mapping
from importlib import metadata
from typing import TYPE_CHECKING, TypedDict

from service import version
from service.records.jobs import AttemptProgress
from service.workers.attempt import Attempt, Ending
from service.workers.supervisor import Supervisor
from service.workers.timings import DEFAULT
from service.workers.warm import Slot
from solver import PHYSICS_VERSION

if TYPE_CHECKING:
    from distributed import Worker

PROGRESS = "whipple-progress"  # topic of progress messages
SOFTWARE = "whipple-software"  # entry of a worker's description


def software() -> dict[str, str]:
    """Versions that decide the numbers, and that service and worker must share."""
    return {
        "whipple": version(),
        "physics": str(PHYSICS_VERSION),
        "python": ".".join(platform.python_version_tuple()[:2]),
        **{name: metadata.version(name) for name in ("numba", "numpy")},
    }


OFFER = "whipple " + " ".join(f"{name}={value}" for name, value in software().items())


def differences(offered: Mapping[str, str] | None) -> str:
    """The reason why a worker with these versions receives no work; empty if it receives work."""
    if offered is None:
        return f"the worker was started without --preload {__name__}"
    own = software()
    names = [name for name in {**own, **offered} if own.get(name) != offered.get(name)]
    return "; ".join(f"{name} {offered.get(name)}, on the service {own.get(name)}" for name in names)


class ProgressEvent(TypedDict):
    """A message about an attempt."""

    key: str
    progress: AttemptProgress


_WORKERS: "list[Worker]" = []  # workers of this process: one, unless a test starts more
_SLOT = Slot()  # slot of this worker, which has one thread
_UNDER_WAY: dict[str, Supervisor] = {}  # by key of the attempt


def dask_setup(worker: "Worker") -> None:
    """Describe a worker before it registers with the scheduler; called by Dask."""
    _WORKERS.append(worker)
    worker.startup_information[SOFTWARE] = _describe
    worker.state.total_resources[OFFER] = worker.state.available_resources[OFFER] = 1.0


def dask_teardown(worker: "Worker") -> None:
    """Let attempts leave a worker that ends or has lost its scheduler; called by Dask, which waits for the thread."""
    leave(list(_UNDER_WAY))
    _SLOT.close()


def compute(attempt: Attempt) -> Ending:
    """Compute an attempt as a Dask task, in the one thread of a worker."""
    worker = _WORKERS[-1]

    def send(progress: AttemptProgress) -> None:
        worker.log_event(PROGRESS, ProgressEvent(key=attempt.key, progress=progress))

    def is_wanted() -> bool:
        """Whether the scheduler still wants the task: not, once its service died before the scheduler kept it."""
        task = worker.state.tasks.get(attempt.key)
        return task is not None and task.state != "cancelled"

    supervisor = _UNDER_WAY[attempt.key] = Supervisor(attempt, send, is_wanted=is_wanted)
    try:
        return supervisor.run(_SLOT)
    finally:
        del _UNDER_WAY[attempt.key]


async def call(function: Callable[[list[str]], None], keys: list[str]) -> None:
    """Call ``stop`` or ``leave`` in the loop of a worker, while its thread supervises."""
    function(keys)


def stop(keys: list[str]) -> None:
    """Stop those of the attempts that are under way in this process."""
    for supervisor in _under_way(keys):
        supervisor.stop()


def leave(keys: list[str]) -> None:
    """Let attempts write a checkpoint and leave; one that has not left in time is stopped."""
    for supervisor in _under_way(keys):
        supervisor.leave(DEFAULT.leave)


def _under_way(keys: list[str]) -> list[Supervisor]:
    under_way = _UNDER_WAY.copy()
    return [under_way[key] for key in keys if key in under_way]


async def _describe(worker: "Worker") -> dict[str, str]:
    return software()
