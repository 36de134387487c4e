"""Engines, which compute attempts: the protocol, and the two that follow it.

``protocol`` is what the dispatcher calls; ``local`` is the engine of this machine, ``dask`` that of a cluster
(``dask_worker`` runs there). ``tests/contracts/test_engine.py`` runs over both. The command line opens an engine.
"""

from functools import partial
from typing import TYPE_CHECKING, Any

from studies.quantities.findings import MissingExtra

if TYPE_CHECKING:
    from service.execution.protocol import Cluster, OpenEngine
    from service.settings import Settings
    from service.workers.warm import WarmProcess

CURE = "pip install 'whipple[cluster]', or remove the engine setting to compute runs on this machine"


def engine_of(settings: "Settings", ready: "list[WarmProcess] | None" = None) -> "OpenEngine":
    """The function that opens the engine of the settings; raises MissingExtra.

    ``ready``: processes for the first attempts on this machine.
    """
    if settings.engine is None:
        from service.execution.local import LocalEngine

        return partial(LocalEngine, settings.workers, ready=ready)
    dask = _dask_for(settings)
    return partial(dask.DaskEngine, dask.Remote.of(settings))


def probe(settings: "Settings") -> "Cluster":
    """Ask the scheduler of the settings for its workers; raises OSError, MissingExtra."""
    cluster: Cluster = _dask_for(settings).probe(settings)
    return cluster


def _dask_for(settings: "Settings") -> Any:
    """The module that talks to a scheduler; raises MissingExtra without its libraries."""
    try:
        from service.execution import dask
    except ModuleNotFoundError as error:
        missing = f"the engine {settings.engine} needs {error.name}, which is not installed"
        raise MissingExtra(f"{missing}: {CURE}") from None
    return dask
