"""What makes a Dask worker a slot: it says what it computes with, and lets attempts leave when it must.

A worker loads this module with ``--preload service.slot``. It then offers one unit of the resource
``OFFER``, a name made of versions, and an attempt asks for one unit of its service's own: so work goes
to workers that compute the same numbers, one attempt at a time, and to no other worker of the cluster.
"""

import platform
from collections.abc import Callable, Mapping
from importlib import metadata
from multiprocessing import spawn
from typing import Any

from service import steady, supervisor, warm
from service.attempt import Ending, Ticket
from service.version import version
from solver import PHYSICS_VERSION

WORKER_PROCESS = "Dask Worker process"  # how distributed.nanny names them
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
        return "it was started without --preload service.slot"
    ours = software()
    names = [name for name in {**ours, **found} if ours.get(name) != found.get(name)]
    return "; ".join(f"{name} {found.get(name)}, here {ours.get(name)}" for name in names)


_WORKERS: list[Any] = []  # of this process: one, unless a test starts more


def dask_setup(worker: Any) -> None:
    """Called in a worker before it tells the scheduler of itself."""
    steady.keep_time()
    _WORKERS.append(worker)
    worker.startup_information[SOFTWARE] = _describe
    worker.state.total_resources[OFFER] = worker.state.available_resources[OFFER] = 1.0


def dask_teardown(worker: Any) -> None:
    """Called in a worker that was told to end, or has lost its scheduler; it waits for its thread."""
    supervisor.leave()
    warm.dismiss()


def compute(ticket: Ticket) -> Ending:
    """The task that an attempt is for Dask: runs in the one thread of a worker."""
    worker = _WORKERS[-1]

    def tell(words: Mapping[str, Any]) -> None:
        worker.log_event(PROGRESS, {"key": ticket.key, **words})

    return supervisor.supervise(ticket, tell)


async def call(word: Callable[[list[str]], None], keys: list[str]) -> None:
    """Called in the loop of a worker, while its thread supervises."""
    word(keys)


def spare_the_main_module() -> None:
    """Let workers start without importing the program that called us.

    Else a script that calls ``run_sweep`` outside of ``if __name__ == "__main__"`` would run again
    in each worker, and fail there; so would every worker that is replaced later.
    """
    plain = spawn.get_preparation_data

    def prepare(name: str) -> dict[str, Any]:
        prepared = plain(name)
        if name.startswith(WORKER_PROCESS):
            for entry in ("init_main_from_name", "init_main_from_path"):
                prepared.pop(entry, None)
        return prepared

    if plain.__module__ == spawn.__name__:  # else it is ours already
        spawn.get_preparation_data = prepare


async def _describe(worker: Any) -> dict[str, str]:
    return software()
