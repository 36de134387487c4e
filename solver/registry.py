"""What a folder holds: each module of a kind's package offers one entry, and there is no list to edit.

A module named ``maiden.py`` in ``studies/laws`` offers its law under the attribute ``LAW``;
``entries("studies.laws", "LAW")`` finds it. Another distribution adds an entry through the entry-point group
``whipple.studies.laws``. A module that cannot be imported, or lacks its entry, stops the start and is named.
"""

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache
from importlib.metadata import entry_points
from types import MappingProxyType
from typing import Any

from solver.errors import RegistryError


@cache
def entries(package: str, kind: str) -> Mapping[str, Any]:
    """Entries of one kind by their ``name``, sorted; modules that start with an underscore are passed over."""
    folder = importlib.import_module(package)
    found: dict[str, Any] = {}
    for module_name in sorted(module.name for module in pkgutil.iter_modules(folder.__path__)):
        if not module_name.startswith("_"):
            _add(found, _load(f"{package}.{module_name}", kind), f"{package}.{module_name}")
    for point in entry_points(group=f"whipple.{package}"):
        _add(found, point.load(), point.value)
    return MappingProxyType(dict(sorted(found.items())))


def _load(module_name: str, kind: str) -> Any:
    try:
        module = importlib.import_module(module_name)
    except Exception as error:
        raise RegistryError(f"{module_name} cannot be imported: {error}") from error
    if not hasattr(module, kind):
        raise RegistryError(f"{module_name} has no {kind}: each module of this folder offers one")
    return getattr(module, kind)


def _add(found: dict[str, Any], entry: Any, origin: str) -> None:
    if entry.name in found:
        raise RegistryError(f"{origin} offers {entry.name!r} a second time")
    found[entry.name] = entry
