"""Engines, which compute attempts: ``protocol`` is what the dispatcher calls, ``local`` the engine of this machine.

Engines on other machines are features. To add one: a class like ``protocol.RemoteEngine``, and a line
``scheme = "module:Class"`` of the entry-point group ``whipple.service.execution.engines``;
``tests/contracts/test_engine.py`` runs over all. The command line opens an engine.
"""

from collections.abc import Mapping
from functools import partial

from service.execution.local import LocalEngine
from service.execution.protocol import OpenEngine, RemoteEngine
from service.settings import Settings
from service.workers.warm import WarmProcess
from solver.registry import points

ENGINES = "service.execution.engines"  # the group of entry points


def engine_of(settings: Settings, ready: list[WarmProcess] | None = None) -> OpenEngine:
    """The function that opens the engine of the settings; raises MissingExtra.

    ``ready``: processes for the first attempts on this machine.
    """
    if settings.engine is None:
        return partial(LocalEngine, settings.workers, ready=ready)
    return _remote(settings.engine).opener(settings)


def probe(settings: Settings) -> Mapping[str, str]:
    """``RemoteEngine.probe`` of the engine of the settings; raises OSError, MissingExtra."""
    assert settings.engine is not None
    return _remote(settings.engine).probe(settings)


def _remote(address: str) -> type[RemoteEngine]:
    """The engine that serves an address, whose scheme the settings have checked; raises MissingExtra."""
    [point] = points(ENGINES).select(name=address.partition("://")[0])
    engine: type[RemoteEngine] = point.load()
    return engine
