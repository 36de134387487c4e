"""What computes attempts: the protocol of an engine, and the engines that follow it.

``protocol`` says what the dispatcher asks of an engine; ``local`` is the one of this machine, ``dask`` the one of a
cluster (``dask_worker`` runs there). ``tests/contracts/test_engine.py`` runs over both.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from studies.values.errors import MissingExtra

if TYPE_CHECKING:
    from service.execution.protocol import OpenEngine
    from service.records.settings import Settings

CURE = "pip install 'whipple[cluster]', or leave the engine out: runs are then computed on this machine"


def engine_of(settings: "Settings") -> "OpenEngine":
    """What opens the engine that the settings ask for; raises MissingExtra."""
    if settings.engine is None:
        from service.execution.local import LocalEngine

        return partial(LocalEngine, settings.workers)
    dask = _dask_for(settings)
    return partial(dask.DaskEngine, dask.Remote.of(settings))


@dataclass(frozen=True)
class Cluster:
    """What answers at an address."""

    address: str
    workers: Mapping[str, str]  # by address: why it gets no work; empty if it gets some


def probe(settings: "Settings") -> Cluster:
    """Ask the scheduler of the settings who works for it; raises OSError, MissingExtra."""
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
